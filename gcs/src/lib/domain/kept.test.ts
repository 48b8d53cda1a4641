import { expect, test } from 'vitest';
import { missing } from './kept';

test('what is lost is counted apart from what may still be fetched', () => {
  const gaps = [
    { first: 3, last: 5, is_lost: false },
    { first: 9, last: 9, is_lost: true },
    { first: 20, last: 29, is_lost: false },
  ];
  expect(missing(gaps)).toEqual({ toFetch: 13, lost: 1 });
  expect(missing([])).toEqual({ toFetch: 0, lost: 0 });
});
