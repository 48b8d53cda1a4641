import { afterEach, describe, expect, it, vi } from 'vitest';
import { FlightClock } from './flight-time';

describe('FlightClock', () => {
  it('counts from take-off to landing and then stands still', () => {
    const clock = new FlightClock('1');
    expect(clock.update(10, false)).toBeNull();
    expect(clock.update(20, true)).toEqual({ seconds: 0, isExact: true });
    expect(clock.update(80, true)).toEqual({ seconds: 60, isExact: true });
    expect(clock.update(90, false)).toEqual({ seconds: 70, isExact: true });
    expect(clock.update(200, false)).toEqual({ seconds: 70, isExact: true });
    expect(clock.update(300, true)).toEqual({ seconds: 0, isExact: true });
  });

  it('says "at least" when it came in mid-flight', () => {
    const clock = new FlightClock('2');
    clock.update(500, true);
    expect(clock.update(530, true)).toEqual({ seconds: 30, isExact: false });
  });

  it('starts anew after a reboot', () => {
    const clock = new FlightClock('3');
    clock.update(10, false);
    clock.update(20, true);
    expect(clock.update(5, false)).toBeNull();
    clock.update(20, true);
    clock.update(900, true);
    expect(clock.update(60, false)).toBeNull();
  });

  describe('on a page that was closed in flight', () => {
    const day_s = 86_400;
    const stored = () => {
      const store = new Map<string, string>();
      vi.stubGlobal('localStorage', {
        getItem: (key: string) => store.get(key) ?? null,
        setItem: (key: string, value: string) => store.set(key, value),
      });
      const clock = new FlightClock('5');
      clock.update(499, false, 499);
      clock.update(500, true, 500);
      return () => new FlightClock('5');
    };
    afterEach(() => vi.unstubAllGlobals());

    it('goes on when it is opened again', () => {
      expect(stored()().update(620, true, 621)).toEqual({ seconds: 120, isExact: true });
    });

    it('knows nothing of the flight of another day', () => {
      const opened = stored();
      expect(opened().update(200, false, day_s)).toBeNull();
      expect(opened().update(620, true, day_s)).toEqual({ seconds: 0, isExact: false });
    });
  });

  it('keeps counting while it is not known whether it flies', () => {
    const clock = new FlightClock('4');
    clock.update(10, false);
    clock.update(20, true);
    expect(clock.update(25, null)).toEqual({ seconds: 5, isExact: true });
  });
});
