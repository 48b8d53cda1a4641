// Where a lost plane probably is: dead reckoning from its last telemetry.
import { bearing_deg, destination } from './geo';
import { type LonLat, wrap360_deg } from './lonlat';
import { momentAt, placesOf, type Track } from './rehearsal';

/** The last that is known of a plane. */
export interface LastKnown {
  at: LonLat;
  /** Of the movement over ground, clockwise from true north. */
  course_deg: number;
  /** Of the nose. */
  heading_deg: number;
  groundspeed_m_s: number;
  /** Clockwise positive; 0 unless the core reported circling. */
  turn_rate_deg_s: number;
}

export interface Ghost {
  at: LonLat;
  course_deg: number;
  heading_deg: number;
  /** How long ago the plane was last heard. */
  elapsed_s: number;
  /** The plane cannot be farther than this from where it was last heard, at its last speed. */
  reach_m: number;
  /** The way from where it was last heard to where it is thought to be. */
  path: readonly LonLat[];
  /** Whether it follows its mission; else a line or circle. */
  isOnRoute: boolean;
}

/** After this long the estimate stays where it is: it is worth nothing any more. */
export const GHOST_LIMIT_S = 300;
/** Slower than this is standing: a plane on the ground has no ghost that wanders off. */
const MOVING_M_S = 3;
/** Below this turn rate the path is a straight line. */
const STRAIGHT_DEG_S = 0.2;

/** Goes on along the last path: a straight line, or the circle that the plane was flying. */
export function deadReckon(last: LastKnown, elapsed_s: number): Ghost {
  const time_s = Math.min(Math.max(elapsed_s, 0), GHOST_LIMIT_S);
  const way_m = last.groundspeed_m_s >= MOVING_M_S ? last.groundspeed_m_s * time_s : 0;
  if (way_m === 0) {
    const { at, course_deg, heading_deg } = last;
    return { at, course_deg, heading_deg, elapsed_s, reach_m: 0, path: [at], isOnRoute: false };
  }
  const rate_deg_s = Math.abs(last.turn_rate_deg_s) < STRAIGHT_DEG_S ? 0 : last.turn_rate_deg_s;
  const turned_deg = rate_deg_s * time_s;
  // The chord of the arc that was flown leaves with half of the angle turned.
  const after = (part: number): LonLat => {
    const half_rad = (turned_deg * part * Math.PI) / 360;
    const chord_m = way_m * part * (half_rad === 0 ? 1 : Math.sin(half_rad) / half_rad);
    return destination(last.at, wrap360_deg(last.course_deg + (turned_deg * part) / 2), chord_m);
  };
  // more than a turn of a circle adds nothing to see
  const pieces = turned_deg === 0 ? 1 : Math.min(72, Math.ceil(Math.abs(turned_deg) / 6));
  const seen = Math.min(1, 360 / Math.max(Math.abs(turned_deg), 1));
  const path = Array.from({ length: pieces + 1 }, (_, index) => after(1 - seen + (seen * index) / pieces));
  return {
    at: after(1),
    course_deg: wrap360_deg(last.course_deg + turned_deg),
    heading_deg: wrap360_deg(last.heading_deg + turned_deg),
    elapsed_s,
    reach_m: way_m,
    path,
    isOnRoute: false,
  };
}

/** Goes on along a rehearsed track that began `early_s` before the last that is known; it stays where that ends. */
export function followTrack(last: LastKnown, track: Track, early_s: number, elapsed_s: number): Ghost {
  const end_s = early_s + Math.min(Math.max(elapsed_s, 0), GHOST_LIMIT_S);
  const moment = momentAt(track, end_s);
  if (moment === null) return deadReckon(last, elapsed_s);
  const between = placesOf(track).filter((_, index) => {
    const time_s = track.time_s[index] ?? 0;
    return time_s > early_s && time_s < end_s;
  });
  const path = [last.at, ...between, moment.at];
  return {
    at: moment.at,
    course_deg: bearing_deg(path.at(-2) ?? last.at, moment.at),
    heading_deg: moment.heading_deg,
    elapsed_s,
    reach_m: last.groundspeed_m_s * (end_s - early_s),
    path,
    isOnRoute: true,
  };
}
