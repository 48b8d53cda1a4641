/**
 * The way of a plan as every view of it shows it: to which items the vehicle flies, by which line, how far, and how it circles there.
 * The core lays it out (`POST /plan/way`). Until its answer is there, and for as long as there is no station, the places are joined by
 * straight lines that are marked as such.
 */

import { USUAL_PLANE } from './core';
import { bearing_deg, distance_m } from './geo';
import { type LonLat, sameLonLat } from './lonlat';
import { type Home, isDestination, kindOf, type PlanItem, placeOf } from './plan';
import type { Profile } from './profile';

/** How an approach goes down. */
export interface Descent {
  /** Height lost, metres. */
  readonly drop_m: number;
  /** Whether it is steep, or does not lead down. */
  readonly is_doubtful: boolean;
}

/** Properties of the vehicle that determine the path of a plan. */
export interface RouteOptions {
  /** Whether it flies the arcs of NAV_ARC_WAYPOINT, as an ArduCopter does; a plane passes straight over such an item. */
  readonly fliesArcs: boolean;
  /** Radius of circles that name none, metres (WP_LOITER_RAD). */
  readonly loiterRadius_m: number;
  /** Speed until the plan changes it, metres per second (AIRSPEED_CRUISE). */
  readonly cruise_m_s: number;
}

/** An ArduPlane as it comes. */
export const PLANE_ROUTE: RouteOptions = {
  fliesArcs: false,
  loiterRadius_m: USUAL_PLANE.loiter_radius_m,
  cruise_m_s: USUAL_PLANE.airspeed_m_s,
};

/** The circling at an item, from the core. */
export interface Loiter {
  readonly kind: 'turns' | 'time' | 'height' | 'unlimited';
  readonly radius_m: number;
  readonly is_clockwise: boolean;
  /** False when the vehicle's own radius is taken, which may differ. */
  readonly is_own_radius: boolean;
  /** Distance flown in it, metres; `null` when it has no end, or is not known. */
  readonly length_m: number | null;
  /** Time in it, seconds; `null` likewise. */
  readonly time_s: number | null;
  /** Whether the length depends on facts outside the plan. */
  readonly is_estimate: boolean;
  /** Of a circle to a height: how much of the change is done when the circling begins, 0 to 1; 1 for the others. */
  readonly changed_before: number;
}

type LegKind = 'takeoff' | 'flown' | 'approach' | 'return';

/** A path from the core; items count from 1. */
export interface ToldWay {
  readonly stops: readonly {
    readonly item: number;
    readonly leg: {
      /** `null` for home. */
      readonly from_item: number | null;
      readonly kind: LegKind;
      readonly length_m: number;
      readonly course_deg: number;
      readonly lat_deg: readonly number[];
      readonly lon_deg: readonly number[];
      readonly descent: Descent | null;
    } | null;
    readonly loiter: Loiter | null;
  }[];
  readonly jumps: readonly { readonly item: number; readonly to_item: number }[];
  readonly end: {
    /** The first item of the landing or return that ends it, one more than there are where it ends with neither. */
    readonly item: number;
    /** Where that landing is as one is designed, the first item of it. */
    readonly designed_item: number | null;
  };
  readonly profile: Profile;
}

/** A path from the core, and its plan. */
export interface WayAnswer {
  readonly items: readonly Item[];
  readonly home: Home | null;
  readonly way: ToldWay;
}

/** An item, in a draft with the key that it keeps while it is edited. */
type Item = PlanItem & { readonly key?: number };

/** One piece of the way, from one place to the next. */
export interface Leg {
  readonly from: LonLat;
  readonly to: LonLat;
  /** Index in the items of where the leg begins; `null` for home. */
  readonly fromIndex: number | null;
  /** Index in the items of where the leg ends. For a return to launch, that item. */
  readonly toIndex: number;
  readonly kind: LegKind;
  readonly length_m: number;
  readonly course_deg: number;
  /** At a circle it begins or ends on it. */
  readonly line: readonly LonLat[];
  /** Of an approach, where its heights count from the same level. */
  readonly descent: Descent | null;
  /** A straight line until the core has answered. */
  readonly isGuess: boolean;
}

/** An item that the vehicle flies to. */
export interface Stop {
  readonly index: number;
  /** The way to it; `null` when it begins there. */
  readonly leg: Leg | null;
  readonly loiter: Loiter | null;
}

export interface Way {
  readonly stops: readonly Stop[];
  readonly jumps: readonly { readonly fromIndex: number; readonly toIndex: number }[];
}

/** How a mission ends, by the keys that its items keep while they are edited. */
export interface End {
  /** Of the landing that ends it with its approach, or the return. */
  readonly keys: ReadonlySet<number>;
  /** Of those that are a landing as one is designed, in their order. */
  readonly designed: readonly number[];
}

export const NO_END: End = { keys: new Set(), designed: [] };

/** How the mission ends, from the core's answer. */
export function endOf({ items, way: { end } }: WayAnswer): End {
  const from = (item: number): number[] => items.slice(item - 1).flatMap(({ key }) => key ?? []);
  return { keys: new Set(from(end.item)), designed: end.designed_item === null ? [] : from(end.designed_item) };
}

/** The places that the items are flown to, in the order of the plan. */
export function placesFlown(
  items: readonly PlanItem[],
  home: LonLat | null,
  fliesArcs: boolean,
): { readonly index: number; readonly at: LonLat }[] {
  return items.flatMap((item, index) => {
    const kind = kindOf(item);
    const at =
      kind === 'return_to_launch' ? home : kind === 'takeoff' || isDestination(item, fliesArcs) ? placeOf(item) : null;
    return at === null ? [] : [{ index, at }];
  });
}

/** The path of these items: from the core's answer, and straight lines where there is none yet. */
export function wayOf(
  items: readonly Item[],
  home: Home | null,
  fliesArcs: boolean,
  answer: WayAnswer | null = null,
): Way {
  const told = new Told(answer);
  const stops: Stop[] = [];
  let from: { readonly index: number | null; readonly at: LonLat } | null = home && { index: null, at: home };
  for (const { index, at } of placesFlown(items, home, fliesArcs)) {
    const item = items[index] as Item;
    const before: PlanItem | null = from?.index == null ? null : (items[from.index] as Item);
    const leg: Leg | null =
      from === null || sameLonLat(from.at, at)
        ? null
        : (told.leg(item, before, home, { from: from.at, to: at, fromIndex: from.index, toIndex: index }) ??
          straight(from.at, at, from.index, index, item, before));
    stops.push({ index, leg, loiter: told.loiter(item) });
    from = { index, at };
  }
  return { stops, jumps: told.jumps(items) };
}

function straight(
  from: LonLat,
  to: LonLat,
  fromIndex: number | null,
  toIndex: number,
  item: PlanItem,
  before: PlanItem | null,
): Leg {
  const isFromTakeoff = before !== null && kindOf(before) === 'takeoff';
  const kinds: Partial<Record<string, LegKind>> = { return_to_launch: 'return', land: 'approach', takeoff: 'takeoff' };
  return {
    ...{ from, to, fromIndex, toIndex, descent: null, isGuess: true },
    kind: kinds[kindOf(item)] ?? (isFromTakeoff ? 'takeoff' : 'flown'),
    length_m: distance_m(from, to),
    course_deg: bearing_deg(from, to),
    line: [from, to],
  };
}

/** The core's answer about a plan, for those of its items that are unchanged. */
class Told {
  readonly #answer: WayAnswer | null;
  readonly #byItem = new Map<PlanItem, ToldWay['stops'][number]>();
  readonly #byKey = new Map<number, { readonly item: Item; readonly loiter: Loiter }>();

  constructor(answer: WayAnswer | null) {
    this.#answer = answer;
    for (const stop of answer?.way.stops ?? []) {
      const item = answer?.items[stop.item - 1];
      if (item === undefined) continue;
      this.#byItem.set(item, stop);
      if (item.key !== undefined && stop.loiter !== null) this.#byKey.set(item.key, { item, loiter: stop.loiter });
    }
  }

  /** The leg to an item, when both of its ends are unchanged since the answer. */
  leg(
    item: Item,
    before: PlanItem | null,
    home: Home | null,
    ends: Pick<Leg, 'from' | 'to' | 'fromIndex' | 'toIndex'>,
  ): Leg | null {
    const leg = this.#byItem.get(item)?.leg;
    if (leg == null) return null;
    const source = leg.from_item === null ? null : (this.#answer?.items[leg.from_item - 1] ?? null);
    const needsHome = before === null || leg.kind === 'return';
    if (source !== before || (needsHome && !isSameHome(home, this.#answer?.home ?? null))) return null;
    const { kind, length_m, course_deg, lat_deg, lon_deg, descent } = leg;
    const line = lat_deg.map((lat, index) => ({ lat_deg: lat, lon_deg: lon_deg[index] ?? 0 }));
    return { ...ends, kind, length_m, course_deg, line, descent, isGuess: false };
  }

  /** The circle at an item, also while it is being dragged. */
  loiter(item: Item): Loiter | null {
    const stop = this.#byItem.get(item);
    if (stop !== undefined) return stop.loiter;
    const known = item.key === undefined ? undefined : this.#byKey.get(item.key);
    const isSame =
      known?.item.command === item.command && [0, 1, 2, 3].every((at) => known.item.params[at] === item.params[at]);
    return isSame ? known.loiter : null;
  }

  jumps(items: readonly Item[]): Way['jumps'] {
    const { way, items: toldItems } = this.#answer ?? { way: null, items: [] };
    if (way === null || way.jumps.length === 0) return [];
    const indexOf = new Map(items.map((item, index): [PlanItem, number] => [item, index]));
    return way.jumps.flatMap(({ item, to_item }) => {
      const fromIndex = indexOf.get(toldItems[item - 1] as Item);
      // a target that is dragged is still the target
      const toIndex = items[to_item - 1] === undefined ? undefined : to_item - 1;
      return fromIndex === undefined || toIndex === undefined ? [] : [{ fromIndex, toIndex }];
    });
  }
}

const isSameHome = (a: Home | null, b: Home | null): boolean =>
  a === b || (a !== null && b !== null && sameLonLat(a, b) && a.alt_amsl_m === b.alt_amsl_m);
