// Which changes of height are held: what a digit too many or too few makes of them.

/** A larger change is held, metres. */
const LARGE_M = 100;
/** So is a height below this part of the present one. */
const LOW_PART = 0.5;

/** Whether a new height above home, metres, is far from the present one; an unknown one is far from all. */
export const isLargeChange = (from_m: number | null, to_m: number): boolean =>
  from_m === null || Math.abs(to_m - from_m) > LARGE_M || to_m < from_m * LOW_PART;
