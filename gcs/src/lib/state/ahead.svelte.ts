// The rest of the mission that a plane flies now, as rehearsed from where it is, beside what was expected when it began.
import type { RehearsedFlight } from '$lib/api/types';
import { batteryLeft_pct, expectedAt } from '$lib/domain/ahead';
import { lonLat } from '$lib/domain/lonlat';
import { planWind } from './plan-wind.svelte';
import { planeProfile } from './plane-profile.svelte';
import { api } from './station.svelte';
import { type Vehicle, vehicles } from './vehicles.svelte';

/** Flies the rest of its mission from where it was last heard to be, and leaves that to its ghost; `null` when it flies none. */
async function rehearseRest(vehicle: Vehicle): Promise<RehearsedFlight | null> {
  const from_ms = vehicle.placed_ms;
  const { ahead } = await api.whatIf({
    vehicle: vehicle.systemId,
    wind: planWind.wind,
    triggers: [],
    profile: vehicle === vehicles.selected ? planeProfile.asked : {},
  });
  vehicle.rest = ahead === null || from_ms === null ? null : { track: ahead.track, from_ms };
  return ahead;
}

/** Between two rehearsals of the rest. */
const ASK_MS = 2000;

interface Beginning {
  readonly flight: RehearsedFlight;
  readonly since: Date;
  /** By the plane's own clock, which runs faster in some simulators. */
  readonly flown_s: number;
  readonly battery_pct: number | null;
}

/** How it goes; what is not known is `null`. */
export interface Outlook {
  readonly flight: RehearsedFlight;
  /** When the expectation is from. */
  readonly since: Date;
  /** Later than expected, seconds; negative: earlier. */
  readonly late_s: number | null;
  /** Lower than expected, metres. */
  readonly low_m: number | null;
  /** What will be left of the battery at the end, per cent. */
  readonly battery_pct: number | null;
}

class Ahead {
  /** Of the selected vehicle; `null` while it flies no mission. */
  outlook = $state.raw<Outlook | null>(null);
  /** The vehicle whose mission's rest is rehearsed. */
  flying = $derived.by<Vehicle | null>(() => {
    const vehicle = vehicles.selected;
    return vehicle?.isInMission && !vehicle.isLost ? vehicle : null;
  });

  /** Whose rest has been asked for since they were lost. */
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
    let beginning: Beginning | null = null;
    let isOver = false;
    const ask = async (): Promise<void> => {
      try {
        const ahead = await rehearseRest(vehicle);
        if (isOver) return;
        if (ahead !== null) {
          beginning ??= {
            flight: ahead,
            since: new Date(),
            flown_s: flown_s(vehicle),
            battery_pct: remaining_pct(vehicle),
          };
        }
        this.outlook = ahead === null || beginning === null ? null : outlook(vehicle, ahead, beginning);
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

const remaining_pct = (vehicle: Vehicle): number | null => vehicle.groups.batteries?.[0]?.remaining_pct ?? null;

const flown_s = (vehicle: Vehicle): number => vehicle.flightTime?.seconds ?? 0;

function outlook(vehicle: Vehicle, flight: RehearsedFlight, beginning: Beginning): Outlook {
  const { flight: first, since, battery_pct } = beginning;
  const { position } = vehicle.groups;
  const at = lonLat(position?.lon_deg, position?.lat_deg);
  const expected = at === null ? null : expectedAt(first.track, at, vehicle.progress?.item ?? null);
  const since_s = flown_s(vehicle) - beginning.flown_s;
  const height_m = position?.alt_rel_home_m ?? null;
  const now_pct = remaining_pct(vehicle);
  return {
    flight,
    since,
    late_s: expected === null ? null : since_s - expected.time_s,
    low_m: expected === null || height_m === null ? null : expected.height_m - height_m,
    battery_pct:
      battery_pct === null || now_pct === null ? null : batteryLeft_pct(battery_pct, now_pct, since_s, flight.ends_s),
  };
}

export const ahead = new Ahead();
