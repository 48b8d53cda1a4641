/** The height profile of a mission: heights above home over the distance flown. */

import { altRelHome_m, type Home, heightFrameOf, isDestination, kindOf, type PlanItem, placeOf, routeOf } from './plan';

export interface ProfilePoint {
  /** Index in the items; `null` for home at the beginning. */
  readonly index: number | null;
  /** Distance flown from the beginning, metres. */
  readonly distance_m: number;
  /** Height above home, metres. */
  readonly alt_rel_home_m: number;
  /** False when the height counts from the terrain or from sea level and home's height is not known: a guess. */
  readonly isCertain: boolean;
}

export interface Profile {
  readonly points: readonly ProfilePoint[];
  readonly length_m: number;
  readonly min_m: number;
  readonly max_m: number;
}

export function profileOf(items: readonly PlanItem[], home: Home | null): Profile {
  const points: ProfilePoint[] = [];
  let total_m = 0;
  const lengths = new Map(routeOf(items, home).map((leg) => [leg.toIndex, leg.length_m]));
  if (home !== null) points.push({ index: null, distance_m: 0, alt_rel_home_m: 0, isCertain: true });
  for (const [index, item] of items.entries()) {
    const kind = kindOf(item);
    if (kind === 'return_to_launch') {
      const last = points.at(-1);
      if (home === null || last === undefined) continue;
      total_m += lengths.get(index) ?? 0;
      points.push({ index, distance_m: total_m, alt_rel_home_m: last.alt_rel_home_m, isCertain: false });
      continue;
    }
    const to = placeOf(item);
    if (to === null || !(isDestination(item) || kind === 'takeoff')) continue;
    total_m += lengths.get(index) ?? 0;
    const alt_m = altRelHome_m(item, home);
    const guess_m = heightFrameOf(item) === 'terrain' ? (item.params[6] ?? 0) : (points.at(-1)?.alt_rel_home_m ?? 0);
    points.push({ index, distance_m: total_m, alt_rel_home_m: alt_m ?? guess_m, isCertain: alt_m !== null });
  }
  const heights = points.map((point) => point.alt_rel_home_m);
  return { points, length_m: total_m, min_m: Math.min(0, ...heights), max_m: Math.max(0, ...heights) };
}

/** Round values for an axis from `min` to `max`, about `count` of them: 1, 2 or 5 times a power of ten apart. */
export function ticks(min: number, max: number, count: number): number[] {
  const span = max - min;
  if (!(span > 0) || count < 1) return [min];
  const step = niceStep(span / count);
  const first = Math.ceil(min / step - 1e-9);
  const last = Math.floor(max / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, index) => (first + index) * step);
}

/** The smallest of 1, 2, 5 times a power of ten that is not below `value`. */
export function niceStep(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  for (const factor of [1, 2, 5]) if (factor * power >= value * (1 - 1e-9)) return factor * power;
  return 10 * power;
}
