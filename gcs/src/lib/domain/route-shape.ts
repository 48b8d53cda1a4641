/**
 * What line a vehicle flies along each leg of a plan: arcs as arcs, splines as curves, and to and from a circle along its
 * tangent. Radii and angles are those of the plan; how the plane rounds a corner is its own affair and not drawn.
 */

import { bearing_deg, destination, distance_m, geodesicLine, length_m, offset_m } from './geo';
import { type LonLat, sameLonLat, wrap360_deg } from './lonlat';
import { circleOf, COMMAND, type PlanItem, placeOf } from './plan';
import { type Leg, PLANE_ROUTE, routeOf, type RouteOptions } from './route';

const DEG = 180 / Math.PI;
/** Points of a curve stand so many degrees of turn apart. */
const STEP_DEG = 5;

export interface Circle {
  readonly centre: LonLat;
  readonly radius_m: number;
  readonly isClockwise: boolean;
}

export interface ShapedLeg extends Leg {
  /** From where the leg begins to where it ends; at a circle these are points of the circle. */
  readonly line: readonly LonLat[];
  /** Halfway along the line. */
  readonly middle: LonLat;
}

/** Radius of the arc that turns by `angle_deg` between two places: chord / (2 sin(angle / 2)), metres. */
export function arcRadius_m(from: LonLat, to: LonLat, angle_deg: number): number {
  return distance_m(from, to) / (2 * Math.sin(Math.abs(angle_deg) / DEG / 2));
}

/** Whether an angle makes an arc; 0 and full turns make none. */
const isArcAngle = (angle_deg: number): boolean => Math.abs(angle_deg) >= 0.5 && Math.abs(angle_deg) < 360;

/**
 * The arc from one place to another that turns by `angle_deg` on the way, clockwise positive (NAV_ARC_WAYPOINT, parameter 1
 * of the MAVLink common dialect). A chord leaves an arc with half of the angle that it spans.
 */
export function arcLine(from: LonLat, to: LonLat, angle_deg: number): LonLat[] {
  if (!isArcAngle(angle_deg) || sameLonLat(from, to)) return [from, to];
  const radius_m = arcRadius_m(from, to, angle_deg);
  const begin_deg = bearing_deg(from, to) - angle_deg / 2;
  const pieces = Math.max(2, Math.ceil(Math.abs(angle_deg) / STEP_DEG));
  return Array.from({ length: pieces + 1 }, (_, index) => {
    if (index === 0) return from;
    if (index === pieces) return to;
    const turned_deg = (angle_deg * index) / pieces;
    return destination(
      from,
      wrap360_deg(begin_deg + turned_deg / 2),
      2 * radius_m * Math.sin(Math.abs(turned_deg) / DEG / 2),
    );
  });
}

/** Where a line that comes from `from` touches a circle in the circle's sense. `null` from inside of it. */
export function entryTangent(from: LonLat, { centre, radius_m, isClockwise }: Circle): LonLat | null {
  const away_m = distance_m(from, centre);
  if (away_m <= radius_m) return null;
  // a clockwise circle has its centre on the right of the plane
  const aside_deg = Math.asin(radius_m / away_m) * DEG * (isClockwise ? -1 : 1);
  return destination(from, wrap360_deg(bearing_deg(from, centre) + aside_deg), Math.sqrt(away_m ** 2 - radius_m ** 2));
}

/** Where a plane leaves a circle straight towards `to`. `null` when that lies inside of it. */
export const exitTangent = (circle: Circle, to: LonLat): LonLat | null =>
  // flown backwards it is an entry, the other way round
  entryTangent(to, { ...circle, isClockwise: !circle.isClockwise });

/** The circle that a plane flies at an item, with the place where it lies. */
export function circleAt(item: PlanItem, default_radius_m?: number): Circle | null {
  const round = circleOf(item, default_radius_m);
  const centre = placeOf(item);
  return round === null || centre === null
    ? null
    : { centre, radius_m: round.radius_m, isClockwise: round.isClockwise };
}

/** From circle to circle, place to circle, or circle to place. */
function tangentLine(from: LonLat, leaving: Circle | null, to: LonLat, entering: Circle | null): LonLat[] {
  let [begin, end] = [from, to];
  // each end depends on the other where both are circles; it settles within metres after two rounds
  for (let round = 0; round < (leaving !== null && entering !== null ? 4 : 1); round += 1) {
    begin = (leaving && exitTangent(leaving, end)) ?? from;
    end = (entering && entryTangent(begin, entering)) ?? to;
  }
  return geodesicLine(begin, end);
}

/**
 * A spline leg: the cubic Hermite curve whose ends move as ArduPilot's do (AC_WPNav, SplineCurve): at a spline point along
 * the line between its neighbours, at a straight one along the leg, and never faster than four times the leg's length.
 */
function splineLine(before: LonLat | null, from: LonLat, to: LonLat, after: LonLat | null): LonLat[] {
  const vector = (a: LonLat, b: LonLat): [number, number] => {
    const { north_m, east_m } = offset_m(a, b);
    return [north_m, east_m];
  };
  const leg = vector(from, to);
  let leave = before === null ? ([0, 0] as const) : vector(before, to);
  let arrive = after === null ? leg : vector(from, after);
  const speed = Math.hypot(...leave) + Math.hypot(...arrive);
  const most = 4 * Math.hypot(...leg);
  if (speed > most && speed > 0) {
    const scale = most / speed;
    leave = [leave[0] * scale, leave[1] * scale];
    arrive = [arrive[0] * scale, arrive[1] * scale];
  }
  const pieces = 24;
  return Array.from({ length: pieces + 1 }, (_, index) => {
    if (index === 0) return from;
    if (index === pieces) return to;
    const s = index / pieces;
    const [h10, h01, h11] = [s * (1 - s) ** 2, s * s * (3 - 2 * s), s * s * (s - 1)];
    const north_m = h10 * leave[0] + h01 * leg[0] + h11 * arrive[0];
    const east_m = h10 * leave[1] + h01 * leg[1] + h11 * arrive[1];
    return destination(from, wrap360_deg(Math.atan2(east_m, north_m) * DEG), Math.hypot(north_m, east_m));
  });
}

/** Parameter 4 of circles that end: more than 0 leaves from the circle, 0 goes for the line from its centre. */
const EXIT_PARAM = 3;

/** The legs of a plan with the lines that are flown along them. */
export function shapedRoute(
  items: readonly PlanItem[],
  home: LonLat | null,
  options: RouteOptions = PLANE_ROUTE,
): ShapedLeg[] {
  const legs = routeOf(items, home, options);
  return legs.map((leg, index) => {
    const item = items[leg.toIndex] as PlanItem;
    const source = leg.fromIndex === null ? undefined : items[leg.fromIndex];
    let line: readonly LonLat[];
    if (item.command === COMMAND.arc_waypoint) line = arcLine(leg.from, leg.to, item.params[0] ?? 0);
    else if (item.command === COMMAND.spline_waypoint) {
      const next = legs[index + 1];
      const isNextSpline = next !== undefined && items[next.toIndex]?.command === COMMAND.spline_waypoint;
      line = splineLine(legs[index - 1]?.from ?? null, leg.from, leg.to, isNextSpline ? next.to : null);
    } else {
      const leaving = source === undefined ? null : circleAt(source, options.loiterRadius_m);
      const isFromCircle = (source?.params[EXIT_PARAM] ?? 0) > 0;
      line = tangentLine(
        leg.from,
        isFromCircle ? leaving : null,
        leg.to,
        leg.kind === 'return' ? null : circleAt(item, options.loiterRadius_m),
      );
    }
    return { ...leg, line, middle: middleOf(line) };
  });
}

function middleOf(line: readonly LonLat[]): LonLat {
  let left_m = length_m(line) / 2;
  for (let index = 1; index < line.length; index += 1) {
    const [from, to] = [line[index - 1] as LonLat, line[index] as LonLat];
    const piece_m = distance_m(from, to);
    if (piece_m >= left_m && piece_m > 0) return destination(from, bearing_deg(from, to), left_m);
    left_m -= piece_m;
  }
  return line.at(-1) as LonLat;
}
