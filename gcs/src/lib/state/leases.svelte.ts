// Control of the station, and of vehicles that another ground station may have: who has it, and what can be done here.
import { SvelteMap, SvelteSet } from 'svelte/reactivity';
import type { ControlRequest } from '$lib/domain/control-request';
import type { RosterRow } from '$lib/domain/roster';
import type { Problem } from '$lib/api/types';
import { fleet } from './fleet.svelte';
import { api, problemFrom, station } from './station.svelte';

export interface Lease {
  /** Name of the vehicle; null for the station itself. */
  readonly vehicle: string | null;
  readonly has: boolean;
  readonly holder: string | null;
  readonly requestedBy: string | null;
  /** What became of our request. */
  readonly request: ControlRequest['state'];
  /** Why the last change was refused, until control changes hands or is asked for. */
  readonly problem: Problem | null;
  /** Whether the server has yet to answer. */
  readonly isBusy: boolean;
  readonly ask: () => Promise<void>;
  readonly give: () => Promise<void>;
  readonly keep: (requestedBy: string) => Promise<void>;
}

export const stationLease = (): Lease => ({
  vehicle: null,
  has: station.hasControl,
  holder: station.holder,
  requestedBy: station.requestedBy,
  request: station.controlRequest,
  problem: station.controlProblem,
  isBusy: station.isControlBusy,
  ask: station.requestControl,
  give: station.releaseControl,
  keep: station.keepControl,
});

/** Why the last change was refused, by vehicle. */
const problems = new SvelteMap<number, Problem>();
const busy = new SvelteSet<number>();
const STANDING: readonly (keyof RosterRow)[] = ['holder', 'is_held_here', 'requested_by'];

// A refusal is about the state of control at its time.
station.whenTold((message) => {
  // what was asked before may never be answered
  if (message.type === 'hello') busy.clear();
  if (message.type !== 'roster') return;
  for (const id of message.gone) problems.delete(id);
  for (const row of message.rows) if (STANDING.some((field) => field in row)) problems.delete(row.id);
});

/** What has changed comes with the list of vehicles. */
async function change(id: number, call: () => Promise<unknown>): Promise<void> {
  problems.delete(id);
  busy.add(id);
  try {
    await call();
  } catch (error) {
    problems.set(id, problemFrom(error));
  } finally {
    busy.delete(id);
  }
}

export const vehicleLease = (row: RosterRow): Lease => ({
  vehicle: fleet.nameOf(row),
  has: row.is_held_here === true,
  holder: row.holder,
  requestedBy: row.requested_by,
  request: fleet.requestFor(row.id).state,
  problem: problems.get(row.id) ?? null,
  isBusy: busy.has(row.id),
  ask: () => change(row.id, () => api.requestVehicle(row.id)),
  give: () => change(row.id, () => api.releaseVehicle(row.id)),
  keep: (requestedBy) => change(row.id, () => api.keepVehicle(row.id, requestedBy)),
});
