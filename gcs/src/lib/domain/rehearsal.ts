/** A plan as it was flown in the core's rehearsal: where the plane is at any moment of it, and how far it has come. */

import type { LonLat } from './lonlat';

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

/** The first passage of each item, by its number. */
export function firstPassages<Each extends Passage>(passages: readonly Each[]): Map<number, Each> {
  const first = new Map<number, Each>();
  for (const passage of passages) if (!first.has(passage.item)) first.set(passage.item, passage);
  return first;
}
