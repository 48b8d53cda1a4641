import { expect, it } from 'vitest';
import { isLargeChange } from './height-change';

it('takes a digit too many or too few for a large change', () => {
  const from = (from_m: number | null, ...to_m: number[]) => to_m.map((one) => isLargeChange(from_m, one));
  expect(from(100, 1000, 201, 200, 60, 50, 49, 10)).toEqual([true, true, false, false, false, true, true]);
  expect(from(400, 299, 301)).toEqual([true, false]);
  expect(from(null, 80), 'unknown').toEqual([true]);
});
