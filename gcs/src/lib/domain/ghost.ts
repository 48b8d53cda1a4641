// Where a plane that is not heard any more probably is: dead reckoning from what it last said.
import { destination } from './geo';
import { type LonLat, wrap360_deg } from './lonlat';

/** The last that is known of a plane. */
export interface LastKnown {
  at: LonLat;
  /** Of the movement over ground, clockwise from true north. */
  course_deg: number;
  /** Of the nose. */
  heading_deg: number;
  groundspeed_m_s: number;
  /** Clockwise positive; 0 unless the plane was circling, because other turns end soon. */
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
    return { at: last.at, course_deg: last.course_deg, heading_deg: last.heading_deg, elapsed_s, reach_m: 0 };
  }
  const rate_deg_s = Math.abs(last.turn_rate_deg_s) < STRAIGHT_DEG_S ? 0 : last.turn_rate_deg_s;
  const turned_deg = rate_deg_s * time_s;
  // The chord of the arc that was flown leaves with half of the angle turned.
  const half_rad = (turned_deg * Math.PI) / 360;
  const chord_m = half_rad === 0 ? way_m : way_m * (Math.sin(half_rad) / half_rad);
  return {
    at: destination(last.at, wrap360_deg(last.course_deg + turned_deg / 2), chord_m),
    course_deg: wrap360_deg(last.course_deg + turned_deg),
    heading_deg: wrap360_deg(last.heading_deg + turned_deg),
    elapsed_s,
    reach_m: way_m,
  };
}

/** Turn rate of a coordinated turn, clockwise positive: g · tan(roll) / speed. */
export function turnRate_deg_s(roll_rad: number, speed_m_s: number): number {
  if (speed_m_s < MOVING_M_S || Math.abs(roll_rad) > 1.4) return 0;
  return ((9.80665 * Math.tan(roll_rad)) / speed_m_s) * (180 / Math.PI);
}
