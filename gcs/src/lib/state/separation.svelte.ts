// Missions on board held against each other: where two flights would come too near, as the core rehearses them.
import type { Problem, Separation } from '$lib/api/types';
import { load, save } from './stored';
import { api, problemFrom } from './station.svelte';
import { vehicles, type Vehicle } from './vehicles.svelte';

/** Flights that the server compares at once. */
const MOST = 32;

interface Limits {
  readonly horizontal_m: number;
  readonly vertical_m: number;
  readonly window_s: number;
}

const USUAL: Limits = { horizontal_m: 100, vertical_m: 30, window_s: 10 };
/** Least and most of each. */
export const LIMITS: Readonly<Record<keyof Limits, readonly [number, number]>> = {
  horizontal_m: [1, 10_000],
  vertical_m: [1, 10_000],
  window_s: [0, 3600],
};

function read(value: unknown): Limits | null {
  if (typeof value !== 'object' || value === null) return null;
  const stored = value as Record<string, unknown>;
  const isGood = Object.entries(LIMITS).every(([name, [least, most]]) => {
    const one = stored[name];
    return typeof one === 'number' && one >= least && one <= most;
  });
  return isGood ? (stored as unknown as Limits) : null;
}

class Separations {
  #limits = $state.raw<Limits>(load('separation', USUAL, read));
  #found = $state.raw<{ readonly of: string; readonly separation: Separation } | null>(null);
  problem = $state.raw<Problem | null>(null);
  isUnderWay = $state(false);

  /** Those whose mission on board is known. */
  known = $derived<readonly Vehicle[]>(
    vehicles.all
      .filter(({ planStates }) => planStates?.mission.state === 'verified' && (planStates.mission.count ?? 0) > 0)
      .slice(0, MOST),
  );

  /** All that an answer is of: the limits, and which mission each of them has. */
  #question = $derived(
    JSON.stringify([this.#limits, this.known.map(({ systemId, planStates }) => [systemId, planStates?.mission.hash])]),
  );
  /** The core's answer, while it is of what is on board and of the limits; `null` otherwise. */
  found = $derived(this.#found?.of === this.#question ? this.#found.separation : null);

  get limits(): Limits {
    return this.#limits;
  }

  set(name: keyof Limits, value: number): void {
    const [least, most] = LIMITS[name];
    if (!(value >= least && value <= most)) return;
    this.#limits = { ...this.#limits, [name]: value };
    save('separation', this.#limits);
  }

  /** Asks again, as if all of them started at once. */
  async compare(): Promise<void> {
    if (this.isUnderWay || this.known.length < 2) return;
    this.isUnderWay = true;
    this.problem = null;
    const of = this.#question;
    try {
      const flights = this.known.map(({ systemId }) => ({ vehicle: systemId, starts_s: 0 }));
      this.#found = { of, separation: await api.separation({ flights, ...this.#limits }) };
    } catch (error) {
      this.#found = null;
      this.problem = problemFrom(error);
    } finally {
      this.isUnderWay = false;
    }
  }
}

export const separations = new Separations();
