/** How a flight goes, beside the rehearsal of it from some moment before. */

import { bearing_deg, distance_m } from './geo';
import type { LonLat } from './lonlat';
import type { Track } from './rehearsal';

/** Farther from the expected track the plane is not on it: neither late nor low. */
const ASTRAY_M = 150;
/** Part of the battery that must be used, per cent, before its rate says anything. */
const LEAST_USED_PCT = 2;

/** Where the plane was expected. */
export interface Expected {
  readonly time_s: number;
  readonly height_m: number;
}

/** The moment at which the plane was expected where it is, on its way to this item; `null` away from that way. */
export function expectedAt(track: Track, at: LonLat, item: number | null): Expected | null {
  let best: (Expected & { readonly off_m: number }) | null = null;
  for (let index = 0; index + 1 < track.time_s.length; index += 1) {
    if (track.item[index] !== item) continue;
    const place = (which: number): LonLat => ({
      lat_deg: track.lat_deg[which] ?? 0,
      lon_deg: track.lon_deg[which] ?? 0,
    });
    const [from, to] = [place(index), place(index + 1)];
    const [leg_m, away_m] = [distance_m(from, to), distance_m(from, at)];
    const angle = ((bearing_deg(from, at) - bearing_deg(from, to)) * Math.PI) / 180;
    const part = leg_m > 0 ? Math.min(1, Math.max(0, (away_m * Math.cos(angle)) / leg_m)) : 0;
    // of the triangle from the leg's beginning: what is left to the place that is nearest
    const off_m = Math.hypot(away_m * Math.sin(angle), away_m * Math.cos(angle) - part * leg_m);
    if (off_m > ASTRAY_M || (best !== null && off_m >= best.off_m)) continue;
    const between = (values: readonly number[]): number => {
      const value = values[index] ?? 0;
      return value + ((values[index + 1] ?? value) - value) * part;
    };
    best = { off_m, time_s: between(track.time_s), height_m: between(track.height_m) };
  }
  return best;
}

/** What will be left of the battery, per cent, when it goes on as since it was `before_pct`; `null` while that says nothing. */
export function batteryLeft_pct(before_pct: number, now_pct: number, since_s: number, left_s: number): number | null {
  const used_pct = before_pct - now_pct;
  if (used_pct < LEAST_USED_PCT || since_s <= 0) return null;
  return Math.max(0, now_pct - (used_pct / since_s) * left_s);
}
