import { describe, expect, it } from 'vitest';
import { type Quad, quadMapping } from './projection-quad';

describe('a picture by its corners', () => {
  const quads: readonly Quad[] = [
    [
      [0, 0],
      [10, 0],
      [10, 10],
      [0, 10],
    ],
    [
      [3, -4],
      [90, 10],
      [70, 55],
      [-5, 80],
    ],
  ];

  it('has its corners where they were put, and straight edges', () => {
    for (const quad of quads) {
      const place = quadMapping(quad);
      const corners = [place?.(0, 0), place?.(1, 0), place?.(1, 1), place?.(0, 1)];
      corners.forEach((corner, index) => {
        expect(corner?.[0]).toBeCloseTo(quad[index]?.[0] ?? NaN, 9);
        expect(corner?.[1]).toBeCloseTo(quad[index]?.[1] ?? NaN, 9);
      });
      const [x, y] = place?.(0.3, 0) ?? [NaN, NaN];
      const [[x0, y0], [x1, y1]] = quad;
      expect((x - x0) * (y1 - y0)).toBeCloseTo((y - y0) * (x1 - x0), 6);
    }
  });

  it('keeps the middle of a rectangle in its middle, and that of a perspective on its diagonals', () => {
    expect(quadMapping(quads[0] as Quad)?.(0.5, 0.5)).toEqual([5, 5]);
    const quad = quads[1] as Quad;
    const [x, y] = quadMapping(quad)?.(0.5, 0.5) ?? [NaN, NaN];
    const [[x0, y0], , [x2, y2]] = quad;
    expect((x - x0) * (y2 - y0)).toBeCloseTo((y - y0) * (x2 - x0), 6);
  });

  it('is none when corners cross or fall together', () => {
    const [a, b, c, d] = quads[1] as Quad;
    expect(quadMapping([a, c, b, d])).toBeNull();
    expect(quadMapping([a, a, c, d])).toBeNull();
    expect(quadMapping([a, b, [46.5, 3], d])).toBeNull();
  });
});
