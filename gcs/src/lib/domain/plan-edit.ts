/**
 * Editing of a plan: each operation takes a draft and gives the next one, and never changes what it took. Items carry
 * a key of their own, so a selection survives moves, and jumps follow the items that they jump to.
 */

import type { LonLat } from './lonlat';
import {
  altOf_m,
  type ComplexItem,
  type EditableKind,
  type Fence,
  type HeightFrame,
  type Home,
  heightFrameOf,
  FRAME,
  isPlaced,
  kindOf,
  makeItem,
  type NewItem,
  type Plan,
  type PlanItem,
  type PlannedFor,
  placeOf,
  type RallyPoint,
  withAlt,
  withCommand,
  withParam,
  withPlace,
} from './plan';
import { type End, NO_END, PLANE_ROUTE, placesFlown, type RouteOptions } from './way';

export interface DraftItem extends PlanItem {
  /** Tells items apart while they are edited; never leaves the station. */
  key: number;
}

export interface Draft {
  readonly items: readonly DraftItem[];
  readonly home: Home | null;
  readonly fence: Fence;
  readonly rally: readonly RallyPoint[];
  /** What stood for several items in the file; handed back with them, whatever was edited. */
  readonly complexItems: readonly ComplexItem[];
  /** What the file said of its vehicle; `null` when the plan is of no file, or that said nothing. */
  readonly plannedFor: PlannedFor | null;
  /** The next key to give. */
  readonly nextKey: number;
}

export interface EditDefaults {
  /** Height of new items, metres in `frame`. */
  readonly alt_m: number;
  readonly frame: HeightFrame;
  /** Of the vehicle that is to fly it; an ArduPlane as it comes by default. */
  readonly route?: RouteOptions;
  /** How the mission ends. */
  readonly end?: End;
}

export function draftOf(plan: Plan): Draft {
  return {
    items: plan.items.map((item, index) => ({ ...item, key: index + 1 })),
    home: plan.home,
    fence: plan.fence,
    rally: plan.rally,
    complexItems: plan.complex_items ?? [],
    plannedFor: plan.planned_for ?? null,
    nextKey: plan.items.length + 1,
  };
}

export function planOf(draft: Draft): Plan {
  return {
    items: draft.items.map(({ key: _, ...item }) => item),
    home: draft.home,
    fence: draft.fence,
    rally: [...draft.rally],
    ...(draft.complexItems.length > 0 ? { complex_items: [...draft.complexItems] } : {}),
    ...(draft.plannedFor === null ? {} : { planned_for: draft.plannedFor }),
  };
}

const indexOfKey = (draft: Draft, key: number): number => draft.items.findIndex((item) => item.key === key);

/** Number of an item as the vehicle counts: from 1, home not counted. `null` when it is not there. */
export function numberOfKey(draft: Draft, key: number): number | null {
  const index = indexOfKey(draft, key);
  return index < 0 ? null : index + 1;
}

export interface Added {
  readonly draft: Draft;
  /** Keys of what was added, in order. */
  readonly keys: readonly number[];
}

/** Puts items before the one at `index`; at the end when `index` is the length. */
export function insertItems(draft: Draft, index: number, items: readonly PlanItem[]): Added {
  const keyed = items.map((item, at) => ({ ...item, key: draft.nextKey + at }));
  const next = [...draft.items.slice(0, index), ...keyed, ...draft.items.slice(index)];
  return {
    draft: withItems({ ...draft, nextKey: draft.nextKey + items.length }, next, draft.items),
    keys: keyed.map((item) => item.key),
  };
}

/**
 * Index of the first of these items in the draft, when all of them are there together and untouched: those of a complex item, as it made
 * them. `null` when one of them was edited, moved or deleted, or another was put among them.
 */
export function standsAt(draft: Draft, items: readonly DraftItem[]): number | null {
  const [first] = items;
  const index = first === undefined ? -1 : draft.items.indexOf(first);
  return index >= 0 && items.every((item, at) => draft.items[index + at] === item) ? index : null;
}

interface PlacedComplex {
  readonly draft: Draft;
  /** The items it generated. */
  readonly items: readonly DraftItem[];
}

/** Puts what a complex item makes before the item at `index`. */
export function insertComplex(
  draft: Draft,
  index: number,
  complex: ComplexItem,
  items: readonly PlanItem[],
): PlacedComplex {
  const { draft: next, keys } = insertItems(draft, index, items);
  const complexItems = [...draft.complexItems, complex];
  return { draft: { ...next, complexItems }, items: next.items.slice(index, index + keys.length) };
}

/** Replaces a complex item whose items start at `index`; jumps to its beginning still lead there. */
export function replaceComplex(
  draft: Draft,
  old: { readonly complex: ComplexItem; readonly index: number; readonly count: number },
  complex: ComplexItem,
  items: readonly PlanItem[],
): PlacedComplex {
  const replaced = replaceItems(draft, old.index, old.count, items);
  const complexItems = draft.complexItems.map((one) => (one === old.complex ? complex : one));
  return {
    draft: { ...replaced, complexItems },
    items: replaced.items.slice(old.index, old.index + items.length),
  };
}

/** Replaces items; the first ones keep their keys, so that selections and jumps to them stay valid. */
export function replaceItems(draft: Draft, index: number, count: number, items: readonly PlanItem[]): Draft {
  const kept = draft.items.slice(index, index + count);
  const keyed = items.map((item, at) => ({ ...item, key: kept[at]?.key ?? draft.nextKey + at }));
  const next = [...draft.items.slice(0, index), ...keyed, ...draft.items.slice(index + count)];
  return withItems({ ...draft, nextKey: draft.nextKey + items.length }, next, draft.items);
}

/** Takes a complex item away, with its items where they are given. */
export function removeComplex(draft: Draft, complex: ComplexItem, items: readonly DraftItem[] = []): Draft {
  const rest = removeKeys(draft, new Set(items.map((item) => item.key)));
  return { ...rest, complexItems: draft.complexItems.filter((one) => one !== complex) };
}

/**
 * Index at which an item that is added "at the end" belongs: before the landing or return that ends the mission, from the core's answer;
 * for a plan changed since, before the last item if it is a landing or return.
 */
export function endIndex(draft: Draft, end: End): number {
  const last = draft.items.at(-1);
  const isEnd = last !== undefined && ['return_to_launch', 'land'].includes(kindOf(last));
  let index = draft.items.length - (isEnd ? 1 : 0);
  while (end.keys.has(draft.items[index - 1]?.key ?? -1)) index -= 1;
  return index;
}

/**
 * Adds an item of a kind at a place, where it belongs: a take-off first (it replaces one that is there), a return to
 * launch last, anything else before the landing or return. A landing is `addLanding`'s.
 */
export function addAt(
  draft: Draft,
  kind: Exclude<EditableKind, 'land'>,
  at: LonLat | null,
  defaults: EditDefaults,
): Added {
  const item = makeItem(kind, { at, alt_m: defaults.alt_m, frame: defaults.frame });
  switch (kind) {
    case 'takeoff': {
      const first = draft.items[0];
      const isThere = first !== undefined && kindOf(first) === 'takeoff';
      const without = isThere ? removeKeys(draft, new Set([first.key])) : draft;
      return insertItems(without, 0, [{ ...item, frame: FRAME.home }]);
    }
    case 'return_to_launch':
      return insertItems(draft, draft.items.length, [item]);
    default:
      return insertItems(draft, endIndex(draft, defaults.end ?? NO_END), [item]);
  }
}

/** Ends the mission with a landing as it was designed; one that ends it already is replaced, approach and all. */
export function addLanding(draft: Draft, landing: readonly PlanItem[], end: End): Added {
  const without = removeKeys(draft, new Set(draft.items.slice(endIndex(draft, end)).map((old) => old.key)));
  return insertItems(without, without.items.length, landing);
}

/** A part of a designed landing that can be moved; the server lets the rest follow. */
export type LandingPart = 'point' | 'final-leg' | 'circle';

/** Which part of the landing that ends the mission an item is; `null` when it is not part of a designed landing. */
export function landingPart(draft: Draft, key: number, end: End): LandingPart | null {
  const items = designedLanding(draft, end);
  const index = items.findIndex((item) => item.key === key);
  const parts: readonly LandingPart[] = ['final-leg', 'circle', 'point'];
  return index < 0 ? null : (parts[index + parts.length - items.length] ?? null);
}

/** The items of a landing that ends the mission as one is designed; else none. */
export function designedLanding(draft: Draft, { designed }: End): readonly DraftItem[] {
  const last = designed.length === 0 ? [] : draft.items.slice(-designed.length);
  return last.every((item, at) => item.key === designed[at]) ? last : [];
}

/** Replaces the landing that ends the mission; its items keep their keys, so that they stay selected. */
export function changeLanding(draft: Draft, landing: readonly PlanItem[], end: End): Draft {
  const old = designedLanding(draft, end);
  if (old.length !== landing.length) return addLanding(draft, landing, end).draft;
  const items = landing.map((item, index) => ({ ...item, key: (old[index] as DraftItem).key }));
  return { ...draft, items: [...draft.items.slice(0, -old.length), ...items] };
}

/** Inserts a waypoint on the leg that ends at item `toIndex`, at the height in the middle of its two ends. */
export function insertOnLeg(draft: Draft, toIndex: number, at: LonLat, defaults: EditDefaults): Added {
  const { fliesArcs } = defaults.route ?? PLANE_ROUTE;
  const from = placesFlown(draft.items, draft.home, fliesArcs).findLast(({ index }) => index < toIndex);
  const after = draft.items[toIndex];
  const before = from && draft.items[from.index];
  const [high_m, low_m] = [before && altOf_m(before), after && altOf_m(after)];
  const isSameFrame = before && after && isPlaced(after) && heightFrameOf(before) === heightFrameOf(after);
  const isMiddle = isSameFrame && high_m != null && low_m != null;
  const item = makeItem('waypoint', {
    at,
    alt_m: isMiddle ? Math.round((high_m + low_m) / 2) : defaults.alt_m,
    frame: isMiddle ? heightFrameOf(before) : defaults.frame,
  });
  return insertItems(draft, toIndex, [item]);
}

export function removeKeys(draft: Draft, keys: ReadonlySet<number>): Draft {
  return withItems(
    draft,
    draft.items.filter((item) => !keys.has(item.key)),
    draft.items,
  );
}

/** Changes one item. A change that would do nothing gives the same draft. */
function updateKey(draft: Draft, key: number, change: (item: PlanItem) => PlanItem): Draft {
  return updateKeys(draft, new Set([key]), change);
}

function updateKeys(draft: Draft, keys: ReadonlySet<number>, change: (item: PlanItem) => PlanItem): Draft {
  let isChanged = false;
  const items = draft.items.map((item) => {
    if (!keys.has(item.key)) return item;
    const next = change(item);
    if (next === item) return item;
    isChanged = true;
    return { ...next, key: item.key };
  });
  return isChanged ? { ...draft, items } : draft;
}

/** Moves every placed item of `keys` by the same difference of latitude and longitude. */
export function shiftKeys(draft: Draft, keys: ReadonlySet<number>, from: LonLat, to: LonLat): Draft {
  const [lat_deg, lon_deg] = [to.lat_deg - from.lat_deg, to.lon_deg - from.lon_deg];
  return updateKeys(draft, keys, (item) => {
    const at = placeOf(item);
    if (at === null) return item;
    const next = { lat_deg: Math.max(-90, Math.min(90, at.lat_deg + lat_deg)), lon_deg: at.lon_deg + lon_deg };
    return withPlace(item, next);
  });
}

export const moveTo = (draft: Draft, key: number, at: LonLat): Draft =>
  updateKey(draft, key, (item) => withPlace(item, at));
export const setAlt = (draft: Draft, keys: ReadonlySet<number>, alt_m: number): Draft =>
  updateKeys(draft, keys, (item) => (isPlaced(item) ? withAlt(item, alt_m) : item));
export const setParam = (draft: Draft, key: number, index: number, value: number | null): Draft =>
  updateKey(draft, key, (item) => withParam(item, index, value));

/** Replaces these items, found by their keys; one that was changed meanwhile stays as it is. */
export function exchange(draft: Draft, old: readonly DraftItem[], items: readonly PlanItem[]): Draft {
  const next = new Map(old.map((item, index): [DraftItem, PlanItem | undefined] => [item, items[index]]));
  return updateKeys(draft, new Set(old.map(({ key }) => key)), (item) => next.get(item as DraftItem) ?? item);
}

/** Changes the command of an item. A command that needs a position gets `at`, or that of the nearest item before. */
export function changeCommand(
  draft: Draft,
  key: number,
  command: number,
  defaults: EditDefaults,
  at: LonLat | null = null,
): Draft {
  const fallback = fallbackFor(draft, key, defaults, at);
  return updateKey(draft, key, (item) => withCommand(item, command, fallback));
}

function fallbackFor(draft: Draft, key: number, { alt_m, frame }: EditDefaults, at: LonLat | null): NewItem {
  const index = indexOfKey(draft, key);
  const before = draft.items.slice(0, Math.max(index, 0)).map(placeOf);
  const home = draft.home && { lon_deg: draft.home.lon_deg, lat_deg: draft.home.lat_deg };
  return { at: at ?? before.findLast((place) => place !== null) ?? home, alt_m, frame };
}

/** Moves the items of `keys`, in their order, so that they stand before the item that is now at `index`. */
export function reorder(draft: Draft, keys: ReadonlySet<number>, index: number): Draft {
  const moved = draft.items.filter((item) => keys.has(item.key));
  const before = draft.items.slice(0, index).filter((item) => !keys.has(item.key));
  const after = draft.items.slice(index).filter((item) => !keys.has(item.key));
  const items = [...before, ...moved, ...after];
  if (items.every((item, at) => item === draft.items[at])) return draft;
  return withItems(draft, items, draft.items);
}

/** Moves the items of `keys` up (−1) or down (+1) by one place, as a block. */
export function nudge(draft: Draft, keys: ReadonlySet<number>, by: -1 | 1): Draft {
  const indices = draft.items.flatMap((item, index) => (keys.has(item.key) ? [index] : []));
  const [first, last] = [indices[0], indices.at(-1)];
  if (first === undefined || last === undefined) return draft;
  if (by < 0) return first === 0 ? draft : reorder(draft, keys, first - 1);
  return last === draft.items.length - 1 ? draft : reorder(draft, keys, last + 2);
}

/** New items in place of the old ones, with each jump pointing at the item it pointed at. */
function withItems(draft: Draft, items: readonly DraftItem[], old: readonly DraftItem[]): Draft {
  const indexByKey = new Map(items.map((item, index) => [item.key, index]));
  const oldKeys = new Set(old.map((item) => item.key));
  const next = items.map((item) => {
    const target = kindOf(item) === 'jump' ? item.params[0] : null;
    if (target === null || !oldKeys.has(item.key)) return item;
    const number = numberAfter(target, old, indexByKey, items.length);
    return number === target ? item : { ...withParam(item, 0, number), key: item.key };
  });
  return { ...draft, items: next };
}

/** The number that the item with the old number `target` has now; of one that is gone, that of what followed it. */
function numberAfter(
  target: number,
  old: readonly DraftItem[],
  indexByKey: ReadonlyMap<number, number>,
  count: number,
): number {
  if (!Number.isInteger(target) || target < 1 || target > old.length) return target;
  for (let index = target - 1; index < old.length; index += 1) {
    const now = indexByKey.get((old[index] as DraftItem).key);
    if (now !== undefined) return now + 1;
  }
  return Math.max(count, 1);
}
