/** Undo and redo over immutable values. */

export interface History<T> {
  readonly past: readonly T[];
  readonly present: T;
  readonly future: readonly T[];
  /** What the newest step was about; steps about the same thing in a row (a drag, typing in one field) are one. */
  readonly about: string | null;
}

/** Steps that can be undone; older ones are forgotten first. */
const MAX_STEPS = 200;

export const historyOf = <T>(present: T): History<T> => ({ past: [], present, future: [], about: null });

export function commit<T>(history: History<T>, next: T, about: string | null = null): History<T> {
  if (next === history.present) return history;
  if (about !== null && about === history.about && history.past.length > 0) {
    return { ...history, present: next, future: [] };
  }
  return { past: [...history.past, history.present].slice(-MAX_STEPS), present: next, future: [], about };
}

/** Ends a run of steps about the same thing: the next one can be undone separately. */
export const seal = <T>(history: History<T>): History<T> =>
  history.about === null ? history : { ...history, about: null };

export function undo<T>(history: History<T>): History<T> {
  const previous = history.past.at(-1);
  if (previous === undefined) return history;
  return {
    past: history.past.slice(0, -1),
    present: previous,
    future: [history.present, ...history.future],
    about: null,
  };
}

export function redo<T>(history: History<T>): History<T> {
  const [next, ...future] = history.future;
  if (next === undefined) return history;
  return { past: [...history.past, history.present], present: next, future, about: null };
}
