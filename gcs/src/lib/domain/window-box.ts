// A window inside a room, in pixels: it keeps a size that can be used, and never leaves the room.

export interface Box {
  x: number;
  y: number;
  width: number;
  height: number;
}

export const MIN_WIDTH = 260;
export const MIN_HEIGHT = 220;

const clamp = (value: number, low: number, high: number): number => Math.max(low, Math.min(high, value));

/** `box` made to fit into a room of this size, its upper edge first. */
export function clampBox(box: Box, roomWidth: number, roomHeight: number): Box {
  const width = clamp(box.width, MIN_WIDTH, Math.max(MIN_WIDTH, roomWidth));
  const height = clamp(box.height, MIN_HEIGHT, Math.max(MIN_HEIGHT, roomHeight));
  return {
    x: clamp(box.x, 0, Math.max(0, roomWidth - width)),
    y: clamp(box.y, 0, Math.max(0, roomHeight - height)),
    width,
    height,
  };
}

/** A box that was stored; null for anything else. */
export function readBox(value: unknown): Box | null {
  if (typeof value !== 'object' || value === null) return null;
  const { x, y, width, height } = value as Record<string, unknown>;
  const isNumber = (side: unknown): side is number => typeof side === 'number' && Number.isFinite(side);
  return isNumber(x) && isNumber(y) && isNumber(width) && isNumber(height) ? { x, y, width, height } : null;
}
