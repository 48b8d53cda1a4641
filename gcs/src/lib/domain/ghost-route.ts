/**
 * Where a plane that flies its mission probably is while it is not heard: on along its route, round the next turns and
 * circles. An estimate: what was left of a circle or of a counted jump is not known, so circles are flown from their
 * beginning and counted jumps are not taken.
 */

import { bearing_deg, destination, distance_m, geodesicLine } from './geo';
import { GHOST_LIMIT_S, type Ghost, type LastKnown, MOVING_M_S } from './ghost';
import { type LonLat, wrap180_deg, wrap360_deg } from './lonlat';
import { COMMAND, isDestination, kindOf, type PlanItem, placeOf } from './plan';
import { flightOrder, PLANE_ROUTE, type RouteOptions } from './route';
import { arcLine, type Circle, circleAt, entryTangent, exitTangent, splineLine } from './route-shape';

const DEG = 180 / Math.PI;
const G_M_S2 = 9.80665;
/** Bank of turns at corners: well inside of the limit of 45° that an ArduPlane comes with. */
const BANK_RAD = 40 / DEG;
/** Turns smaller than this are flown without a curve that could be seen. */
const CORNER_DEG = 12;

export interface Wind {
  /** Where it blows from. */
  readonly from_deg: number;
  readonly speed_m_s: number;
}

export interface Flight {
  readonly items: readonly PlanItem[];
  readonly home: LonLat | null;
  /** Item in execution, counted from 1. */
  readonly current: number;
  readonly airspeed_m_s: number | null;
  readonly wind: Wind | null;
  /** Of the vehicle; an ArduPlane as it comes by default. */
  readonly route?: RouteOptions;
}

/**
 * Goes on along the route for `elapsed_s`; `null` when the route says nothing of where the plane is, as during a take-off,
 * or when it stands.
 */
export function followRoute(last: LastKnown, flight: Flight, elapsed_s: number): Ghost | null {
  if (last.groundspeed_m_s < MOVING_M_S) return null;
  const time_s = Math.min(Math.max(elapsed_s, 0), GHOST_LIMIT_S);
  const fastest_m_s = Math.max(last.groundspeed_m_s, (flight.airspeed_m_s ?? 0) + (flight.wind?.speed_m_s ?? 0));
  // corners are cut: the way must be longer than what is flown of it
  const raw = pathAhead(last, flight, 2 * fastest_m_s * time_s + 1);
  if (raw === null) return null;
  const radius_m = last.groundspeed_m_s ** 2 / (G_M_S2 * Math.tan(BANK_RAD));
  const points = withRoundCorners(raw, radius_m);
  return walk(points, last, flight, time_s, elapsed_s);
}

/** The way from the plane's last place, at least `wanted_m` long unless it ends before. */
function pathAhead(
  last: LastKnown,
  { items, home, current, route = PLANE_ROUTE }: Flight,
  wanted_m: number,
): LonLat[] | null {
  const first = items[current - 1];
  if (first === undefined || kindOf(first) === 'takeoff') return null;
  const path = new Path(last.at, wanted_m);
  const circleHome = (): void => {
    if (home !== null) path.circle({ centre: home, radius_m: route.loiterRadius_m, isClockwise: true }, Infinity);
  };
  const order = flightOrder(items, current - 1, true);
  while (path.isShort) {
    const step = order.next();
    if (step.done) {
      // an ArduPlane whose mission is over returns
      if (step.value === 'end') circleHome();
      break;
    }
    const index = step.value;
    const item = items[index] as PlanItem;
    const kind = kindOf(item);
    if (kind === 'return_to_launch') {
      circleHome();
      break;
    }
    const to = placeOf(item);
    if (to === null || !isDestination(item, route.fliesArcs)) continue;
    const before = items
      .slice(0, index)
      .findLast((one) => isDestination(one, route.fliesArcs) && placeOf(one) !== null);
    const from = (before && placeOf(before)) ?? home;
    const isFirst = index === current - 1;
    const circle = circleAt(item, route.loiterRadius_m);
    if (circle !== null) path.circle(circle, turnsOf(item, circle, last.groundspeed_m_s));
    else if (item.command === COMMAND.arc_waypoint && from !== null)
      path.curve(arcLine(from, to, item.params[0] ?? 0), isFirst);
    else if (item.command === COMMAND.spline_waypoint && from !== null)
      path.curve(splineLine(null, from, to, null), isFirst);
    else path.straight(to);
    if (kind === 'land') break;
  }
  return path.points;
}

function turnsOf(item: PlanItem, circle: Circle, speed_m_s: number): number {
  if (kindOf(item) === 'loiter_turns') return Math.max(item.params[0] ?? 0, 0);
  if (kindOf(item) === 'loiter_time') {
    return (Math.max(item.params[0] ?? 0, 0) * speed_m_s) / (2 * Math.PI * circle.radius_m);
  }
  return Infinity;
}

/** A way that grows until it is long enough. */
class Path {
  readonly points: LonLat[];
  #left_m: number;
  /** The circle that the way has just gone round: it is left along its tangent. */
  #leaving: Circle | null = null;

  constructor(from: LonLat, wanted_m: number) {
    this.points = [from];
    this.#left_m = wanted_m;
  }

  get isShort(): boolean {
    return this.#left_m > 0;
  }

  get #end(): LonLat {
    return this.points.at(-1) as LonLat;
  }

  straight(to: LonLat): void {
    this.#leaveTowards(to);
    for (const point of geodesicLine(this.#end, to).slice(1)) this.#add(point);
  }

  /** A curve; one that the plane is on already is taken up where it comes nearest. */
  curve(line: readonly LonLat[], isUnderWay: boolean): void {
    this.#leaveTowards(line[0] as LonLat);
    let begin = 0;
    if (isUnderWay) {
      const away_m = line.map((point) => distance_m(point, this.#end));
      begin = Math.min(away_m.indexOf(Math.min(...away_m)) + 1, line.length - 1);
    }
    for (const point of line.slice(begin)) this.#add(point);
  }

  circle(circle: Circle, turns: number): void {
    const entry = entryTangent(this.#end, circle);
    if (entry !== null) this.straight(entry);
    const step_deg = circle.isClockwise ? 6 : -6;
    const steps = Math.ceil(turns * 60);
    const begin_deg = bearing_deg(circle.centre, this.#end);
    for (let step = 1; step <= steps && this.isShort; step += 1) {
      this.#add(destination(circle.centre, wrap360_deg(begin_deg + step * step_deg), circle.radius_m));
    }
    this.#leaving = circle;
  }

  /** Goes on round the circle to the point from which it is straight on. */
  #leaveTowards(to: LonLat): void {
    const circle = this.#leaving;
    this.#leaving = null;
    const exit = circle && exitTangent(circle, to);
    if (circle === null || exit === null) return;
    const begin_deg = bearing_deg(circle.centre, this.#end);
    const sense = circle.isClockwise ? 1 : -1;
    const turn_deg = wrap360_deg((bearing_deg(circle.centre, exit) - begin_deg) * sense);
    for (let turned_deg = 6; turned_deg < turn_deg; turned_deg += 6) {
      this.#add(destination(circle.centre, wrap360_deg(begin_deg + sense * turned_deg), circle.radius_m));
    }
    this.#add(exit);
  }

  #add(point: LonLat): void {
    this.#left_m -= distance_m(this.#end, point);
    this.points.push(point);
  }
}

/** The way with corners flown as arcs of a radius, inside of them, as far as the legs have room. */
function withRoundCorners(points: readonly LonLat[], radius_m: number): LonLat[] {
  const round: LonLat[] = [points[0] as LonLat];
  for (let index = 1; index < points.length - 1; index += 1) {
    const [before, at, after] = [points[index - 1], points[index], points[index + 1]] as [LonLat, LonLat, LonLat];
    const [in_deg, out_deg] = [bearing_deg(before, at), bearing_deg(at, after)];
    const turn_deg = wrap180_deg(out_deg - in_deg);
    if (Math.abs(turn_deg) < CORNER_DEG) {
      round.push(at);
      continue;
    }
    const room_m = Math.min(distance_m(before, at), distance_m(at, after)) / 2;
    const cut_m = Math.min(radius_m * Math.tan(Math.min(Math.abs(turn_deg), 150) / DEG / 2), room_m);
    const begin = destination(at, wrap360_deg(in_deg + 180), cut_m);
    const end = destination(at, out_deg, cut_m);
    round.push(...arcLine(begin, end, turn_deg));
  }
  if (points.length > 1) round.push(points.at(-1) as LonLat);
  return round;
}

/** Speed over ground and nose of a plane that flies a track: the wind triangle. */
export function alongTrack(
  track_deg: number,
  airspeed_m_s: number,
  wind: Wind,
): { groundspeed_m_s: number; heading_deg: number } {
  const off_rad = (wind.from_deg + 180 - track_deg) / DEG;
  const [along_m_s, across_m_s] = [wind.speed_m_s * Math.cos(off_rad), wind.speed_m_s * Math.sin(off_rad)];
  const sine = Math.max(-1, Math.min(1, across_m_s / airspeed_m_s));
  return {
    groundspeed_m_s: Math.max(along_m_s + airspeed_m_s * Math.sqrt(1 - sine * sine), 1),
    heading_deg: wrap360_deg(track_deg - Math.asin(sine) * DEG),
  };
}

function walk(
  points: readonly LonLat[],
  last: LastKnown,
  { airspeed_m_s, wind }: Flight,
  time_s: number,
  elapsed_s: number,
): Ghost {
  const drift_deg = wrap180_deg(last.heading_deg - last.course_deg);
  const motion = (track_deg: number): { groundspeed_m_s: number; heading_deg: number } =>
    airspeed_m_s !== null && wind !== null && airspeed_m_s > MOVING_M_S
      ? alongTrack(track_deg, airspeed_m_s, wind)
      : { groundspeed_m_s: last.groundspeed_m_s, heading_deg: wrap360_deg(track_deg + drift_deg) };
  const path: LonLat[] = [last.at];
  let left_s = time_s;
  let way_m = 0;
  let at = last.at;
  let [course_deg, heading_deg] = [last.course_deg, last.heading_deg];
  for (let index = 1; index < points.length && left_s > 0; index += 1) {
    const to = points[index] as LonLat;
    const piece_m = distance_m(at, to);
    if (piece_m < 1e-3) continue;
    const track_deg = bearing_deg(at, to);
    const { groundspeed_m_s, heading_deg: nose_deg } = motion(track_deg);
    const go_m = Math.min(piece_m, groundspeed_m_s * left_s);
    [course_deg, heading_deg] = [track_deg, nose_deg];
    at = go_m < piece_m ? destination(at, track_deg, go_m) : to;
    left_s -= piece_m / groundspeed_m_s;
    way_m += go_m;
    path.push(at);
  }
  return { at, course_deg, heading_deg, elapsed_s, reach_m: way_m, path, isOnRoute: true };
}
