import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { CONFIRM_MS, HOLD_MS, Hold, type HoldState } from './hold';

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

function make() {
  let done = 0;
  const states: HoldState[] = [];
  const hold = new Hold(
    () => (done += 1),
    (state) => states.push(state),
  );
  return { hold, states, done: () => done };
}

/** Held in a page whose timers come when it has time for them. */
function makeLate() {
  let now_ms = 0;
  let due: (() => void) | null = null;
  let done = 0;
  const hold = new Hold(
    () => (done += 1),
    () => undefined,
    { now: () => now_ms, setTimeout: (run) => (due = run), clearTimeout: () => (due = null) },
  );
  const comes = (after_ms: number) => {
    now_ms += after_ms;
    due?.();
  };
  return { hold, comes, done: () => done };
}

describe('Hold', () => {
  it('counts after one second, once', () => {
    const { hold, done, states } = make();
    hold.begin();
    vi.advanceTimersByTime(HOLD_MS - 1);
    expect(done()).toBe(0);
    vi.advanceTimersByTime(1);
    expect(done()).toBe(1);
    hold.end();
    vi.advanceTimersByTime(10 * HOLD_MS);
    expect(done()).toBe(1);
    expect(states).toEqual(['holding', 'idle']);
  });

  it('does not count when let go early, and begins anew', () => {
    const { hold, done, states } = make();
    for (let round = 0; round < 5; round += 1) {
      hold.begin();
      vi.advanceTimersByTime(HOLD_MS - 1);
      hold.end();
    }
    vi.advanceTimersByTime(10 * HOLD_MS);
    expect(done()).toBe(0);
    expect(states.slice(-3)).toEqual(['holding', 'hint', 'idle']);
  });

  it('does not count a short press in a page that stood still', () => {
    for (const isHeld of [false, true]) {
      const { hold, comes, done } = makeLate();
      hold.begin();
      comes(3 * HOLD_MS);
      expect(done(), 'the timer may come before the release that waits').toBe(0);
      if (!isHeld) hold.end();
      comes(HOLD_MS / 10);
      expect(done()).toBe(isHeld ? 1 : 0);
    }
  });

  it('counts on a display on which each timer is late', () => {
    const { hold, comes, done } = makeLate();
    hold.begin();
    for (let round = 0; round < 6; round += 1) {
      expect(done()).toBe(0);
      comes(2 * HOLD_MS);
    }
    expect(done()).toBe(1);
  });

  it('a key that repeats does not begin anew', () => {
    const { hold, done } = make();
    hold.begin();
    vi.advanceTimersByTime(HOLD_MS / 2);
    hold.begin();
    vi.advanceTimersByTime(HOLD_MS / 2);
    expect(done()).toBe(1);
  });

  it('takes two presses of what cannot hold', () => {
    const { hold, done } = make();
    hold.press();
    expect(done()).toBe(0);
    hold.press();
    expect(done()).toBe(1);
    hold.press();
    vi.advanceTimersByTime(CONFIRM_MS);
    hold.press();
    expect(done()).toBe(1);
  });

  it('cancel forgets', () => {
    const { hold, done } = make();
    hold.begin();
    hold.cancel();
    vi.advanceTimersByTime(10 * HOLD_MS);
    expect(done()).toBe(0);
  });
});
