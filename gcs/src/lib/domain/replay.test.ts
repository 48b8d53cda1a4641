import { describe, expect, it } from 'vitest';
import { positionAfter, type ReplayState, timeAt } from './replay';

describe('a replay', () => {
  const replay: ReplayState = {
    position_s: 10,
    duration_s: 60,
    unix_s: 1_700_000_010,
    speed: 4,
    is_paused: false,
    is_over: false,
  };

  it('goes on at its speed until the end, and stands still while it is paused', () => {
    expect(positionAfter(replay, 2)).toBe(18);
    expect(positionAfter(replay, 600)).toBe(60);
    expect(positionAfter({ ...replay, is_paused: true }, 600)).toBe(10);
    expect(positionAfter({ ...replay, is_over: true, position_s: 60 }, 600)).toBe(60);
  });

  it('has the time of its recording', () => {
    expect(timeAt(replay, 18)).toBe(1_700_000_018);
    expect(timeAt({ ...replay, unix_s: null }, 18)).toBeNull();
  });
});
