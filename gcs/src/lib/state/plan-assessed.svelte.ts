// The core's assessment of the draft: findings, distance and time, and the rehearsed flight.
import type { PlanFinding, Rehearsal, Trip } from '$lib/api/types';
import { elevation } from './maps-elevation.svelte';
import { PLAN_PARTS } from './on-board.svelte';
import { params } from './params.svelte';
import { plan } from './plan.svelte';
import { planWind } from './plan-wind.svelte';
import { planeProfile } from './plane-profile.svelte';
import { station } from './station.svelte';
import { vehicles } from './vehicles.svelte';

/** A rehearsal is drawn as old after this time without a newer one, so that it does not flicker between two answers. */
const OLD_AFTER_MS = 200;
/** After that the core is asked again for a flight over ground that it did not know yet. */
const GROUND_AGAIN_MS = 700;

class PlanAssessed {
  findings = $state.raw<readonly PlanFinding[]>([]);
  /** Distance and time of the mission as flown; `null` when unknown. */
  trip = $state.raw<Trip | null>(null);
  /** The mission as the plane would fly it in the wind; `null` when it was not rehearsed. */
  rehearsal = $state.raw<Rehearsal | null>(null);
  /** Whether the rehearsal is of the plan as it was before. */
  isRehearsalOld = $state(false);
  checkState = $state<'none' | 'checking' | 'done' | 'unavailable'>('none');
  isReadingParams = $derived(params.selected?.isReading === true);
  #isAsking = false;
  #asksAgain = false;
  #oldTimer: ReturnType<typeof setTimeout> | undefined;
  #groundTimer: ReturnType<typeof setTimeout> | undefined;

  /** Asks the core about the draft: one question at a time, and of the edits that come meanwhile the last. */
  assess(): void {
    if (this.#isNothing) {
      this.#note(null);
      this.checkState = 'none';
      return;
    }
    // the old findings stay until the answer
    if (this.checkState !== 'done') this.checkState = 'checking';
    if (this.#isAsking) this.#asksAgain = true;
    else void this.#ask();
  }

  get #isNothing(): boolean {
    return PLAN_PARTS.every((part) => plan.isEmpty(part));
  }

  async #ask(): Promise<void> {
    this.#isAsking = true;
    try {
      do {
        this.#asksAgain = false;
        this.#oldTimer ??= setTimeout(() => (this.isRehearsalOld = true), OLD_AFTER_MS);
        // complex items do not affect the flight
        const asked = { ...plan.asApi(), complex_items: [] };
        const vehicle = vehicles.selected?.systemId;
        const told = await station.assess(asked, vehicle, planWind.wind, elevation.clearance_m, planeProfile.asked);
        this.#note(this.#isNothing ? null : told);
        clearTimeout(this.#groundTimer);
        // ground that the server had not at hand is there a moment later
        if (told.rehearsal?.is_ground_pending) this.#groundTimer = setTimeout(() => this.assess(), GROUND_AGAIN_MS);
        if (this.#isNothing) return;
      } while (this.#asksAgain);
      this.checkState = 'done';
    } catch {
      this.#note(null);
      this.checkState = 'unavailable';
    } finally {
      this.#isAsking = false;
    }
    // of the plan that was refused an answer was not the last word, when it has been edited since
    if (this.#asksAgain) await this.#ask();
  }

  #note(told: Awaited<ReturnType<typeof station.assess>> | null): void {
    clearTimeout(this.#oldTimer);
    this.#oldTimer = undefined;
    this.isRehearsalOld = false;
    this.findings = told?.findings ?? [];
    // without items that would be the return from where the plane is
    const flown = plan.isEmpty('mission') ? null : told;
    [this.trip, this.rehearsal] = [flown?.trip ?? null, flown?.rehearsal ?? null];
  }

  /** Reads the vehicle's parameters, so that the rehearsal flies as it does. */
  async readParams(): Promise<void> {
    const { selected } = params;
    if (selected === null) return;
    plan.problem = null;
    if (!(await selected.read())) plan.problem = selected.problem;
  }
}

export const planAssessed = new PlanAssessed();
plan.whenChanged(() => planAssessed.assess());
params.whenChanged(() => planAssessed.assess());
