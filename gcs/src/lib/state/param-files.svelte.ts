// Parameter files: saved from the vehicle's values, and compared with them to write those that differ.
import type { FileParameter, Problem } from '$lib/api/types';
import { compareParams, type ParamComparison } from '$lib/domain/params';
import { SvelteSet } from 'svelte/reactivity';
import { params, type VehicleParams } from './params.svelte';
import { api, problemFrom } from './station.svelte';

interface Opened {
  readonly name: string;
  readonly file: readonly FileParameter[];
  /** The vehicle that it is compared with: another one has a comparison of its own. */
  readonly of: VehicleParams;
}

/** A file that is being written, to whatever vehicle. */
export interface Writing {
  readonly of: VehicleParams;
  readonly file: string;
  readonly done: number;
  readonly total: number;
}

/** How a writing ended. */
export interface Written {
  readonly of: VehicleParams;
  readonly file: string;
  readonly set: number;
  readonly refused: number;
  /** How many were left unwritten because the vehicle was not known to be disarmed any more. */
  readonly unheld: number;
  /** What ended it. */
  readonly problem: Problem | null;
}

/** Whether a refusal concerns one parameter; after any other the next one would fare no better. */
function isOfOne({ cause }: Problem): boolean {
  if (cause?.code === 'unknown-param') return cause.told;
  return ['param-refused', 'param-not-kept', 'invalid-param', 'needs-confirmation'].includes(cause?.code ?? '');
}

class ParamFiles {
  #opened = $state.raw<Opened | null>(null);
  #failed = $state.raw<{ readonly of: VehicleParams; readonly problem: Problem } | null>(null);
  /** Names that are not to be written. */
  readonly skipped = new SvelteSet<string>();
  writing = $state.raw<Writing | null>(null);
  #written = $state.raw<Written | null>(null);
  #isStopped = false;

  /** The file that is compared with the selected vehicle. */
  opened = $derived(this.#opened?.of === params.selected ? this.#opened : null);
  comparison = $derived.by<ParamComparison | null>(() =>
    this.opened === null ? null : compareParams(this.opened.file, this.opened.of.byName),
  );
  /** The end of the last writing, if that was to the selected vehicle. */
  written = $derived(this.#written?.of === params.selected ? this.#written : null);
  /** What went wrong with a file of the selected vehicle. */
  problem = $derived((this.#failed?.of === params.selected ? this.#failed?.problem : this.written?.problem) ?? null);
  /** A writing to another vehicle than the selected one that is under way or was cut short: whoever began it has to know. */
  elsewhere = $derived.by<Writing | Written | null>(() => {
    if (this.writing !== null) return this.writing.of === params.selected ? null : this.writing;
    const ended = this.#written;
    if (ended === null || ended.of === params.selected) return null;
    return ended.unheld > 0 || ended.problem !== null ? ended : null;
  });
  chosen = $derived((this.comparison?.differing ?? []).filter(({ name }) => !this.skipped.has(name)));

  async open(file: File): Promise<void> {
    const of = params.selected;
    if (of === null || this.writing !== null) return;
    this.close();
    try {
      const read = await api.parseParams(file);
      for (const { name } of read) of.answers.delete(name);
      this.#opened = { name: file.name, file: read, of };
    } catch (error) {
      this.#failed = { of, problem: problemFrom(error) };
    }
  }

  /** Puts the file away, and what became of it; not what became of a file of another vehicle. */
  close(): void {
    this.#opened = null;
    if (this.#failed?.of === params.selected) this.#failed = null;
    if (this.#written?.of === params.selected) this.#written = null;
    this.skipped.clear();
  }

  /** Puts away what became of the last file. */
  dismiss(): void {
    this.#failed = null;
    this.#written = null;
  }

  choose(name: string, isChosen: boolean): void {
    if (isChosen) this.skipped.delete(name);
    else this.skipped.add(name);
  }

  chooseAll(isChosen: boolean): void {
    this.skipped.clear();
    if (!isChosen) for (const { name } of this.comparison?.differing ?? []) this.skipped.add(name);
  }

  /**
   * Writes the chosen ones, one after the other. Those that are set are equal then, and leave the list. What was begun with the vehicle
   * disarmed stops when it is armed: from then on each value takes a held button.
   */
  async write(): Promise<void> {
    const { opened, chosen } = this;
    if (opened === null || this.writing !== null) return;
    const { of, name: file } = opened;
    const wasHeld = of.isHeld;
    const total = chosen.length;
    this.#isStopped = false;
    this.dismiss();
    let [set, refused, unheld] = [0, 0, 0];
    let problem: Problem | null = null;
    for (const [done, { name, inFile }] of chosen.entries()) {
      if (this.#isStopped) break;
      if (of.isHeld && !wasHeld) {
        unheld = total - done;
        break;
      }
      this.writing = { of, file, done, total };
      const answer = await of.set(name, inFile);
      if (answer.state === 'set') set += 1;
      else refused += 1;
      if (answer.state === 'refused' && !isOfOne(answer.problem)) {
        problem = answer.problem;
        break;
      }
    }
    this.#written = { of, file, set, refused, unheld, problem };
    this.writing = null;
  }

  /** Ends the writing after the parameter that is being set. */
  stop(): void {
    this.#isStopped = true;
  }

  /** All parameters of a vehicle as a file; `null` when it cannot be made. */
  async fileOf(of: VehicleParams): Promise<Blob | null> {
    this.#failed = null;
    try {
      return await api.formatParams([...of.byName.values()].map(({ name, value }) => ({ name, value })));
    } catch (error) {
      this.#failed = { of, problem: problemFrom(error) };
      return null;
    }
  }
}

export const paramFiles = new ParamFiles();
