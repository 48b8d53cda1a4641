// The place of a replay between two messages about it, and the time of a recording.

/** What is known of a replay; as in the API. */
export interface ReplayState {
  readonly position_s: number;
  readonly duration_s: number;
  readonly unix_s: number | null;
  readonly speed: number;
  readonly is_paused: boolean;
  readonly is_over: boolean;
}

/** Speeds to choose from, times the recorded one. */
export const SPEEDS = [0.5, 1, 2, 4, 8, 16, 32] as const;

export const isStopped = ({ is_paused, is_over }: ReplayState): boolean => is_paused || is_over;

/** Its place some time after that was known, seconds. */
export function positionAfter(replay: ReplayState, passed_s: number): number {
  const on_s = isStopped(replay) ? 0 : Math.max(0, passed_s) * replay.speed;
  return Math.min(replay.duration_s, replay.position_s + on_s);
}

/** Time of day in the recording at a place near the present one, seconds since 1970; null when the recording has none. */
export function timeAt(replay: ReplayState, position_s: number): number | null {
  return replay.unix_s === null ? null : replay.unix_s + (position_s - replay.position_s);
}
