import { describe, expect, it } from 'vitest';
import { inTurns, outcomeOf } from './group-act';

describe('a group act', () => {
  it('tells apart what was not done, what nobody knows, and what was refused', () => {
    expect(['vehicle-lost', 'unreached', 'not-sent'].map(outcomeOf)).toEqual(['unreached', 'unreached', 'unreached']);
    expect([null, 'command-timeout', 'not-confirmed'].map(outcomeOf)).toEqual(['unknown', 'unknown', 'unknown']);
    expect(['command-refused', 'remote-refused', 'control'].map(outcomeOf)).toEqual(['refused', 'refused', 'refused']);
  });

  it('asks a few at a time, everybody once, in order', async () => {
    const begun: number[] = [];
    const ends: (() => void)[] = [];
    const done = inTurns([1, 2, 3, 4, 5], 2, async (item) => {
      begun.push(item);
      await new Promise<void>((resolve) => ends.push(resolve));
    });
    for (let n = 0; n < 5; n += 1) {
      expect(begun.length).toBe(Math.min(5, n + 2));
      ends[n]?.();
      await new Promise((resolve) => setTimeout(resolve, 0));
    }
    await done;
    expect(begun).toEqual([1, 2, 3, 4, 5]);
  });
});
