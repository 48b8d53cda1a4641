// Ground elevation at the pointer and under the plane; null where unknown.
import type { ElevationPoint } from '$lib/api/maps-types';
import { distance_m } from '$lib/domain/geo';
import type { LonLat } from '$lib/domain/lonlat';
import { maps, mapsApi } from './maps.svelte';
import { load, save } from './stored';

/** Questions within this time go together. */
const GATHER_MS = 60;
/** Terrain data are 10 m to 90 m apart: nearer than this the ground is the same. */
const SAME_M = 12;
/** Answers that are kept, and for how long one that is not known is believed. */
const KEPT = 4000;
const UNKNOWN_MS = 10_000;
/** Default height above ground that a plan should keep. */
const DEFAULT_CLEARANCE_M = 30;

const UNKNOWN: ElevationPoint = { alt_amsl_m: null, source: null, resolution_m: null, datum: null };

interface Answer {
  readonly point: ElevationPoint;
  readonly at_ms: number;
}

class Elevation {
  /** Whether there is anything to ask. */
  isKnowable = $derived(maps.elevations.some((source) => !['invalid', 'set_aside'].includes(source.state.status)));
  /** Ground at the pointer, metres above mean sea level. */
  pointer_m = $state<number | null>(null);
  /** Where the height at the pointer comes from. */
  pointerSource = $state<string | null>(null);
  /** Ground under the plane, metres above mean sea level. */
  under_m = $state<number | null>(null);
  #clearance_m = $state(
    load('maps-clearance', DEFAULT_CLEARANCE_M, (value) =>
      typeof value === 'number' && value >= 0 && value <= 1000 ? value : null,
    ),
  );

  readonly #answers = new Map<string, Answer>();
  #gathering: { at: LonLat; resolve: (point: ElevationPoint) => void }[] = [];
  #pointer: LonLat | null = null;
  #plane: LonLat | null = null;

  get clearance_m(): number {
    return this.#clearance_m;
  }
  set clearance_m(value_m: number) {
    this.#clearance_m = value_m;
    save('maps-clearance', value_m);
  }

  setPointer(at: LonLat | null): void {
    this.#pointer = at;
    if (at === null || !this.isKnowable) {
      this.pointer_m = null;
      this.pointerSource = null;
      return;
    }
    void this.at(at).then((point) => {
      // the pointer has gone on
      if (this.#pointer !== at) return;
      this.pointer_m = point.alt_amsl_m ?? null;
      this.pointerSource = point.source ?? null;
    });
  }

  /** Sets the plane's position; may be called often. */
  setPlane(at: LonLat | null): void {
    if (at === null || !this.isKnowable) {
      this.#plane = null;
      this.under_m = null;
      return;
    }
    if (this.#plane !== null && distance_m(this.#plane, at) < SAME_M) return;
    this.#plane = at;
    void this.at(at).then((point) => {
      if (this.#plane === at) this.under_m = point.alt_amsl_m ?? null;
      // not known now may be known later
      if (this.#plane === at && point.alt_amsl_m == null) this.#plane = null;
    });
  }

  /** Height above the ground under the plane, metres; `null` while either is not known. */
  above(alt_amsl_m: number | null | undefined): number | null {
    return alt_amsl_m == null || this.under_m === null ? null : alt_amsl_m - this.under_m;
  }

  /** Height of the ground at a place; asked for together with others. */
  at(at: LonLat): Promise<ElevationPoint> {
    const known = this.#answers.get(keyOf(at));
    if (known && (known.point.alt_amsl_m != null || performance.now() - known.at_ms < UNKNOWN_MS)) {
      return Promise.resolve(known.point);
    }
    return new Promise((resolve) => {
      if (this.#gathering.length === 0) setTimeout(() => void this.#ask(), GATHER_MS);
      // a moving pointer asks again before it is answered
      this.#gathering.push({ at, resolve });
    });
  }

  async #ask(): Promise<void> {
    const asked = this.#gathering.splice(0, 2000);
    let points: readonly ElevationPoint[] = [];
    try {
      ({ points } = await mapsApi.elevation(asked.map(({ at: { lat_deg, lon_deg } }) => ({ lat_deg, lon_deg }))));
    } catch {
      // no answer is an unknown height; asked again later
    }
    const at_ms = performance.now();
    asked.forEach(({ at, resolve }, index) => {
      const point = points[index] ?? UNKNOWN;
      this.#answers.set(keyOf(at), { point, at_ms });
      resolve(point);
    });
    for (const key of this.#answers.keys()) {
      if (this.#answers.size <= KEPT) break;
      this.#answers.delete(key);
    }
  }
}

/** About ten metres. */
const keyOf = ({ lat_deg, lon_deg }: LonLat): string => `${lat_deg.toFixed(4)},${lon_deg.toFixed(4)}`;

export const elevation = new Elevation();
