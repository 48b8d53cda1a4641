/** What is seen of the map: keeping the plane in sight (SPEC G8), and fitting a plan between what lies over the map. */

export interface Size {
  readonly width: number;
  readonly height: number;
}

/** Parts of the window that panels cover, pixels. */
export interface Insets {
  readonly top: number;
  readonly right: number;
  readonly bottom: number;
  readonly left: number;
}

/** Margin that the plane may enter before the view follows, as part of the shorter side of the visible area. */
const MARGIN = 0.12;
/** Where the widened view puts the plane, as part of the half size of the visible area: well inside the margin. */
const SETTLED = 0.6;
/** The view widens by at least this factor: seldom and clearly rather than often and a little. */
const MIN_FACTOR = 1.35;
/** And by at most this one at a time. */
const MAX_FACTOR = 64;

/** The free part of the window. */
function freeBox(size: Size, insets: Insets): { x: number; y: number; width: number; height: number } {
  const width = Math.max(size.width - insets.left - insets.right, size.width * 0.2, 1);
  const height = Math.max(size.height - insets.top - insets.bottom, size.height * 0.2, 1);
  return {
    x: Math.min(insets.left, size.width - width),
    y: Math.min(insets.top, size.height - height),
    width,
    height,
  };
}

/** The middle of what panels leave free, pixels from the top left. */
export function freeCentre(size: Size, insets: Insets): { x: number; y: number } {
  const free = freeBox(size, insets);
  return { x: free.x + free.width / 2, y: free.y + free.height / 2 };
}

/**
 * Factor by which the view must widen, about the middle of what is free, so that the plane at pixel (`x`, `y`) is in sight
 * again; 1 while it is. Works for a plane that is already out of the window.
 */
export function widenFactor(x: number, y: number, size: Size, insets: Insets): number {
  const free = freeBox(size, insets);
  const margin = Math.min(free.width, free.height) * MARGIN;
  const isInside =
    x >= free.x + margin &&
    x <= free.x + free.width - margin &&
    y >= free.y + margin &&
    y <= free.y + free.height - margin;
  if (isInside || !Number.isFinite(x) || !Number.isFinite(y)) return 1;
  const centre = freeCentre(size, insets);
  const needed = Math.max(
    Math.abs(x - centre.x) / ((free.width / 2) * SETTLED),
    Math.abs(y - centre.y) / ((free.height / 2) * SETTLED),
  );
  return Math.min(Math.max(needed, MIN_FACTOR), MAX_FACTOR);
}

/** Factor below which the view narrows again: as clearly as it widens. */
const NARROWS_BELOW = 1 / 1.6;

/**
 * Factor by which a view that was widened may narrow towards the one before, which is `wanted` of it, with the plane at pixel
 * (`x`, `y`) well inside; 1 while that is not worth a move.
 */
export function narrowFactor(x: number, y: number, size: Size, insets: Insets, wanted: number): number {
  const free = freeBox(size, insets);
  const centre = freeCentre(size, insets);
  const needed = Math.max(
    Math.abs(x - centre.x) / ((free.width / 2) * SETTLED),
    Math.abs(y - centre.y) / ((free.height / 2) * SETTLED),
  );
  const factor = Math.max(needed, wanted);
  return factor < NARROWS_BELOW ? factor : 1;
}

/** A part of the window, pixels from its top left. */
export interface Rect {
  readonly left: number;
  readonly top: number;
  readonly right: number;
  readonly bottom: number;
}

/** A cover that would leave less than this part of the width or height to the plan is drawn over. */
const LEAST_LEFT = 1 / 3;

/**
 * The insets that show a shape of this width and height as large as possible beside what covers the map: each cover is passed on its
 * side or above or below it.
 */
export function insetsBeside(covers: readonly Rect[], shape: Size, size: Size, insets: Insets): Insets {
  const free = freeBox(size, insets);
  const cost = ({ top, right, bottom, left }: Insets): number => {
    const [width, height] = [size.width - left - right, size.height - top - bottom];
    if (width < free.width * LEAST_LEFT || height < free.height * LEAST_LEFT) return Infinity;
    // of equals the one that leaves more
    return Math.max(shape.width / width, shape.height / height) + 1e-9 / (width * height);
  };
  const reaches = ({ left, top, right, bottom }: Rect, all: Insets): boolean =>
    left < size.width - all.right && right > all.left && top < size.height - all.bottom && bottom > all.top;
  const best = (from: number, all: Insets): Insets => {
    const cover = covers[from];
    if (cover === undefined) return all;
    if (!reaches(cover, all)) return best(from + 1, all);
    const isLeft = (cover.left + cover.right) / 2 < free.x + free.width / 2;
    const isUpper = (cover.top + cover.bottom) / 2 < free.y + free.height / 2;
    const aside = isLeft ? { ...all, left: cover.right } : { ...all, right: size.width - cover.left };
    const past = isUpper ? { ...all, top: cover.bottom } : { ...all, bottom: size.height - cover.top };
    const choices = [aside, past].filter((one) => cost(one) < Infinity).map((one) => best(from + 1, one));
    if (choices.length === 0) return best(from + 1, all);
    return choices.reduce((a, b) => (cost(b) < cost(a) ? b : a));
  };
  return best(0, insets);
}
