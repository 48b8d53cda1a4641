/** Grids of tiles as people think of them: how fine a level is on the ground, and what part of the world an area is. */

import { crsOf } from './projection';
import { type LonLat, wrap180_deg } from './lonlat';

export interface Level {
  /** Units of the grid's system in a pixel. */
  readonly resolution: number;
}

export interface Grid {
  readonly crs: string;
  readonly levels: readonly Level[];
  readonly min_level: number;
  readonly max_level: number;
}

/** Length of a degree of a meridian, metres: a quarter of it (10,001,965.73 m on WGS 84) over 90. */
const M_PER_DEG = 10_001_965.73 / 90;

/** Metres on the ground in a pixel of a level, at a latitude. */
export function groundResolution_m(crs: string, resolution: number, lat_deg: number): number {
  const kind = crsOf(crs)?.kind;
  if (kind === 'geographic') return resolution * M_PER_DEG;
  if (kind === 'web-mercator') return resolution * Math.cos((lat_deg * Math.PI) / 180);
  return resolution;
}

/** The level that is as fine as `wanted_m` metres in a pixel, or the next coarser one. */
export function levelFor(grid: Grid, wanted_m: number, lat_deg: number): number {
  let best = grid.min_level;
  for (let level = grid.min_level; level <= grid.max_level; level += 1) {
    const resolution = grid.levels[level]?.resolution;
    if (resolution === undefined) break;
    if (groundResolution_m(grid.crs, resolution, lat_deg) >= wanted_m * 0.99) best = level;
  }
  return best;
}

export interface Box {
  /** More than `east_deg` when the box lies across the date line. */
  readonly west_deg: number;
  readonly south_deg: number;
  readonly east_deg: number;
  readonly north_deg: number;
}

/** The box of two corners, the shorter way around the world. */
export function boxOf(a: LonLat, b: LonLat): Box {
  const across_deg = wrap180_deg(b.lon_deg - a.lon_deg);
  const [west, east] = across_deg >= 0 ? [a, b] : [b, a];
  return {
    west_deg: west.lon_deg,
    east_deg: east.lon_deg,
    south_deg: Math.min(a.lat_deg, b.lat_deg),
    north_deg: Math.max(a.lat_deg, b.lat_deg),
  };
}

/** The corners of a box in turn, without a repeated one; longitudes go on past 180 across the date line. */
export function boxCorners({ west_deg, south_deg, east_deg, north_deg }: Box): LonLat[] {
  const east = east_deg < west_deg ? east_deg + 360 : east_deg;
  return [
    { lon_deg: west_deg, lat_deg: north_deg },
    { lon_deg: east, lat_deg: north_deg },
    { lon_deg: east, lat_deg: south_deg },
    { lon_deg: west_deg, lat_deg: south_deg },
  ];
}

/** The smallest box around places, across the date line where that is smaller; `null` without places. */
export function boxAround(places: readonly LonLat[]): Box | null {
  if (places.length === 0) return null;
  const lons = places.map((place) => wrap180_deg(place.lon_deg)).sort((a, b) => a - b);
  const lats = places.map((place) => place.lat_deg);
  // the widest gap between neighbours is what the box leaves out
  let [widest, after] = [(lons[0] as number) + 360 - (lons.at(-1) as number), 0];
  for (let index = 1; index < lons.length; index += 1) {
    const gap = (lons[index] as number) - (lons[index - 1] as number);
    if (gap > widest) [widest, after] = [gap, index];
  }
  return {
    west_deg: lons[after] as number,
    east_deg: lons[(after + lons.length - 1) % lons.length] as number,
    south_deg: Math.min(...lats),
    north_deg: Math.max(...lats),
  };
}
