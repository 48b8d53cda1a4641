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

interface Writing {
  readonly done: number;
  readonly total: number;
}

/** Whether a refusal concerns one parameter; after any other the next one would fare no better. */
function isOfOne({ cause }: Problem): boolean {
  if (cause?.code === 'unknown-param') return cause.told;
  return ['param-refused', 'param-not-kept', 'invalid-param', 'needs-confirmation'].includes(cause?.code ?? '');
}

class ParamFiles {
  #opened = $state.raw<Opened | null>(null);
  problem = $state.raw<Problem | null>(null);
  /** Names that are not to be written. */
  readonly skipped = new SvelteSet<string>();
  writing = $state.raw<Writing | null>(null);
  /** Of the last writing: how many were set, and how many were not. */
  written = $state.raw<{ readonly set: number; readonly refused: number } | null>(null);
  #isStopped = false;

  /** The file that is compared with the selected vehicle. */
  opened = $derived(this.#opened?.of === params.selected ? this.#opened : null);
  comparison = $derived.by<ParamComparison | null>(() =>
    this.opened === null ? null : compareParams(this.opened.file, this.opened.of.byName),
  );
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
      this.problem = problemFrom(error);
    }
  }

  close(): void {
    this.#opened = null;
    this.problem = null;
    this.written = null;
    this.skipped.clear();
  }

  choose(name: string, isChosen: boolean): void {
    if (isChosen) this.skipped.delete(name);
    else this.skipped.add(name);
  }

  chooseAll(isChosen: boolean): void {
    this.skipped.clear();
    if (!isChosen) for (const { name } of this.comparison?.differing ?? []) this.skipped.add(name);
  }

  /** Writes the chosen ones, one after the other. Those that are set are equal then, and leave the list. */
  async write(): Promise<void> {
    const { opened, chosen } = this;
    if (opened === null || this.writing !== null) return;
    this.#isStopped = false;
    this.problem = null;
    let [set, refused] = [0, 0];
    for (const [done, { name, inFile }] of chosen.entries()) {
      if (this.#isStopped) break;
      this.writing = { done, total: chosen.length };
      const answer = await opened.of.set(name, inFile);
      if (answer.state === 'set') set += 1;
      else refused += 1;
      if (answer.state === 'refused' && !isOfOne(answer.problem)) {
        this.problem = answer.problem;
        break;
      }
    }
    this.written = { set, refused };
    this.writing = null;
  }

  /** Ends the writing after the parameter that is being set. */
  stop(): void {
    this.#isStopped = true;
  }

  /** All parameters of the selected vehicle as a file; `null` when it cannot be made. */
  async fileOf(of: VehicleParams): Promise<Blob | null> {
    this.problem = null;
    try {
      return await api.formatParams([...of.byName.values()].map(({ name, value }) => ({ name, value })));
    } catch (error) {
      this.problem = problemFrom(error);
      return null;
    }
  }
}

export const paramFiles = new ParamFiles();
