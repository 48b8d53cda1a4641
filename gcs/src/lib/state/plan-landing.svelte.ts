// The landing that ends the plan: designed by the core, on a point or a runway, and moved by its parts.
import type { LandingRequest } from '$lib/api/types';
import { distance_m } from '$lib/domain/geo';
import type { LonLat } from '$lib/domain/lonlat';
import { altOf_m, emptyPlan, type PlanItem, placeOf } from '$lib/domain/plan';
import {
  addLanding,
  changeLanding,
  designedLanding,
  type DraftItem,
  landingPart,
  type LandingPart,
  moveTo,
} from '$lib/domain/plan-edit';
import { elevation } from './maps-elevation.svelte';
import { plan } from './plan.svelte';
import { planWind } from './plan-wind.svelte';
import { api, problemFrom } from './station.svelte';
import { vehicles } from './vehicles.svelte';

/** A line to land on, in either direction. */
export interface Runway {
  readonly begin: LonLat;
  readonly end: LonLat;
}

/** A part of the landing under a pointer. */
interface LandingDrag {
  readonly part: LandingPart;
  readonly key: number;
  /** The landing as it was before. */
  readonly items: readonly PlanItem[];
  readonly to: LonLat;
  readonly isEnd: boolean;
  /** The plan's generation in which it began. */
  readonly generation: number;
}

class PlanLanding {
  #run = 0;
  /** Whether the core is at work on a landing that was asked for. */
  isDesigning = $state(false);
  /** The runway that the landing was last designed for. */
  #runway = $state.raw<Runway | null>(null);
  /** The end of a runway that was clicked first. */
  runwayBegin = $state.raw<LonLat | null>(null);
  #drag: LandingDrag | null = null;
  #isMoving = false;

  /** One end of a runway, then the other: the mission is to land there, into the wind. */
  markRunway(at: LonLat): void {
    const begin = this.runwayBegin;
    this.runwayBegin = begin === null ? placeOnly(at) : null;
    if (begin === null) return;
    plan.tool = 'waypoint';
    plan.waitFor(this.land(at, { begin, end: placeOnly(at) }));
  }

  /** Ends the mission with a landing as the core designs it; of two that are asked for in a row the last one counts. */
  async land(at: LonLat, runway: Runway | null = null): Promise<void> {
    const run = ++this.#run;
    const { generation } = plan;
    this.isDesigning = true;
    try {
      plan.problem = null;
      const { items } = await api.designLanding(this.#request(at, runway, null));
      if (run !== this.#run || generation !== plan.generation) return;
      this.#runway = runway;
      this.#endWith(items);
    } catch (error) {
      if (run === this.#run) plan.problem = problemFrom(error);
    } finally {
      if (run === this.#run) this.isDesigning = false;
    }
  }

  /** Ends the mission with a landing, without waiting for the core to recognise it. */
  #endWith(landing: readonly PlanItem[]): void {
    let keys: readonly number[] = [];
    plan.addWith((draft) => {
      const added = addLanding(draft, landing, plan.end);
      keys = added.keys;
      return added;
    });
    plan.end = { keys: new Set(keys), designed: keys };
  }

  /** A request for a landing in place of the one that ends the mission; `null` without one. */
  landingHere(): LandingRequest | null {
    const land = this.landing.at(-1);
    const at = land ? placeOf(land) : null;
    if (land === undefined || at === null) return null;
    return this.#request(at, this.runway, altOf_m(land));
  }

  /** A landing that ends this plan in its wind; the server lays it out for the vehicle. */
  #request(at: LonLat, runway: Runway | null, ground_rel_home_m: number | null): LandingRequest {
    const vehicle = vehicles.selected?.systemId ?? null;
    const { items, home } = plan.asApi();
    return {
      at: runway === null ? placeOnly(at) : null,
      runway,
      wind: planWind.known,
      ground_rel_home_m,
      plan: { ...emptyPlan(), items, home },
      vehicle,
      // not known yet whether the vehicle would arm with a DO_LAND_START
      has_land_start: vehicle === null ? false : null,
    };
  }

  #aboveHome_m(ground_amsl_m: number | null): number | null {
    return ground_amsl_m === null || plan.home === null ? null : ground_amsl_m - plan.home.alt_amsl_m;
  }

  /** The landing that ends the mission, where it is of the designed kind. */
  landing = $derived<readonly DraftItem[]>(designedLanding(plan.draft, plan.end));

  /** The runway that the mission lands on; `null` for a landing at a point, as one that was dragged away, or came back by undo. */
  runway = $derived.by<Runway | null>(() => {
    const land = this.landing.at(-1);
    const at = land ? placeOf(land) : null;
    const runway = this.#runway;
    return runway !== null && at !== null && beside_m(runway, at) < 0.5 ? runway : null;
  });

  /** Replaces it by another landing. */
  takeLanding(items: readonly PlanItem[]): void {
    plan.edit((draft) => changeLanding(draft, items, plan.end));
  }

  /** One part of the landing is dragged; the server lets the rest follow, and the last place that it was dragged to counts. */
  async #followDrag(): Promise<void> {
    if (this.#isMoving) return;
    this.#isMoving = true;
    let drag = this.#drag;
    try {
      while (drag !== null) {
        const { part, key, items, to, isEnd }: LandingDrag = drag;
        const ground = isEnd && part === 'point' && elevation.isKnowable ? await elevation.at(to) : null;
        const moved = await api.moveLanding({
          items: items.map(({ command, name, frame, params, autocontinue }) => {
            return { command, name, frame, params, autocontinue };
          }),
          part,
          to: placeOnly(to),
          wind: planWind.known,
          ground_rel_home_m: this.#aboveHome_m(ground?.alt_amsl_m ?? null),
          vehicle: vehicles.selected?.systemId ?? null,
        });
        const latest: LandingDrag | null = this.#drag;
        if (drag.generation !== plan.generation) {
          drag = latest === drag ? null : latest;
          continue;
        }
        plan.edit((draft) => {
          if (landingPart(draft, key, plan.end) !== part) return draft;
          const next = changeLanding(draft, moved.items, plan.end);
          // what is under the pointer stays there, however old the answer
          return latest === drag || latest?.key !== key ? next : moveTo(next, key, latest.to);
        }, `drag-${key}`);
        drag = latest === drag ? null : latest;
      }
      plan.problem = null;
    } catch (error) {
      plan.problem = problemFrom(error);
      const before = drag;
      if (before?.generation === plan.generation)
        plan.edit((draft) => changeLanding(draft, before.items, plan.end), `drag-${before.key}`);
    } finally {
      this.#isMoving = false;
      if (this.#drag?.isEnd === true) {
        this.#drag = null;
        plan.seal();
      }
    }
  }

  /** Moves a part of the landing, as a pointer drags it. */
  drag(part: LandingPart, key: number, from: LonLat, to: LonLat, isEnd: boolean): void {
    const { generation } = plan;
    const isSame = this.#drag?.key === key && !this.#drag.isEnd && this.#drag.generation === generation;
    const before = isSame ? this.#drag : null;
    const item = plan.items.find((one) => one.key === key);
    const at = before?.to ?? (item ? placeOf(item) : null);
    if (at === null) return;
    const there = {
      lat_deg: Math.max(-90, Math.min(90, at.lat_deg + to.lat_deg - from.lat_deg)),
      lon_deg: at.lon_deg + to.lon_deg - from.lon_deg,
    };
    this.#drag = { part, key, items: before?.items ?? this.landing, to: there, isEnd, generation };
    plan.edit((draft) => moveTo(draft, key, there), `drag-${key}`);
    plan.waitFor(this.#followDrag());
  }
}

/** How much longer the way over a place is than the runway. */
const beside_m = ({ begin, end }: Runway, at: LonLat): number =>
  distance_m(begin, at) + distance_m(at, end) - distance_m(begin, end);

const placeOnly = ({ lat_deg, lon_deg }: LonLat): LonLat => ({ lat_deg, lon_deg });

export const planLanding = new PlanLanding();
