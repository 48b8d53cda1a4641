// Replays: what a person does with them. Their state comes with their vehicles.
import { problemFrom } from '$lib/api/problem';
import { replaysApi, type NewReplay, type ReplayChange, type ReplayMark } from '$lib/api/replays';
import type { Problem } from '$lib/api/types';
import { station } from './station.svelte';

class Replays {
  problem = $state.raw<Problem | null>(null);
  /** Whether a recording is being opened: a large one takes seconds. */
  isOpening = $state(false);
  /** What happened in a recording, by the id of its replay. */
  #marks = $state.raw<{ readonly id: number; readonly list: readonly ReplayMark[] } | null>(null);

  /** Replays a recording, and shows its first vehicle: a person asked for it. */
  async open(asked: NewReplay): Promise<void> {
    this.isOpening = true;
    await this.#try(async () => {
      const replay = await replaysApi.open(asked);
      station.applyReplay(replay);
      const [first] = replay.vehicles;
      if (first !== undefined) station.choose(first);
    });
    this.isOpening = false;
  }

  change(id: number, change: ReplayChange): Promise<void> {
    return this.#try(async () => station.applyReplay(await replaysApi.change(id, change)));
  }

  close(id: number): Promise<void> {
    return this.#try(() => replaysApi.close(id));
  }

  marksOf(id: number): readonly ReplayMark[] {
    return this.#marks?.id === id ? this.#marks.list : [];
  }

  /** Fetches what happened in a recording; without it the scale has no marks. */
  async readMarks(id: number): Promise<void> {
    try {
      this.#marks = { id, list: await replaysApi.marks(id) };
    } catch {
      this.#marks = { id, list: [] };
    }
  }

  async #try(work: () => Promise<unknown>): Promise<void> {
    this.problem = null;
    try {
      await work();
    } catch (error) {
      this.problem = problemFrom(error);
    }
  }
}

export const replays = new Replays();
