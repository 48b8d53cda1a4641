// How the draft stands to what the selected vehicle has on board, as the core compares them.
import type { PlanChange, PlanKind } from '$lib/api/types';
import { isFenceEmpty } from '$lib/domain/area-edit';
import type { Plan, PlanItem } from '$lib/domain/plan';
import { Comparison, type Question } from './comparison.svelte';
import { onBoard, PLAN_PARTS } from './on-board.svelte';
import { plan } from './plan.svelte';
import { planTransfers } from './plan-transfers.svelte';
import { api, station } from './station.svelte';
import { vehicles } from './vehicles.svelte';

/** A step from the mission on board to the draft: the item there and here, where there is one. */
export interface ItemChange {
  readonly change: PlanChange;
  readonly item: PlanItem | undefined;
  readonly was: PlanItem | undefined;
}

/** The draft compared with the plan known to be on board the selected vehicle; `uncompared` until the core has answered. */
type DraftState = 'empty' | 'not-sent' | 'sending' | 'verified' | 'differs' | 'uncompared' | 'unknown';

class PlanCompared {
  /** What the selected vehicle has on board; `null` when that is not known. */
  vehiclePlan = $derived<Plan | null>(onBoard.planOf('mission'));
  vehicleAreas = $derived({
    fence: onBoard.planOf('fence')?.fence ?? null,
    rally: onBoard.planOf('rally')?.rally ?? null,
  });

  readonly #comparison = new Comparison((...asked) => api.comparePlan(...asked));
  /** The pair to compare; `null` while the plan on board is unknown. */
  #comparable = $derived.by<Question | null>(() => {
    const vehicle = vehicles.selected;
    const { planStates } = vehicle ?? {};
    if (vehicle === null || !planStates || PLAN_PARTS.every((part) => planStates[part].state !== 'verified'))
      return null;
    const { items: mission, fence, rally } = plan.draft;
    const { hash: missionHash } = planStates.mission;
    const [fenceHash, rallyHash] = [planStates.fence.hash, planStates.rally.hash];
    return { vehicle: vehicle.systemId, mission, fence, rally, missionHash, fenceHash, rallyHash };
  });

  /** How each part of the draft stands to the selected vehicle. */
  states = $derived.by<Readonly<Record<PlanKind, DraftState>>>(() => {
    const { fence, rally } = this.vehicleAreas;
    return {
      mission: this.#stateOf('mission', this.vehiclePlan && this.vehiclePlan.items.length === 0),
      fence: this.#stateOf('fence', fence && isFenceEmpty(fence)),
      rally: this.#stateOf('rally', rally && rally.length === 0),
    };
  });
  state = $derived<DraftState>(this.states.mission);

  /** `isNothing`: whether nothing is on board; `null` when that is not known. */
  #stateOf(part: PlanKind, isNothing: boolean | null): DraftState {
    const { transfer } = planTransfers;
    if (transfer?.kind === 'send' && transfer.part === part && transfer.vehicle === vehicles.selected) return 'sending';
    const isEmpty = plan.isEmpty(part);
    if (vehicles.selected === null) return isEmpty ? 'empty' : 'not-sent';
    if (isNothing === null) return 'unknown';
    if (isNothing) return isEmpty ? 'empty' : 'not-sent';
    const compared = this.#comparable && this.#comparison.of(part, this.#comparable);
    if (compared === null) return 'uncompared';
    return compared.changes.length === 0 ? 'verified' : 'differs';
  }

  /** The parts that the vehicle does not have as they are here, nothing included that is in neither place. */
  unsent = $derived(
    PLAN_PARTS.filter((part) => !plan.isEmpty(part) && !['verified', 'sending'].includes(this.states[part])),
  );

  /** Differences between the draft and the plan on board; empty when unknown. */
  difference = $derived.by<readonly ItemChange[]>(() => {
    const compared = this.#comparable && this.#comparison.of('mission', this.#comparable);
    if (compared === null || this.vehiclePlan === null) return [];
    const { items } = this.vehiclePlan;
    return compared.changes.map((change) => ({
      change,
      item: 'item' in change ? compared.of[change.item - 1] : undefined,
      was: 'on_board' in change ? items[change.on_board - 1] : undefined,
    }));
  });

  /** Asks how the draft differs; to be called when the draft, the plan on board or the connection changes. */
  compare(): void {
    if (station.isOnline) this.#comparison.ask(this.#comparable);
    else this.#comparison.forget();
  }
}

export const planCompared = new PlanCompared();
