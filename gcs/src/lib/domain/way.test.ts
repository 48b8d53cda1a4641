import { describe, expect, it } from 'vitest';
import { destination } from './geo';
import { makeItem, type PlanItem, withParam, withPlace } from './plan';
import { NO_PROFILE } from './profile';
import { type Loiter, placesFlown, type ToldWay, type Way, wayOf } from './way';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 690 };
const at = (away_m: number, bearing_deg = 0) => destination(HOME, bearing_deg, away_m);
const waypoint = (away_m: number, alt_m = 80) => makeItem('waypoint', { at: at(away_m), alt_m });
const keyed = (items: PlanItem[]) => items.map((item, index) => ({ ...item, key: index + 1 }));
const LOITER: Loiter = {
  ...{ kind: 'turns', radius_m: 100, is_clockwise: true, is_own_radius: true },
  ...{ length_m: 200 * Math.PI, time_s: 30, is_estimate: false, changed_before: 1 },
};
/** What the core would tell: each leg a line of three points. */
const told = (items: readonly PlanItem[], loiters: Record<number, Loiter> = {}): ToldWay => ({
  stops: wayOf(items, HOME, false).stops.map(({ index, leg }) => ({
    item: index + 1,
    leg: leg && {
      from_item: leg.fromIndex === null ? null : leg.fromIndex + 1,
      kind: leg.kind,
      length_m: leg.length_m + 1,
      course_deg: leg.course_deg,
      lat_deg: [leg.from.lat_deg, 40.5, leg.to.lat_deg],
      lon_deg: [leg.from.lon_deg, -3.7, leg.to.lon_deg],
      descent: null,
    },
    loiter: loiters[index] ?? null,
  })),
  jumps: [],
  end: { item: items.length + 1, designed_item: null },
  profile: NO_PROFILE,
});
const guesses = (way: Way) => way.stops.map(({ leg }) => leg?.isGuess);

describe('before the core has told', () => {
  it('joins the places that are flown to by straight lines, marked as such', () => {
    const items = [
      makeItem('takeoff', { at: at(300, 270), alt_m: 50 }),
      makeItem('change_speed'),
      waypoint(600),
      waypoint(900),
      makeItem('land', { at: at(20), alt_m: 0 }),
      makeItem('return_to_launch'),
    ];
    const { stops } = wayOf(items, HOME, false);
    expect(stops.map(({ index, leg }) => [index, leg?.kind])).toEqual([
      [0, 'takeoff'],
      [2, 'takeoff'],
      [3, 'flown'],
      [4, 'approach'],
      [5, 'return'],
    ]);
    expect(stops.every(({ leg }) => leg?.isGuess && leg.line.length === 2)).toBe(true);
    expect(stops[2]?.leg?.length_m).toBeCloseTo(300, 3);
    expect(wayOf(items.slice(2, 3), null, false).stops).toMatchObject([{ index: 0, leg: null }]);
    expect(wayOf([], HOME, false)).toEqual({ stops: [], jumps: [] });
  });

  it('passes over an arc unless the vehicle flies it, and returns only to a home that is known', () => {
    const items = [waypoint(500), makeItem('arc_waypoint', { at: at(900) }), makeItem('return_to_launch')];
    expect(placesFlown(items, HOME, false).map(({ index }) => index)).toEqual([0, 2]);
    expect(placesFlown(items, null, true).map(({ index }) => index)).toEqual([0, 1]);
  });
});

describe('what the core told', () => {
  const items = keyed([
    waypoint(500),
    makeItem('loiter_turns', { at: at(1000), alt_m: 80 }),
    waypoint(1500),
    waypoint(2000),
  ]);
  const answer = { items, home: HOME, way: { ...told(items, { 1: LOITER }), jumps: [{ item: 4, to_item: 2 }] } };

  it('is drawn', () => {
    const way = wayOf(items, HOME, false, answer);
    expect(guesses(way)).toEqual([false, false, false, false]);
    expect(way.stops[0]?.leg?.line).toHaveLength(3);
    expect(way.stops[1]?.loiter).toBe(LOITER);
    expect(way.jumps).toEqual([{ fromIndex: 3, toIndex: 1 }]);
  });

  it('holds for what is still the same while an item is dragged', () => {
    const dragged = items.map((item, index) => (index === 1 ? { ...withPlace(item, at(1000, 20)), key: 2 } : item));
    const way = wayOf(dragged, HOME, false, answer);
    expect(guesses(way)).toEqual([false, true, true, false]);
    // the circle goes with it
    expect(way.stops[1]?.loiter).toBe(LOITER);
    const wider = dragged.map((item, index) => (index === 1 ? { ...withParam(item, 2, 150), key: 2 } : item));
    expect(wayOf(wider, HOME, false, answer).stops[1]?.loiter).toBeNull();
  });

  it('holds beside an item that is put in or taken out', () => {
    const more = [items[0]!, { ...waypoint(700), key: 9 }, ...items.slice(1)];
    expect(guesses(wayOf(more, HOME, false, answer))).toEqual([false, true, true, false, false]);
    expect(guesses(wayOf(items.slice(1), HOME, false, answer))).toEqual([true, false, false]);
    const elsewhere = { ...HOME, lat_deg: 40.4 };
    expect(guesses(wayOf(items, elsewhere, false, answer))).toEqual([true, false, false, false]);
  });
});
