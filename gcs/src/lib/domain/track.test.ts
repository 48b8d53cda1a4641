import { describe, expect, it } from 'vitest';
import { destination } from './geo';
import { freeCentre, insetsBeside, narrowFactor, widenFactor } from './sight';
import { Trail } from './track';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978 };

describe('trail', () => {
  it('keeps what is new and forgets the oldest', () => {
    const trail = new Trail(10, 3);
    for (let metres = 0; metres < 28; metres += 1) trail.add(destination(HOME, 90, metres * 1.02), 50);
    expect(trail.length).toBe(10);
    expect(trail.lon_deg(0)).toBeCloseTo(HOME.lon_deg, 9);
    for (let metres = 40; metres < 80; metres += 4) trail.add(destination(HOME, 90, metres), 50 + metres);
    expect(trail.length).toBe(10);
    expect(trail.alt_m(9)).toBe(126);
    expect(trail.lon_deg(0)).toBeGreaterThan(HOME.lon_deg);
  });

  it('knows how long the way is that it keeps', () => {
    const trail = new Trail(10, 3);
    expect(trail.flown_m).toBe(0);
    for (let count = 0; count <= 9; count += 1) trail.add(destination(HOME, 90, count * 4), 50);
    expect(trail.flown_m).toBeCloseTo(36, 0);
    for (let count = 10; count <= 30; count += 1) trail.add(destination(HOME, 90, count * 4), 50);
    expect(trail.flown_m).toBeCloseTo(36, 0);
    const again = new Trail(10, 3);
    again.restore(trail.serialize());
    expect(again.flown_m).toBeCloseTo(trail.flown_m, 0);
    trail.clear();
    expect(trail.flown_m).toBe(0);
  });

  it('notes a climb on the spot', () => {
    const trail = new Trail(10, 3);
    expect([0, 2, 4].map((alt_m) => trail.add(HOME, alt_m))).toEqual([true, false, true]);
  });

  it('survives a reload', () => {
    const trail = new Trail(50_000, 3);
    for (let index = 0; index < 50_000; index += 1) {
      trail.add({ lat_deg: 40 + index * 1e-4, lon_deg: -3.7978 }, index % 3000);
    }
    expect(trail.length).toBe(50_000);
    const text = trail.serialize();
    expect(text.length).toBeLessThan(700_000);
    const again = new Trail(50_000, 3);
    again.restore(text);
    expect(again.length).toBe(50_000);
    expect(again.lat_deg(12_345)).toBeCloseTo(trail.lat_deg(12_345), 7);
    expect(again.alt_m(12_345)).toBeCloseTo(trail.alt_m(12_345), 1);
    expect(trail.serialize(100).length).toBeLessThan(1400);
  });

  it('takes nothing from a spoiled storage', () => {
    const trail = new Trail(10, 3);
    for (const text of ['', 'no base64 at all!', btoa('abc'), btoa('\xff'.repeat(20))]) {
      trail.restore(text);
      expect(trail.length).toBeLessThanOrEqual(2);
    }
    trail.restore(btoa('\x7f'.repeat(20)));
    expect(trail.length).toBe(0);
  });
});

describe('keeping in sight', () => {
  const size = { width: 1000, height: 800 };
  const none = { top: 0, right: 0, bottom: 0, left: 0 };

  it('leaves the view alone while the plane is well inside', () => {
    expect(widenFactor(500, 400, size, none)).toBe(1);
    expect(widenFactor(110, 110, size, none)).toBe(1);
  });

  it('widens when the plane comes near an edge, and then it is well inside', () => {
    for (const [x, y] of [
      [40, 400],
      [990, 400],
      [500, 10],
      [500, 795],
      [-3000, 9000],
    ] as const) {
      const factor = widenFactor(x, y, size, none);
      expect(factor).toBeGreaterThanOrEqual(1.35);
      const after = [500 + (x - 500) / factor, 400 + (y - 400) / factor] as const;
      expect(widenFactor(after[0], after[1], size, none)).toBe(1);
    }
  });

  it('counts what panels cover as not in sight', () => {
    const insets = { top: 0, right: 400, bottom: 0, left: 0 };
    expect(widenFactor(700, 400, size, none)).toBe(1);
    expect(widenFactor(700, 400, size, insets)).toBeGreaterThan(1);
    expect(freeCentre(size, insets)).toEqual({ x: 300, y: 400 });
  });

  it('stays sane with a window that is all panels, and with nonsense', () => {
    expect(
      widenFactor(50, 50, { width: 100, height: 100 }, { top: 90, right: 90, bottom: 90, left: 90 }),
    ).toBeGreaterThanOrEqual(1);
    expect(widenFactor(Number.NaN, 0, size, none)).toBe(1);
  });

  it('narrows to the view that was chosen, or to what the plane still needs, where that is clearly less', () => {
    expect(narrowFactor(500, 400, size, none, 0.25)).toBe(0.25);
    expect(narrowFactor(575, 400, size, none, 0.125)).toBeCloseTo(0.25);
    expect(narrowFactor(800, 400, size, none, 0.25)).toBe(1);
    expect(narrowFactor(500, 400, size, none, 0.9)).toBe(1);
    const factor = narrowFactor(575, 450, size, none, 0.1);
    expect(widenFactor(500 + 75 / factor, 400 + 50 / factor, size, none)).toBe(1);
  });

  it('passes what covers the map on the side that leaves the plan larger', () => {
    const dial = { left: 0, top: 600, right: 200, bottom: 800 };
    const wide = { width: 4000, height: 1000 };
    const high = { width: 1000, height: 4000 };
    expect(insetsBeside([dial], wide, size, none)).toEqual({ ...none, bottom: 200 });
    expect(insetsBeside([dial], high, size, none)).toEqual({ ...none, left: 200 });
    // below a panel it covers nothing
    expect(insetsBeside([dial], wide, size, { ...none, bottom: 200 })).toEqual({ ...none, bottom: 200 });
    const buttons = { left: 940, top: 400, right: 1000, bottom: 800 };
    expect(insetsBeside([dial, buttons], { width: 4000, height: 2400 }, size, none)).toEqual({
      ...none,
      bottom: 200,
      right: 60,
    });
    // one that would leave hardly anything is drawn over
    expect(insetsBeside([{ left: 100, top: 100, right: 950, bottom: 780 }], wide, size, none)).toEqual(none);
  });
});
