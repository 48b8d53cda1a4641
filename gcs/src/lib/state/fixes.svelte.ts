// Remedies by one click: the core tries them once the plan is left alone, for each takes a rehearsal.
import type { FindingFix, PlanFinding, Problem } from '$lib/api/types';
import { type Draft, replaceItems } from '$lib/domain/plan-edit';
import type { PlanItem } from '$lib/domain/plan';
import { elevation } from './maps-elevation.svelte';
import { params } from './params.svelte';
import { plan } from './plan.svelte';
import { planAssessed } from './plan-assessed.svelte';
import { planWind } from './plan-wind.svelte';
import { planeProfile } from './plane-profile.svelte';
import { api } from './station.svelte';
import { vehicles } from './vehicles.svelte';

/** Delay after the last edit before remedies are looked for. */
const QUIET_MS = 600;

interface Found {
  readonly draft: Draft;
  /** What they were tried with, as text. */
  readonly terms: string;
  readonly vehicle: number | null;
  readonly fixes: readonly FindingFix[];
}

class Fixes {
  #found = $state.raw<Found | null>(null);
  /** What remedies are tried with, beside the plan: the same as its findings come from. */
  #terms = $derived({
    vehicle: vehicles.selected?.systemId ?? null,
    wind: planWind.wind,
    clearance_m: elevation.clearance_m,
    profile: planeProfile.asked,
  });
  /** Of the plan as it is, for this vehicle: another plan's would put its items in the wrong places. */
  #fixes = $derived(
    this.#found?.draft === plan.draft && this.#found.terms === JSON.stringify(this.#terms) ? this.#found.fixes : [],
  );
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
        const terms = this.#terms;
        const found = await api.planFixes({ plan: asked, ...terms });
        this.#found = { draft, terms: JSON.stringify(terms), vehicle: terms.vehicle, fixes: found };
      } while (this.#asksAgain);
    } catch {
      this.#found = null; // what to do stands beside each finding in words
    } finally {
      this.#isAsking = false;
    }
  }

  /** Changes the plan (undo takes it back), or sets a parameter on the vehicle, which the user has confirmed by holding the button. */
  async apply({ first_item, count, items, ...fix }: FindingFix): Promise<void> {
    this.problem = null;
    if (fix.does !== 'set-parameter') {
      plan.edit((draft) => replaceItems(draft, first_item - 1, count, items as PlanItem[]));
      return;
    }
    // for the vehicle that it was tried for
    const vehicle = this.#found?.vehicle ?? null;
    if (vehicle === null || vehicle !== vehicles.selected?.systemId) return;
    const answer = await params.of(vehicle).set(fix.with.name, fix.with.value);
    if (answer.state === 'refused') this.problem = answer.problem;
  }
}

export const fixes = new Fixes();
