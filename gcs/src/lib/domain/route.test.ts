import { describe, expect, it } from 'vitest';
import { destination } from './geo';
import { makeItem, withParam } from './plan';
import { profileOf } from './profile';
import { approachesOf, PLANE_ROUTE, stopsOf } from './route';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 690 };
const at = (distance_m: number) => destination(HOME, 0, distance_m);
const waypoint = (distance_m: number, alt_m = 80) => makeItem('waypoint', { at: at(distance_m), alt_m });
const turns = (distance_m: number, count: number, radius_m: number) =>
  withParam(withParam(makeItem('loiter_turns', { at: at(distance_m), alt_m: 80 }), 0, count), 2, radius_m);

it('climbs on the way to a circle first, and in it for the rest', () => {
  // 300 m at 2.5 m/s are 120 s, of which 5 pass on the leg of 100 m
  const items = [waypoint(1000, 100), makeItem('loiter_to_height', { at: at(1100), alt_m: 400 })];
  const [, there] = stopsOf(items, HOME, { ...PLANE_ROUTE, cruise_m_s: 20 });
  expect(there!.loiter!.changedBefore).toBeCloseTo(5 / 120, 4);
});

it('draws no way to an arc that a plane passes over', () => {
  const items = [waypoint(500), withParam(makeItem('arc_waypoint', { at: at(900) }), 0, 90), waypoint(1500)];
  expect(stopsOf(items, HOME).map((stop) => stop.index)).toEqual([0, 2]);
  expect(stopsOf(items, HOME, { ...PLANE_ROUTE, fliesArcs: true }).map((stop) => stop.index)).toEqual([0, 1, 2]);
  expect(profileOf(items, HOME).length_m).toBeCloseTo(1500, 1);
});

describe('the height profile', () => {
  it('has the distance that is circled, and goes on after it', () => {
    const profile = profileOf([turns(1000, 2, 100), waypoint(2000)], HOME);
    expect(profile.length_m).toBeCloseTo(2000 + 400 * Math.PI, 1);
    expect(profile.loiters).toMatchObject([{ index: 0, kind: 'turns', isUnknown: false }]);
    expect(profile.points.filter((point) => point.isItem).map((point) => point.index)).toEqual([0, 1]);
    expect(profile.points.map((point) => point.isBeyond)).toEqual([false, false, false, false]);
  });

  it('puts the height of a climbing circle where it is reached', () => {
    const items = [waypoint(1000, 100), makeItem('loiter_to_height', { at: at(1100), alt_m: 400 })];
    const points = profileOf(items, HOME).points.filter((point) => point.index === 1);
    expect(points.map((point) => point.isItem)).toEqual([false, true]);
    expect(points[0]!.alt_rel_home_m).toBeLessThan(120);
    expect(points[1]!.alt_rel_home_m).toBe(400);
  });

  it('tells what is flown from what comes after a circle without end', () => {
    const endless = makeItem('loiter_unlimited', { at: at(1000), alt_m: 80 });
    const profile = profileOf([endless, waypoint(2000)], HOME);
    expect(profile.loiters).toMatchObject([{ kind: 'unlimited', isUnknown: false }]);
    expect(profile.points.map((point) => point.isBeyond)).toEqual([false, false, true]);
  });
});

it('tells how steep the way down to a landing is', () => {
  const items = [makeItem('loiter_to_height', { at: at(500), alt_m: 40 }), makeItem('land', { at: HOME, alt_m: 0 })];
  expect(approachesOf(items, HOME)).toMatchObject([{ landIndex: 1, drop_m: 40, slope: expect.closeTo(0.08, 4) }]);
  expect(approachesOf([waypoint(500, 40)], HOME)).toEqual([]);
});
