// A group action: N requests, N answers; their meaning, and sending a few at a time.
import type { RosterRow } from './roster';

/** Actions for a group; each vehicle gets its own command. */
export const GROUP_ACTS = ['return-to-launch', 'loiter', 'mission/pause', 'mission/resume'] as const;
export type GroupAct = (typeof GROUP_ACTS)[number];

/** Result for one vehicle: done; refused; unreached, so nothing was done; unknown, so it may have been done. */
export const OUTCOMES = ['done', 'refused', 'unreached', 'unknown'] as const;
export type Outcome = (typeof OUTCOMES)[number];

/** Causes after which nothing was done because the vehicle was not reached. */
const UNREACHED: ReadonlySet<string> = new Set(['vehicle-lost', 'no-vehicle', 'not-found', 'not-sent', 'unreached']);
/** Causes after which it is unknown whether the command was executed. */
const UNKNOWN: ReadonlySet<string> = new Set(['command-timeout', 'not-confirmed', 'cancelled', 'closed', 'rebooted']);

/** What a failure means, by the code of its cause; null where the server gave none, as when it went away meanwhile. */
export function outcomeOf(code: string | null): Exclude<Outcome, 'done'> {
  if (code === null || UNKNOWN.has(code)) return 'unknown';
  return UNREACHED.has(code) ? 'unreached' : 'refused';
}

/** A disarmed plane would execute the command as soon as it is armed, so it is not sent. Unknown does not count as disarmed. */
export const isToldNothing = (row: RosterRow): boolean => row.is_armed === false;

/** Does it for each, a few at a time, in order. */
export async function inTurns<T>(all: readonly T[], atOnce: number, one: (item: T) => Promise<void>): Promise<void> {
  const waiting = [...all];
  const work = async (): Promise<void> => {
    for (let next = waiting.shift(); next !== undefined; next = waiting.shift()) await one(next);
  };
  await Promise.all(Array.from({ length: Math.min(atOnce, all.length) }, work));
}
