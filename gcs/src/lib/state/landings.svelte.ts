// The landings that there are to choose from, for the landing that the mission ends with and the wind of the plan.
import type { LandingAlternative, Problem } from '$lib/api/types';
import { planLanding } from './plan-landing.svelte';
import { api, problemFrom } from './station.svelte';

/** Alternatives shown: the best ones, with what speaks against them. */
const SHOWN = 6;

class LandingChoices {
  found = $state.raw<readonly LandingAlternative[]>([]);
  problem = $state.raw<Problem | null>(null);
  isAsking = $state(false);
  #run = 0;

  /** Asks for them; of two questions in a row the last one counts. */
  async ask(): Promise<void> {
    const asked = planLanding.landingHere();
    if (asked === null) return;
    const run = ++this.#run;
    this.isAsking = true;
    try {
      const found = await api.landingAlternatives(asked);
      if (run !== this.#run) return;
      this.found = found.slice(0, SHOWN);
      this.problem = null;
    } catch (error) {
      if (run === this.#run) this.problem = problemFrom(error);
    } finally {
      if (run === this.#run) this.isAsking = false;
    }
  }

  /** The one that the mission has now. */
  isTaken({ landing }: LandingAlternative): boolean {
    const [now, circle] = [planLanding.landing.at(-1), planLanding.landing.at(-2)];
    const [there, round] = [landing.items.at(-1), landing.items.at(-2)];
    const isNear = (a: number | null | undefined, b: number | null | undefined) => Math.abs((a ?? 0) - (b ?? 0)) < 1e-6;
    return [4, 5].every(
      (at) => isNear(now?.params[at], there?.params[at]) && isNear(circle?.params[at], round?.params[at]),
    );
  }
}

export const landings = new LandingChoices();
