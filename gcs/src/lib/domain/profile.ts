/** The height profile of a mission: heights above home over the distance flown, circles included. */

import { altRelHome_m, type Home, heightFrameOf, kindOf, type PlanItem } from './plan';
import type { Loiter, Way } from './way';

export interface ProfilePoint {
  /** Index in the items; `null` for home at the beginning. */
  readonly index: number | null;
  /** Distance flown from the beginning, metres. */
  readonly distance_m: number;
  /** Height above home, metres. */
  readonly alt_rel_home_m: number;
  /** False when the height counts from the terrain or from sea level and home's height is not known: a guess. */
  readonly isCertain: boolean;
  /** Whether the item's own height is here: an item that circles has two points, and this holds for one. */
  readonly isItem: boolean;
  /** Whether it comes after a circle without end, and is flown only when a pilot goes on to it. */
  readonly isBeyond: boolean;
}

/** A stretch in which the plane circles at an item. */
export interface ProfileLoiter {
  readonly index: number;
  readonly kind: Loiter['kind'];
  readonly from_m: number;
  /** The same as `from_m` when it has no end or its length is not known. */
  readonly to_m: number;
  /** Whether its length is not known, though it has one. */
  readonly isUnknown: boolean;
  readonly alt_rel_home_m: number;
}

export interface Profile {
  readonly points: readonly ProfilePoint[];
  readonly loiters: readonly ProfileLoiter[];
  readonly length_m: number;
  readonly min_m: number;
  readonly max_m: number;
}

/**
 * Heights at the items along their way; jumps are not followed. `ground_m` gives the ground's height above home at an item, where it is
 * known.
 */
export function profileOf(
  items: readonly PlanItem[],
  home: Home | null,
  way: Way,
  ground_m: (index: number) => number | null = () => null,
): Profile {
  const points: ProfilePoint[] = [];
  const loiters: ProfileLoiter[] = [];
  let total_m = 0;
  let isBeyond = false;
  if (home !== null)
    points.push({ index: null, distance_m: 0, alt_rel_home_m: 0, isCertain: true, isItem: false, isBeyond });
  for (const { index, leg, loiter } of way.stops) {
    const item = items[index] as PlanItem;
    const before_m = points.at(-1)?.alt_rel_home_m ?? 0;
    total_m += leg?.length_m ?? 0;
    const isReturn = kindOf(item) === 'return_to_launch';
    // a return keeps a height that the vehicle is set to, which the plan does not tell
    const isOverGround = heightFrameOf(item) === 'terrain' && item.params[6] != null;
    const there = isOverGround ? ground_m(index) : null;
    const alt_m = isReturn ? null : there === null ? altRelHome_m(item, home) : there + (item.params[6] ?? 0);
    const guess_m = heightFrameOf(item) === 'terrain' ? (item.params[6] ?? 0) : before_m;
    const there_m = alt_m ?? guess_m;
    const point = { index, isCertain: alt_m !== null, isBeyond };
    if (loiter === null) {
      points.push({ ...point, distance_m: total_m, alt_rel_home_m: there_m, isItem: true });
      continue;
    }
    const arrival_m = before_m + (there_m - before_m) * loiter.changed_before;
    const isClimb = loiter.kind === 'height';
    points.push({ ...point, distance_m: total_m, alt_rel_home_m: arrival_m, isItem: !isClimb });
    const from_m = total_m;
    total_m += loiter.length_m ?? 0;
    if (isClimb || total_m > from_m)
      points.push({ ...point, distance_m: total_m, alt_rel_home_m: there_m, isItem: isClimb });
    loiters.push({
      index,
      kind: loiter.kind,
      from_m,
      to_m: total_m,
      isUnknown: loiter.length_m === null && loiter.kind !== 'unlimited',
      alt_rel_home_m: there_m,
    });
    isBeyond ||= loiter.kind === 'unlimited';
  }
  const heights = points.map((point) => point.alt_rel_home_m);
  return { points, loiters, length_m: total_m, min_m: Math.min(0, ...heights), max_m: Math.max(0, ...heights) };
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
