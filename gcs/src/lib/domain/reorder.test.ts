import { expect, it } from 'vitest';
import { insertionIndex } from './reorder';

it('puts a row before the one whose upper half the pointer is over', () => {
  const rows = [0, 50, 150].map((top, index) => ({ top, bottom: [50, 150, 200][index] ?? 0 }));
  expect([-10, 24, 26, 99, 101, 174, 176, 900].map((y) => insertionIndex(rows, y))).toEqual([0, 0, 1, 1, 2, 2, 3, 3]);
  expect(insertionIndex([], 5)).toBe(0);
});
