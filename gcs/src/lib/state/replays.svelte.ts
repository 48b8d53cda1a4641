// Replays: what a person does with them. Their state comes with their vehicles.
import { problemFrom } from '$lib/api/problem';
import { replaysApi, type NewReplay, type ReplayChange, type ReplayMark } from '$lib/api/replays';
import type { Problem } from '$lib/api/types';
import { SvelteMap } from 'svelte/reactivity';
import { station } from './station.svelte';
import { vehicles } from './vehicles.svelte';

class Replays {
  #failed = $state.raw<{ readonly id: number | null; readonly problem: Problem } | null>(null);
  /** Why none could be opened. */
  problem = $derived(this.#failed?.id === null ? this.#failed.problem : null);
  /** Whether a recording is being opened: a large one takes seconds. */
  isOpening = $state(false);
  /** What happened in recordings, by the id of their replay. */
  readonly #marks = new SvelteMap<number, readonly ReplayMark[]>();

  /** Where replays are being taken to, by their ids. */
  readonly #sought_s = new SvelteMap<number, number>();

  /** Replays a recording, and shows its first vehicle: a person asked for it, unless that person has selected another meanwhile. */
  async open(asked: NewReplay): Promise<void> {
    this.isOpening = true;
    const before = vehicles.selected;
    await this.#try(null, async () => {
      const replay = await replaysApi.open(asked);
      station.beginReplay(replay);
      const [first] = replay.vehicles;
      const now = vehicles.selected;
      const isAsBefore = now === before || (now !== null && replay.vehicles.includes(now.systemId));
      if (first !== undefined && isAsBefore) station.choose(first);
    });
    this.isOpening = false;
  }

  change(id: number, change: ReplayChange): Promise<void> {
    return this.#try(id, async () => station.applyReplay(await replaysApi.change(id, change)));
  }

  /** Takes a replay to a place: one request at a time, and of the places asked for meanwhile the last. */
  async seek(id: number, position_s: number): Promise<void> {
    const isUnderWay = this.#sought_s.has(id);
    this.#sought_s.set(id, position_s);
    if (isUnderWay) return;
    let asked_s: number | null;
    do {
      asked_s = this.soughtIn(id);
      await this.change(id, { position_s: asked_s });
    } while (asked_s !== this.soughtIn(id));
    this.#sought_s.delete(id);
  }

  /** The place that a replay is being taken to, seconds; null while it plays from where it is. */
  soughtIn(id: number): number | null {
    return this.#sought_s.get(id) ?? null;
  }

  close(id: number): Promise<void> {
    return this.#try(id, () => replaysApi.close(id));
  }

  /** What went wrong with a replay. */
  problemOf(id: number): Problem | null {
    return this.#failed?.id === id ? this.#failed.problem : null;
  }

  dismiss(): void {
    this.#failed = null;
  }

  /** What happened to a vehicle of a recording. */
  marksOf(id: number, systemId: number): readonly ReplayMark[] {
    return (this.#marks.get(id) ?? []).filter(({ vehicle }) => vehicle === systemId);
  }

  /** Fetches what happened in a recording; without it the scale has no marks. */
  async readMarks(id: number): Promise<void> {
    try {
      this.#marks.set(id, await replaysApi.marks(id));
    } catch {
      this.#marks.delete(id);
    }
  }

  /** `id`: of the replay; `null` while there is none yet. */
  async #try(id: number | null, work: () => Promise<unknown>): Promise<void> {
    this.#failed = null;
    try {
      await work();
    } catch (error) {
      this.#failed = { id, problem: problemFrom(error) };
    }
  }
}

export const replays = new Replays();
