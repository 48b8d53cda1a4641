import { expect, it } from 'vitest';
import { indexNear, rowsWithin, topsOf } from './row-sight';

it('of two thousand rows of different heights those in sight are drawn', () => {
  const tops = topsOf(Array.from({ length: 2000 }, (_, index) => (index % 10 === 0 ? 40 : 60)));
  expect([tops.length, tops[1], tops.at(-1)]).toEqual([2001, 40, 116_000]);
  expect(rowsWithin(tops, 0, 500, 0)).toEqual({ from: 0, to: 9 });
  // half of the first one in sight is above the edge
  expect(rowsWithin(tops, 610, 500, 0)).toEqual({ from: 10, to: 20 });
  expect(rowsWithin(tops, 1e9, 500)).toEqual({ from: 1996, to: 2000 });
  expect(rowsWithin(topsOf([]), 0, 500)).toEqual({ from: 0, to: 0 });
});

it('in place of a row that left is the one after it, or the last', () => {
  expect([indexNear(7, 3, 9), indexNear(-1, 3, 9), indexNear(-1, 8, 8), indexNear(-1, 0, 0)]).toEqual([7, 3, 7, 0]);
});
