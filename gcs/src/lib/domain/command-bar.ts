// Why a vehicle takes no command from this page: the one place that decides it.

/** What decides it. */
export interface Standing {
  /** Whether the vehicle comes from a recording. */
  readonly isRecorded: boolean;
  readonly isOnline: boolean;
  readonly isOperator: boolean;
  readonly hasControl: boolean;
  /** Whether another ground station has control of the vehicle. */
  readonly isHeldElsewhere: boolean;
}

/** The reason, the weightiest first: nothing changes that a recording takes no commands. */
export type CommandBar = 'recording' | 'away' | 'watching' | 'control' | 'held';

/** Why no command is sent; null when one may be. */
export function commandBar(standing: Standing): CommandBar | null {
  const { isRecorded, isOnline, isOperator, hasControl, isHeldElsewhere } = standing;
  if (isRecorded) return 'recording';
  if (!isOnline) return 'away';
  if (!isOperator) return 'watching';
  if (!hasControl) return 'control';
  return isHeldElsewhere ? 'held' : null;
}
