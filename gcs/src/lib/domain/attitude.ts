// What the attitude indicator shows. Between two messages it follows the plane's own rates for a moment, without jumps.
import type { TelemetryGroups } from '$lib/api/types';
import type { Freshness } from './freshness';

export interface AttitudeSample {
  roll_rad: number;
  pitch_rad: number;
  heading_rad: number;
}

export interface AttitudeInput extends AttitudeSample {
  roll_rate_rad_s: number;
  pitch_rate_rad_s: number;
  yaw_rate_rad_s: number;
  /** How old the message is. */
  age_s: number;
}

/** Rates are followed at most this long after a message: beyond, they would invent a movement. */
const FOLLOW_S = 0.25;
/** Time constant with which the picture approaches what it should show. */
const SMOOTH_S = 0.05;

/** `angle` brought into −π to π. */
export function wrapPi(angle_rad: number): number {
  return Math.atan2(Math.sin(angle_rad), Math.cos(angle_rad));
}

/** The next picture, `dt_s` after `shown`. */
export function nextAttitude(shown: AttitudeSample | null, input: AttitudeInput, dt_s: number): AttitudeSample {
  const ahead_s = Math.min(Math.max(input.age_s, 0), FOLLOW_S);
  // Euler rates from body rates, Tait-Bryan ZYX (Stevens & Lewis, Aircraft Control and Simulation, eq. 1.3-22a), with
  // the pitch kept off the pole.
  const { roll_rad, pitch_rad, roll_rate_rad_s: p, pitch_rate_rad_s: q, yaw_rate_rad_s: r } = input;
  const cosPitch = Math.max(Math.cos(pitch_rad), 0.1);
  const aroundDown = (q * Math.sin(roll_rad) + r * Math.cos(roll_rad)) / cosPitch;
  const target: AttitudeSample = {
    roll_rad: wrapPi(roll_rad + (p + aroundDown * Math.sin(pitch_rad)) * ahead_s),
    pitch_rad: pitch_rad + (q * Math.cos(roll_rad) - r * Math.sin(roll_rad)) * ahead_s,
    heading_rad: wrapPi(input.heading_rad + aroundDown * ahead_s),
  };
  if (shown === null) return target;
  const part = 1 - Math.exp(-Math.max(dt_s, 0) / SMOOTH_S);
  return {
    roll_rad: wrapPi(shown.roll_rad + wrapPi(target.roll_rad - shown.roll_rad) * part),
    pitch_rad: shown.pitch_rad + (target.pitch_rad - shown.pitch_rad) * part,
    heading_rad: wrapPi(shown.heading_rad + wrapPi(target.heading_rad - shown.heading_rad) * part),
  };
}

/** Approaches `target` like the attitude does; a first value, or a jump after a gap, is taken at once. */
export function approach(shown: number | null, target: number, dt_s: number): number {
  if (shown === null || dt_s > 1) return target;
  return shown + (target - shown) * (1 - Math.exp(-Math.max(dt_s, 0) / 0.15));
}

/** Values of the tapes; null when unknown. */
interface Tapes {
  readonly airspeed_m_s: number | null;
  readonly climb_m_s: number | null;
  readonly groundspeed_m_s: number | null;
  readonly throttle_pct: number | null;
  readonly alt_rel_home_m: number | null;
  readonly heading_rad: number | null;
  /** Whether the speeds and the throttle, which come in one message, are old. */
  readonly isHudOld: boolean;
  readonly isPositionOld: boolean;
}

/**
 * The tapes' values, each as old as its own message: attitude may come while the others are silent. Values of a silent message are
 * not shown beside a horizon that moves; where the attitude is silent too, the last of all stays, and is marked as old.
 */
export function tapesOf(
  { attitude, hud, position }: TelemetryGroups,
  freshnessOf: (group: 'attitude' | 'hud' | 'position') => Freshness,
): Tapes {
  const isShown = (group: 'hud' | 'position'): boolean =>
    freshnessOf(group) !== 'lost' || freshnessOf('attitude') === 'lost';
  const isOld = (group: 'hud' | 'position'): boolean => ['stale', 'lost'].includes(freshnessOf(group));
  const shownHud = isShown('hud') ? hud : null;
  const shownPosition = isShown('position') ? position : null;
  const heading_deg = shownHud?.heading_deg ?? shownPosition?.heading_deg ?? null;
  return {
    airspeed_m_s: shownHud?.airspeed_m_s ?? null,
    climb_m_s: shownHud?.climb_m_s ?? null,
    groundspeed_m_s: shownHud?.groundspeed_m_s ?? null,
    throttle_pct: shownHud?.throttle_pct ?? null,
    // no other height in its place: that above the sea may be hundreds of metres more
    alt_rel_home_m: shownPosition?.alt_rel_home_m ?? null,
    heading_rad: attitude?.yaw_rad ?? (heading_deg === null ? null : (heading_deg * Math.PI) / 180),
    isHudOld: isOld('hud'),
    isPositionOld: isOld('position'),
  };
}
