// Many rehearsals of the edited plan: where they pass, and the odds. On request only; cancelled when the plan changes.
import { connection } from '$lib/api/connection';
import type { Problem, Rehearsal, Spread } from '$lib/api/types';
import { plan } from './plan.svelte';
import { planAssessed } from './plan-assessed.svelte';
import { planWind } from './plan-wind.svelte';
import { planeProfile } from './plane-profile.svelte';
import { api, problemFrom } from './station.svelte';
import { vehicles } from './vehicles.svelte';

const RUNS = 200;

/** Whether two rehearsals are of one flight: the core is asked again and again for the same. */
function isSame(a: Rehearsal | null, b: Rehearsal | null): boolean {
  const key = (flown: Rehearsal | null): string =>
    JSON.stringify(
      flown && [flown.wind, flown.airframe, flown.passages, flown.touch_down, flown.duration_s, flown.battery],
    );
  return a === b || key(a) === key(b);
}

class Odds {
  #told = $state.raw<{ readonly of: Rehearsal; readonly spread: Spread } | null>(null);
  #asking: { readonly of: Rehearsal; readonly end: AbortController } | null = null;
  isAsking = $state(false);
  problem = $state.raw<Problem | null>(null);
  /** For the rehearsal that is shown; `null` when that has changed. */
  spread = $derived(isSame(this.#told?.of ?? null, planAssessed.rehearsal) ? (this.#told?.spread ?? null) : null);

  /** Asks again; supersedes an earlier question. */
  async ask(): Promise<void> {
    const of = planAssessed.rehearsal;
    this.cancel();
    this.problem = null;
    if (of === null) return;
    const asking = { of, end: new AbortController() };
    this.#asking = asking;
    this.isAsking = true;
    try {
      const asked = {
        plan: { ...plan.asApi(), complex_items: [] },
        vehicle: vehicles.selected?.systemId ?? null,
        wind: planWind.wind,
        profile: planeProfile.asked,
        runs: RUNS,
      };
      const spread = await api.spread(asked, connection.or(asking.end.signal));
      if (this.#asking === asking) this.#told = { of, spread };
    } catch (error) {
      if (this.#asking === asking) this.problem = problemFrom(error);
    } finally {
      if (this.#asking === asking) this.cancel();
    }
  }

  /** Cancels the question; the server stops simulating. */
  cancel(): void {
    this.#asking?.end.abort();
    this.#asking = null;
    this.isAsking = false;
  }

  hide(): void {
    this.#told = null;
  }

  /** Cancels a question about a different flight. */
  settle(shown: Rehearsal | null): void {
    if (this.#asking !== null && !isSame(this.#asking.of, shown)) this.cancel();
  }
}

export const odds = new Odds();
