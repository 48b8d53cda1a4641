/** A picture on the map by its four corners: the projective mapping of the unit square (Heckbert 1989, section 2.2.3). */

export type Point = readonly [x: number, y: number];

/** Corners in the order of the picture: top left, top right, bottom right, bottom left. */
export type Quad = readonly [Point, Point, Point, Point];

/**
 * Where a place of the picture lies: `u` from its left (0) to its right (1), `v` from its top to its bottom. `null` when the
 * corners make no picture: three in a line, or two that cross over.
 */
export function quadMapping([[x0, y0], [x1, y1], [x2, y2], [x3, y3]]: Quad): ((u: number, v: number) => Point) | null {
  if (!isConvex([x0, y0], [x1, y1], [x2, y2], [x3, y3])) return null;
  const [sx, sy] = [x0 - x1 + x2 - x3, y0 - y1 + y2 - y3];
  const [dx1, dy1, dx2, dy2] = [x1 - x2, y1 - y2, x3 - x2, y3 - y2];
  const determinant = dx1 * dy2 - dx2 * dy1;
  const g = (sx * dy2 - dx2 * sy) / determinant;
  const h = (dx1 * sy - sx * dy1) / determinant;
  const [a, b, c] = [x1 - x0 + g * x1, x3 - x0 + h * x3, x0];
  const [d, e, f] = [y1 - y0 + g * y1, y3 - y0 + h * y3, y0];
  return (u, v) => {
    const w = g * u + h * v + 1;
    return [(a * u + b * v + c) / w, (d * u + e * v + f) / w];
  };
}

/** Whether four corners, in turn, make a convex shape that is more than a line. */
function isConvex(...corners: readonly Point[]): boolean {
  const turns = corners.map(([x, y], index) => {
    const [nextX, nextY] = corners[(index + 1) % 4] as Point;
    const [afterX, afterY] = corners[(index + 2) % 4] as Point;
    return Math.sign((nextX - x) * (afterY - nextY) - (nextY - y) * (afterX - nextX));
  });
  return turns[0] !== 0 && turns.every((turn) => turn === turns[0]);
}
