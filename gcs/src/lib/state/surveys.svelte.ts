// Surveys and corridors of the mission: drawing, reopening and changing them; the core lays them out while a corner is dragged. Also
// keeps track of all complex items, landing patterns and structure scans among them, whose items were edited by hand.
import type { NamedCamera, Problem, Survey, SurveyRequest } from '$lib/api/types';
import type { AreaHandle, PlacedHandle } from '$lib/domain/area-edit';
import type { LonLat } from '$lib/domain/lonlat';
import { middleOf } from '$lib/domain/outline';
import type { ComplexItem, PlanItem } from '$lib/domain/plan';
import {
  type DraftItem,
  endIndex,
  insertComplex,
  removeComplex,
  replaceComplex,
  standsAt,
} from '$lib/domain/plan-edit';
import { leastPlaces, moveSurvey, NEW_WIDTH_M, surveyHandles, turner, withoutCorner } from '$lib/domain/survey';
import { roundLength_m } from '$lib/domain/units';
import { elevation } from './maps-elevation.svelte';
import { plan } from './plan.svelte';
import { planWind } from './plan-wind.svelte';
import { settings } from './settings.svelte';
import type { ShapeEditor } from './shape-editor';
import { api, problemFrom } from './station.svelte';
import { load, save } from './stored';
import { vehicles } from './vehicles.svelte';

/** How a survey is to be flown, without where. */
type SurveySettings = Omit<SurveyRequest, 'places' | 'width_m' | 'wind' | 'home' | 'vehicle'>;
/** All that one is laid out from but home and the vehicle. */
type SurveyAsked = Omit<SurveyRequest, 'home' | 'vehicle'>;
/** The displayed part of a laid-out survey. */
type LaidOut = Omit<Survey, 'items' | 'complex_item'>;

/** What is known of a complex item of the draft. */
interface Known {
  /** The same for all that a survey becomes while it is changed. */
  readonly id: number;
  /** As it made them; empty when they were edited before they came here. */
  readonly items: readonly DraftItem[];
  /** What a survey or corridor was laid out from; `null` for other complex items. */
  readonly asked: SurveyAsked | null;
  /** `null` until it was laid out here. */
  readonly answer: LaidOut | null;
}

/** A complex item where the mission has it. */
export interface Part {
  readonly complex: ComplexItem;
  readonly id: number;
  readonly index: number;
  readonly items: readonly DraftItem[];
  readonly asked: SurveyAsked | null;
  readonly answer: LaidOut | null;
}

/** What is to be laid out next. */
interface Wanted {
  readonly id: number;
  readonly asked: SurveyAsked;
  readonly about: string | null;
  readonly isEnd: boolean;
  /** The plan's generation for which it is asked. */
  readonly generation: number;
}

const FIRST_CAMERA = 'Sony a6000 16mm';
/** Height of a new one, metres: 2.4 cm a pixel with the first camera, and below the 120 m that the EU's open category allows. */
const NEW_HEIGHT_M = 100;
const USUAL: SurveySettings = {
  camera: null,
  is_landscape: true,
  front_overlap: 0.75,
  side_overlap: 0.65,
};

class SurveyStore implements ShapeEditor {
  cameras = $state.raw<readonly NamedCamera[]>([]);
  /** By the complex item itself: undo brings back the very same. Those that no draft has any more are let go with it. */
  readonly #known = new WeakMap<ComplexItem, Known>();
  /** Counts what became known. */
  #learnt = $state(0);
  #isLearning = false;
  #nextId = 1;
  #drawing = $state<'area' | 'line' | null>(null);
  sketch = $state.raw<readonly LonLat[]>([]);
  selected = $state.raw<AreaHandle | null>(null);
  #openId = $state<number | null>(null);
  /** What the open survey is to become, while that is under way or cannot be laid out; of the complex item `over`, or of none yet. */
  #live = $state.raw<{ readonly asked: SurveyAsked; readonly over: ComplexItem | null } | null>(null);
  problem = $state.raw<Problem | null>(null);
  isAsking = $state(false);
  #wanted: Wanted | null = null;
  #settings: SurveySettings | null = load('survey', null, readSettings);

  // --- What the mission has -----------------------------------------------------------------------------------------

  /** Complex items whose items are as they made them, in the mission's order. */
  parts = $derived.by<readonly Part[]>(() => {
    void this.#learnt;
    const parts = plan.draft.complexItems.flatMap((complex) => {
      const known = this.#known.get(complex);
      const index = known === undefined ? null : standsAt(plan.draft, known.items);
      return known === undefined || index === null ? [] : [{ complex, index, ...known }];
    });
    return parts.sort((a, b) => a.index - b.index);
  });

  /** Surveys whose items are shown one by one. */
  #unfolded = $state.raw<ReadonlySet<number>>(new Set());
  /** Surveys and corridors, by the number of their first item. */
  rows = $derived(new Map(this.parts.filter(({ asked }) => asked !== null).map((part) => [part.index + 1, part])));
  /** Numbers of the items that stand behind the row of their survey: what only the survey is to change. */
  folded = $derived.by<ReadonlySet<number>>(() => {
    const numbers = new Set<number>();
    for (const [first, part] of this.rows)
      if (this.isFolded(part)) part.items.forEach((_, at) => numbers.add(first + at));
    return numbers;
  });

  isFolded(part: Part): boolean {
    return !this.#unfolded.has(part.id);
  }

  setFolded({ id }: Part, isFolded: boolean): void {
    const next = new Set(this.#unfolded);
    if (isFolded) next.delete(id);
    else next.add(id);
    this.#unfolded = next;
  }

  /** Shows the items of the survey that an item belongs to. */
  unfold(number: number): void {
    const part = this.#partWith(number);
    if (part !== undefined) this.setFolded(part, false);
  }

  /** Moves the selection by one row of the table: past a whole survey that is folded. */
  nudge(by: -1 | 1): void {
    const at = plan.items.flatMap(({ key }, index) => (plan.selectedKeys.has(key) ? [index + 1] : []));
    const next = (by < 0 ? (at[0] ?? 0) : (at.at(-1) ?? 0)) + by;
    const part = this.folded.has(next) ? this.#partWith(next) : undefined;
    if (part === undefined || at.length === 0) plan.nudge(by);
    else plan.reorder(plan.selectedKeys, by < 0 ? part.index : part.index + part.items.length);
  }

  #partWith(number: number): Part | undefined {
    return [...this.rows.values()].find(({ index, items }) => number > index && number <= index + items.length);
  }

  /** Complex items whose items were edited by hand and are plain items now. Those with no items left are not listed. */
  edited = $derived.by<readonly { readonly complex: ComplexItem; readonly numbers: readonly number[] }[]>(() => {
    void this.#learnt;
    return plan.draft.complexItems.flatMap((complex) => {
      const known = this.#known.get(complex);
      if (known === undefined || standsAt(plan.draft, known.items) !== null) return [];
      const keys = new Set(known.items.map((item) => item.key));
      const numbers = plan.items.flatMap((item, index) => (keys.has(item.key) ? [index + 1] : []));
      return known.items.length === 0 || numbers.length > 0 ? [{ complex, numbers }] : [];
    });
  });

  /** Asks the core where the items of complex items are that came with a file or a draft. */
  async learn(): Promise<void> {
    const unknown = plan.draft.complexItems.some((complex) => !this.#known.has(complex));
    if (!unknown || this.#isLearning) return;
    this.#isLearning = true;
    const { draft } = plan;
    try {
      const parts = await api.complexParts(plan.asApi());
      draft.complexItems.forEach((complex, at) => {
        const part = parts[at];
        if (part === undefined || this.#known.has(complex)) return;
        const begin = part.first_item === null ? null : part.first_item - 1;
        const items = begin === null ? [] : draft.items.slice(begin, begin + part.count);
        this.#note(complex, { id: this.#nextId++, items, asked: part.survey, answer: null });
      });
    } catch {
      // they are kept as they are; the next look at the plan asks again
    } finally {
      this.#isLearning = false;
    }
  }

  #note(complex: ComplexItem, known: Known): void {
    this.#known.set(complex, known);
    this.#learnt += 1;
  }

  /** Dismisses the notice that the items are plain ones now. */
  forget(complex: ComplexItem): void {
    plan.edit((draft) => removeComplex(draft, complex));
  }

  // --- The one that is open -----------------------------------------------------------------------------------------

  open = $derived<Part | null>(this.#partOf(this.#openId));
  #isLive = $derived(this.#live !== null && this.#live.over === (this.open?.complex ?? null));
  /** What the open one is laid out from, or is to be. */
  asked = $derived<SurveyAsked | null>(this.#isLive ? (this.#live?.asked ?? null) : (this.open?.asked ?? null));
  answer = $derived<LaidOut | null>(this.open?.answer ?? null);
  /** Whether the lines and figures shown are of an earlier state of the survey. */
  isOld = $derived(this.#isLive);
  /** Whether the plan's wind has changed since it was laid out. */
  isOtherWind = $derived.by(() => {
    const [then, now] = [this.open?.asked?.wind ?? null, planWind.known];
    return !this.#isLive && this.open !== null && JSON.stringify(then) !== JSON.stringify(now && { ...now });
  });

  isDrawing = $derived(this.#drawing !== null);
  isSketchLine = $derived(this.#drawing === 'line');
  isEditing = $derived(
    plan.isEditing && plan.part === 'mission' && (this.#drawing !== null || this.open !== null || this.#isLive),
  );
  isSketching = $derived(this.#drawing !== null && this.sketch.length > 0);
  canFinish = $derived(
    this.#drawing !== null && this.sketch.length >= leastPlaces({ width_m: this.isSketchLine ? 0 : null }),
  );

  #shape = $derived(this.asked === null ? null : { places: this.asked.places, width_m: this.asked.width_m ?? null });
  #course_deg = $derived(this.asked?.course_deg ?? this.answer?.course_deg ?? null);
  handles = $derived<readonly PlacedHandle[]>(
    this.isEditing && this.#shape !== null ? surveyHandles(this.#shape, this.#course_deg) : [],
  );
  /** From the middle to the handle that turns the lines. */
  arrow = $derived.by<readonly [LonLat, LonLat] | null>(() => {
    const [shape, course_deg] = [this.#shape, this.#course_deg];
    const middle = shape && middleOf(shape.places);
    if (shape === null || middle === null || course_deg === null || shape.width_m !== null) return null;
    return [middle, turner(shape, course_deg)];
  });

  /** Begins to draw one. */
  begin(kind: 'area' | 'line'): void {
    this.close();
    this.#drawing = kind;
    plan.selectKeys([]);
    void this.loadCameras();
  }

  openPart(id: number): void {
    this.close();
    this.#openId = id;
    plan.selectKeys([]);
    void this.loadCameras();
    if (this.open?.answer === null) void this.#look(this.open);
  }

  /** Back to the mission; a drawing that was not ended is discarded. A change that is being laid out is still made. */
  close(): void {
    this.#drawing = null;
    this.sketch = [];
    this.selected = null;
    this.#openId = null;
    this.#live = null;
    this.problem = null;
  }

  async loadCameras(): Promise<void> {
    if (this.cameras.length > 0) return;
    try {
      this.cameras = await api.cameras();
    } catch {
      // one can be described by its numbers
    }
  }

  // --- Gestures -----------------------------------------------------------------------------------------------------

  click(at: LonLat): void {
    if (this.#drawing !== null) this.sketch = [...this.sketch, at];
    else this.selected = null;
  }

  finish(): void {
    if (!this.canFinish) return;
    const [places, width_m] = [this.sketch.map(place), this.isSketchLine ? NEW_WIDTH_M : null];
    this.#drawing = null;
    this.sketch = [];
    this.#openId = this.#nextId++;
    this.#ask({ ...this.#usual(), places, width_m, wind: planWind.known }, null, true);
  }

  unsketch(): void {
    this.sketch = this.sketch.slice(0, -1);
  }

  cancelSketch(): void {
    this.sketch = [];
  }

  drag(handle: AreaHandle, from: LonLat, to: LonLat, isEnd: boolean): AreaHandle {
    const moved = this.#shape === null ? null : moveSurvey(this.#shape, handle, from, to);
    if (moved === null) return handle;
    this.selected = moved.handle;
    const { places, course_deg } = moved.change;
    this.change(
      { ...(places ? { places: places.map(place) } : {}), ...(course_deg === undefined ? {} : { course_deg }) },
      'drag',
      isEnd,
    );
    return moved.handle;
  }

  remove(handle: AreaHandle | null = this.selected): void {
    if (handle === null || this.#shape === null) return;
    const places = withoutCorner(this.#shape, handle);
    this.selected = null;
    if (places !== null) this.change({ places: places.map(place) });
  }

  // --- Changes ------------------------------------------------------------------------------------------------------

  /** Lays the open one out again with changes, in the wind of the plan. Changes with the same `about` are one step for undo. */
  change(change: Partial<SurveyAsked>, about: string | null = null, isEnd = true): void {
    if (this.asked === null) return;
    const asked = { ...this.asked, ...change, wind: planWind.known };
    this.#settings = settingsOf(asked);
    save('survey', this.#settings);
    this.#ask(asked, about, isEnd);
  }

  /** Takes the open one out of the mission, with its items. */
  delete(): void {
    const { open } = this;
    this.close();
    if (open !== null) plan.edit((draft) => removeComplex(draft, open.complex, open.items));
  }

  /** What new ones are laid out from: as the last one was. */
  #usual(): SurveySettings {
    if (this.#settings !== null) return this.#settings;
    const first = this.cameras.find(({ name }) => name === FIRST_CAMERA) ?? this.cameras[0];
    return first === undefined
      ? { ...USUAL, height_m: plan.defaults.alt_m, spacing_m: plan.defaults.alt_m }
      : { ...USUAL, camera: first.camera, height_m: roundLength_m(NEW_HEIGHT_M, settings.units.length) };
  }

  #ask(asked: SurveyAsked, about: string | null, isEnd: boolean): void {
    const id = this.#openId;
    if (id === null) return;
    this.#live = { asked, over: this.open?.complex ?? null };
    const { generation } = plan;
    this.#wanted = { id, asked, about: about === null ? null : `survey-${id}-${about}`, isEnd, generation };
    if (!this.isAsking) plan.waitFor(this.#follow());
  }

  /** One question at a time, and of those that come meanwhile the last. */
  async #follow(): Promise<void> {
    this.isAsking = true;
    try {
      while (this.#wanted !== null) {
        const wanted: Wanted = this.#wanted;
        this.#wanted = null;
        try {
          const asked = { ...wanted.asked, ground_rel_home_m: await this.#ground(wanted) };
          const answer = await this.#laidOut(asked);
          if (wanted.generation !== plan.generation) {
            this.#drop(wanted);
            continue;
          }
          const old = this.#partOf(wanted.id);
          if (wanted.id === this.#openId || old !== null) this.#take(old, wanted, asked, answer);
        } catch (error) {
          if (wanted.id === this.#openId) this.problem = problemFrom(error);
        }
      }
    } finally {
      this.isAsking = false;
    }
  }

  /** The plan has gone elsewhere meanwhile: the survey is as the plan has it. */
  #drop({ id }: Wanted): void {
    if (id === this.#openId && this.#wanted === null) this.#live = null;
  }

  #laidOut(asked: SurveyAsked): Promise<Survey> {
    return api.designSurvey({ ...asked, home: plan.home, vehicle: vehicles.selected?.systemId ?? null });
  }

  /** Height of the ground above home, in the middle; while something is dragged that of before. */
  async #ground({ asked, isEnd }: Wanted): Promise<number | null> {
    const [middle, { home }] = [middleOf(asked.places), plan];
    if (!isEnd || middle === null || home === null || !elevation.isKnowable) return asked.ground_rel_home_m ?? null;
    const { alt_amsl_m } = await elevation.at(middle);
    return alt_amsl_m == null ? null : alt_amsl_m - home.alt_amsl_m;
  }

  #partOf(id: number | null): Part | null {
    return this.parts.find((part) => part.id === id) ?? null;
  }

  #take(
    old: Part | null,
    wanted: Wanted,
    asked: SurveyAsked,
    { items, complex_item: complex, ...answer }: Survey,
  ): void {
    let placed: readonly DraftItem[] = [];
    plan.edit((draft) => {
      const next =
        old === null
          ? insertComplex(draft, endIndex(draft, plan.end), complex, items as PlanItem[])
          : replaceComplex(
              draft,
              { complex: old.complex, index: old.index, count: old.items.length },
              complex,
              items as PlanItem[],
            );
      placed = next.items;
      return next.draft;
    }, wanted.about);
    this.#note(complex, { id: wanted.id, items: placed, asked, answer: lean(answer) });
    if (wanted.isEnd) plan.seal();
    if (wanted.id !== this.#openId) return;
    this.problem = null;
    this.#live = this.#wanted === null ? null : { asked: this.#wanted.asked, over: complex };
  }

  /** Lays out a survey from a file unchanged, for its figures; the mission keeps its items. */
  async #look({ complex, id, items, asked }: Part): Promise<void> {
    if (asked === null) return;
    try {
      const { items: laid, complex_item: _, ...answer } = await this.#laidOut(asked);
      const isSame =
        laid.length === items.length &&
        laid.every(({ command, params }, at) => {
          const item = items[at];
          return item?.command === command && params.every((value, which) => isNear(value, item.params[which]));
        });
      if (isSame) this.#note(complex, { id, items, asked, answer: lean(answer) });
    } catch (error) {
      if (this.#openId === id) this.problem = problemFrom(error);
    }
  }
}

const place = ({ lat_deg, lon_deg }: LonLat): { lat_deg: number; lon_deg: number } => ({ lat_deg, lon_deg });
const isNear = (a: number | null | undefined, b: number | null | undefined): boolean =>
  Math.abs((a ?? 0) - (b ?? 0)) < 1e-6;

/** Without what each picture shows, which is much and drawn nowhere. */
const lean = (answer: LaidOut): LaidOut => ({ ...answer, flown: { ...answer.flown, footprints: [] } });

const SETTINGS = [
  ...([
    'camera',
    'is_landscape',
    'gsd_m',
    'height_m',
    'front_overlap',
    'side_overlap',
    'spacing_m',
    'trigger_m',
  ] as const),
  ...(['margin_m', 'lead_in_m', 'is_above_terrain', 'airspeed_m_s'] as const),
] satisfies readonly (keyof SurveySettings)[];

/** What the next one has of this one: all but where its lines lead and begin. */
function settingsOf(asked: object): SurveySettings {
  const kept = Object.entries(asked).filter(([name]) => (SETTINGS as readonly string[]).includes(name));
  return { ...USUAL, ...Object.fromEntries(kept) };
}

/** The server checks the values that it is asked with. */
function readSettings(value: unknown): SurveySettings | null {
  return typeof value === 'object' && value !== null && !Array.isArray(value) ? settingsOf(value) : null;
}

export const surveys = new SurveyStore();
plan.whenReplaced((before) => {
  if (plan.items !== before.items) surveys.cancelSketch();
});
