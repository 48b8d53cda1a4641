// The monotonic clock of the app: ages are counted with it, never with the time of day.

/** How often ages on the screen move on. */
const TICK_MS = 250;

class Clock {
  #now_ms = $state(performance.now());
  #timer: ReturnType<typeof setInterval> | null = null;

  /** Monotonic time, in milliseconds; reactive, moves on four times a second. */
  get now_ms(): number {
    return this.#now_ms;
  }

  /** Age in seconds of what came at `at_ms`; null when it never came. Reactive. */
  age_s(at_ms: number | null | undefined): number | null {
    return at_ms == null ? null : Math.max(0, (this.#now_ms - at_ms) / 1000);
  }

  start(): void {
    this.#timer ??= setInterval(() => this.tick(), TICK_MS);
  }

  stop(): void {
    if (this.#timer !== null) clearInterval(this.#timer);
    this.#timer = null;
  }

  /** Reads the time now: called by the timer, and when something new came. */
  tick(now_ms = performance.now()): void {
    this.#now_ms = now_ms;
  }
}

export const clock = new Clock();
