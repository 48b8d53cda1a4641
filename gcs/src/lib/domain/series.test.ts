import { expect, it } from 'vitest';
import { Series } from './series';

it('gives back what came since a moment, oldest first, with gaps', () => {
  const series = new Series(2, 10);
  series.push(1, [1, 10]);
  series.push(2, [2, null]);
  series.push(3, [3]);
  expect(series.since(2)).toEqual([
    [2, 3],
    [2, 3],
    [null, null],
  ]);
});

it('forgets the oldest when it is full', () => {
  const series = new Series(1, 3);
  for (let time_s = 1; time_s <= 8; time_s += 1) series.push(time_s, [time_s]);
  expect(series.length).toBe(3);
  expect(series.since(0)).toEqual([
    [6, 7, 8],
    [6, 7, 8],
  ]);
});

it('ignores samples that are not later', () => {
  const series = new Series(1, 3);
  series.push(5, [1]);
  series.push(5, [2]);
  series.push(4, [3]);
  series.push(Number.NaN, [4]);
  expect(series.since(0)).toEqual([[5], [1]]);
});
