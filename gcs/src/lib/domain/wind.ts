/** The wind as a handle on a disc sets it: where the handle is it comes from, and the farther out the stronger it is. */

export interface Wind {
  /** From true north, 0 to below 360. */
  readonly from_deg: number;
  readonly speed_m_s: number;
}

/** At the disc's edge: more than a small plane flies in. */
export const MOST_WIND_M_S = 20;
/** Nearer to the middle than this part of the way out it is calm. */
const CALM_WITHIN = 0.08;
const STEP_DEG = 5;
const STEP_M_S = 0.5;

/** Where the handle stands, as parts of the way from the middle to the edge. */
export function handleOf({ from_deg, speed_m_s }: Wind): { east: number; south: number } {
  const [out, from_rad] = [speed_m_s / MOST_WIND_M_S, (from_deg * Math.PI) / 180];
  return { east: out * Math.sin(from_rad), south: -out * Math.cos(from_rad) };
}

/** The wind of a place on the disc, in round figures; calm keeps the direction that it had. */
export function windOf(east: number, south: number, before: Wind): Wind {
  const out = Math.min(1, Math.hypot(east, south));
  if (out < CALM_WITHIN) return { ...before, speed_m_s: 0 };
  const from_deg = (Math.atan2(east, -south) * 180) / Math.PI;
  return {
    from_deg: (Math.round(from_deg / STEP_DEG) * STEP_DEG + 360) % 360,
    speed_m_s: Math.round((out * MOST_WIND_M_S) / STEP_M_S) * STEP_M_S,
  };
}
