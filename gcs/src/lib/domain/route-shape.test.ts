import { describe, expect, it } from 'vitest';
import { bearing_deg, destination, distance_m, length_m } from './geo';
import { wrap180_deg } from './lonlat';
import { makeItem, type PlanItem, withParam } from './plan';
import { PLANE_ROUTE, routeOf } from './route';
import { arcLine, arcRadius_m, circleAt, entryTangent, exitTangent, shapedRoute } from './route-shape';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978 };
const at = (bearing: number, distance: number) => destination(HOME, bearing, distance);
const circleOf = (radius_m: number) =>
  withParam(makeItem('loiter_turns', { at: at(0, 1000), alt_m: 80 }), 2, radius_m) satisfies PlanItem;

describe('arcs', () => {
  it('turns by its angle, clockwise when it is positive, and ends where it should', () => {
    const [from, to] = [HOME, at(90, 400)];
    for (const angle_deg of [90, -90, 180, 270, -300]) {
      const line = arcLine(from, to, angle_deg);
      expect(line[0]).toEqual(from);
      expect(line.at(-1)).toEqual(to);
      const radius_m = arcRadius_m(from, to, angle_deg);
      expect(length_m(line)).toBeCloseTo((radius_m * Math.abs(angle_deg) * Math.PI) / 180, -1);
      const turn = wrap180_deg(
        bearing_deg(line.at(-2)!, to) - bearing_deg(from, line[1]!) - angle_deg * (1 - 1 / (line.length - 1)),
      );
      expect(Math.abs(turn)).toBeLessThan(0.2);
    }
    // eastwards and clockwise: over the north
    expect(arcLine(from, to, 180)[18]!.lat_deg).toBeGreaterThan(from.lat_deg);
    expect(arcLine(from, to, -180)[18]!.lat_deg).toBeLessThan(from.lat_deg);
  });

  it('is a straight leg without an angle', () => {
    expect(arcLine(HOME, at(0, 100), 0)).toHaveLength(2);
    expect(arcLine(HOME, at(0, 100), 360)).toHaveLength(2);
  });

  it('counts as long as it is in route and mission', () => {
    const items = [
      makeItem('waypoint', { at: at(0, 100) }),
      withParam(makeItem('arc_waypoint', { at: at(0, 500) }), 0, 180),
    ];
    const copter = { ...PLANE_ROUTE, fliesArcs: true };
    expect(routeOf(items, HOME, copter)[1]!.length_m).toBeCloseTo(Math.PI * 200, 0);
    const [, arc] = shapedRoute(items, HOME, copter);
    expect(arc!.line.length).toBeGreaterThan(20);
    expect(distance_m(arc!.middle, at(0, 300))).toBeCloseTo(200, 0);
    // a plane passes over it
    expect(shapedRoute(items, HOME)).toHaveLength(1);
  });
});

describe('circles', () => {
  it.each([60, -60])('touches them in their sense (radius %i)', (radius_m) => {
    const circle = circleAt(circleOf(radius_m))!;
    expect(circle).toMatchObject({ radius_m: 60, isClockwise: radius_m > 0 });
    const entry = entryTangent(HOME, circle)!;
    expect(distance_m(entry, circle.centre)).toBeCloseTo(60, 1);
    // flying north to a clockwise circle one passes it on its left side, so that the centre lies on the right
    expect(entry.lon_deg < circle.centre.lon_deg).toBe(radius_m > 0);
    const exit = exitTangent(circle, HOME)!;
    expect(distance_m(exit, circle.centre)).toBeCloseTo(60, 1);
    expect(exit.lon_deg > circle.centre.lon_deg).toBe(radius_m > 0);
    expect(entryTangent(at(0, 990), circle)).toBeNull();
  });

  it('is left on the tangent only when its item says so', () => {
    const items = [circleOf(100), makeItem('waypoint', { at: at(90, 1000) })];
    const leaves = (exit: number) => shapedRoute([withParam(items[0]!, 3, exit), items[1]!], HOME)[1]!.line[0]!;
    expect(distance_m(leaves(1), at(0, 1000))).toBeCloseTo(100, 1);
    expect(distance_m(leaves(0), at(0, 1000))).toBeLessThan(0.01);
  });
});

it('bends a spline between its neighbours', () => {
  const spline: PlanItem = {
    ...makeItem('waypoint', { at: at(45, 800) }),
    command: 82,
    name: 'MAV_CMD_NAV_SPLINE_WAYPOINT',
  };
  const items = [
    makeItem('waypoint', { at: at(0, 400) }),
    spline,
    { ...spline, params: makeItem('waypoint', { at: at(90, 800) }).params },
  ];
  const [, curve] = shapedRoute(items, HOME);
  expect(curve!.line[0]).toEqual(curve!.from);
  expect(curve!.line.at(-1)).toEqual(curve!.to);
  expect(length_m(curve!.line)).toBeGreaterThan(curve!.length_m * 1.001);
  expect(length_m(curve!.line)).toBeLessThan(curve!.length_m * 2);
});
