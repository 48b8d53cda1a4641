import { describe, expect, it } from 'vitest';
import { destination, distance_m } from './geo';
import { FRAME, makeItem } from './plan';
import { profileOf } from './profile';
import { groundOf, routePoints } from './terrain';
import { type Loiter, type Way, wayOf } from './way';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 690 };
const ITEMS = [
  makeItem('takeoff', { at: destination(HOME, 270, 300), alt_m: 50 }),
  makeItem('waypoint', { at: destination(HOME, 270, 1300), alt_m: 100 }),
  makeItem('waypoint', { at: destination(HOME, 270, 3300), alt_m: 100 }),
  makeItem('land', { at: destination(HOME, 270, 300), alt_m: 0 }),
];

const straight = (items = ITEMS, home = HOME): Way => wayOf(items, home, false);
/** A way with a circle at its first stop. */
const circling = (way: Way, loiter: Partial<Loiter>): Way => {
  const made = {
    kind: 'turns',
    radius_m: 100,
    is_clockwise: true,
    is_own_radius: true,
    length_m: null,
    time_s: null,
  } as const;
  const whole = { ...made, is_estimate: false, changed_before: 1, ...loiter };
  return { ...way, stops: way.stops.map((stop, index) => (index === 0 ? { ...stop, loiter: whole } : stop)) };
};

describe('places of a route', () => {
  it('lie along it, at the distances of the height profile', () => {
    const points = routePoints(ITEMS, straight(), 100);
    expect(points.length).toBeGreaterThan(60);
    expect(points.length).toBeLessThanOrEqual(110);
    const ends = points.filter((point) => point.changed === 1).map((point) => point.distance_m);
    const profile = profileOf(ITEMS, HOME, straight()).points.slice(1);
    expect(ends).toHaveLength(4);
    ends.forEach((end, index) => expect(end).toBeCloseTo(profile[index]!.distance_m, 3));
    expect(points.every((point, index) => index === 0 || point.distance_m >= points[index - 1]!.distance_m)).toBe(true);
  });

  it('stay on their way over the date line', () => {
    const west = { lat_deg: -16.8, lon_deg: 179.98, alt_amsl_m: 5 };
    const items = [makeItem('waypoint', { at: { lat_deg: -16.8, lon_deg: -179.98 }, alt_m: 90 })];
    const points = routePoints(items, straight(items, west));
    expect(points.length).toBeGreaterThan(100);
    expect(points.every(({ at }) => Math.abs(at.lon_deg) > 179.97)).toBe(true);
  });

  it('go round circles, and on where the height profile does', () => {
    const turns = makeItem('loiter_turns', { at: destination(HOME, 0, 800), alt_m: 80 });
    const items = [turns, makeItem('waypoint', { at: destination(HOME, 0, 1600), alt_m: 80 })];
    const way = circling(straight(items), { length_m: 400 * Math.PI });
    const points = routePoints(items, way);
    const round = points.filter(({ distance_m }) => distance_m > 801 && distance_m < 800 + 399 * Math.PI);
    expect(round.length).toBeGreaterThan(20);
    for (const { at } of round) expect(Math.abs(distance_m(at, destination(HOME, 0, 800)) - 100)).toBeLessThan(1);
    expect(points.at(-1)!.distance_m).toBeCloseTo(profileOf(items, HOME, way).length_m, 3);
    const wait = [makeItem('loiter_unlimited', { at: destination(HOME, 0, 800), alt_m: 80 })];
    const endless = routePoints(wait, circling(straight(wait), { kind: 'unlimited', radius_m: 60 }));
    expect(endless.at(-1)!.distance_m).toBeCloseTo(800, 1);
    expect(distance_m(endless.at(-1)!.at, destination(HOME, 0, 800))).toBeCloseTo(60, 0);
  });

  it('are none without a plan', () => expect(routePoints([], straight([]))).toEqual([]));
});

describe('ground', () => {
  const points = routePoints(ITEMS, straight(), 200);

  it('is compared with the height that the plane has there', () => {
    // flat, 10 m above the ground at home
    const heights = points.map((_, index) => (index === 0 ? 690 : 700));
    const ground = groundOf(ITEMS, HOME, points, heights, 30);
    const last = ground.points.find((point) => point.distance_m > 1299.9);
    expect(last?.clearance_m).toBeCloseTo(90, 0);
    expect(ground.unknown).toBe(0);
    // the climb to 50 m ends 40 m above the ground, and it only gets higher from there
    expect(ground.lowest?.clearance_m).toBeCloseTo(40, 0);
  });

  it('warns once for each stretch that is too low, and not of climbing out', () => {
    const hill = points.map(({ distance_m }) => (distance_m > 1800 && distance_m < 2400 ? 775 : 690));
    const ground = groundOf(ITEMS, HOME, points, hill, 30);
    expect(ground.tooLow).toHaveLength(1);
    expect(ground.tooLow[0]?.distance_m).toBeGreaterThan(1800);
    expect(ground.lowest?.clearance_m).toBeCloseTo(15, 0);
  });

  it('counts from the ground at home, whatever the map is off there', () => {
    const off = points.map(({ distance_m }) => (distance_m > 1800 && distance_m < 2400 ? 785 : 700));
    const ground = groundOf(ITEMS, HOME, points, off, 30);
    expect(ground.lowest?.clearance_m).toBeCloseTo(15, 0);
    expect(ground.points[0]?.ground_rel_home_m).toBe(0);
  });

  it('does not take the error of terrain data at home for a hill', () => {
    const off = points.map(() => 698);
    expect(groundOf(ITEMS, HOME, points, off, 30).tooLow).toHaveLength(0);
  });

  it('warns of a climb into a hill', () => {
    const hill = points.map(({ distance_m }) => (distance_m > 100 && distance_m < 200 ? 760 : 690));
    expect(groundOf(ITEMS, HOME, points, hill, 30).tooLow).toHaveLength(1);
  });

  it('keeps heights that count from the terrain', () => {
    const items = [...ITEMS.slice(0, 2), { ...ITEMS[2]!, frame: FRAME.terrain }];
    const route = routePoints(items, straight(items), 200);
    const hill = route.map(({ distance_m }) => 690 + Math.max(0, distance_m - 1500) / 5);
    const ground = groundOf(items, HOME, route, hill, 30);
    expect(ground.points.at(-1)?.clearance_m).toBeCloseTo(100, 6);
    expect(ground.tooLow).toHaveLength(0);
  });

  it('leaves unknown what is unknown', () => {
    const ground = groundOf(ITEMS, HOME, points, Array<null>(points.length).fill(null), 30);
    expect(ground).toMatchObject({ lowest: null, tooLow: [], unknown: points.length });
    expect(ground.points.every((point) => point.clearance_m === null)).toBe(true);
    expect(groundOf(ITEMS, null, points, [], 30).points).toEqual([]);
  });
});
