/** Keeping the plane in sight: how a view must change so that a plane near its edge stays on the map (SPEC G8). */

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
