import { describe, expect, it } from 'vitest';
import { ServerClock } from './server-clock';

describe('ServerClock', () => {
  it('knows no age before the server said the time', () => {
    expect(new ServerClock().age_s(1000, 0)).toBeNull();
  });

  it('believes what came fastest, so that a slow network makes nothing look young', () => {
    const clock = new ServerClock();
    clock.hear(1_000_000, 50); // 50 ms on its way
    clock.hear(1_001_000, 1400); // 400 ms on its way
    expect(clock.age_s(1_000_000, 1050)).toBeCloseTo(1.0);
    clock.hear(1_002_000, 2010); // 10 ms
    expect(clock.age_s(1_002_000, 2010)).toBeCloseTo(0);
    expect(clock.age_s(1_001_500, 2010)).toBeCloseTo(0.5);
  });

  it('follows a clock that was set, after some time', () => {
    const clock = new ServerClock();
    clock.hear(2_000_000, 0);
    for (let i = 1; i <= 16; i += 1) clock.hear(1_000_000 + 1000 * i, 1000 * i);
    expect(clock.age_s(1_015_000, 16_000)).toBeCloseTo(1);
  });

  it('does not take nonsense for a time', () => {
    const clock = new ServerClock();
    clock.hear(Number.NaN, 0);
    expect(clock.age_s(0, 0)).toBeNull();
  });
});
