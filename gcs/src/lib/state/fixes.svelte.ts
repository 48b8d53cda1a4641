// Remedies by one click: the core tries them once the plan is left alone, for each takes a rehearsal.
import type { FindingFix, PlanFinding, Problem } from '$lib/api/types';
import { type Draft, replaceItems } from '$lib/domain/plan-edit';
import type { PlanItem } from '$lib/domain/plan';
import { elevation } from './maps-elevation.svelte';
import { plan } from './plan.svelte';
import { planAssessed } from './plan-assessed.svelte';
import { planWind } from './plan-wind.svelte';
import { api, problemFrom } from './station.svelte';
import { vehicles } from './vehicles.svelte';

/** A plan that was not edited for so long is looked at. */
const QUIET_MS = 600;

class Fixes {
  #found = $state.raw<{ readonly draft: Draft; readonly fixes: readonly FindingFix[] } | null>(null);
  /** Of the plan as it is; another one's would put its items in the wrong places. */
  #fixes = $derived(this.#found?.draft === plan.draft ? this.#found.fixes : []);
  problem = $state.raw<Problem | null>(null);
  #timer: ReturnType<typeof setTimeout> | undefined;
  #isAsking = false;
  #asksAgain = false;

  of(finding: PlanFinding): FindingFix | null {
    return this.#fixes.find((one) => one.finding.code === finding.code && one.finding.item === finding.item) ?? null;
  }

  /** Looks for some when the plan has been let alone for a moment. */
  look(): void {
    clearTimeout(this.#timer);
    if (planAssessed.findings.some(({ item }) => item !== null))
      this.#timer = setTimeout(() => void this.#ask(), QUIET_MS);
  }

  async #ask(): Promise<void> {
    this.#asksAgain = this.#isAsking;
    if (this.#isAsking) return;
    this.#isAsking = true;
    try {
      do {
        this.#asksAgain = false;
        const { draft } = plan;
        const asked = { ...plan.asApi(), complex_items: [] };
        const vehicle = vehicles.selected?.systemId ?? null;
        const { clearance_m } = elevation;
        this.#found = { draft, fixes: await api.planFixes({ plan: asked, vehicle, wind: planWind.wind, clearance_m }) };
      } while (this.#asksAgain);
    } catch {
      this.#found = null; // what to do stands beside each finding in words
    } finally {
      this.#isAsking = false;
    }
  }

  /** Changes the plan; undo takes it back. What concerns the vehicle is set there, by somebody who was asked. */
  async apply({ first_item, count, items, ...fix }: FindingFix): Promise<void> {
    this.problem = null;
    if (fix.does !== 'set-parameter') {
      plan.edit((draft) => replaceItems(draft, first_item - 1, count, items as PlanItem[]));
      return;
    }
    const vehicle = vehicles.selected;
    if (vehicle === null) return;
    try {
      await api.setParam(vehicle.systemId, fix.with.name, fix.with.value);
      planAssessed.assess();
    } catch (error) {
      this.problem = problemFrom(error);
    }
  }
}

export const fixes = new Fixes();
