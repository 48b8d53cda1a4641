// The plan being edited: its items, the selection, and undo. Its assessment is in
// plan-assessed, the comparison with the vehicle in plan-compared, transfers in plan-transfers, its landing in plan-landing.
import type { Plan as ApiPlan, PlanKind, Problem, UnknownLevel } from '$lib/api/types';
import { type Areas, isFenceEmpty } from '$lib/domain/area-edit';
import { commit, type History, historyOf, redo, seal, undo } from '$lib/domain/history';
import type { LonLat } from '$lib/domain/lonlat';
import { altOf_m, type EditableKind, emptyPlan, type HeightFrame, type Home, type Plan } from '$lib/domain/plan';
import {
  type Added,
  changeCommand,
  type Draft,
  type DraftItem,
  draftOf,
  type EditDefaults,
  exchange,
  insertOnLeg,
  moveTo,
  nudge,
  numberOfKey,
  planOf,
  removeKeys,
  reorder,
  setAlt,
  setParam,
} from '$lib/domain/plan-edit';
import { readPlan } from '$lib/domain/plan-read';
import { roundLength_m } from '$lib/domain/units';
import { type End, NO_END } from '$lib/domain/way';
import { settings } from './settings.svelte';
import { api, problemFrom } from './station.svelte';
import { load, save } from './stored';
import { vehicles } from './vehicles.svelte';

/** What a click on the map makes. */
export type PlanTool = EditableKind | 'select' | 'runway';

const SAVE_MS = 300;

/** Height of new items until one is chosen, metres. */
const NEW_ALT_M = 80;

interface Chosen {
  /** `null` until one is chosen. */
  readonly alt_m: number | null;
  readonly frame: HeightFrame;
}

class PlanStore {
  #history = $state.raw<History<Draft>>(historyOf(draftOf(load('draft', emptyPlan(), readPlan))));
  #selection = $state.raw<ReadonlySet<number>>(new Set());
  #isEditing = $state(false);
  #chosen = $state.raw<Chosen>(load('plan-defaults', { alt_m: null, frame: 'home' }, readChosen));
  /** How the mission ends, from the core's last answer. */
  end = $state.raw<End>(NO_END);
  tool = $state<PlanTool>('waypoint');
  /** Which part of the plan is being edited. */
  part = $state<PlanKind>('mission');
  /** What went wrong with the last file or change of the draft. */
  problem = $state.raw<Problem | null>(null);
  #unconverted = $state.raw<{ readonly level: UnknownLevel; readonly items: readonly DraftItem[] } | null>(null);
  /** Whether each click or tap on an item adds it to the selection, for those who have no Shift key. */
  isPickingMany = $state(false);
  #underWay: Promise<unknown> = Promise.resolve();
  #generation = 0;
  #saveTimer: ReturnType<typeof setTimeout> | undefined;
  readonly #listeners: (() => void)[] = [];
  readonly #onReplaced: ((before: Draft) => void)[] = [];

  /** Where heights count from: the vehicle's home, else the one that the plan names. */
  home = $derived.by<Home | null>(() => {
    const [lat_deg, lon_deg, alt_amsl_m] = [this.#homeLat_deg, this.#homeLon_deg, this.#homeAlt_m];
    if (lat_deg === null || lon_deg === null || alt_amsl_m === null) return this.#history.present.home;
    return { lat_deg, lon_deg, alt_amsl_m };
  });
  // as plain numbers: home is sent repeatedly, and unchanged values must not cause a redraw
  #homeLat_deg = $derived(vehicles.selected?.groups.home?.lat_deg ?? null);
  #homeLon_deg = $derived(vehicles.selected?.groups.home?.lon_deg ?? null);
  #homeAlt_m = $derived(vehicles.selected?.groups.home?.alt_amsl_m ?? null);
  draft = $derived<Draft>(this.#history.present);
  items = $derived<readonly DraftItem[]>(this.draft.items);
  selectedKeys = $derived(this.#selection);
  selection = $derived.by<ReadonlySet<number>>(() => {
    const numbers = [...this.#selection].map((key) => numberOfKey(this.draft, key));
    return new Set(numbers.filter((number) => number !== null));
  });
  /** What the last step was about, while it goes on. */
  get about(): string | null {
    return this.#history.about;
  }
  canUndo = $derived(this.#history.past.length > 0);
  canRedo = $derived(this.#history.future.length > 0);

  /** Items whose heights could not be converted to another level because a level is not known, until they are edited. */
  unconverted = $derived.by(() => {
    if (this.#unconverted === null) return null;
    const { level, items } = this.#unconverted;
    const numbers = items.map((item) => this.items.indexOf(item) + 1).filter((number) => number > 0);
    return numbers.length === 0 ? null : { level, numbers };
  });
  forgetUnconverted(): void {
    this.#unconverted = null;
  }

  /** Whether a part of the draft holds nothing. */
  isEmpty(part: PlanKind): boolean {
    if (part === 'mission') return this.items.length === 0;
    return part === 'fence' ? isFenceEmpty(this.draft.fence) : this.draft.rally.length === 0;
  }

  get isEditing(): boolean {
    return this.#isEditing;
  }
  set isEditing(isEditing: boolean) {
    this.#isEditing = isEditing;
    if (!isEditing) {
      this.tool = 'waypoint';
      this.part = 'mission';
      this.isPickingMany = false;
    }
  }

  get defaults(): EditDefaults {
    const { alt_m, frame } = this.#chosen;
    const length = settings.units.length;
    return { alt_m: alt_m ?? roundLength_m(NEW_ALT_M, length), frame, route: vehicles.route, end: this.end };
  }

  setDefaults(change: Partial<{ alt_m: number; frame: HeightFrame }>): void {
    this.#chosen = { ...this.#chosen, ...change };
    save('plan-defaults', this.#chosen);
  }

  // --- Selection ----------------------------------------------------------------------------------------------------

  select(numbers: Iterable<number>): void {
    const keys = [...numbers].map((number) => this.items[number - 1]?.key);
    this.#selection = new Set(keys.filter((key) => key !== undefined));
  }

  selectKeys(keys: Iterable<number>): void {
    this.#selection = new Set(keys);
  }

  /** Selects one item; adds it to the selection, or takes it out, when `isAdding`. */
  pick(key: number, isAdding = this.isPickingMany): void {
    if (!isAdding) this.#selection = new Set([key]);
    else {
      const next = new Set(this.#selection);
      if (!next.delete(key)) next.add(key);
      this.#selection = next;
    }
  }

  /** Selects all items from the selected one that is nearest to `key` up to it. */
  pickRange(key: number): void {
    const at = this.items.findIndex((item) => item.key === key);
    const picked = this.items.flatMap((item, index) => (this.#selection.has(item.key) ? [index] : []));
    const from = picked.length === 0 ? at : picked.reduce((a, b) => (Math.abs(b - at) < Math.abs(a - at) ? b : a));
    const [first, last] = [Math.min(from, at), Math.max(from, at)];
    this.#selection = new Set([...this.#selection, ...this.items.slice(first, last + 1).map((item) => item.key)]);
  }

  // --- Editing ------------------------------------------------------------------------------------------------------

  /** Registers a pending change by the core; sending and saving wait for it. */
  waitFor(change: Promise<void>): void {
    this.#underWay = Promise.allSettled([this.#underWay, change]);
  }

  /**
   * Changes with undo, redo, and another plan in the draft's place. An answer of the core to a question of an earlier generation is
   * not taken: it would bring back what was undone, and lose what can be redone.
   */
  get generation(): number {
    return this.#generation;
  }

  /** Resolves when no change is pending. */
  get settled(): Promise<unknown> {
    return this.#underWay;
  }

  /** Calls after each change of the draft. */
  whenChanged(listener: () => void): void {
    this.#listeners.push(listener);
  }

  /** Calls after the draft, or a part of it, was emptied or made another one: what was half drawn for the old one goes with it. */
  whenReplaced(listener: (before: Draft) => void): void {
    this.#onReplaced.push(listener);
  }

  #replaced(before: Draft): void {
    for (const listener of this.#onReplaced) listener(before);
  }

  /** Inserts on the leg that ends at item `toIndex`; gives the number of the new item. */
  insertOnLeg(toIndex: number, at: LonLat): number | null {
    return this.addWith((draft) => insertOnLeg(draft, toIndex, at, this.defaults), `insert-${this.draft.nextKey}`);
  }

  move(key: number, at: LonLat): void {
    this.edit((draft) => moveTo(draft, key, at));
  }

  setAlt(keys: ReadonlySet<number>, alt_m: number): void {
    this.edit((draft) => setAlt(draft, keys, alt_m));
  }

  /** Raises or lowers items by the same amount. Changes of the same items with the same `about` are one step. */
  shiftAlt(keys: ReadonlySet<number>, by_m: number, about: string): void {
    this.edit(
      (draft) => {
        let next = draft;
        for (const item of draft.items) {
          const alt_m = keys.has(item.key) ? altOf_m(item) : null;
          if (alt_m !== null) next = setAlt(next, new Set([item.key]), Math.round((alt_m + by_m) * 10) / 10);
        }
        return next;
      },
      `${about}-${[...keys].join()}`,
    );
  }

  /** Converts heights to another reference level; the core computes them. */
  setFrame(keys: ReadonlySet<number>, frame: HeightFrame): void {
    this.waitFor(
      this.#countFrom(
        frame,
        this.items.filter((item) => keys.has(item.key)),
      ),
    );
  }

  async #countFrom(frame: HeightFrame, chosen: readonly DraftItem[]): Promise<void> {
    const { items } = planOf({ ...this.draft, items: chosen });
    const vehicle = vehicles.selected?.systemId ?? null;
    try {
      this.problem = null;
      const asked = { plan: { ...emptyPlan(), items, home: this.home }, frame, vehicle };
      const { items: counted, unconverted } = await api.countFrom(asked);
      this.edit((draft) => exchange(draft, chosen, counted));
      const [first] = unconverted;
      const keys = new Set(unconverted.map(({ item }) => chosen[item - 1]?.key));
      const kept = this.items.filter(({ key }) => keys.has(key));
      this.#unconverted = first === undefined ? null : { level: first.level, items: kept };
    } catch (error) {
      this.problem = problemFrom(error);
    }
  }

  setParam(key: number, index: number, value: number | null): void {
    this.edit((draft) => setParam(draft, key, index, value));
  }

  changeCommand(key: number, command: number, at: LonLat | null = null): void {
    this.edit((draft) => changeCommand(draft, key, command, this.defaults, at));
  }

  remove(keys: ReadonlySet<number> = this.#selection): void {
    const first = this.items.findIndex((item) => keys.has(item.key));
    this.edit((draft) => removeKeys(draft, keys));
    // the next item is selected, so that the keyboard goes on where it was
    const next = this.items[Math.min(first, this.items.length - 1)];
    this.selectKeys(first >= 0 && next ? [next.key] : []);
  }

  nudge(by: -1 | 1): void {
    this.edit((draft) => nudge(draft, this.#selection, by));
  }

  reorder(keys: ReadonlySet<number>, index: number): void {
    this.edit((draft) => reorder(draft, keys, index));
  }

  /** Changes fence or rally points. Changes with the same `about` are one step. */
  editAreas(change: (areas: Areas) => Areas, about: string | null = null): void {
    this.edit((draft) => {
      const { fence, rally } = change(draft);
      return fence === draft.fence && rally === draft.rally ? draft : { ...draft, fence, rally };
    }, about);
  }

  /** Empties a part of the draft, or all of it; undo brings it back. */
  clear(part: PlanKind | 'all' = 'all'): void {
    const empty = emptyPlan();
    const before = this.draft;
    this.#generation += 1;
    this.edit((draft) => {
      if (part === 'fence') return { ...draft, fence: empty.fence };
      if (part === 'rally') return { ...draft, rally: empty.rally };
      return part === 'mission'
        ? { ...draft, items: [], complexItems: [], plannedFor: null }
        : { ...draftOf(empty), nextKey: draft.nextKey };
    });
    this.selectKeys([]);
    this.#replaced(before);
  }

  undo(): void {
    this.#generation += 1;
    this.#set(undo(this.#history));
  }

  redo(): void {
    this.#generation += 1;
    this.#set(redo(this.#history));
  }

  /** Ends a run of changes that count as one step. */
  seal(): void {
    this.#history = seal(this.#history);
  }

  /** Replaces the draft by a plan found on a vehicle. Nothing is lost, so there is nothing to undo. */
  begin(draft: Draft): void {
    const before = this.draft;
    this.#generation += 1;
    this.#set(historyOf(draft));
    this.#replaced(before);
  }

  /** Replaces the draft by a plan; undo brings the old one back. */
  replace(plan: Plan): void {
    const before = this.draft;
    this.#generation += 1;
    this.edit((draft) => {
      const next = draftOf(plan);
      const base = draft.nextKey;
      return {
        ...next,
        items: next.items.map((item) => ({ ...item, key: item.key + base })),
        nextKey: next.nextKey + base,
      };
    });
    this.selectKeys([]);
    this.#replaced(before);
  }

  /** Adds items, and selects the last; gives its number. */
  addWith(edit: (draft: Draft) => Added, about: string | null = null): number | null {
    let keys: readonly number[] = [];
    this.edit((draft) => {
      const added = edit(draft);
      keys = added.keys;
      return added.draft;
    }, about);
    const key = keys.at(-1);
    if (key === undefined) return null;
    this.selectKeys([key]);
    return numberOfKey(this.draft, key);
  }

  /** Changes the draft. Changes with the same `about` are one step. */
  edit(change: (draft: Draft) => Draft, about: string | null = null): void {
    const now = this.#history.present;
    const from = now.home === null && this.home !== null ? { ...now, home: this.home } : now;
    const next = change(from);
    this.#set(commit(this.#history, next === from ? now : next, about));
  }

  #set(history: History<Draft>): void {
    if (history === this.#history) return;
    this.#history = history;
    const alive = new Set(history.present.items.map((item) => item.key));
    if ([...this.#selection].some((key) => !alive.has(key))) {
      this.#selection = new Set([...this.#selection].filter((key) => alive.has(key)));
    }
    clearTimeout(this.#saveTimer);
    this.#saveTimer = setTimeout(() => this.saveNow(), SAVE_MS);
    for (const listener of this.#listeners) listener();
  }

  saveNow(): void {
    clearTimeout(this.#saveTimer);
    save('draft', planOf(this.#history.present));
  }

  /** As the server takes it. */
  asApi(): ApiPlan {
    return { ...planOf(this.#history.present), home: this.home };
  }
}

function readChosen(value: unknown): Chosen | null {
  if (typeof value !== 'object' || value === null) return null;
  const { alt_m, frame } = value as Record<string, unknown>;
  if (alt_m !== null && (typeof alt_m !== 'number' || !Number.isFinite(alt_m))) return null;
  return { alt_m, frame: (['home', 'amsl', 'terrain'] as const).find((one) => one === frame) ?? 'home' };
}

export const plan = new PlanStore();
