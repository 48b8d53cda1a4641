/** From a plan to the take-off: what is done, and what comes next. */

/** What is known of the vehicle and the plan; `null` is what is not known yet. */
export interface Standing {
  hasPlan: boolean;
  isSent: boolean;
  isArmed: boolean | null;
  /** Whether it must be prepared for a flight. */
  needsPreparation: boolean | null;
  isReady: boolean | null;
  /** Whether its mode flies the mission. */
  followsMission: boolean | null;
}

/** The steps in their order. One is done only when that is known. */
export const firstSteps = ({ hasPlan, isSent, isArmed, needsPreparation, isReady, followsMission }: Standing) =>
  [
    { name: 'plan', isDone: hasPlan },
    { name: 'send', isDone: isSent },
    { name: 'prepare', isDone: isArmed === true || (isArmed === false && needsPreparation === false) },
    { name: 'ready', isDone: isArmed === true || isReady === true },
    { name: 'arm', isDone: isArmed === true },
    { name: 'start', isDone: isArmed === true && followsMission === true },
  ] as const;

export type Steps = ReturnType<typeof firstSteps>;
export type StepName = Steps[number]['name'];

/** What comes next; `null` when all is done. */
export const nextStep = (steps: Steps): StepName | null => steps.find(({ isDone }) => !isDone)?.name ?? null;

/** The step to be taken next. When readiness is unknown that is arming; while the vehicle is not ready there is none. */
export function stepToTake({ isReady, ...standing }: Standing): StepName | null {
  const next = nextStep(firstSteps({ isReady, ...standing }));
  if (next !== 'ready') return next;
  return isReady === null ? 'arm' : null;
}
