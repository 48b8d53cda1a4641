/** Corners of a polygon, or points of a line, while they are edited: of fences and of surveys. Nothing changes what it took. */

import { bearing_deg, between, destination, distance_m } from './geo';
import { type LonLat, rounded, sameLonLat } from './lonlat';

interface Edge {
  /** Index of the corner that it goes out from. */
  readonly after: number;
  readonly middle: LonLat;
  readonly ends: readonly [LonLat, LonLat];
}

/** The edges between corners; of a polygon with fewer than three corners none. */
export function edgesOf(points: readonly LonLat[], isClosed: boolean): Edge[] {
  if (isClosed && points.length < 3) return [];
  return points.slice(0, isClosed ? points.length : -1).map((from, after) => {
    const to = points[(after + 1) % points.length] as LonLat;
    return { after, middle: between(from, to, 0.5), ends: [from, to] };
  });
}

/** The mean of all corners; `null` without any. */
export function middleOf(points: readonly LonLat[]): LonLat | null {
  const [first] = points;
  if (first === undefined) return null;
  // corners near the date line are taken to the side of the first
  const near = (lon_deg: number): number => lon_deg - 360 * Math.round((lon_deg - first.lon_deg) / 360);
  return rounded({
    lat_deg: points.reduce((sum, point) => sum + point.lat_deg, 0) / points.length,
    lon_deg: points.reduce((sum, point) => sum + near(point.lon_deg), 0) / points.length,
  });
}

export const moved = (points: readonly LonLat[], index: number, to: LonLat): LonLat[] =>
  points.map((point, other) => (other === index ? rounded(to) : point));

/** With a corner more, before the one that is at `index` now. */
export const inserted = (points: readonly LonLat[], index: number, at: LonLat): LonLat[] => [
  ...points.slice(0, index),
  rounded(at),
  ...points.slice(index),
];

export const without = (points: readonly LonLat[], index: number): LonLat[] =>
  points.filter((_, other) => other !== index);

/** All moved as from one place to another, along the same geodesic: shapes keep their size at every latitude. */
export function shifted(points: readonly LonLat[], from: LonLat, to: LonLat): LonLat[] {
  if (sameLonLat(from, to)) return [...points];
  const [bearing, far_m] = [bearing_deg(from, to), distance_m(from, to)];
  return points.map((point) => rounded(destination(point, bearing, far_m)));
}
