/**
 * The trail that a plane has flown. Kept in typed arrays: tens of thousands of points are drawn from here without ever
 * becoming objects.
 */

import { type LonLat, wrap180_deg } from './lonlat';

/** Points kept; the oldest go first. At 20 Hz and one point in 3 m that is two hours of flight. */
export const TRAIL_POINTS = 50_000;

/** Metres per degree of latitude; good enough to tell whether the plane has moved. */
const M_PER_DEG = 111_195;

/** Points for which there is room at first; it is doubled up to the capacity. */
const FIRST_POINTS = 1024;

/** A ring buffer of positions with heights. */
export class Trail {
  readonly capacity: number;
  /** Nearer points are not kept, metres. */
  readonly spacing_m: number;
  #lon_deg: Float64Array;
  #lat_deg: Float64Array;
  #alt_m: Float32Array;
  /** Where the next point goes. */
  #next = 0;
  #count = 0;
  #added = 0;
  #flown_m = 0;

  constructor(capacity = TRAIL_POINTS, spacing_m = 3) {
    this.capacity = capacity;
    this.spacing_m = spacing_m;
    const room = Math.min(capacity, FIRST_POINTS);
    this.#lon_deg = new Float64Array(room);
    this.#lat_deg = new Float64Array(room);
    this.#alt_m = new Float32Array(room);
  }

  get length(): number {
    return this.#count;
  }

  /** Points ever added; grows with each one kept, so a drawing knows what is new to it. */
  get added(): number {
    return this.#added;
  }

  /** Length of the way over the points that are kept, metres, climbs and descents included. */
  get flown_m(): number {
    return this.#flown_m;
  }

  /** Adds a point unless it is nearer than `spacing_m` to the last; says whether it was kept. */
  add(at: LonLat, alt_m: number): boolean {
    const step_m = this.#count === 0 ? 0 : this.#distance_m(this.#count - 1, at, alt_m);
    if (this.#count > 0 && step_m < this.spacing_m) return false;
    this.#flown_m += step_m;
    if (this.#count === this.capacity && this.capacity > 1) {
      // the oldest goes, and the way from it to the next
      this.#flown_m -= this.#distance_m(0, this.#place(1), this.alt_m(1));
    }
    if (this.#next === this.#alt_m.length) this.#grow();
    this.#lon_deg[this.#next] = at.lon_deg;
    this.#lat_deg[this.#next] = at.lat_deg;
    this.#alt_m[this.#next] = alt_m;
    this.#next = (this.#next + 1) % this.capacity;
    this.#count = Math.min(this.#count + 1, this.capacity);
    this.#added += 1;
    return true;
  }

  /** Only a trail that has never been full grows: its points are in order. */
  #grow(): void {
    const room = Math.min(this.capacity, 2 * this.#alt_m.length);
    const [lon_deg, lat_deg, alt_m] = [new Float64Array(room), new Float64Array(room), new Float32Array(room)];
    lon_deg.set(this.#lon_deg);
    lat_deg.set(this.#lat_deg);
    alt_m.set(this.#alt_m);
    [this.#lon_deg, this.#lat_deg, this.#alt_m] = [lon_deg, lat_deg, alt_m];
  }

  clear(): void {
    this.#next = 0;
    this.#count = 0;
    this.#flown_m = 0;
    this.#added += 1;
  }

  /** Longitude of point `index`, 0 the oldest. */
  lon_deg(index: number): number {
    return this.#lon_deg[this.#slot(index)] as number;
  }

  lat_deg(index: number): number {
    return this.#lat_deg[this.#slot(index)] as number;
  }

  alt_m(index: number): number {
    return this.#alt_m[this.#slot(index)] as number;
  }

  #slot(index: number): number {
    return (this.#next - this.#count + index + this.capacity) % this.capacity;
  }

  #place(index: number): LonLat {
    return { lon_deg: this.lon_deg(index), lat_deg: this.lat_deg(index) };
  }

  /** From point `index`. Flat, which points of one trail are near enough for. */
  #distance_m(index: number, at: LonLat, alt_m: number): number {
    const north_m = (at.lat_deg - this.lat_deg(index)) * M_PER_DEG;
    const east_m = wrap180_deg(at.lon_deg - this.lon_deg(index)) * M_PER_DEG * Math.cos((at.lat_deg * Math.PI) / 180);
    return Math.hypot(north_m, east_m, alt_m - this.alt_m(index));
  }

  /** The trail as text for the browser's storage: 10 bytes a point, degE7 and decimetres, in base64. */
  serialize(maxPoints = this.capacity): string {
    const begin = Math.max(0, this.#count - maxPoints);
    const bytes = new Uint8Array((this.#count - begin) * BYTES_PER_POINT);
    const view = new DataView(bytes.buffer);
    for (let index = begin; index < this.#count; index += 1) {
      const at = (index - begin) * BYTES_PER_POINT;
      view.setInt32(at, Math.round(this.lon_deg(index) * 1e7), true);
      view.setInt32(at + 4, Math.round(this.lat_deg(index) * 1e7), true);
      view.setInt16(at + 8, Math.max(-32_768, Math.min(32_767, Math.round(this.alt_m(index) * 10))), true);
    }
    let text = '';
    for (let at = 0; at < bytes.length; at += 8190) text += String.fromCharCode(...bytes.subarray(at, at + 8190));
    return btoa(text);
  }

  /** Puts back what `serialize` gave; anything else leaves the trail empty. */
  restore(text: string): void {
    this.clear();
    let binary: string;
    try {
      binary = atob(text);
    } catch {
      return;
    }
    if (binary.length % BYTES_PER_POINT !== 0) return;
    const view = new DataView(Uint8Array.from(binary, (char) => char.charCodeAt(0)).buffer);
    for (let at = 0; at < binary.length; at += BYTES_PER_POINT) {
      const [lon_deg, lat_deg] = [view.getInt32(at, true) / 1e7, view.getInt32(at + 4, true) / 1e7];
      if (Math.abs(lon_deg) <= 180 && Math.abs(lat_deg) <= 90)
        this.add({ lon_deg, lat_deg }, view.getInt16(at + 8, true) / 10);
    }
  }
}

const BYTES_PER_POINT = 10;
