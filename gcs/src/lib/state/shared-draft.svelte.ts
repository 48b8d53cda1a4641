// The plan's draft on the server, beside the one in this browser: saved there after each change, offered where it is not open,
// and a person is asked when two were changed.
import type { PlanDraft as ServerDraft, PlanDrafts } from '$lib/api/types';
import { isFenceEmpty } from '$lib/domain/area-edit';
import { markOf, meet } from '$lib/domain/draft-sync';
import { emptyPlan, type Plan } from '$lib/domain/plan';
import { planOf } from '$lib/domain/plan-edit';
import { readPlan } from '$lib/domain/plan-read';
import { plan } from './plan.svelte';
import { api, problemFrom, station } from './station.svelte';
import { load, save } from './stored';

/** After an edit the next is waited for before the draft goes to the server. */
const PUSH_MS = 1000;

/** A draft on the server that differs from the one open here. */
interface Theirs {
  readonly kind: 'offer' | 'conflict';
  readonly draft: ServerDraft;
  readonly plan: Plan;
}

const markOfPlan = (value: Plan): string => markOf(JSON.stringify(readPlan(value) ?? emptyPlan()));
const isEmptyPlan = ({ items, fence, rally }: Plan): boolean =>
  items.length === 0 && isFenceEmpty(fence) && rally.length === 0;
const readCount = (value: unknown): number | null => (Number.isSafeInteger(value) ? (value as number) : null);
const readText = (value: unknown): string | null => (typeof value === 'string' ? value : null);

class SharedDraft {
  theirs = $state.raw<Theirs | null>(null);
  /** This browser, for the others. */
  readonly author = ownName();
  #base = load('draft-base', 0, readCount);
  #savedMark = load('draft-saved', '', readText);
  /** Mark of a draft taken over from a vehicle, which holds no changes of the user. */
  #foundMark = load('draft-found', '', readText);
  #timer: ReturnType<typeof setTimeout> | undefined;
  #isBusy = false;
  /** The revision that the server had last; null until it was looked at. */
  #seen: number | null = null;
  /** An offer that was declined is not made again. */
  #declined = 0;

  /** Takes the plan on board a vehicle into the draft without counting that as a change by the user. */
  found(take: () => void): void {
    const mine = planOf(plan.draft);
    const isOurs = this.#isChanged(markOfPlan(mine)) && !isEmptyPlan(mine);
    take();
    if (isOurs) return;
    this.#foundMark = markOfPlan(planOf(plan.draft));
    save('draft-found', this.#foundMark);
  }

  #isChanged(mark: string): boolean {
    return mark !== this.#savedMark && mark !== this.#foundMark;
  }

  /** The draft was edited. */
  changed(): void {
    clearTimeout(this.#timer);
    if (this.theirs?.kind === 'conflict' || this.#seen === null) return;
    // a drag changes the draft in every frame: what it comes to is compared once, afterwards
    this.#timer = setTimeout(() => {
      if (!this.#isChanged(markOfPlan(planOf(plan.draft)))) return;
      // what the server has and we do not know is looked at first
      void (this.#seen === this.#base ? this.#push(this.#base) : this.look());
    }, PUSH_MS);
  }

  /** The draft on the server was changed. */
  told(revision: number, author: string): void {
    // it may come before the answer to our own save; other windows of this browser share our name
    if (revision !== this.#base && (author !== this.author || !this.#isBusy)) void this.look();
  }

  /** Looks at what the server has: after each connection, and when it was changed there. */
  async look(): Promise<void> {
    if (!station.isOperator) return;
    let drafts: PlanDrafts;
    try {
      drafts = await api.draft();
    } catch {
      return; // an older server, or none: the next connection looks again
    }
    const draft = drafts.current;
    this.#seen = draft?.revision ?? 0;
    // what others wrote is checked like any file
    const theirs = draft === null ? null : (readPlan(draft.plan) ?? emptyPlan());
    const mine = planOf(plan.draft);
    const mark = markOfPlan(mine);
    const local = {
      base: this.#base,
      mark,
      isChanged: this.#isChanged(mark),
      isEmpty: isEmptyPlan(mine) || mark === this.#foundMark,
    };
    const known =
      draft === null || theirs === null
        ? null
        : { revision: draft.revision, mark: markOfPlan(theirs), isEmpty: isEmptyPlan(theirs) };
    const meeting = meet(local, known);
    this.theirs = null;
    if (meeting === 'adopt') this.#note(known?.revision ?? 0, mark);
    else if (meeting === 'push') await this.#push(known?.revision ?? 0);
    else if (draft !== null && theirs !== null && (meeting === 'offer' || meeting === 'conflict')) {
      if (meeting === 'offer' && draft.revision === this.#declined) return;
      this.theirs = { kind: meeting, draft, plan: theirs };
    }
  }

  /** Opens theirs; undo brings ours back. */
  takeTheirs(): void {
    const theirs = this.theirs;
    if (theirs === null) return;
    this.theirs = null;
    plan.replace(theirs.plan);
    this.#note(theirs.draft.revision, markOfPlan(planOf(plan.draft)));
  }

  /** Ours stays. After a conflict it takes the place of theirs, which the server keeps beside it. */
  async keepMine(): Promise<void> {
    const theirs = this.theirs;
    if (theirs === null) return;
    this.theirs = null;
    if (theirs.kind === 'offer') this.#declined = theirs.draft.revision;
    else await this.#push(theirs.draft.revision);
  }

  async #push(base: number): Promise<void> {
    clearTimeout(this.#timer);
    if (!station.isOperator || !station.isOnline) return;
    if (this.#isBusy) {
      this.#timer = setTimeout(() => void this.#push(this.#base), PUSH_MS);
      return;
    }
    const mine = planOf(plan.draft);
    const mark = markOfPlan(mine);
    this.#isBusy = true;
    let isConflict = false;
    try {
      const { revision } = await api.saveDraft({ base, author: this.author, plan: mine });
      this.#note(revision, mark);
    } catch (error) {
      isConflict = problemFrom(error).status === 409;
    } finally {
      this.#isBusy = false;
    }
    if (isConflict) await this.look();
  }

  #note(revision: number, mark: string): void {
    this.#base = revision;
    this.#seen = revision;
    this.#savedMark = mark;
    save('draft-base', revision);
    save('draft-saved', mark);
  }
}

/** A name by chance, which stays this browser's. */
function ownName(): string {
  const known = load('draft-author', '', readText);
  if (/^[0-9a-f]{16}$/.test(known)) return known;
  const bytes = globalThis.crypto.getRandomValues(new Uint8Array(8));
  const name = [...bytes].map((byte) => byte.toString(16).padStart(2, '0')).join('');
  save('draft-author', name);
  return name;
}

export const sharedDraft = new SharedDraft();
