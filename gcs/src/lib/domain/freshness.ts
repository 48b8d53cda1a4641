// Freshness of a value by its age.
import { AGES } from './core';

export type Freshness = 'fresh' | 'stale' | 'lost' | 'never';

/** `age_s` is null when the value never came. */
export function freshness(age_s: number | null): Freshness {
  if (age_s === null) return 'never';
  if (age_s <= AGES.stale_s) return 'fresh';
  return age_s <= AGES.lost_s ? 'stale' : 'lost';
}
