// The fleet list: rows, search, marks, and saved groups.
import { SvelteMap, SvelteSet } from 'svelte/reactivity';
import { type ControlRequest, followed, NO_REQUEST } from '$lib/domain/control-request';
import { vehicleKind } from '$lib/domain/core';
import {
  type AttentionLevel,
  attentionTo,
  changedRow,
  found,
  inOrder,
  isGone,
  isHeldElsewhere,
  isMute,
  isWanted,
  keyOf,
  levelOf,
  type Listed,
  placesByName,
  type RosterChange,
  type RosterOrder,
  type RosterRow,
} from '$lib/domain/roster';
import { t } from '$lib/i18n/index.svelte';
import { clock } from './clock.svelte';
import { load, save } from './stored';
import { vehicleName } from './vehicle-name';

/** Vehicles by name of their group. */
type Groups = Readonly<Record<string, readonly string[]>>;

const MAX_GROUPS = 50;
const MAX_NAME = 40;

function readGroups(value: unknown): Groups | null {
  if (typeof value !== 'object' || value === null) return null;
  const isList = (one: unknown): one is string[] => Array.isArray(one) && one.every((key) => typeof key === 'string');
  const kept = Object.entries(value).filter((entry): entry is [string, string[]] => isList(entry[1]));
  return Object.fromEntries(kept.slice(0, MAX_GROUPS));
}

class Fleet {
  readonly #byId = new Map<number, RosterRow>();
  /** Counts the messages: the rows themselves stay out of reactive state. */
  #version = $state(0);
  /** Rank of each vehicle by name; null when it has to be computed again. */
  #places: Map<number, number> | null = null;
  /** When the newest came, monotonic and on the station's clock. */
  #at_ms = 0;
  #at_s = 0;
  #groups = $state.raw<Groups>(load('fleet-groups', {}, readGroups));

  search = $state('');
  order = $state<RosterOrder>('attention');
  /** Shows only this group; null for all. */
  group = $state<string | null>(null);
  /** Ids of those that a group act is meant for. */
  readonly marked = new SvelteSet<number>();

  /** Our requests for control of vehicles. */
  readonly #requests = new SvelteMap<number, ControlRequest>();

  /** When those that are lost and forgotten were heard last: they are listed again once they are heard. */
  readonly #forgotten = new SvelteMap<number, number | null>();

  /** Each message has ages move on; without one, each second does. */
  #silent_s = $derived(Math.floor(Math.max(0, clock.now_ms - this.#at_ms - 1000) / 1000));

  listed = $derived.by<readonly Listed[]>(() => {
    void this.#version;
    void this.#silent_s;
    const now_ms = performance.now();
    this.#places ??= placesByName([...this.#byId.values()].map((row) => ({ id: row.id, name: this.nameOf(row) })));
    return [...this.#byId.values()].filter(({ id }) => !this.isForgotten(id)).map((row) => this.#list(row, now_ms));
  });
  count = $derived(this.listed.length);
  /** How many there are, the forgotten ones with them. */
  known = $derived.by(() => (this.#version >= 0 ? this.#byId.size : 0));
  shown = $derived.by<readonly Listed[]>(() => {
    const members = this.group === null ? null : new Set(this.#groups[this.group] ?? []);
    const ofGroup = members === null ? this.listed : this.listed.filter(({ row }) => members.has(keyOf(row)));
    return inOrder(found(ofGroup, this.search), this.order);
  });
  /** How many need attention. */
  needing = $derived(this.listed.filter(({ attention }) => attention.length > 0).length);
  groupNames = $derived(Object.keys(this.#groups).sort((a, b) => a.localeCompare(b)));

  /** Takes over what changed; those that went are forgotten. */
  apply(time_s: number, rows: readonly RosterChange[], gone: readonly number[], now_ms: number): void {
    [this.#at_s, this.#at_ms] = [time_s, now_ms];
    for (const change of rows) {
      if ('remote_name' in change || 'is_recorded' in change || 'mav_type' in change) this.#places = null;
      const row = changedRow(this.#byId.get(change.id), change);
      this.#byId.set(change.id, row);
      this.#followRequest(row);
    }
    if (gone.length > 0) this.#places = null;
    for (const id of gone) this.#byId.delete(id);
    // of those that went while nothing was heard, the whole list is silent
    for (const id of this.marked) if (!this.#byId.has(id)) this.marked.delete(id);
    this.#version += 1;
  }

  #followRequest(row: RosterRow): void {
    const before = this.requestFor(row.id);
    const [requestedBy, isRequestOurs] = [row.requested_by, row.is_requested_here === true];
    const now = followed(before, { has: row.is_held_here === true, holder: row.holder, requestedBy, isRequestOurs });
    if (now.state === 'none') this.#requests.delete(row.id);
    else if (now.state !== before.state || now.askedOf !== before.askedOf) this.#requests.set(row.id, now);
  }

  /** What became of our request for control of a vehicle. */
  requestFor(id: number): ControlRequest {
    return this.#requests.get(id) ?? NO_REQUEST;
  }

  /** Whether another ground station has control of a vehicle. */
  isHeldElsewhere(id: number): boolean {
    void this.#version;
    const row = this.#byId.get(id);
    return row !== undefined && isHeldElsewhere(row);
  }

  /** Its row, as it is now. Reactive. */
  row(id: number): RosterRow | undefined {
    void this.#version;
    return this.#byId.get(id);
  }

  /** The vehicles that we have control of, and another ground station asks for. */
  wanted = $derived.by<readonly RosterRow[]>(() => {
    void this.#version;
    return [...this.#byId.values()].filter(isWanted);
  });

  /** The whole list comes next. */
  begin(): void {
    this.#byId.clear();
    this.#places = null;
  }

  /** Whether it was taken off the list, and has not been heard since. */
  isForgotten(id: number): boolean {
    void this.#version;
    return this.#forgotten.has(id) && this.#forgotten.get(id) === this.#byId.get(id)?.heard_s;
  }

  /** All ids, in the order in which they were received. */
  get ids(): number[] {
    return [...this.#byId.keys()];
  }

  get(id: number): RosterRow | undefined {
    return this.#byId.get(id);
  }

  /** How long ago a vehicle was heard. */
  age_s(row: RosterRow, now_ms = performance.now()): number | null {
    return row.heard_s === null ? null : Math.max(0, this.#at_s - row.heard_s + (now_ms - this.#at_ms) / 1000);
  }

  /** What a vehicle is called. */
  nameOf({ id, mav_type, remote_name, is_recorded }: RosterRow): string {
    const isRecorded = is_recorded === true;
    return vehicleName({ systemId: id, kind: vehicleKind(mav_type), remoteName: remote_name, isRecorded });
  }

  /** How urgently a vehicle needs attention. */
  levelOf(id: number): AttentionLevel {
    const row = this.#byId.get(id);
    return row === undefined ? 'none' : levelOf(attentionTo(row, this.age_s(row)));
  }

  /** A recording is not marked: it takes no group act. */
  mark(id: number, isMarked: boolean): void {
    if (isMarked && this.#byId.get(id)?.is_recorded !== true) this.marked.add(id);
    else this.marked.delete(id);
  }

  /** The marked rows in list order, those that do not answer last, so that the others do not wait for them. */
  markedRows(): Listed[] {
    const some = this.listed.filter(({ row }) => this.marked.has(row.id));
    return inOrder(some, 'name').sort((a, b) => Number(isMute(a)) - Number(isMute(b)));
  }

  /** The marked ones that are lost, or out of the fleet. */
  markedLost = $derived(this.listed.filter((one) => this.marked.has(one.row.id) && isGone(one)));

  /** Takes the marked ones that are lost off the list until they are heard again. */
  forgetLost(): void {
    for (const { row } of this.markedLost) {
      this.#forgotten.set(row.id, row.heard_s);
      this.marked.delete(row.id);
    }
  }

  /** Keeps those marked under a name; a group of that name is replaced. Whether there was room. */
  keepGroup(name: string): boolean {
    const kept = name.trim().slice(0, MAX_NAME);
    const isNew = !(kept in this.#groups);
    if (kept === '' || this.marked.size === 0 || (isNew && this.groupNames.length >= MAX_GROUPS)) return false;
    this.#setGroups({ ...this.#groups, [kept]: this.markedRows().map(({ row }) => keyOf(row)) });
    this.group = kept;
    return true;
  }

  forgetGroup(name: string): void {
    const { [name]: _, ...others } = this.#groups;
    this.#setGroups(others);
    if (this.group === name) this.group = null;
  }

  #setGroups(groups: Groups): void {
    this.#groups = groups;
    save('fleet-groups', groups);
  }

  #list(row: RosterRow, now_ms: number): Listed {
    const age_s = this.age_s(row, now_ms);
    const name = this.nameOf(row);
    const attention = attentionTo(row, age_s);
    const words = (): string => {
      const reasons = attention.map((reason) => t(`fleet.why.${reason}`));
      return [name, row.id, row.mode ?? '', row.holder ?? '', ...reasons, row.alarm?.text ?? ''].join(' ');
    };
    return { row, name, place: this.#places?.get(row.id) ?? 0, age_s, attention, words };
  }
}

export const fleet = new Fleet();
