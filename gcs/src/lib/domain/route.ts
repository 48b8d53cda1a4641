/**
 * The route of a plan: which items the vehicle flies to, in which order, how far and how long. Every view of a plan (map,
 * table, height profile, ground) asks here, so that all show the same.
 */

import { bearing_deg, distance_m } from './geo';
import { type LonLat, sameLonLat } from './lonlat';
import {
  altRelHome_m,
  circleOf,
  COMMAND,
  DEFAULT_LOITER_RADIUS_M,
  type Home,
  isDestination,
  kindOf,
  type PlanItem,
  placeOf,
} from './plan';

/** What of the vehicle decides where a plan takes it. */
export interface RouteOptions {
  /** Whether it flies the arcs of NAV_ARC_WAYPOINT, as an ArduCopter does; a plane passes straight over such an item. */
  readonly fliesArcs: boolean;
  /** Radius of circles that name none, metres (WP_LOITER_RAD). */
  readonly loiterRadius_m: number;
  /** Speed until the plan changes it, metres per second (AIRSPEED_CRUISE). */
  readonly cruise_m_s: number;
  /** Climb and descent in a circle to a height, metres per second, as the core takes it. */
  readonly climb_m_s: number;
}

/** An ArduPlane as it comes. */
export const PLANE_ROUTE: RouteOptions = {
  fliesArcs: false,
  loiterRadius_m: DEFAULT_LOITER_RADIUS_M,
  cruise_m_s: 22,
  climb_m_s: 2.5,
};

/** One piece of the planned route, from one place to the next. */
export interface Leg {
  readonly from: LonLat;
  readonly to: LonLat;
  /** Index in the items of where the leg begins; `null` for home. */
  readonly fromIndex: number | null;
  /** Index in the items of where the leg ends. For a return to launch, that item. */
  readonly toIndex: number;
  readonly kind: 'takeoff' | 'flown' | 'approach' | 'return';
  readonly length_m: number;
}

/** The circling at an item. */
export interface Loiter {
  readonly kind: 'turns' | 'time' | 'height' | 'unlimited';
  /** Distance flown in it, metres; `null` when it has no end, or is not known. */
  readonly length_m: number | null;
  /** Time in it, seconds; `null` likewise. */
  readonly time_s: number | null;
  /** Whether the length depends on what the plan does not tell: a speed, a climb, the vehicle's own radius. */
  readonly isEstimate: boolean;
  /** Of a circle to a height: how much of the change is done when the circling begins, 0 to 1; 1 for the others. */
  readonly changedBefore: number;
}

/** An item that the vehicle flies to. */
export interface Stop {
  readonly index: number;
  /** The way to it; `null` when it begins there. */
  readonly leg: Leg | null;
  readonly loiter: Loiter | null;
  /** Speed on the way, metres per second. */
  readonly speed_m_s: number;
}

/** The items that the vehicle flies to, one after the other as `order` has them; by default as they stand in the plan. */
export function stopsOf(
  items: readonly PlanItem[],
  home: LonLat | Home | null,
  options: RouteOptions = PLANE_ROUTE,
  order: Iterable<number> = items.keys(),
): Stop[] {
  const stops: Stop[] = [];
  let from: LonLat | null = home;
  let before: PlanItem | null = null;
  let fromIndex: number | null = null;
  let speed_m_s = options.cruise_m_s;
  for (const index of order) {
    const item = items[index] as PlanItem;
    const kind = kindOf(item);
    if (kind === 'change_speed') speed_m_s = speedOf(item) ?? speed_m_s;
    const isReturn = kind === 'return_to_launch';
    const to = isReturn ? home : kind === 'takeoff' || isDestination(item, options.fliesArcs) ? placeOf(item) : null;
    if (to === null) continue;
    const isFromTakeoff = before !== null && kindOf(before) === 'takeoff';
    const leg: Leg | null =
      from === null || sameLonLat(from, to)
        ? null
        : {
            from,
            to,
            fromIndex,
            toIndex: index,
            kind: isReturn
              ? 'return'
              : kind === 'land'
                ? 'approach'
                : kind === 'takeoff' || isFromTakeoff
                  ? 'takeoff'
                  : 'flown',
            length_m: legLength_m(from, to, item),
          };
    const loiter = loiterAt(item, before, leg?.length_m ?? 0, speed_m_s, home, options);
    stops.push({ index, leg, loiter, speed_m_s });
    from = to;
    fromIndex = index;
    before = item;
  }
  return stops;
}

/**
 * The route as it is drawn: from home over the take-off and all destinations to the landing or back home. Jumps are
 * not followed; what comes after a landing or an endless circle is drawn nevertheless, since a pilot edits it.
 */
export const routeOf = (items: readonly PlanItem[], home: LonLat | null, options?: RouteOptions): Leg[] =>
  stopsOf(items, home, options).flatMap(({ leg }) => leg ?? []);

/** The speed that a change of speed sets, metres per second; `null` when it sets another, or none. */
function speedOf(item: PlanItem): number | null {
  const [kind, speed_m_s] = item.params;
  return (kind ?? 0) < 2 && speed_m_s !== null && speed_m_s >= 1 ? speed_m_s : null;
}

/** Length of the leg to an item: the chord, or the arc that ends there. */
function legLength_m(from: LonLat, to: LonLat, item: PlanItem): number {
  const chord_m = distance_m(from, to);
  const angle_rad = item.command === COMMAND.arc_waypoint ? Math.abs(((item.params[0] ?? 0) * Math.PI) / 180) : 0;
  return angle_rad < 0.01 || angle_rad >= 2 * Math.PI ? chord_m : (chord_m * angle_rad) / 2 / Math.sin(angle_rad / 2);
}

/** How far and how long the plane circles at an item; `null` where it does not. As the core's `progress` counts it. */
function loiterAt(
  item: PlanItem,
  before: PlanItem | null,
  leg_m: number,
  speed_m_s: number,
  home: LonLat | Home | null,
  options: RouteOptions,
): Loiter | null {
  const circle = circleOf(item, options.loiterRadius_m);
  if (circle === null) return null;
  const amount = Math.max(item.params[0] ?? 0, 0);
  switch (kindOf(item)) {
    case 'loiter_turns': {
      const length_m = amount * 2 * Math.PI * circle.radius_m;
      const isEstimate = !circle.isOwnRadius;
      return { kind: 'turns', length_m, time_s: length_m / speed_m_s, isEstimate, changedBefore: 1 };
    }
    case 'loiter_time':
      return { kind: 'time', length_m: amount * speed_m_s, time_s: amount, isEstimate: true, changedBefore: 1 };
    case 'loiter_to_height': {
      const datum = home !== null && 'alt_amsl_m' in home ? home : null;
      const from_m = before === null ? null : altRelHome_m(before, datum);
      const to_m = altRelHome_m(item, datum);
      if (from_m === null || to_m === null)
        return { kind: 'height', length_m: null, time_s: null, isEstimate: true, changedBefore: 1 };
      // it climbs on the leg already
      const change_s = Math.abs(to_m - from_m) / options.climb_m_s;
      const leg_s = leg_m / speed_m_s;
      const time_s = Math.max(0, change_s - leg_s);
      const changedBefore = change_s > leg_s ? leg_s / change_s : 1;
      return { kind: 'height', length_m: time_s * speed_m_s, time_s, isEstimate: true, changedBefore };
    }
    default:
      return { kind: 'unlimited', length_m: null, time_s: null, isEstimate: false, changedBefore: 1 };
  }
}

/** MAV_CMD_JUMP_TAG and MAV_CMD_DO_JUMP_TAG: jumps to a mark instead of a number. */
const [TAG, JUMP_TO_TAG] = [600, 601];

/** Index of the item that a jump goes to; `null` when there is none. */
export function jumpTarget(items: readonly PlanItem[], jump: PlanItem): number | null {
  const wanted = jump.params[0];
  const index =
    jump.command === JUMP_TO_TAG
      ? items.findIndex((item) => item.command === TAG && item.params[0] === wanted)
      : (wanted ?? 0) - 1;
  return Number.isInteger(index) && index >= 0 && index < items.length ? index : null;
}

/** Last approach of a plan: from the place before the landing to the landing. */
export interface Approach {
  readonly landIndex: number;
  readonly from: LonLat;
  readonly to: LonLat;
  readonly bearing_deg: number;
  readonly length_m: number;
  /** Height lost, metres; `null` when the two heights count from different levels. */
  readonly drop_m: number | null;
  /** Height lost per distance; `null` when it is not known. */
  readonly slope: number | null;
}

/** Above this the checks call an approach steep. */
export const STEEP_SLOPE = 0.1;

export function approachesOf(items: readonly PlanItem[], home: Home | null, options?: RouteOptions): Approach[] {
  return routeOf(items, home, options)
    .filter((leg) => leg.kind === 'approach')
    .map((leg) => {
      const land = items[leg.toIndex] as PlanItem;
      const before = leg.fromIndex === null ? null : items[leg.fromIndex];
      const high_m = before ? altRelHome_m(before, home) : 0;
      const low_m = altRelHome_m(land, home);
      const drop_m = high_m === null || low_m === null ? null : high_m - low_m;
      return {
        landIndex: leg.toIndex,
        from: leg.from,
        to: leg.to,
        bearing_deg: bearing_deg(leg.from, leg.to),
        length_m: leg.length_m,
        drop_m,
        slope: drop_m === null || leg.length_m <= 0 ? null : drop_m / leg.length_m,
      };
    });
}
