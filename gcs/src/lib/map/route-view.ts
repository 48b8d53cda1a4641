// A planned route as it is drawn: the geometry of a plan in map coordinates, made anew only when the plan changes.
import { fromLonLat } from 'ol/proj';
import { between, circle } from '$lib/domain/geo';
import type { LonLat } from '$lib/domain/lonlat';
import { altRelHome_m, circleOf, type Home, type ItemKind, kindOf, type PlanItem, placeOf } from '$lib/domain/plan';
import { MERCATOR_LIMIT_DEG } from '$lib/domain/projection';
import { approachesOf, jumpTarget, type Leg, PLANE_ROUTE, type RouteOptions } from '$lib/domain/route';
import { shapedRoute } from '$lib/domain/route-shape';
import type { XY } from './frame';

export interface RouteItem {
  /** As the vehicle counts: from 1. */
  readonly number: number;
  readonly kind: ItemKind;
  readonly place: LonLat;
  readonly at: XY;
  readonly alt_rel_home_m: number | null;
}

export interface RouteLeg {
  readonly kind: Leg['kind'];
  /** Index of the item where the leg ends. */
  readonly toIndex: number;
  readonly line: readonly XY[];
  readonly middle: XY;
  readonly middlePlace: LonLat;
}

export interface RouteCircle {
  readonly number: number;
  readonly line: readonly XY[];
  readonly isClockwise: boolean;
  /** False when the vehicle's own radius is drawn, which may be another. */
  readonly isOwnRadius: boolean;
}

export interface RouteApproach {
  readonly middle: XY;
  readonly slope: number | null;
  readonly drop_m: number | null;
  readonly length_m: number;
}

export interface RouteView {
  readonly items: readonly RouteItem[];
  readonly legs: readonly RouteLeg[];
  readonly circles: readonly RouteCircle[];
  readonly jumps: readonly { readonly from: XY; readonly to: XY; readonly number: number }[];
  readonly approaches: readonly RouteApproach[];
}

export const EMPTY_ROUTE: RouteView = { items: [], legs: [], circles: [], jumps: [], approaches: [] };

export function toXY(at: LonLat): XY {
  const [x = 0, y = 0] = fromLonLat([
    at.lon_deg,
    Math.max(-MERCATOR_LIMIT_DEG, Math.min(MERCATOR_LIMIT_DEG, at.lat_deg)),
  ]);
  return [x, y];
}

/** A line of positions in map coordinates, without jumps at the date line. */
export function toLine(points: readonly LonLat[]): XY[] {
  let shift_deg = 0;
  return points.map((at, index) => {
    const before = points[index - 1];
    if (before && at.lon_deg - before.lon_deg > 180) shift_deg -= 360;
    if (before && at.lon_deg - before.lon_deg < -180) shift_deg += 360;
    return toXY({ lat_deg: at.lat_deg, lon_deg: at.lon_deg + shift_deg });
  });
}

export function routeView(
  items: readonly PlanItem[],
  home: Home | null,
  options: RouteOptions = PLANE_ROUTE,
): RouteView {
  const places = items.map(placeOf);
  const placeBefore = (index: number): LonLat | null => places.slice(0, index).findLast((at) => at !== null) ?? null;
  return {
    items: items.flatMap((item, index) => {
      const place = places[index] ?? null;
      if (place === null) return [];
      return [
        {
          number: index + 1,
          kind: kindOf(item),
          place,
          at: toXY(place),
          alt_rel_home_m: altRelHome_m(item, home),
        },
      ];
    }),
    legs: shapedRoute(items, home, options).map((leg) => ({
      kind: leg.kind,
      toIndex: leg.toIndex,
      line: toLine(leg.line),
      middle: toXY(leg.middle),
      middlePlace: leg.middle,
    })),
    circles: items.flatMap((item, index) => {
      const round = circleOf(item, options.loiterRadius_m);
      const place = places[index] ?? null;
      if (round === null || place === null) return [];
      const { isClockwise, isOwnRadius } = round;
      return [{ number: index + 1, line: toLine(circle(place, round.radius_m)), isClockwise, isOwnRadius }];
    }),
    jumps: items.flatMap((item, index) => {
      if (kindOf(item) !== 'jump') return [];
      const target = jumpTarget(items, item);
      const from = placeBefore(index);
      const to = target === null ? null : (places.slice(target).find((at) => at !== null) ?? null);
      return from === null || to === null ? [] : [{ from: toXY(from), to: toXY(to), number: index + 1 }];
    }),
    approaches: approachesOf(items, home, options).map((approach) => ({
      middle: toXY(between(approach.from, approach.to, 0.5)),
      slope: approach.slope,
      drop_m: approach.drop_m,
      length_m: approach.length_m,
    })),
  };
}
