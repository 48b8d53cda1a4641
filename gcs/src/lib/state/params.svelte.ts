// Parameters of the vehicles: read all at once, changed one at a time, and kept up to date with what the vehicle reports of them.
import type { Operation, Parameter, Problem, ServerMessage } from '$lib/api/types';
import { countPrefixes, readParam, writeParam } from '$lib/domain/params';
import { SvelteMap } from 'svelte/reactivity';
import { settings } from './settings.svelte';
import { api, operations, problemFrom, station } from './station.svelte';
import { vehicles } from './vehicles.svelte';

/** What became of the last change of a parameter. */
export type ParamAnswer =
  | { readonly state: 'sending'; readonly value: number }
  | { readonly state: 'set'; readonly value: number; readonly was: number | null }
  | { readonly state: 'refused'; readonly value: number; readonly problem: Problem };

/** A value being typed. */
export interface ParamEdit {
  readonly name: string;
  text: string;
  /** The value that the vehicle reported meanwhile; `null`: none. */
  told: number | null;
}

/** The decimal point of the language in use. */
export const decimalPoint = (): string =>
  new Intl.NumberFormat(settings.locale).formatToParts(0.5).find(({ type }) => type === 'decimal')?.value ?? '.';

export class VehicleParams {
  readonly systemId: number;
  /** The known ones in the vehicle's order; replaced, never changed. */
  byName = $state.raw<ReadonlyMap<string, Parameter>>(new Map());
  /** When each was last read or reported. */
  readonly #at = new Map<string, Date>();
  /** Counts the values that came one by one, to tell which are newer than a list. */
  #singles = 0;
  readonly #singleOf = new Map<string, number>();
  /** Whether all were read. */
  isWhole = $state(false);
  /** What may have changed them unseen since: a restart of the vehicle, or a gap in this page's own connection. */
  outdatedBy = $state<'restart' | 'gap' | null>(null);
  /** Whether they may be out of date. */
  isOld = $derived(this.outdatedBy !== null);
  /** What went wrong when they were read. */
  problem = $state.raw<Problem | null>(null);
  /** Whether a person stopped the reading. */
  isStopped = $state(false);
  edit = $state<ParamEdit | null>(null);
  readonly answers = new SvelteMap<string, ParamAnswer>();
  #operation = $state.raw<Operation | null>(null);
  #reading = $state.raw<Promise<boolean> | null>(null);
  /** Whether nobody asked for the reading that is under way. */
  #isUnasked = false;
  /** Whether the reading that is under way was given up: it becomes due again. */
  #isGivenUp = false;
  /** Whether it waits for a plan. */
  #hasMadeRoom = $state(false);
  readonly #whenChanged: () => void;
  /** What is to be edited once it is known. */
  #wanted: string | null = null;

  isReading = $derived(this.#reading !== null);
  /** Why none is set now; `null` when one may be. */
  bar = $derived.by(() => station.barOf(vehicles.get(this.systemId) ?? null));
  /** Whether a change takes a held button: unknown does not count as disarmed. */
  isHeld = $derived.by(() => vehicles.get(this.systemId)?.isArmed !== false);
  /**
   * Whether the panel reads them without being asked. Not of an armed vehicle: the list takes a large share of a slow radio, and a plan
   * waits for it. Not after a gap in the page's connection either: vehicle and station need not have lost each other.
   */
  isDue = $derived.by(() => {
    if (this.isReading || this.isStopped || this.#hasMadeRoom || this.problem !== null || this.isHeld) return false;
    if (!station.isOperator || this.bar === 'recording' || this.bar === 'away') return false;
    if (operations.running.some(({ vehicle }) => vehicle === this.systemId)) return false;
    return !this.isWhole || this.outdatedBy === 'restart';
  });
  /** Share of the list that was read; `null` while that is not known. */
  done = $derived.by<number | null>(() => {
    if (this.#operation === null) return null;
    const { done, total } = operations.get(this.#operation.id) ?? this.#operation;
    return total > 0 ? Math.min(1, done / total) : null;
  });
  prefixes = $derived(countPrefixes(this.byName.values()));
  /** Whether the vehicle gives default values. */
  hasDefaults = $derived([...this.byName.values()].some((param) => param.default != null));

  constructor(systemId: number, whenChanged: () => void) {
    this.systemId = systemId;
    this.#whenChanged = whenChanged;
  }

  get(name: string): Parameter | undefined {
    return this.byName.get(name);
  }

  readAt(name: string): Date | undefined {
    void this.byName; // changes with it
    return this.#at.get(name);
  }

  /** Reads all, unless that is under way; whether they were read. */
  read(): Promise<boolean> {
    this.#isUnasked = false;
    return this.#begin();
  }

  /** Reads all without being asked: that makes room for a plan, and ends when the vehicle is armed. */
  readUnasked(): void {
    if (this.isReading) return;
    this.#isUnasked = true;
    void this.#begin();
  }

  /** The vehicle has told of its state: the list takes a large share of a slow radio. */
  heard(): void {
    if (this.#reading !== null && this.#isUnasked && !this.#isGivenUp && this.isHeld) void this.#giveUpUnasked();
  }

  /** Ends a reading that nobody asked for, until it is due again. */
  async #giveUpUnasked(): Promise<void> {
    if (this.#reading === null || !this.#isUnasked) return;
    this.#isGivenUp = true;
    await this.#cancel();
    await this.#reading;
  }

  /** Does something without a reading that nobody asked for: of a vehicle one transfer is under way at a time. */
  async makeRoom<Result>(work: () => Promise<Result>): Promise<Result> {
    this.#hasMadeRoom = true;
    try {
      await this.#giveUpUnasked();
      return await work();
    } finally {
      this.#hasMadeRoom = false;
    }
  }

  #begin(): Promise<boolean> {
    this.#reading ??= this.#read().finally(() => (this.#reading = null));
    return this.#reading;
  }

  async #read(): Promise<boolean> {
    this.problem = null;
    [this.isStopped, this.#isGivenUp] = [false, false];
    const begun = this.#singles;
    try {
      this.#operation = await api.readParams(this.systemId);
      if (this.isStopped || this.#isGivenUp) await operations.cancel(this.#operation.id);
      this.#takeAll(await operations.finish<Parameter[]>(this.#operation), begun);
      return true;
    } catch (error) {
      this.problem = this.isStopped || this.#isGivenUp ? null : problemFrom(error);
      return false;
    } finally {
      this.#operation = null;
    }
  }

  async stopReading(): Promise<void> {
    this.isStopped = true;
    await this.#cancel();
  }

  async #cancel(): Promise<void> {
    if (this.#operation === null) return;
    try {
      await operations.cancel(this.#operation.id);
    } catch (error) {
      this.problem = problemFrom(error);
    }
  }

  /** How many values came one by one until now: what a list that begins now is given as `begun`. */
  get singles(): number {
    return this.#singles;
  }

  /** Takes over a list, except what was set or told one by one after its reading had begun: that is newer. */
  #takeAll(params: readonly Parameter[], begun: number): void {
    const byName = new Map(params.map((param) => [param.name, param]));
    const now = new Date();
    for (const { name } of params) if ((this.#singleOf.get(name) ?? 0) <= begun) this.#at.set(name, now);
    for (const [name, single] of this.#singleOf) {
      const known = this.byName.get(name);
      if (single <= begun || known === undefined) continue;
      byName.set(name, { ...known, default: byName.get(name)?.default ?? known.default ?? null });
    }
    this.byName = byName;
    for (const { name, value } of byName.values()) this.#settle(name, value);
    this.isWhole = true;
    this.outdatedBy = null;
    this.problem = null;
    this.#beginWanted();
    this.#whenChanged();
  }

  /** An answer "set and verified" ends with the value that it is about. */
  #settle(name: string, value: number): void {
    const answer = this.answers.get(name);
    if (answer?.state === 'set' && answer.value !== value) this.answers.delete(name);
  }

  /** Reads one from the vehicle; throws its problem. */
  async readOne(name: string): Promise<Parameter> {
    const param = await api.readParam(this.systemId, name);
    this.#take(param);
    return param;
  }

  /** A value as the vehicle has it; only a list gives its default. */
  #take(param: Parameter): void {
    const known = this.byName.get(param.name);
    const isNews = known?.value !== param.value;
    this.#at.set(param.name, new Date());
    this.#singleOf.set(param.name, ++this.#singles);
    this.#settle(param.name, param.value);
    this.byName = new Map(this.byName).set(param.name, { ...param, default: param.default ?? known?.default ?? null });
    if (isNews) this.#whenChanged();
  }

  /** A value that the vehicle reported, whoever set it. What is being typed stays, and the news is told beside it. */
  told(param: Parameter): void {
    const isOurs = this.answers.get(param.name)?.state === 'sending';
    const isNews = this.byName.get(param.name)?.value !== param.value;
    if (this.edit?.name === param.name && isNews && !isOurs) this.edit.told = param.value;
    if (isNews && !isOurs) this.answers.delete(param.name);
    this.#take(param);
  }

  /** Another page has read all: its list is taken over. `begun`: the count of `singles` when that reading began. */
  async follow(operation: Operation, begun: number): Promise<void> {
    if (this.isReading) return;
    try {
      const { result } = await api.operation<Parameter[]>(operation.id);
      if (result !== undefined && !this.isReading) this.#takeAll(result, begun);
    } catch {
      // what is known stays
    }
  }

  /** Begins an edit as soon as the parameter is known. What is being typed for another stays. */
  want(name: string): void {
    const { edit } = this;
    const edited = edit === null ? undefined : this.byName.get(edit.name);
    const isTyped = edited !== undefined && edit?.text !== writeParam(edited.value, edited.kind, decimalPoint());
    this.#wanted = isTyped ? null : name;
    this.#beginWanted();
  }

  #beginWanted(): void {
    if (this.#wanted === null || !this.byName.has(this.#wanted)) return;
    this.begin(this.#wanted);
    this.#wanted = null;
  }

  /** Begins to type a new value; another edit ends. */
  begin(name: string): void {
    const param = this.byName.get(name);
    if (param === undefined || this.edit?.name === name) return;
    this.edit = { name, text: writeParam(param.value, param.kind, decimalPoint()), told: null };
    if (this.answers.get(name)?.state === 'set') this.answers.delete(name);
  }

  /** Ends the edit. A refusal was read by then. */
  leave(): void {
    const name = this.edit?.name ?? '';
    if (this.answers.get(name)?.state === 'refused') this.answers.delete(name);
    this.edit = null;
  }

  /** Sends what was typed, if it can be sent. */
  async send(): Promise<void> {
    const { edit } = this;
    const param = edit === null ? undefined : this.byName.get(edit.name);
    if (edit === null || param === undefined) return;
    const { value } = readParam(edit.text, param.kind);
    if (value === null) return;
    const answer = await this.set(edit.name, value);
    if (answer.state === 'set' && this.edit === edit) this.leave();
  }

  /**
   * Sets one parameter; the server reports success when the vehicle shows the value. `acts`: what a person has confirmed of it.
   */
  async set(name: string, value: number, acts: readonly string[] = []): Promise<ParamAnswer> {
    const was = this.byName.get(name)?.value ?? null;
    this.answers.set(name, { state: 'sending', value });
    let answer: ParamAnswer;
    try {
      const param = await api.setParam(this.systemId, name, value, acts);
      this.#take(param);
      answer = { state: 'set', value: param.value, was };
    } catch (error) {
      const problem = problemFrom(error);
      const known = this.byName.get(name);
      if (problem.cause?.code === 'param-not-kept' && known !== undefined) {
        this.#take({ ...known, value: problem.cause.kept });
      }
      answer = { state: 'refused', value, problem };
    }
    this.answers.set(name, answer);
    return answer;
  }
}

class Params {
  readonly #byVehicle = new Map<number, VehicleParams>();
  readonly #listeners = new Set<() => void>();
  /** Readings that are under way, of any page, with the `singles` at their beginning. Those that had ended before this page came may be
   * out of date. */
  readonly #running = new Map<Operation['id'], number>();
  /** What the panel searches for; set to show a parameter that is named elsewhere. */
  search = $state('');
  /** Those of the selected vehicle. */
  selected = $derived.by(() => (vehicles.selected === null ? null : this.of(vehicles.selected.systemId)));

  of(systemId: number): VehicleParams {
    let found = this.#byVehicle.get(systemId);
    if (found === undefined) {
      found = new VehicleParams(systemId, () => this.#listeners.forEach((listener) => listener()));
      this.#byVehicle.set(systemId, found);
    }
    return found;
  }

  /** Calls `listener` after values have changed: those of a plane decide how it flies a plan. */
  whenChanged(listener: () => void): void {
    this.#listeners.add(listener);
  }

  receive(message: ServerMessage): void {
    if (message.type === 'hello') for (const one of this.#byVehicle.values()) one.outdatedBy ??= 'gap';
    if (message.type === 'operation' && message.kind === 'read_params') {
      const table = this.#byVehicle.get(message.vehicle);
      const begun = this.#running.get(message.id);
      if (message.state === 'running') this.#running.set(message.id, begun ?? table?.singles ?? 0);
      else {
        this.#running.delete(message.id);
        if (begun !== undefined && message.state === 'done') void table?.follow(message, begun);
      }
    }
    if (message.type === 'telemetry') this.#byVehicle.get(message.vehicle)?.heard();
    if (message.type === 'param') this.#byVehicle.get(message.vehicle)?.told(message.param);
    if (message.type === 'event' && message.kind === 'rebooted') {
      const rebooted = this.#byVehicle.get(message.vehicle);
      if (rebooted !== undefined) rebooted.outdatedBy = 'restart';
    }
  }
}

export const params = new Params();
station.whenTold((message) => params.receive(message));
