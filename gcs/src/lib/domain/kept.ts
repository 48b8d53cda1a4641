// What is missing of a history.

interface Gap {
  first: number;
  last: number;
  is_lost: boolean;
}

/** How many records may still be fetched, and how many the aircraft has no more. */
export function missing(gaps: readonly Gap[]): { toFetch: number; lost: number } {
  const found = { toFetch: 0, lost: 0 };
  for (const { first, last, is_lost } of gaps) found[is_lost ? 'lost' : 'toFetch'] += last - first + 1;
  return found;
}
