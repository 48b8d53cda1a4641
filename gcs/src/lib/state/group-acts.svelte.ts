// A group action on the marked vehicles: one request to each, and each result.
import { SvelteMap } from 'svelte/reactivity';
import { connection } from '$lib/api/connection';
import type { Problem } from '$lib/api/types';
import { type GroupAct, inTurns, isToldNothing, type Outcome, OUTCOMES, outcomeOf } from '$lib/domain/group-act';
import type { Listed } from '$lib/domain/roster';
import { api, problemFrom } from './station.svelte';

/** Requests under way at once: a browser has six connections, and a single act must find one free. */
const AT_ONCE = 4;

interface GroupAnswer {
  readonly id: number;
  readonly name: string;
  readonly state: 'waiting' | Outcome;
  readonly problem: Problem | null;
  /** It is disarmed: nothing was sent. */
  readonly isDisarmed: boolean;
}

class GroupActs {
  /** The act that was asked for last; null when none was, or its answers were put away. */
  act = $state<GroupAct | null>(null);
  readonly #answers = new SvelteMap<number, GroupAnswer>();
  /** Aborted when another act takes this one's place. */
  #overtaken = new AbortController();

  answers = $derived([...this.#answers.values()]);
  counts = $derived(
    Object.fromEntries(
      ['waiting', ...OUTCOMES].map((state) => [state, this.answers.filter((one) => one.state === state).length]),
    ) as Record<'waiting' | Outcome, number>,
  );
  isUnderWay = $derived(this.counts.waiting > 0);

  /** Whether this very act is under way. */
  isDoing(act: GroupAct): boolean {
    return this.isUnderWay && this.act === act;
  }

  /**
   * Asks each of them, in this order; resolves when each has its answer. Another act, which may be urgent, ends the one under way:
   * its requests are given up, and those that wait in line are not sent.
   */
  async do(act: GroupAct, whom: readonly Listed[]): Promise<void> {
    if (this.isDoing(act) || whom.length === 0) return;
    this.#overtaken.abort();
    this.#overtaken = new AbortController();
    const { signal: overtaken } = this.#overtaken;
    this.act = act;
    this.#answers.clear();
    for (const { row, name } of whom) {
      const isDisarmed = isToldNothing(row);
      const state = isDisarmed ? 'refused' : 'waiting';
      this.#answers.set(row.id, { id: row.id, name, state, problem: null, isDisarmed });
    }
    const told = whom.filter(({ row }) => !isToldNothing(row));
    // requests still queued when the connection is lost are not sent later
    const signal = connection.or(overtaken);
    await inTurns(told, AT_ONCE, async ({ row, name }) => {
      if (overtaken.aborted) return;
      let answer: GroupAnswer = { id: row.id, name, state: 'done', problem: null, isDisarmed: false };
      try {
        await api.command(row.id, act, {}, { signal });
      } catch (error) {
        const problem = problemFrom(error);
        answer = { ...answer, state: outcomeOf(problem.cause?.code ?? null), problem };
      }
      if (!overtaken.aborted) this.#answers.set(row.id, answer);
    });
  }

  /** Puts the answers away. */
  forget(): void {
    if (this.isUnderWay) return;
    this.act = null;
    this.#answers.clear();
  }
}

export const groupActs = new GroupActs();
