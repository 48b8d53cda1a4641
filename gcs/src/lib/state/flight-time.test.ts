import { describe, expect, it } from 'vitest';
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
  });

  it('keeps counting while it is not known whether it flies', () => {
    const clock = new FlightClock('4');
    clock.update(10, false);
    clock.update(20, true);
    expect(clock.update(25, null)).toEqual({ seconds: 5, isExact: true });
  });
});
