// Known plans on board, by the fingerprint that the server gives of each part.
import type { PlanKind, PlanState } from '$lib/api/types';
import { emptyPlan, type Plan } from '$lib/domain/plan';
import { readPlan } from '$lib/domain/plan-read';
import { load, save } from './stored';
import { type Vehicle, vehicles } from './vehicles.svelte';

/** The parts of a plan: each is sent, read and cleared separately. */
export const PLAN_PARTS = ['mission', 'fence', 'rally'] as const satisfies readonly PlanKind[];

interface Known {
  readonly vehicle: number;
  readonly hash: string | null;
  readonly plan: Plan;
}

type KnownParts = Readonly<Partial<Record<PlanKind, Known>>>;

class OnBoard {
  #known = $state.raw<KnownParts>(load('on-board', {}, readKnown));

  /** The selected vehicle's plan, of which this part counts; `null` when that is not known. Reactive. */
  planOf(part: PlanKind): Plan | null {
    const vehicle = vehicles.selected;
    const told = vehicle?.planStates?.[part];
    if (!vehicle || !told) return null;
    if (told.state === 'empty') return emptyPlan();
    const known = this.#known[part];
    if (told.state !== 'verified' || known?.vehicle !== vehicle.systemId) return null;
    return known.hash === told.hash ? known.plan : null;
  }

  /** Notes the plan on board, with the state and fingerprint reported by the server. */
  note(vehicle: Vehicle, part: PlanKind, told: PlanState, plan: Plan): void {
    vehicle.applyPlanState(part, told);
    if (told.state !== 'verified') return;
    this.#known = { ...this.#known, [part]: { vehicle: vehicle.systemId, hash: told.hash, plan } };
    save('on-board', this.#known);
  }
}

function readKnown(value: unknown): KnownParts | null {
  if (typeof value !== 'object' || value === null) return null;
  const stored = value as Record<string, unknown>;
  const read = PLAN_PARTS.map((part) => [part, readOne(stored[part])] as const);
  return Object.fromEntries(read.filter(([, known]) => known !== null)) as KnownParts;
}

function readOne(value: unknown): Known | null {
  if (typeof value !== 'object' || value === null) return null;
  const { vehicle, hash, plan } = value as Record<string, unknown>;
  const read = readPlan(plan);
  if (typeof vehicle !== 'number' || read === null) return null;
  return { vehicle, hash: typeof hash === 'string' ? hash : null, plan: read };
}

export const onBoard = new OnBoard();
