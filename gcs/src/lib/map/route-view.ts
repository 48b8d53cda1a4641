// A planned route for drawing: the geometry of a plan in map coordinates, rebuilt only when the plan changes.
import { fromLonLat } from 'ol/proj';
import { circle } from '$lib/domain/geo';
import type { LonLat } from '$lib/domain/lonlat';
import { type ItemKind, kindOf, type PlanItem, placeOf } from '$lib/domain/plan';
import { MERCATOR_LIMIT_DEG } from '$lib/domain/projection';
import type { Descent, Leg, Way } from '$lib/domain/way';
import type { XY } from './frame';

export interface RouteItem {
  /** As the vehicle counts: from 1. */
  readonly number: number;
  readonly kind: ItemKind;
  readonly place: LonLat;
  readonly at: XY;
}

export interface RouteLeg {
  readonly kind: Leg['kind'];
  /** Index of the item where the leg ends. */
  readonly toIndex: number;
  readonly line: readonly XY[];
  readonly middle: XY;
  /** A straight line until the core has answered. */
  readonly isGuess: boolean;
}

interface RouteCircle {
  readonly number: number;
  readonly line: readonly XY[];
  readonly isClockwise: boolean;
  /** False when the vehicle's own radius is drawn, which may differ. */
  readonly isOwnRadius: boolean;
}

interface RouteApproach extends Descent {
  readonly middle: XY;
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

export function routeView(items: readonly PlanItem[], way: Way): RouteView {
  const places = items.map(placeOf);
  return {
    items: items.flatMap((item, index) => {
      const place = places[index] ?? null;
      if (place === null) return [];
      return [{ number: index + 1, kind: kindOf(item), place, at: toXY(place) }];
    }),
    legs: way.stops.flatMap(({ leg }) => {
      if (leg === null) return [];
      const { kind, toIndex, isGuess } = leg;
      const line = toLine(leg.line);
      return [{ kind, toIndex, isGuess, line, middle: middleOf(line) }];
    }),
    circles: way.stops.flatMap(({ index, loiter }) => {
      const place = places[index] ?? null;
      if (loiter === null || place === null) return [];
      const { radius_m, is_clockwise: isClockwise, is_own_radius: isOwnRadius } = loiter;
      return [{ number: index + 1, line: toLine(circle(place, radius_m)), isClockwise, isOwnRadius }];
    }),
    jumps: way.jumps.flatMap(({ fromIndex, toIndex }) => {
      const from = places.slice(0, fromIndex).findLast((at) => at !== null);
      const to = places.slice(toIndex).find((at) => at !== null);
      return from == null || to == null ? [] : [{ from: toXY(from), to: toXY(to), number: fromIndex + 1 }];
    }),
    approaches: way.stops.flatMap(({ leg }) => {
      if (leg?.descent == null) return [];
      return [{ ...leg.descent, length_m: leg.length_m, middle: middleOf([toXY(leg.from), toXY(leg.to)]) }];
    }),
  };
}

/** Halfway along a line as it is seen. */
function middleOf(line: readonly XY[]): XY {
  const pieces = line.slice(1).map(([x, y], index) => {
    const [fromX, fromY] = line[index] as XY;
    return Math.hypot(x - fromX, y - fromY);
  });
  let left = pieces.reduce((sum, piece) => sum + piece, 0) / 2;
  for (const [index, piece] of pieces.entries()) {
    if (piece >= left && piece > 0) {
      const [[fromX, fromY], [toX, toY]] = [line[index] as XY, line[index + 1] as XY];
      return [fromX + ((toX - fromX) * left) / piece, fromY + ((toY - fromY) * left) / piece];
    }
    left -= piece;
  }
  return line.at(-1) as XY;
}
