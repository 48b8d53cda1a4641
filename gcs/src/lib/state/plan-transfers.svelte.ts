// The way of the plan to the vehicle and back, part by part, and what the station has read from there.
import { ownProblem, ProblemError } from '$lib/api/problem';
import type { Operation, Plan as ApiPlan, PlanKind, Problem } from '$lib/api/types';
import { emptyPlan, type Plan } from '$lib/domain/plan';
import { type Draft, draftOf } from '$lib/domain/plan-edit';
import { SvelteMap } from 'svelte/reactivity';
import { onBoard, PLAN_PARTS } from './on-board.svelte';
import { params } from './params.svelte';
import { plan } from './plan.svelte';
import { sharedDraft } from './shared-draft.svelte';
import { api, operations, problemFrom } from './station.svelte';
import { type Vehicle, vehicles } from './vehicles.svelte';

interface Transfer {
  readonly kind: 'send' | 'read' | 'clear';
  readonly vehicle: Vehicle;
  readonly part: PlanKind;
  readonly operation: Operation | null;
  /** Aborted when a person cancels before the server has begun an operation. */
  readonly cancelled: AbortController;
}

class PlanTransfers {
  transfer = $state.raw<Transfer | null>(null);
  /** What went wrong with the last transfer of each vehicle. */
  readonly #problems = new SvelteMap<number, Problem>();
  problem = $derived<Problem | null>(this.#problems.get(vehicles.selected?.systemId ?? -1) ?? null);
  /** The parts of the draft as they were found on board. */
  readonly #asRead: Partial<Record<PlanKind, unknown>> = {};

  /**
   * Sends parts of the draft, one after the other, and stops at the first that fails. All go to the vehicle that is selected now,
   * whichever is selected meanwhile. A part counts as on board only when the vehicle has been read back.
   */
  async send(...parts: readonly PlanKind[]): Promise<void> {
    const vehicle = vehicles.selected;
    let sent: ApiPlan | undefined;
    for (const part of parts.length > 0 ? parts : (['mission'] as const)) {
      const isDone = await this.#transfer('send', part, vehicle, async (vehicle) => {
        await Promise.race([plan.settled, this.#cancelled()]);
        sent ??= plan.asApi();
        await this.#follow(await api.sendPlan(vehicle.systemId, part, sent));
        return sent;
      });
      if (!isDone) return;
    }
  }

  /** Reads a part of the vehicle's plan into the draft. */
  async read(part: PlanKind = 'mission'): Promise<void> {
    await this.#transfer('read', part, vehicles.selected, async (vehicle) => {
      const read = await this.#follow<ApiPlan>(await api.readPlan(vehicle.systemId, part));
      this.#take(part, read);
      return read;
    });
  }

  /** Clears a part of the plan on board; the draft stays. */
  async clear(part: PlanKind = 'mission'): Promise<void> {
    await this.#transfer('clear', part, vehicles.selected, async (vehicle) => {
      await this.#follow(await api.clearPlan(vehicle.systemId, part));
      return emptyPlan();
    });
  }

  #take(part: PlanKind, read: Plan): void {
    const { fence, rally } = plan.draft;
    if (part === 'mission') plan.replace({ ...read, fence, rally: [...rally] });
    else plan.editAreas((areas) => ({ ...areas, [part]: read[part] }));
  }

  /** Ends the transfer; one that is being handed to the server, as soon as that has begun an operation. */
  async cancel(): Promise<void> {
    this.transfer?.cancelled.abort();
    const { operation, vehicle } = this.transfer ?? {};
    if (!operation || !vehicle) return;
    try {
      await operations.cancel(operation.id);
    } catch (error) {
      this.#problems.set(vehicle.systemId, problemFrom(error));
    }
  }

  /** Puts away what went wrong with the selected vehicle. */
  forgetProblem(): void {
    if (vehicles.selected !== null) this.#problems.delete(vehicles.selected.systemId);
  }

  /** Progress of the transfer, 0 to 1; `null` while it is not known. */
  done = $derived.by<number | null>(() => {
    const started = this.transfer?.operation;
    if (!started) return null;
    const operation = operations.get(started.id) ?? started;
    return operation.total > 0 ? Math.min(1, operation.done / operation.total) : null;
  });

  /**
   * Takes over what the station has read from the selected vehicle: another station may have loaded a mission that this one
   * follows. Nothing is asked of the vehicle.
   */
  async follow(): Promise<void> {
    const vehicle = vehicles.selected;
    if (vehicle === null) return;
    await Promise.all(PLAN_PARTS.map((part) => this.#followPart(vehicle, part)));
  }

  async #followPart(vehicle: Vehicle, part: PlanKind): Promise<void> {
    // our own transfer notes its result itself
    if (vehicle.planStates?.[part].state !== 'verified' || this.transfer !== null || onBoard.planOf(part) !== null)
      return;
    try {
      const { state, plan: found } = await api.planOnBoard(vehicle.systemId, part);
      if (found === null || this.transfer !== null) return;
      onBoard.note(vehicle, part, state, found);
      // A draft without changes of the user follows the vehicle; a change that the core still works on is one.
      await plan.settled;
      const isUntouched = !plan.canUndo && (plan.isEmpty(part) || partOf(plan.draft, part) === this.#asRead[part]);
      if (vehicle !== vehicles.selected || !isUntouched || this.transfer !== null) return;
      const { fence, rally } = plan.draft;
      sharedDraft.found(() => {
        if (part === 'mission') plan.begin({ ...draftOf(found), fence, rally });
        else plan.begin({ ...plan.draft, [part]: found[part] });
      });
      this.#asRead[part] = partOf(plan.draft, part);
    } catch {
      // it stays unknown, and is shown as such
    }
  }

  async #transfer(
    kind: Transfer['kind'],
    part: PlanKind,
    vehicle: Vehicle | null,
    run: (vehicle: Vehicle) => Promise<Plan>,
  ): Promise<boolean> {
    if (vehicle === null || this.transfer !== null) return false;
    this.#problems.delete(vehicle.systemId);
    this.transfer = { kind, part, vehicle, operation: null, cancelled: new AbortController() };
    try {
      const there = await params.of(vehicle.systemId).makeRoom(() => run(vehicle));
      onBoard.note(vehicle, part, (await api.planOnBoard(vehicle.systemId, part)).state, there);
      return true;
    } catch (error) {
      this.#problems.set(vehicle.systemId, problemFrom(error));
      return false;
    } finally {
      this.transfer = null;
    }
  }

  /** Rejects when the transfer is cancelled. */
  #cancelled(): Promise<never> {
    const signal = this.transfer?.cancelled.signal;
    return new Promise((_, reject) => {
      const end = () => reject(new ProblemError(ownProblem('cancelled', 499)));
      if (signal?.aborted) end();
      signal?.addEventListener('abort', end);
    });
  }

  async #follow<Result = unknown>(operation: Operation): Promise<Result> {
    if (this.transfer !== null) this.transfer = { ...this.transfer, operation };
    if (this.transfer?.cancelled.signal.aborted) await this.cancel();
    return operations.finish<Result>(operation);
  }
}

function partOf(draft: Draft, part: PlanKind): unknown {
  return part === 'mission' ? draft.items : draft[part];
}

export const planTransfers = new PlanTransfers();
