// The rest of the mission being flown, rehearsed from the present position, compared with the forecast at its beginning.
import type { Beginning, Outlook as Told, RehearsedFlight, WhatIfs } from '$lib/api/types';
import { CALM, estimateOf, planWind } from './plan-wind.svelte';
import { planeProfile } from './plane-profile.svelte';
import { api } from './station.svelte';
import { type Vehicle, vehicles } from './vehicles.svelte';

/** Where the wind of a rehearsal is from: the vehicle's own estimate; of one that has none, what a pilot set, or no wind. */
type WindFrom = 'vehicle' | 'pilot' | 'nobody';

function windFrom(vehicle: Vehicle): WindFrom {
  if (estimateOf(vehicle) !== null) return 'vehicle';
  return vehicle === vehicles.selected && planWind.isChosen ? 'pilot' : 'nobody';
}

/** Flies the rest of its mission from where it was last heard to be, and leaves that to its ghost; `null` when it flies none. */
async function rehearseRest(vehicle: Vehicle, begun: Beginning | null = null): Promise<WhatIfs> {
  const from_ms = vehicle.placed_ms;
  const chosen = windFrom(vehicle) === 'pilot' ? planWind.wind : CALM;
  const rest = await api.whatIf({
    vehicle: vehicle.systemId,
    wind: estimateOf(vehicle) ?? chosen,
    triggers: [],
    profile: vehicle === vehicles.selected ? planeProfile.asked : {},
    begun,
  });
  vehicle.rest = rest.ahead === null || from_ms === null ? null : { track: rest.ahead.track, from_ms };
  return rest;
}

/** Between two rehearsals of the rest. */
const ASK_MS = 2000;

/** The outlook; unknown values are `null`. */
export interface Outlook extends Told {
  readonly flight: RehearsedFlight;
  readonly windFrom: WindFrom;
  /** When the forecast was made; `null` without one, because it is not known how much of the circle was flown. */
  readonly since: Date | null;
}

/** The outlook at its very beginning: no deviation is known yet. */
const AS_EXPECTED: Told = { late_s: null, low_m: null, battery_pct: null };

class Ahead {
  /** Of the selected vehicle; `null` while it flies no mission. */
  outlook = $state.raw<Outlook | null>(null);
  /** The vehicle whose mission's rest is rehearsed. */
  flying = $derived.by<Vehicle | null>(() => {
    const vehicle = vehicles.selected;
    return vehicle?.isInMission && !vehicle.isLost ? vehicle : null;
  });

  /** Lost vehicles whose rest has been requested. */
  #lost = new Set<Vehicle>();

  /** Once for each vehicle that is lost in its mission: where it goes on to, from the last that is known of it. */
  expect(lost: readonly Vehicle[]): void {
    const before = this.#lost;
    this.#lost = new Set(lost);
    for (const vehicle of lost) {
      // without an answer it goes straight on
      if (!before.has(vehicle) && vehicle.isInMission) rehearseRest(vehicle).catch(() => undefined);
    }
  }

  /** Asks again and again until it is ended by what this returns. */
  follow(vehicle: Vehicle | null): (() => void) | undefined {
    this.outlook = null;
    if (vehicle === null) return undefined;
    let first: { readonly begun: Beginning; readonly since: Date } | null = null;
    let isOver = false;
    const ask = async (): Promise<void> => {
      try {
        const { ahead: flight, now, outlook } = await rehearseRest(vehicle, first?.begun);
        if (isOver) return;
        if (flight !== null && now !== null) first ??= { begun: { now, track: expectedOf(flight) }, since: new Date() };
        const since = first?.since ?? null;
        this.outlook =
          flight === null ? null : { ...(outlook ?? AS_EXPECTED), flight, since, windFrom: windFrom(vehicle) };
      } catch {
        // not known just now: its mission is not read yet, or the server is gone
        if (!isOver) this.outlook = null;
      }
      if (!isOver) timer = setTimeout(() => void ask(), ASK_MS);
    };
    let timer = setTimeout(() => void ask(), 0);
    return () => {
      isOver = true;
      clearTimeout(timer);
      this.outlook = null;
    };
  }
}

/** The part of a rehearsed flight that later questions include. */
function expectedOf({ track }: RehearsedFlight): Beginning['track'] {
  const { time_s, lat_deg, lon_deg, height_m, item } = track;
  return { time_s, lat_deg, lon_deg, height_m, item };
}

export const ahead = new Ahead();
