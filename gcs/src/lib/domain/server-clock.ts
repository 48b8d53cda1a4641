// The server's time of day, advanced by the page's monotonic clock between messages.

/** Recent time messages; the one with the shortest delay is used. */
const SAMPLES = 16;

export class ServerClock {
  readonly #offsets_ms: number[] = [];

  /** The server said that it was `unix_ms`; heard at `now_ms` on the monotonic clock. */
  hear(unix_ms: number, now_ms: number): void {
    if (!Number.isFinite(unix_ms)) return;
    this.#offsets_ms.push(unix_ms - now_ms);
    if (this.#offsets_ms.length > SAMPLES) this.#offsets_ms.shift();
  }

  /** Age, in seconds, of what was made at `unix_ms` by the server's clock; null before the server said the time. */
  age_s(unix_ms: number, now_ms: number): number | null {
    if (this.#offsets_ms.length === 0) return null;
    // A message that was long on its way makes the server's time look earlier than it is.
    const offset_ms = Math.max(...this.#offsets_ms);
    return Math.max(0, (now_ms + offset_ms - unix_ms) / 1000);
  }
}
