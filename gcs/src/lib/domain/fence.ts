// Whether a fence surely forbids a place (`Fence::forbidden_by` of the core is the whole rule).
import { distance_m } from './geo';
import type { LonLat } from './lonlat';
import type { Fence, FenceZone } from './plan';

/**
 * The first zone that forbids a place: one to stay out of that it lies in, or one to stay in where it lies in none of these. Whether
 * it has to lie in all of them is the vehicle's to say (`FENCE_OPTIONS`, bit 1), which may not have been read.
 */
export function zoneThatForbids({ zones }: Fence, at: LonLat): FenceZone | null {
  const isIncluded = zones.some((zone) => zone.inclusion && holds(zone, at));
  return zones.find((zone) => (zone.inclusion ? !isIncluded : holds(zone, at))) ?? null;
}

function holds({ shape, points, radius_m }: FenceZone, at: LonLat): boolean {
  const [centre] = points;
  if (shape === 'circle') return centre !== undefined && distance_m(centre, at) <= (radius_m ?? 0);
  // a ray eastwards from the place crosses the border an odd number of times; longitudes are those from the place
  const east = (point: LonLat): number => {
    const away_deg = point.lon_deg - at.lon_deg;
    return away_deg - 360 * Math.round(away_deg / 360);
  };
  let isInside = false;
  for (const [index, to] of points.entries()) {
    const from = points[(index || points.length) - 1] as LonLat;
    if (from.lat_deg > at.lat_deg === to.lat_deg > at.lat_deg) continue;
    const part = (at.lat_deg - from.lat_deg) / (to.lat_deg - from.lat_deg);
    if (east(from) + part * (east(to) - east(from)) > 0) isInside = !isInside;
  }
  return isInside;
}
