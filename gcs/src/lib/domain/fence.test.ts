import { expect, it } from 'vitest';
import { zoneThatForbids } from './fence';
import { destination } from './geo';
import type { LonLat } from './lonlat';
import type { FenceZone } from './plan';

const home = { lat_deg: 40, lon_deg: 179.999 };
const at = (bearing: number, far_m: number): LonLat => destination(home, bearing, far_m);
const square = (inclusion: boolean, half_m: number): FenceZone => ({
  inclusion,
  shape: 'polygon',
  points: [45, 135, 225, 315].map((bearing) => at(bearing, half_m * Math.SQRT2)),
  radius_m: null,
});
const circle = (inclusion: boolean, centre: LonLat, radius_m: number): FenceZone => {
  return { inclusion, shape: 'circle', points: [centre], radius_m };
};
const fence = (...zones: FenceZone[]) => ({ zones, return_point: null });

it('forbids a place in a zone to stay out of, or in none of those to stay in', () => {
  // across the date line
  const [around, out] = [square(true, 1000), circle(false, at(90, 600), 100)];
  expect(zoneThatForbids(fence(), home)).toBeNull();
  for (const bearing of [0, 90, 180, 270]) {
    expect(zoneThatForbids(fence(around), at(bearing, 990))).toBeNull();
    expect(zoneThatForbids(fence(around), at(bearing, 1010))).toBe(around);
  }
  expect(zoneThatForbids(fence(around, out), at(90, 490))).toBeNull();
  expect(zoneThatForbids(fence(around, out), at(90, 510))).toBe(out);
  expect(zoneThatForbids(fence(circle(true, home, 500)), at(10, 501))).not.toBeNull();
  expect(zoneThatForbids(fence(square(false, 100)), home)).not.toBeNull();
  // one of two to stay in: whether that is enough is not known
  const other = circle(true, at(90, 5000), 500);
  expect(zoneThatForbids(fence(around, other), home)).toBeNull();
  expect(zoneThatForbids(fence(around, other), at(90, 2500))).toBe(around);
});
