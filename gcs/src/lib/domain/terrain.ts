/** The ground below a plan: where to ask for its height, and how far above it the plane passes. Heights of ground are above mean sea level. */

import { bearing_deg, between, destination, distance_m, length_m } from './geo';
import { type LonLat, wrap360_deg } from './lonlat';
import { altRelHome_m, type Home, heightFrameOf, type PlanItem, placeOf } from './plan';
import type { Loiter, Way } from './way';

/**
 * So much may terrain data be off, metres: SRTM's absolute error stays below 16 m for nine of ten points and is mostly half of that
 * (Rodríguez et al. 2006). A take-off that it puts into the ground by less says nothing.
 */
const TERRAIN_ERROR_M = 10;

/** A place of the route, at which the ground's height is asked for. */
export interface RoutePoint {
  readonly at: LonLat;
  /** Distance flown from the beginning, as in the height profile, metres. */
  readonly distance_m: number;
  /** The items that the leg comes from (`null`: home) and goes to, and how much of the change of height is done there, 0 to 1. */
  readonly fromIndex: number | null;
  readonly toIndex: number;
  readonly changed: number;
  /** Leaving home and coming in to land a plane is low on purpose. */
  readonly isLow: boolean;
}

export interface GroundPoint {
  readonly distance_m: number;
  /** The item that the leg goes to. */
  readonly toIndex: number;
  /** `null` where the ground's height is not known. */
  readonly ground_rel_home_m: number | null;
  /** How far above the ground the plane passes; `null` where that is not known. */
  readonly clearance_m: number | null;
  readonly isTooLow: boolean;
}

export interface Ground {
  readonly points: readonly GroundPoint[];
  /** Where the plane is nearest to the ground, take-off and landing apart; `null` when it is nowhere known. */
  readonly lowest: GroundPoint | null;
  /** The first place of each stretch that is too low. */
  readonly tooLow: readonly GroundPoint[];
  /** Points without a height. */
  readonly unknown: number;
}

/** Places of the way, circles included, at most `most` and not nearer than 10 m to each other, ends of legs included. */
export function routePoints(items: readonly PlanItem[], { stops }: Way, most = 400): RoutePoint[] {
  const total_m = stops.reduce((sum, { leg, loiter }) => sum + (leg?.length_m ?? 0) + (loiter?.length_m ?? 0), 0);
  const step_m = Math.max(10, total_m / Math.max(1, most - 2 * stops.length));
  const points: RoutePoint[] = [];
  let begin_m = 0;
  for (const { index: toIndex, leg, loiter } of stops) {
    const line = leg?.line;
    const changedBefore = loiter?.changed_before ?? 1;
    if (leg !== null && line !== undefined) {
      const pieces = Math.max(1, Math.ceil(leg.length_m / step_m));
      const isLow = leg.fromIndex === null || leg.kind === 'approach';
      alongLine(line, pieces).forEach((at, index) => {
        const part = index / pieces;
        points.push({
          at,
          distance_m: begin_m + leg.length_m * part,
          fromIndex: leg.fromIndex,
          toIndex,
          changed: part === 1 ? changedBefore : part * changedBefore,
          isLow,
        });
      });
      begin_m += leg.length_m;
    }
    const centre = placeOf(items[toIndex] as PlanItem);
    if (loiter === null || centre === null) continue;
    // an endless circle has no length in the profile, but ground below it
    const flown_m = loiter.length_m ?? 2 * Math.PI * loiter.radius_m;
    const pieces = flown_m > 0 ? Math.max(8, Math.min(200, Math.ceil(flown_m / step_m))) : 0;
    roundCircle(centre, loiter, line?.at(-1) ?? null, flown_m, pieces).forEach((at, index) => {
      const part = (index + 1) / pieces;
      points.push({
        at,
        distance_m: begin_m + (loiter.length_m ?? 0) * part,
        fromIndex: leg?.fromIndex ?? null,
        toIndex,
        changed: part === 1 ? 1 : changedBefore + (1 - changedBefore) * part,
        isLow: false,
      });
    });
    begin_m += loiter.length_m ?? 0;
  }
  return points.length <= 2000 ? points : points.filter((_, index) => index % Math.ceil(points.length / 2000) === 0);
}

/** `pieces` places, evenly spaced, of a way round a circle that begins at `from`. */
function roundCircle(
  centre: LonLat,
  { radius_m, is_clockwise }: Loiter,
  from: LonLat | null,
  flown_m: number,
  pieces: number,
): LonLat[] {
  const begin_deg = from === null ? 0 : bearing_deg(centre, from);
  const turned_deg = ((flown_m / radius_m) * 180) / Math.PI / Math.max(1, pieces);
  return Array.from({ length: pieces }, (_, index) =>
    destination(centre, wrap360_deg(begin_deg + (is_clockwise ? 1 : -1) * turned_deg * (index + 1)), radius_m),
  );
}

/** `pieces` + 1 places, evenly spaced, of a line. */
function alongLine(line: readonly LonLat[], pieces: number): LonLat[] {
  const whole_m = length_m(line);
  const places: LonLat[] = [];
  let index = 1;
  let passed_m = 0;
  for (let piece = 0; piece <= pieces; piece += 1) {
    const wanted_m = (whole_m * piece) / pieces;
    let [from, to] = [line[index - 1], line[index]];
    let stretch_m = from && to ? distance_m(from, to) : 0;
    while (index < line.length - 1 && passed_m + stretch_m < wanted_m) {
      passed_m += stretch_m;
      index += 1;
      [from, to] = [line[index - 1], line[index]];
      stretch_m = from && to ? distance_m(from, to) : 0;
    }
    if (!from || !to) continue;
    places.push(piece === pieces ? to : stretch_m > 0 ? between(from, to, (wanted_m - passed_m) / stretch_m) : from);
  }
  return places;
}

/**
 * The ground below the route, and the plane's height above it. Between items the plane's height changes evenly; on the
 * way to an item whose height counts from the terrain, its height above the ground does.
 *
 * `heights_amsl_m` has one for each point; `clearance_m` is the height above ground that should be kept.
 */
export function groundOf(
  items: readonly PlanItem[],
  home: Home | null,
  points: readonly RoutePoint[],
  heights_amsl_m: readonly (number | null)[],
  clearance_m: number,
): Ground {
  if (home === null) return { points: [], lowest: null, tooLow: [], unknown: points.length };
  // The plane stands on the ground at home: what a map is off there it is off everywhere, as for ArduPlane and the rehearsal.
  const base_m = (points[0]?.fromIndex === null ? heights_amsl_m[0] : null) ?? home.alt_amsl_m;
  const found: GroundPoint[] = [];
  let lowest: GroundPoint | null = null;
  const tooLow: GroundPoint[] = [];
  let unknown = 0;
  /** Heights at the beginning of the leg: above home and above ground. */
  let begin: Height = { rel_home_m: 0, ground_m: 0 };
  for (const [index, point] of points.entries()) {
    const ground_amsl_m = heights_amsl_m[index] ?? null;
    if (ground_amsl_m === null) unknown += 1;
    const ground_m = ground_amsl_m === null ? null : ground_amsl_m - base_m;
    const item = items[point.toIndex];
    if (item === undefined) continue;
    if (points[index - 1]?.toIndex !== point.toIndex) {
      const from = point.fromIndex === null ? undefined : items[point.fromIndex];
      const rel_home_m = from === undefined ? 0 : targetRelHome_m(from, home, begin, ground_m);
      begin = { rel_home_m, ground_m: rel_home_m === null || ground_m === null ? null : rel_home_m - ground_m };
    }
    const above_m = ground_m === null ? null : clearanceAt(item, home, begin, point.changed, ground_m);
    const isTooLow = above_m !== null && above_m < (point.isLow ? -TERRAIN_ERROR_M : clearance_m);
    const one: GroundPoint = {
      distance_m: point.distance_m,
      toIndex: point.toIndex,
      ground_rel_home_m: ground_m,
      clearance_m: above_m,
      isTooLow,
    };
    if (isTooLow && !found.at(-1)?.isTooLow) tooLow.push(one);
    if (above_m !== null && !point.isLow && above_m < (lowest?.clearance_m ?? Number.POSITIVE_INFINITY)) lowest = one;
    found.push(one);
  }
  return { points: found, lowest, tooLow, unknown };
}

interface Height {
  readonly rel_home_m: number | null;
  readonly ground_m: number | null;
}

/** Height above home at the end of the leg to an item. */
function targetRelHome_m(item: PlanItem, home: Home, begin: Height, ground_m: number | null): number | null {
  if (heightFrameOf(item) === 'terrain' && item.params[6] != null) {
    return ground_m === null ? null : ground_m + item.params[6];
  }
  // a return home keeps the height that the vehicle is set to, which the plan does not tell
  return altRelHome_m(item, home) ?? begin.rel_home_m;
}

function clearanceAt(item: PlanItem, home: Home, begin: Height, changed: number, ground_m: number): number | null {
  if (heightFrameOf(item) === 'terrain' && item.params[6] != null) {
    const target_m = item.params[6];
    return begin.ground_m === null
      ? changed === 1
        ? target_m
        : null
      : begin.ground_m + (target_m - begin.ground_m) * changed;
  }
  const target_m = targetRelHome_m(item, home, begin, ground_m);
  if (target_m === null || begin.rel_home_m === null)
    return changed === 1 && target_m !== null ? target_m - ground_m : null;
  return begin.rel_home_m + (target_m - begin.rel_home_m) * changed - ground_m;
}
