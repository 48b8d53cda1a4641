import { describe, expect, it } from 'vitest';
import {
  addCircle,
  addPolygon,
  addRally,
  type AreaHandle,
  type Areas,
  fenceHandles,
  middleOfZone,
  moveHandle,
  rallyHandles,
  removeHandle,
  sameHandle,
  withReturnPoint,
} from './area-edit';
import { destination, distance_m } from './geo';
import { emptyPlan, FRAME } from './plan';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978 };
const at = (bearing: number, distance: number) => destination(HOME, bearing, distance);
const SQUARE = [at(315, 500), at(45, 500), at(135, 500), at(225, 500)];

function areas(): Areas {
  let { fence } = emptyPlan();
  fence = addPolygon(fence, true, SQUARE);
  fence = addCircle(fence, false, at(0, 200), 80);
  fence = withReturnPoint(fence, HOME, 60);
  return { fence, rally: addRally(addRally([], at(90, 300), 80.4, 'home'), at(270, 300), 700, 'amsl') };
}
const handleAt = (all: Areas, wanted: AreaHandle) =>
  [...fenceHandles(all.fence), ...rallyHandles(all.rally)].find(({ handle }) => sameHandle(handle, wanted))!.at;

describe('handles', () => {
  it('has one for each corner, edge, middle, radius, return and rally point', () => {
    const all = areas();
    const kinds = [...fenceHandles(all.fence), ...rallyHandles(all.rally)].map(({ handle }) => handle.kind);
    const count = (kind: string) => kinds.filter((one) => one === kind).length;
    expect(['corner', 'edge', 'centre', 'radius', 'return', 'rally'].map(count)).toEqual([4, 4, 2, 1, 1, 2]);
  });

  it('moves a corner, makes one of an edge, and goes on with the new corner', () => {
    const corner = { kind: 'corner', zone: 0, corner: 2 } as const;
    const moved = moveHandle(areas(), corner, HOME, at(135, 900));
    expect(distance_m(handleAt(moved.areas, corner), at(135, 900))).toBeLessThan(0.02);
    const edge = moveHandle(areas(), { kind: 'edge', zone: 0, corner: 3 }, HOME, at(270, 700));
    expect(edge.handle).toEqual({ kind: 'corner', zone: 0, corner: 4 });
    expect(edge.areas.fence.zones[0]!.points).toHaveLength(5);
    expect(distance_m(handleAt(edge.areas, edge.handle), at(270, 700))).toBeLessThan(0.02);
  });

  it('moves a whole zone without changing its size', () => {
    const before = areas();
    const { areas: after } = moveHandle(before, { kind: 'centre', zone: 0 }, HOME, at(20, 3000));
    const [a, b] = [before.fence.zones[0]!.points, after.fence.zones[0]!.points];
    expect(distance_m(b[0]!, b[2]!)).toBeCloseTo(distance_m(a[0]!, a[2]!), 0);
    expect(distance_m(middleOfZone(before.fence.zones[0]!)!, middleOfZone(after.fence.zones[0]!)!)).toBeCloseTo(
      3000,
      0,
    );
    // the other zone stays
    expect(after.fence.zones[1]).toEqual(before.fence.zones[1]);
  });

  it('takes the radius from where its handle is, never too small', () => {
    const radius = { kind: 'radius', zone: 1 } as const;
    expect(distance_m(handleAt(areas(), radius), at(0, 200))).toBeCloseTo(80, 1);
    const bigger = moveHandle(areas(), radius, HOME, destination(at(0, 200), 90, 333)).areas;
    expect(bigger.fence.zones[1]!.radius_m).toBe(333);
    expect(moveHandle(areas(), radius, HOME, at(0, 200)).areas.fence.zones[1]!.radius_m).toBe(10);
  });

  it('moves return and rally points, and keeps their heights', () => {
    const all = moveHandle(areas(), { kind: 'return' }, HOME, at(0, 50)).areas;
    expect(all.fence.return_point).toMatchObject({ alt_rel_home_m: 60 });
    expect(distance_m(all.fence.return_point!, at(0, 50))).toBeLessThan(0.02);
    const rally = moveHandle(all, { kind: 'rally', index: 1 }, HOME, at(180, 50)).areas.rally;
    expect(rally[1]).toMatchObject({ alt_m: 700, frame: FRAME.amsl });
  });

  it('removes a corner while three are left, then the zone', () => {
    let all = removeHandle(areas(), { kind: 'corner', zone: 0, corner: 0 });
    expect(all.fence.zones[0]!.points).toHaveLength(3);
    all = removeHandle(all, { kind: 'corner', zone: 0, corner: 0 });
    expect(all.fence.zones).toHaveLength(1);
    all = removeHandle(removeHandle(all, { kind: 'return' }), { kind: 'rally', index: 0 });
    expect(all.fence.return_point).toBeNull();
    expect(all.rally).toHaveLength(1);
  });
});

it('finds the middle of a zone across the date line', () => {
  const points = [179.9, -179.9, -179.9, 179.9].map((lon_deg, index) => ({ lon_deg, lat_deg: index < 2 ? 1 : -1 }));
  const middle = middleOfZone({ inclusion: true, shape: 'polygon', points, radius_m: null })!;
  expect(Math.abs(Math.abs(middle.lon_deg) - 180)).toBeLessThan(1e-6);
  expect(middle.lat_deg).toBeCloseTo(0, 9);
});
