// How old a value may be before it is marked, and before it says nothing any more.

/** A value older than this is stale: shown, but marked. */
const STALE_AFTER_S = 3.5;
/** A value older than this says nothing about the vehicle any more. */
const LOST_AFTER_S = 5;

export type Freshness = 'fresh' | 'stale' | 'lost' | 'never';

/** `age_s` is null when the value never came. */
export function freshness(age_s: number | null): Freshness {
  if (age_s === null) return 'never';
  if (age_s <= STALE_AFTER_S) return 'fresh';
  return age_s <= LOST_AFTER_S ? 'stale' : 'lost';
}
