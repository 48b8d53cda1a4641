/** The height profile of a mission from the core, and its axes. */

export interface ProfilePoint {
  /** The item that it belongs to, counted from 1; `null` for home at the beginning. */
  readonly item: number | null;
  /** Way flown since the beginning, metres. */
  readonly distance_m: number;
  readonly alt_rel_home_m: number;
  /** Whether that is known; otherwise it is a guess. */
  readonly is_certain: boolean;
  /** Whether the item's own height is here: others lead to it, over the ground or round a circle. */
  readonly is_item: boolean;
  /** Whether it comes after a circle without end, and is flown only when a pilot goes on to it. */
  readonly is_beyond: boolean;
}

/** A stretch in which the plane circles at an item. */
export interface ProfileLoiter {
  readonly item: number;
  readonly kind: 'turns' | 'time' | 'height' | 'unlimited';
  readonly from_m: number;
  /** The same as `from_m` when it has no end or its length is not known. */
  readonly to_m: number;
  /** Whether its length is not known, though it has one. */
  readonly is_unknown: boolean;
}

/** How high above the ground the plane passes somewhere. */
export interface Clearance {
  readonly distance_m: number;
  readonly clearance_m: number;
}

/** The ground below the way, as far as it is known. */
export interface ProfileGround {
  readonly distance_m: readonly number[];
  /** Above the ground at home; `null` where it is not known. */
  readonly ground_rel_home_m: readonly (number | null)[];
  /** Where the plane is nearest to it, take-off and landing apart; `null` when it is nowhere known. */
  readonly lowest: Clearance | null;
  /** Where it is too low; `to_m` is the way to the last such place of the stretch. */
  readonly too_low: readonly (Clearance & { readonly to_m: number })[];
  /** Places whose height is not known. */
  readonly unknown: number;
}

export interface Profile {
  readonly points: readonly ProfilePoint[];
  readonly loiters: readonly ProfileLoiter[];
  readonly length_m: number;
  /** `null` when home is not known, from which heights count. */
  readonly ground: ProfileGround | null;
}

export const NO_PROFILE: Profile = { points: [], loiters: [], length_m: 0, ground: null };

/** Round values for an axis from `min` to `max`, about `count` of them: 1, 2 or 5 times a power of ten apart. */
export function ticks(min: number, max: number, count: number): number[] {
  const span = max - min;
  if (!(span > 0) || count < 1) return [min];
  const step = niceStep(span / count);
  const first = Math.ceil(min / step - 1e-9);
  const last = Math.floor(max / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, index) => (first + index) * step);
}

/** The smallest of 1, 2, 5 times a power of ten that is not below `value`. */
export function niceStep(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  for (const factor of [1, 2, 5]) if (factor * power >= value * (1 - 1e-9)) return factor * power;
  return 10 * power;
}
