// The view of the rehearsed flight: the moment at which the plane is shown, and what-if triggers at it.
import type { Trigger, WhatIf } from '$lib/api/types';
import type { LonLat } from '$lib/domain/lonlat';
import { momentAt } from '$lib/domain/rehearsal';
import { plan } from './plan.svelte';
import { planAssessed } from './plan-assessed.svelte';
import { planWind } from './plan-wind.svelte';
import { planeProfile } from './plane-profile.svelte';
import { api } from './station.svelte';
import { vehicles } from './vehicles.svelte';

/** What follows from a moment; the ring of places is what may be reached without thrust. */
export interface Outcome extends WhatIf {
  readonly at_s: number;
  readonly glide: readonly LonLat[];
}

class RehearsalView {
  /** Since its beginning; at 0 no plane is shown. */
  time_s = $state(0);
  /** The rehearsal of the edited plan; `null` while none is edited. */
  shown = $derived(plan.isEditing ? planAssessed.rehearsal : null);
  moment = $derived(this.shown === null || this.time_s <= 0 ? null : momentAt(this.shown.track, this.time_s));

  /** The assumed event at the moment; `null` for none. */
  trigger = $state<Trigger | null>(null);
  /** The outcome; `null` while unknown, and on the ground. */
  outcome = $state.raw<Outcome | null>(null);
  #isAsking = false;
  #asksAgain = false;

  /** Asks what follows: one question at a time, and of those that come meanwhile the last. */
  async ask(): Promise<void> {
    this.#asksAgain = true;
    if (this.#isAsking) return;
    this.#isAsking = true;
    try {
      while (this.#asksAgain) {
        this.#asksAgain = false;
        this.outcome = await this.#outcome();
      }
    } catch {
      this.outcome = null;
    } finally {
      this.#isAsking = false;
    }
    if (this.#asksAgain) await this.ask();
  }

  async #outcome(): Promise<Outcome | null> {
    const { trigger, moment } = this;
    if (trigger === null || moment === null) return null;
    const { at_s, glide_range, what_ifs } = await api.whatIf({
      plan: plan.asApi(),
      vehicle: vehicles.selected?.systemId ?? null,
      wind: planWind.wind,
      at_s: moment.time_s,
      triggers: [trigger],
      profile: planeProfile.asked,
    });
    const [first] = what_ifs;
    return first === undefined ? null : { ...first, at_s, glide: trigger === 'engine-stopped' ? glide_range : [] };
  }
}

export const rehearsal = new RehearsalView();
