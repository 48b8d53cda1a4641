// Joins updates between two animation frames: however fast messages come, the screen is updated once a frame.
// The newest value wins, so what waits is bounded by the number of groups, also in a hidden window.

/** Flush interval in a hidden window, which has no animation frames. */
const HIDDEN_MS = 500;

export class FrameQueue<Key, Value> {
  readonly #waiting = new Map<Key, Value>();
  readonly #join: (waiting: Value, next: Value) => Value;
  readonly #flush: (key: Key, value: Value) => void;
  readonly #after: () => void;
  readonly #schedule: (run: () => void) => void;
  #isScheduled = false;

  constructor(options: {
    join: (waiting: Value, next: Value) => Value;
    flush: (key: Key, value: Value) => void;
    /** Called once after all that waited was handed out. */
    after?: () => void;
    schedule?: (run: () => void) => void;
  }) {
    this.#join = options.join;
    this.#flush = options.flush;
    this.#after = options.after ?? (() => {});
    this.#schedule = options.schedule ?? nextFrame;
  }

  push(key: Key, value: Value): void {
    const waiting = this.#waiting.get(key);
    this.#waiting.set(key, waiting === undefined ? value : this.#join(waiting, value));
    if (this.#isScheduled) return;
    this.#isScheduled = true;
    this.#schedule(() => {
      this.#isScheduled = false;
      const all = [...this.#waiting];
      this.#waiting.clear();
      for (const [key, value] of all) this.#flush(key, value);
      this.#after();
    });
  }
}

function nextFrame(run: () => void): void {
  if (document.hidden) {
    setTimeout(run, HIDDEN_MS);
    return;
  }
  // Whichever comes first: a window may be hidden while it waits for its frame.
  let isDone = false;
  const once = () => {
    if (isDone) return;
    isDone = true;
    clearTimeout(timer);
    cancelAnimationFrame(frame);
    run();
  };
  const timer = setTimeout(once, HIDDEN_MS);
  const frame = requestAnimationFrame(once);
}
