/** A plan as it was flown in the core's rehearsal: where the plane is at any moment of it, and how far it has come. */

import { distance_m } from './geo';
import type { LonLat } from './lonlat';
import type { Profile } from './profile';

/** Moments of it, a list for each value. */
export interface Track {
  /** Since its beginning, growing. */
  readonly time_s: readonly number[];
  readonly lat_deg: readonly number[];
  readonly lon_deg: readonly number[];
  /** Above home. */
  readonly height_m: readonly number[];
  /** Of the ground below, above home; `null` where it is not known. */
  readonly ground_m: readonly (number | null)[];
  /** Equivalent. */
  readonly airspeed_m_s: readonly number[];
  readonly groundspeed_m_s: readonly number[];
  /** To the right positive. */
  readonly bank_deg: readonly number[];
  readonly heading_deg: readonly number[];
  /** Number of the item that is flown to, from 1; `null` in a return and after the landing. */
  readonly item: readonly (number | null)[];
}

/** One item on the way; jumps repeat them. */
export interface Passage {
  readonly item: number;
  readonly begins_s: number;
  readonly reached_s: number | null;
  readonly nearest_m: number | null;
}

/** Endings after which the plane is not where its pilot wants it. */
const DANGERS = ['ground', 'held', 'grounded', 'endless'];

export const endsInDanger = (rehearsal: { readonly ending: string } | null): boolean =>
  rehearsal !== null && DANGERS.includes(rehearsal.ending);

/** One moment, between those of the track. */
export interface Moment {
  readonly time_s: number;
  readonly at: LonLat;
  readonly height_m: number;
  readonly airspeed_m_s: number;
  readonly groundspeed_m_s: number;
  readonly bank_deg: number;
  readonly heading_deg: number;
  readonly item: number | null;
}

export function placesOf({ lat_deg, lon_deg }: Track): LonLat[] {
  return lat_deg.map((lat_deg, index) => ({ lat_deg, lon_deg: lon_deg[index] ?? 0 }));
}

/** Where a time lies in the track: the moment before it, and the part of the way to the next. */
function placeInTime(times_s: readonly number[], time_s: number): { index: number; part: number } {
  let [low, high] = [0, Math.max(0, times_s.length - 2)];
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if ((times_s[middle] ?? 0) <= time_s) low = middle;
    else high = middle - 1;
  }
  const [from_s = 0, to_s = 0] = [times_s[low], times_s[low + 1]];
  const part = to_s > from_s ? (time_s - from_s) / (to_s - from_s) : 0;
  return { index: low, part: Math.min(1, Math.max(0, part)) };
}

/** A value between two moments. */
function valueAt(values: readonly number[], { index, part }: { index: number; part: number }): number {
  const from = values[index] ?? 0;
  return from + ((values[index + 1] ?? from) - from) * part;
}

/** An angle between two moments, the shorter way round. */
function angleAt(values_deg: readonly number[], { index, part }: { index: number; part: number }): number {
  const from_deg = values_deg[index] ?? 0;
  const by_deg = (((values_deg[index + 1] ?? from_deg) - from_deg + 540) % 360) - 180;
  return (from_deg + by_deg * part + 360) % 360;
}

/** The moment at a time, which is kept within the track; `null` of an empty one. */
export function momentAt(track: Track, time_s: number): Moment | null {
  if (track.time_s.length === 0) return null;
  const place = placeInTime(track.time_s, time_s);
  const lon_deg = angleAt(track.lon_deg, place);
  return {
    time_s: valueAt(track.time_s, place),
    at: { lat_deg: valueAt(track.lat_deg, place), lon_deg: lon_deg > 180 ? lon_deg - 360 : lon_deg },
    height_m: valueAt(track.height_m, place),
    airspeed_m_s: valueAt(track.airspeed_m_s, place),
    groundspeed_m_s: valueAt(track.groundspeed_m_s, place),
    bank_deg: valueAt(track.bank_deg, place),
    heading_deg: angleAt(track.heading_deg, place),
    item: track.item[place.index + (place.part === 1 ? 1 : 0)] ?? null,
  };
}

/** The way in the profile at a time, metres. */
export const alongAt = (track: Track, along_m: readonly number[], time_s: number): number =>
  valueAt(along_m, placeInTime(track.time_s, time_s));

/** How near the flight comes to the ground, and where in the profile; `null` where the ground is nowhere known. */
export interface Nearness {
  readonly clearance_m: number;
  readonly distance_m: number;
}

/**
 * Where the flight is nearest to the ground, the climb to `enough_m` or the second item apart, and what is flown to items of `isLow`:
 * take-offs and landings.
 * `along_m` has the way of each moment in the profile.
 */
export function nearestToGround(
  { height_m, ground_m, item }: Track,
  along_m: readonly number[],
  enough_m: number,
  isLow: (item: number) => boolean,
): Nearness | null {
  let nearest: Nearness | null = null;
  let hasClimbed = false;
  let items = 0;
  let isApart = false;
  height_m.forEach((one_m, index) => {
    const number = item[index] ?? null;
    if (index > 0 && number !== (item[index - 1] ?? null)) items += 1;
    const below_m = ground_m[index] ?? null;
    if (below_m === null) return;
    const clearance_m = one_m - below_m;
    hasClimbed ||= clearance_m >= enough_m || items > 1;
    // what has landed rolls on to no item
    isApart = number === null ? isApart : isLow(number);
    if (!hasClimbed || isApart || clearance_m >= (nearest?.clearance_m ?? Number.POSITIVE_INFINITY)) return;
    nearest = { clearance_m, distance_m: along_m[index] ?? 0 };
  });
  return nearest;
}

/** The first passage of each item, by its number. */
export function firstPassages<Each extends Passage>(passages: readonly Each[]): Map<number, Each> {
  const first = new Map<number, Each>();
  for (const passage of passages) if (!first.has(passage.item)) first.set(passage.item, passage);
  return first;
}

const flownOf = new WeakMap<Track, readonly number[]>();

/** Distance flown until each moment of a track, metres; counted once, since profiles ask for it in each frame of a drag. */
function flownAlong(track: Track): readonly number[] {
  const known = flownOf.get(track);
  if (known !== undefined) return known;
  const places = placesOf(track);
  let total_m = 0;
  const flown_m = places.map((at, index) => (total_m += index === 0 ? 0 : distance_m(places[index - 1] ?? at, at)));
  flownOf.set(track, flown_m);
  return flown_m;
}

/**
 * Where each moment of a track stands in the profile of its plan, metres: by distance flown, with each item where the profile
 * has it, so that planned and flown heights of one place stand over each other. After a jump it goes back.
 */
export function alongProfile(track: Track, passages: readonly Passage[], profile: Profile): number[] {
  const flown_m = flownAlong(track);
  /** By item number: where its leg begins, and where it is done with. */
  const stretches = new Map<number, { from_m: number; to_m: number }>();
  let before_m = 0;
  profile.points.forEach(({ item, distance_m: to_m }, at) => {
    if (item !== null) {
      stretches.set(item, { from_m: before_m, to_m });
      if (profile.points[at + 1]?.item === item) return;
    }
    before_m = to_m;
  });
  const legs: { until_m: number; from_m: number; scale: number; flownFrom_m: number }[] = [];
  let begun_m = 0;
  let at_m = 0;
  for (const { item, reached_s } of passages) {
    const stretch = stretches.get(item);
    if (stretch === undefined) continue;
    const until_m = reached_s === null ? Infinity : valueAt(flown_m, placeInTime(track.time_s, reached_s));
    const isMapped = reached_s !== null && until_m > begun_m;
    const scale = isMapped ? (stretch.to_m - stretch.from_m) / (until_m - begun_m) : 1;
    legs.push({ until_m, from_m: stretch.from_m, scale, flownFrom_m: begun_m });
    [begun_m, at_m] = [until_m, stretch.to_m];
  }
  // what comes after the last item: a return, the run on the ground
  legs.push({ until_m: Infinity, from_m: at_m, scale: 1, flownFrom_m: begun_m });
  let leg = 0;
  return flown_m.map((way_m) => {
    while (way_m > (legs[leg]?.until_m ?? Infinity)) leg += 1;
    const { from_m, scale, flownFrom_m } = legs[leg] as (typeof legs)[number];
    return from_m + (way_m - flownFrom_m) * scale;
  });
}
