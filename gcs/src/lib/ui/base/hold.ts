// How long a dangerous button is held, and how it is without a pointer or keyboard that can hold.

export const HOLD_MS = 1000;
/** A screen reader presses, it cannot hold: the second press within this time counts. */
export const CONFIRM_MS = 6000;

/** How long the hint is shown after a button was released early. */
const HINT_MS = 1500;

/** A timer that is later than this comes after a page that stood still, in which the finger may have left unseen. */
const LATE_MS = 100;

/** How often it is looked again after such a timer: on a display that is always slow each is late, and the button would never act. */
const LOOKS = 5;

/** `hint`: it was let go too early. */
export type HoldState = 'idle' | 'holding' | 'hint' | 'confirm';

interface Timers {
  now(): number;
  setTimeout(run: () => void, ms: number): unknown;
  clearTimeout(timer: unknown): void;
}

const real: Timers = {
  now: () => performance.now(),
  setTimeout: (run, ms) => globalThis.setTimeout(run, ms),
  clearTimeout: (timer) => globalThis.clearTimeout(timer as ReturnType<typeof setTimeout>),
};

/** A press that counts only when it lasts, or is confirmed by a second one. */
export class Hold {
  readonly #done: () => void;
  readonly #changed: (state: HoldState) => void;
  readonly #timers: Timers;
  #state: HoldState = 'idle';
  #timer: unknown = null;

  constructor(done: () => void, changed: (state: HoldState) => void, timers: Timers = real) {
    this.#done = done;
    this.#changed = changed;
    this.#timers = timers;
  }

  /** Pointer or key went down. */
  begin(): void {
    if (this.#state !== 'holding') this.#hold(HOLD_MS);
  }

  /** Fires after the hold time; if the page was blocked meanwhile, only after queued events such as the release were handled. */
  #hold(ms: number, looks = LOOKS): void {
    const due_ms = this.#timers.now() + ms;
    this.#enter('holding', ms, () => {
      if (this.#timers.now() > due_ms + LATE_MS && looks > 0) {
        this.#hold(LATE_MS, looks - 1);
        return;
      }
      this.#enter('idle');
      this.#done();
    });
  }

  /** Pointer or key went up, left, or lost its target: too early. */
  end(): void {
    if (this.#state === 'holding') this.#enter('hint', HINT_MS, () => this.#enter('idle'));
  }

  /** Pressed by something that cannot hold. */
  press(): void {
    if (this.#state === 'holding') return;
    if (this.#state === 'confirm') {
      this.#enter('idle');
      this.#done();
    } else this.#enter('confirm', CONFIRM_MS, () => this.#enter('idle'));
  }

  /** Forgets everything: the button goes away or is disabled. */
  cancel(): void {
    this.#enter('idle');
  }

  #enter(state: HoldState, ms?: number, then?: () => void): void {
    if (this.#timer !== null) this.#timers.clearTimeout(this.#timer);
    this.#timer = ms !== undefined && then !== undefined ? this.#timers.setTimeout(then, ms) : null;
    if (state === this.#state) return;
    this.#state = state;
    this.#changed(state);
  }
}
