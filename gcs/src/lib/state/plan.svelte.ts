// The plan that is being edited, what of it the vehicle has, and the transfers between the two.
import type {
  LandingRequest,
  Operation,
  Plan as ApiPlan,
  PlanChange,
  PlanFileFormat,
  PlanFileNote,
  PlanFinding,
  PlanKind,
  Problem,
  Rehearsal,
  Trip,
  UnknownLevel,
} from '$lib/api/types';
import { type Areas, isFenceEmpty } from '$lib/domain/area-edit';
import { distance_m } from '$lib/domain/geo';
import { commit, type History, historyOf, redo, seal, undo } from '$lib/domain/history';
import type { LonLat } from '$lib/domain/lonlat';
import {
  altOf_m,
  type EditableKind,
  emptyPlan,
  type HeightFrame,
  type Home,
  isPlacedKind,
  type Plan,
  type PlanItem,
  placeOf,
} from '$lib/domain/plan';
import {
  addAt,
  type Added,
  addLanding,
  changeCommand,
  changeLanding,
  designedLanding,
  type Draft,
  type DraftItem,
  draftOf,
  type EditDefaults,
  exchange,
  insertOnLeg,
  landingPart,
  type LandingPart,
  moveTo,
  nudge,
  numberOfKey,
  planOf,
  removeKeys,
  reorder,
  setAlt,
  setParam,
  shiftKeys,
} from '$lib/domain/plan-edit';
import { readPlan } from '$lib/domain/plan-read';
import { type End, NO_END } from '$lib/domain/way';
import { Comparison, type Question } from './comparison.svelte';
import { elevation } from './maps-elevation.svelte';
import { onBoard, PLAN_PARTS } from './on-board.svelte';
import type { DraftState, PlanDraft } from './plan-draft';
import { planWind } from './plan-wind.svelte';
import { planeProfile } from './plane-profile.svelte';
import { api, operations, problemFrom, station } from './station.svelte';
import { load, save } from './stored';
import { type Vehicle, vehicles } from './vehicles.svelte';

/** What a click on the map makes. */
export type PlanTool = EditableKind | 'select' | 'runway';

const SAVE_MS = 300;
/** A rehearsal is drawn as old after so long without a newer one: not in the moments between two answers. */
const OLD_AFTER_MS = 200;
/** After that the core is asked again for a flight over ground that it did not know yet. */
const GROUND_AGAIN_MS = 700;

interface Transfer {
  readonly kind: 'send' | 'read' | 'clear';
  readonly part: PlanKind;
  readonly operation: Operation | null;
}

/** A line to land on, in either direction. */
export interface Runway {
  readonly begin: LonLat;
  readonly end: LonLat;
}

/** A part of the landing under a pointer. */
interface LandingDrag {
  readonly part: LandingPart;
  readonly key: number;
  /** The landing as it was before. */
  readonly items: readonly PlanItem[];
  readonly to: LonLat;
  readonly isEnd: boolean;
}

/** A step from the mission on board to the draft: the item there and here, where there is one. */
export interface ItemChange {
  readonly change: PlanChange;
  readonly item: PlanItem | undefined;
  readonly was: PlanItem | undefined;
}

interface Chosen {
  readonly alt_m: number;
  readonly frame: HeightFrame;
}

class PlanStore implements PlanDraft {
  #history = $state.raw<History<Draft>>(historyOf(draftOf(load('draft', emptyPlan(), readPlan))));
  #selection = $state.raw<ReadonlySet<number>>(new Set());
  #isEditing = $state(false);
  #chosen = $state.raw<Chosen>(load('plan-defaults', { alt_m: 80, frame: 'home' }, readChosen));
  /** How the mission ends, as the core told last. */
  end = $state.raw<End>(NO_END);
  tool = $state<PlanTool>('waypoint');
  /** Which part of the plan is being edited. */
  part = $state<PlanKind>('mission');
  transfer = $state.raw<Transfer | null>(null);
  /** What went wrong with the last transfer or file. */
  problem = $state.raw<Problem | null>(null);
  #unconverted = $state.raw<{ readonly level: UnknownLevel; readonly items: readonly DraftItem[] } | null>(null);
  /** What the file that was read or written last leaves to say. */
  fileNotes = $state.raw<readonly PlanFileNote[]>([]);
  findings = $state.raw<readonly PlanFinding[]>([]);
  /** The mission as it is flown; `null` when that is not known. */
  trip = $state.raw<Trip | null>(null);
  /** The mission as the plane would fly it in the wind; `null` when it was not rehearsed. */
  rehearsal = $state.raw<Rehearsal | null>(null);
  /** Whether the rehearsal is of the plan as it was before. */
  isRehearsalOld = $state(false);
  checkState = $state<'none' | 'checking' | 'done' | 'unavailable'>('none');
  /** Whether each click or tap on an item adds it to the selection, for those who have no Shift key. */
  isPickingMany = $state(false);
  isReadingParams = $state(false);
  #isAsking = false;
  #asksAgain = false;
  #underWay: Promise<unknown> = Promise.resolve();
  #landingRun = 0;
  /** Whether the core is at work on a landing that was asked for. */
  isDesigning = $state(false);
  /** The runway that the landing was last designed for. */
  #runway = $state.raw<Runway | null>(null);
  /** The end of a runway that was clicked first. */
  runwayBegin = $state.raw<LonLat | null>(null);
  #landingDrag: LandingDrag | null = null;
  #isMovingLanding = false;
  #oldTimer: ReturnType<typeof setTimeout> | undefined;
  #groundTimer: ReturnType<typeof setTimeout> | undefined;
  #saveTimer: ReturnType<typeof setTimeout> | undefined;
  /** The parts of the draft as they were found on board. */
  readonly #asRead: Partial<Record<PlanKind, unknown>> = {};

  /** Where heights count from: the vehicle's home, else the one that the plan names. */
  home = $derived.by<Home | null>(() => {
    const [lat_deg, lon_deg, alt_amsl_m] = [this.#homeLat_deg, this.#homeLon_deg, this.#homeAlt_m];
    if (lat_deg === null || lon_deg === null || alt_amsl_m === null) return this.#history.present.home;
    return { lat_deg, lon_deg, alt_amsl_m };
  });
  // as plain numbers: a vehicle tells its home again and again, and what is drawn from it need not be drawn again
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
  canUndo = $derived(this.#history.past.length > 0);
  canRedo = $derived(this.#history.future.length > 0);

  /** What the selected vehicle has on board; `null` when that is not known. */
  vehiclePlan = $derived<Plan | null>(onBoard.planOf('mission'));
  vehicleAreas = $derived({
    fence: onBoard.planOf('fence')?.fence ?? null,
    rally: onBoard.planOf('rally')?.rally ?? null,
  });

  readonly #comparison = new Comparison((...asked) => api.comparePlan(...asked));
  /** What of the draft can be compared with what; `null` while nothing is known of what is on board. */
  #comparable = $derived.by<Question | null>(() => {
    const vehicle = vehicles.selected;
    const { planStates } = vehicle ?? {};
    if (vehicle === null || !planStates || PLAN_PARTS.every((part) => planStates[part].state !== 'verified'))
      return null;
    const { items: mission, fence, rally } = this.draft;
    const { hash: missionHash } = planStates.mission;
    const [fenceHash, rallyHash] = [planStates.fence.hash, planStates.rally.hash];
    return { vehicle: vehicle.systemId, mission, fence, rally, missionHash, fenceHash, rallyHash };
  });

  /** How each part of the draft stands to the selected vehicle. */
  states = $derived.by<Readonly<Record<PlanKind, DraftState>>>(() => {
    const { fence, rally } = this.vehicleAreas;
    return {
      mission: this.#stateOf('mission', this.vehiclePlan && this.vehiclePlan.items.length === 0),
      fence: this.#stateOf('fence', fence && isFenceEmpty(fence)),
      rally: this.#stateOf('rally', rally && rally.length === 0),
    };
  });
  state = $derived<DraftState>(this.states.mission);

  /** The items whose heights were to count from another level and kept their numbers, since a level is not known, until somebody changes them. */
  unconverted = $derived.by(() => {
    if (this.#unconverted === null) return null;
    const { level, items } = this.#unconverted;
    const numbers = items.map((item) => this.items.indexOf(item) + 1).filter((number) => number > 0);
    return numbers.length === 0 ? null : { level, numbers };
  });
  forgetUnconverted(): void {
    this.#unconverted = null;
  }

  /** `isNothing`: whether nothing is on board; `null` when that is not known. */
  #stateOf(part: PlanKind, isNothing: boolean | null): DraftState {
    if (this.transfer?.kind === 'send' && this.transfer.part === part) return 'sending';
    const isEmpty = this.isEmpty(part);
    if (vehicles.selected === null) return isEmpty ? 'empty' : 'not-sent';
    if (isNothing === null) return 'unknown';
    if (isNothing) return isEmpty ? 'empty' : 'not-sent';
    const compared = this.#comparable && this.#comparison.of(part, this.#comparable);
    if (compared === null) return 'uncompared';
    return compared.changes.length === 0 ? 'verified' : 'differs';
  }

  /** Whether a part of the draft holds nothing. */
  isEmpty(part: PlanKind): boolean {
    if (part === 'mission') return this.items.length === 0;
    return part === 'fence' ? isFenceEmpty(this.draft.fence) : this.draft.rally.length === 0;
  }

  /** The parts that the vehicle does not have as they are here, nothing included that is in neither place. */
  unsent = $derived(
    PLAN_PARTS.filter((part) => !this.isEmpty(part) && !['verified', 'sending'].includes(this.states[part])),
  );

  /** How the draft differs from what is on board; empty when that is not known. */
  difference = $derived.by<readonly ItemChange[]>(() => {
    const compared = this.#comparable && this.#comparison.of('mission', this.#comparable);
    if (compared === null || this.vehiclePlan === null) return [];
    const { items } = this.vehiclePlan;
    return compared.changes.map((change) => ({
      change,
      item: 'item' in change ? compared.of[change.item - 1] : undefined,
      was: 'on_board' in change ? items[change.on_board - 1] : undefined,
    }));
  });

  /** Asks how the draft differs; to be called when anything of it, of what is on board, or the station, is another. */
  compare(): void {
    if (station.isOnline) this.#comparison.ask(this.#comparable);
    else this.#comparison.forget();
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
    return { ...this.#chosen, route: vehicles.route, end: this.end };
  }

  setDefaults(change: Partial<Chosen>): void {
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

  /** A change of the draft that the core is at: what is sent or saved meanwhile is to have it. */
  waitFor(change: Promise<void>): void {
    this.#underWay = Promise.allSettled([this.#underWay, change]);
  }

  /** Adds what the tool in hand makes. Take-off and landing are for one click each (SPEC G5). */
  addWithTool(at: LonLat): void {
    if (this.tool === 'select') {
      this.selectKeys([]);
      return;
    }
    if (this.tool === 'runway') {
      this.#markRunway(at);
      return;
    }
    this.add(this.tool, isPlacedKind(this.tool) ? at : null);
    if (this.tool === 'takeoff' || this.tool === 'land' || !isPlacedKind(this.tool)) this.tool = 'waypoint';
  }

  add(kind: EditableKind, at: LonLat | null): void {
    if (kind !== 'land') this.#add((draft) => addAt(draft, kind, at, this.defaults));
    else if (at !== null) this.waitFor(this.#land(at));
  }

  /** One end of a runway, then the other: the mission is to land there, into the wind. */
  #markRunway(at: LonLat): void {
    const begin = this.runwayBegin;
    this.runwayBegin = begin === null ? placeOnly(at) : null;
    if (begin === null) return;
    this.tool = 'waypoint';
    this.waitFor(this.#land(at, { begin, end: placeOnly(at) }));
  }

  /** Ends the mission with a landing as the core designs it; of two that are asked for in a row the last one counts. */
  async #land(at: LonLat, runway: Runway | null = null): Promise<void> {
    const run = ++this.#landingRun;
    this.isDesigning = true;
    try {
      this.problem = null;
      const { items } = await api.designLanding(this.#landing(at, runway, null));
      if (run !== this.#landingRun) return;
      this.#runway = runway;
      this.#endWith(items);
    } catch (error) {
      if (run === this.#landingRun) this.problem = problemFrom(error);
    } finally {
      if (run === this.#landingRun) this.isDesigning = false;
    }
  }

  /** Ends the mission with a landing, of which the core need not say that it is one. */
  #endWith(landing: readonly PlanItem[]): void {
    let keys: readonly number[] = [];
    this.#add((draft) => {
      const added = addLanding(draft, landing, this.end);
      keys = added.keys;
      return added;
    });
    this.end = { keys: new Set(keys), designed: keys };
  }

  /** The landing that the mission ends with, or another one at its place; `null` when it has none. */
  landingHere(): LandingRequest | null {
    const land = this.landing.at(-1);
    const at = land ? placeOf(land) : null;
    if (land === undefined || at === null) return null;
    return this.#landing(at, this.runway, altOf_m(land));
  }

  /** A landing that ends this plan in its wind; the server lays it out for the vehicle. */
  #landing(at: LonLat, runway: Runway | null, ground_rel_home_m: number | null): LandingRequest {
    const vehicle = vehicles.selected?.systemId ?? null;
    const { items, home } = this.asApi();
    return {
      at: runway === null ? placeOnly(at) : null,
      runway,
      wind: planWind.known,
      ground_rel_home_m,
      plan: { ...emptyPlan(), items, home },
      vehicle,
      // nobody knows yet whether the vehicle would arm with a DO_LAND_START
      has_land_start: vehicle === null ? false : null,
    };
  }

  #aboveHome_m(ground_amsl_m: number | null): number | null {
    return ground_amsl_m === null || this.home === null ? null : ground_amsl_m - this.home.alt_amsl_m;
  }

  /** The landing that ends the mission, where it is of the designed kind. */
  landing = $derived<readonly DraftItem[]>(designedLanding(this.draft, this.end));

  /** The runway that the mission lands on; `null` for a landing at a point, as one that was dragged away, or came back by undo. */
  runway = $derived.by<Runway | null>(() => {
    const land = this.landing.at(-1);
    const at = land ? placeOf(land) : null;
    const runway = this.#runway;
    return runway !== null && at !== null && beside_m(runway, at) < 0.5 ? runway : null;
  });

  /** Another landing takes its place. */
  takeLanding(items: readonly PlanItem[]): void {
    this.#edit((draft) => changeLanding(draft, items, this.end));
  }

  /** One part of the landing is dragged; the server lets the rest follow, and the last place that it was dragged to counts. */
  async #followLandingDrag(): Promise<void> {
    if (this.#isMovingLanding) return;
    this.#isMovingLanding = true;
    let drag = this.#landingDrag;
    try {
      while (drag !== null) {
        const { part, key, items, to, isEnd }: LandingDrag = drag;
        const ground = isEnd && part === 'point' && elevation.isKnowable ? await elevation.at(to) : null;
        const moved = await api.moveLanding({
          items: items.map(({ command, name, frame, params, autocontinue }) => {
            return { command, name, frame, params, autocontinue };
          }),
          part,
          to: placeOnly(to),
          wind: planWind.known,
          ground_rel_home_m: this.#aboveHome_m(ground?.alt_amsl_m ?? null),
          vehicle: vehicles.selected?.systemId ?? null,
        });
        const latest: LandingDrag | null = this.#landingDrag;
        this.#edit((draft) => {
          if (landingPart(draft, key, this.end) !== part) return draft;
          const next = changeLanding(draft, moved.items, this.end);
          // what is under the pointer stays there, however old the answer
          return latest === drag || latest?.key !== key ? next : moveTo(next, key, latest.to);
        }, `drag-${key}`);
        drag = latest === drag ? null : latest;
      }
      this.problem = null;
    } catch (error) {
      this.problem = problemFrom(error);
      const before = drag;
      if (before !== null) this.#edit((draft) => changeLanding(draft, before.items, this.end), `drag-${before.key}`);
    } finally {
      this.#isMovingLanding = false;
      if (this.#landingDrag?.isEnd === true) {
        this.#landingDrag = null;
        this.#history = seal(this.#history);
      }
    }
  }

  /** Inserts on the leg that ends at item `toIndex`; gives the number of the new item. */
  insertOnLeg(toIndex: number, at: LonLat): number | null {
    return this.#add((draft) => insertOnLeg(draft, toIndex, at, this.defaults), `insert-${this.draft.nextKey}`);
  }

  /** Moves an item, or the selection that it is part of, as a pointer drags it. */
  drag(number: number, from: LonLat, to: LonLat, isEnd: boolean): void {
    const key = this.items[number - 1]?.key;
    if (key === undefined) return;
    if (!this.#selection.has(key)) this.pick(key, false);
    const part = this.#selection.size === 1 ? landingPart(this.draft, key, this.end) : null;
    if (part !== null) {
      this.#dragLanding(part, key, from, to, isEnd);
      return;
    }
    // what was just inserted by this very drag is one step with it
    const about = this.#history.about?.startsWith('insert-') ? this.#history.about : `drag-${key}`;
    this.#edit((draft) => shiftKeys(draft, this.#selection, from, to), about);
    if (isEnd) this.#history = seal(this.#history);
  }

  #dragLanding(part: LandingPart, key: number, from: LonLat, to: LonLat, isEnd: boolean): void {
    const before = this.#landingDrag?.key === key && !this.#landingDrag.isEnd ? this.#landingDrag : null;
    const item = this.items.find((one) => one.key === key);
    const at = before?.to ?? (item ? placeOf(item) : null);
    if (at === null) return;
    const there = {
      lat_deg: Math.max(-90, Math.min(90, at.lat_deg + to.lat_deg - from.lat_deg)),
      lon_deg: at.lon_deg + to.lon_deg - from.lon_deg,
    };
    this.#landingDrag = { part, key, items: before?.items ?? this.landing, to: there, isEnd };
    this.#edit((draft) => moveTo(draft, key, there), `drag-${key}`);
    this.waitFor(this.#followLandingDrag());
  }

  move(key: number, at: LonLat): void {
    this.#edit((draft) => moveTo(draft, key, at));
  }

  setAlt(keys: ReadonlySet<number>, alt_m: number): void {
    this.#edit((draft) => setAlt(draft, keys, alt_m));
  }

  /** Raises or lowers items by the same amount, as keys and drags on the profile do. */
  shiftAlt(keys: ReadonlySet<number>, by_m: number, about: string): void {
    this.#edit((draft) => {
      let next = draft;
      for (const item of draft.items) {
        const alt_m = keys.has(item.key) ? altOf_m(item) : null;
        if (alt_m !== null) next = setAlt(next, new Set([item.key]), Math.round((alt_m + by_m) * 10) / 10);
      }
      return next;
    }, about);
  }

  /** Lets heights count from another level, as the core converts them. */
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
      this.#edit((draft) => exchange(draft, chosen, counted));
      const [first] = unconverted;
      const keys = new Set(unconverted.map(({ item }) => chosen[item - 1]?.key));
      const kept = this.items.filter(({ key }) => keys.has(key));
      this.#unconverted = first === undefined ? null : { level: first.level, items: kept };
    } catch (error) {
      this.problem = problemFrom(error);
    }
  }

  setParam(key: number, index: number, value: number | null): void {
    this.#edit((draft) => setParam(draft, key, index, value));
  }

  changeCommand(key: number, command: number, at: LonLat | null = null): void {
    this.#edit((draft) => changeCommand(draft, key, command, this.defaults, at));
  }

  remove(keys: ReadonlySet<number> = this.#selection): void {
    const first = this.items.findIndex((item) => keys.has(item.key));
    this.#edit((draft) => removeKeys(draft, keys));
    // the next item is selected, so that the keyboard goes on where it was
    const next = this.items[Math.min(first, this.items.length - 1)];
    this.selectKeys(first >= 0 && next ? [next.key] : []);
  }

  nudge(by: -1 | 1): void {
    this.#edit((draft) => nudge(draft, this.#selection, by));
  }

  reorder(keys: ReadonlySet<number>, index: number): void {
    this.#edit((draft) => reorder(draft, keys, index));
  }

  /** Changes fence or rally points. Changes with the same `about` are one step. */
  editAreas(change: (areas: Areas) => Areas, about: string | null = null): void {
    this.#edit((draft) => {
      const { fence, rally } = change(draft);
      return fence === draft.fence && rally === draft.rally ? draft : { ...draft, fence, rally };
    }, about);
  }

  /** Changes the draft otherwise. Changes with the same `about` are one step. */
  edit(change: (draft: Draft) => Draft, about: string | null = null): void {
    this.#edit(change, about);
  }

  /** Empties a part of the draft, or all of it; undo brings it back. */
  clear(part: PlanKind | 'all' = 'all'): void {
    const empty = emptyPlan();
    this.#edit((draft) => {
      if (part === 'fence') return { ...draft, fence: empty.fence };
      if (part === 'rally') return { ...draft, rally: empty.rally };
      return part === 'mission'
        ? { ...draft, items: [], complexItems: [] }
        : { ...draftOf(empty), nextKey: draft.nextKey };
    });
    this.selectKeys([]);
  }

  undo(): void {
    this.#set(undo(this.#history));
  }

  redo(): void {
    this.#set(redo(this.#history));
  }

  /** Ends a run of changes that count as one step. */
  seal(): void {
    this.#history = seal(this.#history);
  }

  /** Another plan takes the draft's place; undo brings the old one back. */
  replace(plan: Plan): void {
    this.#edit((draft) => {
      const next = draftOf(plan);
      const base = draft.nextKey;
      return {
        ...next,
        items: next.items.map((item) => ({ ...item, key: item.key + base })),
        nextKey: next.nextKey + base,
      };
    });
    this.selectKeys([]);
  }

  #add(edit: (draft: Draft) => Added, about: string | null = null): number | null {
    let keys: readonly number[] = [];
    this.#edit((draft) => {
      const added = edit(draft);
      keys = added.keys;
      return added.draft;
    }, about);
    const key = keys.at(-1);
    if (key === undefined) return null;
    this.selectKeys([key]);
    return numberOfKey(this.draft, key);
  }

  #edit(change: (draft: Draft) => Draft, about: string | null = null): void {
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
    this.assess();
  }

  saveNow(): void {
    clearTimeout(this.#saveTimer);
    save('draft', planOf(this.#history.present));
  }

  // --- Checks, files ------------------------------------------------------------------------------------------------

  /** Asks the core about the draft: one question at a time, and of the edits that come meanwhile the last. */
  assess(): void {
    if (this.#isNothing) {
      this.#note(null);
      this.checkState = 'none';
      return;
    }
    // what was found before stands for the moment until the answer
    if (this.checkState !== 'done') this.checkState = 'checking';
    if (this.#isAsking) this.#asksAgain = true;
    else void this.#ask();
  }

  get #isNothing(): boolean {
    return PLAN_PARTS.every((part) => this.isEmpty(part));
  }

  async #ask(): Promise<void> {
    this.#isAsking = true;
    try {
      do {
        this.#asksAgain = false;
        this.#oldTimer ??= setTimeout(() => (this.isRehearsalOld = true), OLD_AFTER_MS);
        // what stands for several items in a file says nothing of how they are flown
        const asked = { ...this.asApi(), complex_items: [] };
        const vehicle = vehicles.selected?.systemId;
        const told = await station.assess(asked, vehicle, planWind.wind, elevation.clearance_m, planeProfile.asked);
        this.#note(this.#isNothing ? null : told);
        clearTimeout(this.#groundTimer);
        // ground that the server had not at hand is there a moment later
        if (told.rehearsal?.is_ground_pending) this.#groundTimer = setTimeout(() => this.assess(), GROUND_AGAIN_MS);
        if (this.#isNothing) return;
      } while (this.#asksAgain);
      this.checkState = 'done';
    } catch {
      this.#note(null);
      this.checkState = 'unavailable';
    } finally {
      this.#isAsking = false;
    }
  }

  #note(told: Awaited<ReturnType<typeof station.assess>> | null): void {
    clearTimeout(this.#oldTimer);
    this.#oldTimer = undefined;
    this.isRehearsalOld = false;
    [this.findings, this.trip, this.rehearsal] = [told?.findings ?? [], told?.trip ?? null, told?.rehearsal ?? null];
  }

  /** Reads the vehicle's parameters, so that the rehearsal flies as it does. */
  async readParams(): Promise<void> {
    const vehicle = vehicles.selected;
    if (vehicle === null || this.isReadingParams) return;
    this.problem = null;
    this.isReadingParams = true;
    try {
      await operations.finish(await api.readParams(vehicle.systemId));
      this.assess();
    } catch (error) {
      this.problem = problemFrom(error);
    } finally {
      this.isReadingParams = false;
    }
  }

  async loadFile(file: File): Promise<boolean> {
    try {
      this.problem = null;
      this.fileNotes = [];
      const { plan, notes } = await api.parsePlan(file.name, file);
      this.replace(plan);
      this.fileNotes = notes;
      return true;
    } catch (error) {
      this.problem = problemFrom(error);
      return false;
    }
  }

  async fileOf(as: PlanFileFormat): Promise<Blob | null> {
    try {
      this.problem = null;
      await this.#underWay;
      const { file, notes } = await api.formatPlan(this.asApi(), as);
      this.fileNotes = notes;
      return file;
    } catch (error) {
      this.problem = problemFrom(error);
      return null;
    }
  }

  /** As the server takes it. */
  asApi(): ApiPlan {
    return { ...planOf(this.#history.present), home: this.home };
  }

  // --- Transfers ----------------------------------------------------------------------------------------------------

  /**
   * Sends parts of the draft, one after the other, and stops at the first that fails. A part counts as on board only when
   * the vehicle has been read back.
   */
  async send(...parts: readonly PlanKind[]): Promise<void> {
    let plan: ApiPlan | undefined;
    for (const part of parts.length > 0 ? parts : (['mission'] as const)) {
      const isDone = await this.#transfer('send', part, async (vehicle) => {
        await this.#underWay;
        plan ??= this.asApi();
        await this.#follow(await api.sendPlan(vehicle.systemId, part, plan));
        return plan;
      });
      if (!isDone) return;
    }
  }

  /** Reads a part of the vehicle's plan into the draft. */
  async read(part: PlanKind = 'mission'): Promise<void> {
    await this.#transfer('read', part, async (vehicle) => {
      const plan = await this.#follow<ApiPlan>(await api.readPlan(vehicle.systemId, part));
      this.#take(part, plan);
      return plan;
    });
  }

  /** Clears a part of the plan on board; the draft stays. */
  async clearVehicle(part: PlanKind = 'mission'): Promise<void> {
    await this.#transfer('clear', part, async (vehicle) => {
      await this.#follow(await api.clearPlan(vehicle.systemId, part));
      return emptyPlan();
    });
  }

  #take(part: PlanKind, plan: Plan): void {
    const { fence, rally } = this.draft;
    if (part === 'mission') this.replace({ ...plan, fence, rally: [...rally] });
    else this.editAreas((areas) => ({ ...areas, [part]: plan[part] }));
  }

  async cancelTransfer(): Promise<void> {
    const operation = this.transfer?.operation;
    if (!operation) return;
    try {
      await operations.cancel(operation.id);
    } catch (error) {
      this.problem = problemFrom(error);
    }
  }

  /** Progress of the transfer, 0 to 1; `null` while it is not known. */
  transferPart = $derived.by<number | null>(() => {
    const started = this.transfer?.operation;
    if (!started) return null;
    const operation = operations.get(started.id) ?? started;
    return operation.total > 0 ? Math.min(1, operation.done / operation.total) : null;
  });

  /**
   * Takes over what the station has read from the selected vehicle: another station may have loaded a mission that this one
   * follows. Nothing is asked of the vehicle.
   */
  async follow(): Promise<void> {
    const vehicle = vehicles.selected;
    if (vehicle === null) return;
    await Promise.all(PLAN_PARTS.map((part) => this.#followPart(vehicle, part)));
  }

  async #followPart(vehicle: Vehicle, part: PlanKind): Promise<void> {
    // a transfer of ours says itself what it brought
    if (vehicle.planStates?.[part].state !== 'verified' || this.transfer !== null || onBoard.planOf(part) !== null)
      return;
    try {
      const { state, plan } = await api.planOnBoard(vehicle.systemId, part);
      if (plan === null || this.transfer !== null) return;
      onBoard.note(vehicle, part, state, plan);
      // Nothing is lost by it, so there is nothing to undo. What nobody has touched since goes with the vehicle.
      const isUntouched = !this.canUndo && (this.isEmpty(part) || partOf(this.draft, part) === this.#asRead[part]);
      if (vehicle !== vehicles.selected || !isUntouched) return;
      const { fence, rally } = this.draft;
      if (part === 'mission') this.#set(historyOf({ ...draftOf(plan), fence, rally }));
      else this.#set(historyOf({ ...this.draft, [part]: plan[part] }));
      this.#asRead[part] = partOf(this.draft, part);
    } catch {
      // it stays unknown, and says so
    }
  }

  async #transfer(kind: Transfer['kind'], part: PlanKind, run: (vehicle: Vehicle) => Promise<Plan>): Promise<boolean> {
    const vehicle = vehicles.selected;
    if (vehicle === null || this.transfer !== null) return false;
    this.problem = null;
    this.transfer = { kind, part, operation: null };
    try {
      const plan = await run(vehicle);
      onBoard.note(vehicle, part, (await api.planOnBoard(vehicle.systemId, part)).state, plan);
      return true;
    } catch (error) {
      this.problem = problemFrom(error);
      return false;
    } finally {
      this.transfer = null;
    }
  }

  async #follow<Result = unknown>(operation: Operation): Promise<Result> {
    if (this.transfer !== null) this.transfer = { ...this.transfer, operation };
    return operations.finish<Result>(operation);
  }
}

function partOf(draft: Draft, part: PlanKind): unknown {
  return part === 'mission' ? draft.items : draft[part];
}

/** How much longer the way over a place is than the runway. */
const beside_m = ({ begin, end }: Runway, at: LonLat): number =>
  distance_m(begin, at) + distance_m(at, end) - distance_m(begin, end);

const placeOnly = ({ lat_deg, lon_deg }: LonLat): LonLat => ({ lat_deg, lon_deg });

function readChosen(value: unknown): Chosen | null {
  if (typeof value !== 'object' || value === null) return null;
  const { alt_m, frame } = value as Record<string, unknown>;
  if (typeof alt_m !== 'number' || !Number.isFinite(alt_m)) return null;
  return { alt_m, frame: (['home', 'amsl', 'terrain'] as const).find((one) => one === frame) ?? 'home' };
}

/** Whether an item is one that the editor knows, for those who show items. */
export type { PlanItem };

export const plan = new PlanStore();
