// Parts of the world that are kept for a field without a network: those that there are, and the one being drawn.
import type { Area, AreaEstimate, AreaShape, MapSource } from '$lib/api/maps-types';
import { problemFrom } from '$lib/api/problem';
import type { Problem } from '$lib/api/types';
import type { LonLat } from '$lib/domain/lonlat';
import { placeOf } from '$lib/domain/plan';
import { placesFlown } from '$lib/domain/way';
import { type Box, boxCorners, boxOf } from '$lib/domain/tiling';
import { mapsApi } from './maps.svelte';
import { plan } from './plan.svelte';
import { planCompared } from './plan-compared.svelte';
import { vehicles } from './vehicles.svelte';

export type DraftShape = 'plan' | 'view' | 'box' | 'polygon';

const ESTIMATE_MS = 350;
/** Corners that a polygon may have. */
const MOST_CORNERS = 200;

class OfflineAreas {
  areas = $state.raw<readonly Area[]>([]);
  problem = $state.raw<Problem | null>(null);
  isLoaded = $state(false);

  /** Whether one is being made. */
  isDrafting = $state(false);
  shape = $state<DraftShape>('plan');
  points = $state.raw<readonly LonLat[]>([]);
  buffer_m = $state(500);
  estimate = $state.raw<AreaEstimate | null>(null);
  estimateProblem = $state.raw<Problem | null>(null);
  isEstimating = $state(false);
  #estimateTimer: ReturnType<typeof setTimeout> | undefined;
  #asked = 0;

  /** What the draft covers; `null` until enough is drawn. */
  drawn = $derived.by<AreaShape | null>(() => {
    if (this.shape === 'plan') {
      const places = planPlaces();
      return places.length === 0 ? null : { kind: 'route', points: places, buffer_m: this.buffer_m };
    }
    const [a, b] = this.points;
    if (this.shape === 'polygon') {
      const points = this.points.map(({ lat_deg, lon_deg }) => ({ lat_deg, lon_deg }));
      return points.length < 3 ? null : { kind: 'polygon', points };
    }
    return a === undefined || b === undefined ? null : { kind: 'box', ...boxOf(a, b) };
  });

  async load(): Promise<void> {
    try {
      this.areas = await mapsApi.areas();
      this.problem = null;
      this.isLoaded = true;
    } catch (error) {
      this.problem = problemFrom(error);
    }
  }

  // --- The draft ----------------------------------------------------------------------------------------------------

  begin(shape: DraftShape, view: Box | null): void {
    this.isDrafting = true;
    this.shape = shape;
    this.estimate = null;
    this.estimateProblem = null;
    this.points = [];
    if (shape === 'view' && view !== null) {
      const [northWest, , southEast] = boxCorners(view);
      if (northWest && southEast) this.points = [northWest, southEast];
    }
  }

  end(): void {
    this.isDrafting = false;
    this.points = [];
    this.estimate = null;
    clearTimeout(this.#estimateTimer);
  }

  /** Whether a click on the map belongs to the draft. */
  get takesClicks(): boolean {
    if (!this.isDrafting) return false;
    return this.shape === 'polygon'
      ? this.points.length < MOST_CORNERS
      : this.shape === 'box' && this.points.length < 2;
  }

  click(at: LonLat): void {
    if (this.takesClicks) this.points = [...this.points, at];
  }

  move(index: number, to: LonLat): void {
    this.points = this.points.with(index, to);
  }

  removeLast(): void {
    this.points = this.points.slice(0, -1);
  }

  /** Asks what the draft would cost, when it has been left alone for a moment. */
  ask(source: MapSource, min_level: number, max_level: number): void {
    clearTimeout(this.#estimateTimer);
    // an answer under way is about what was drawn before
    this.#asked += 1;
    const shape = this.drawn;
    if (shape === null) {
      this.estimate = null;
      this.isEstimating = false;
      return;
    }
    this.isEstimating = true;
    const asked = this.#asked;
    this.#estimateTimer = setTimeout(async () => {
      let [estimate, problem]: [AreaEstimate | null, Problem | null] = [null, null];
      try {
        estimate = await mapsApi.estimateArea({ source: source.id, name: '', shape, min_level, max_level });
      } catch (error) {
        problem = problemFrom(error);
      }
      if (asked !== this.#asked) return;
      this.estimate = estimate;
      this.estimateProblem = problem;
      this.isEstimating = false;
    }, ESTIMATE_MS);
  }

  async download(source: MapSource, name: string, min_level: number, max_level: number): Promise<void> {
    const shape = this.drawn;
    if (shape === null) return;
    await mapsApi.addArea({ source: source.id, name, shape, min_level, max_level });
    this.end();
    await this.load();
  }

  async act(call: () => Promise<unknown>): Promise<void> {
    try {
      await call();
      await this.load();
    } catch (error) {
      this.problem = problemFrom(error);
    }
  }

  pause = (area: Area) => this.act(() => mapsApi.pauseArea(area.id));
  resume = (area: Area) => this.act(() => mapsApi.resumeArea(area.id));
  remove = (area: Area) => this.act(() => mapsApi.removeArea(area.id));
  import = (source: MapSource, file: File) => this.act(() => mapsApi.importArea(source.id, file));
}

/** The places that the plan goes through, in turn; without a plan, home. */
function planPlaces(): LonLat[] {
  const items = plan.items.length > 0 ? plan.items : (planCompared.vehiclePlan?.items ?? []);
  const flown = placesFlown(items, plan.home, vehicles.route.fliesArcs).map(({ at }) => at);
  const places = [plan.home, ...(flown.length > 0 ? flown : [items.map(placeOf).find((at) => at !== null)])];
  return places.flatMap((at) => (at == null ? [] : [{ lat_deg: at.lat_deg, lon_deg: at.lon_deg }]));
}

export const offlineAreas = new OfflineAreas();
