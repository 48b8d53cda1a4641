// Rows of different heights, one below the other, of which only those in sight are drawn.

/** Where each row begins, and last where they all end. */
export function topsOf(heights_px: readonly number[]): number[] {
  const tops = [0];
  for (const height_px of heights_px) tops.push((tops.at(-1) ?? 0) + height_px);
  return tops;
}

/** Which rows are to be drawn, with some beyond each edge. */
export function rowsWithin(
  tops_px: readonly number[],
  scrolled_px: number,
  height_px: number,
  beyond = 4,
): { readonly from: number; readonly to: number } {
  const count = tops_px.length - 1;
  const first = firstAbove(tops_px, scrolled_px) - 1;
  const last = firstAbove(tops_px, scrolled_px + height_px);
  return { from: Math.max(0, Math.min(count, first - beyond)), to: Math.max(0, Math.min(count, last + beyond)) };
}

/** Index of the first top that is greater. */
function firstAbove(tops_px: readonly number[], at_px: number): number {
  let [low, high] = [0, tops_px.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((tops_px[middle] ?? Infinity) > at_px) high = middle;
    else low = middle + 1;
  }
  return low;
}

/** The index of a row, or of the one that took its place: -1 means that it left the list of `count` rows, where it was at `before`. */
export const indexNear = (index: number, before: number, count: number): number =>
  index >= 0 ? index : Math.max(0, Math.min(before, count - 1));
