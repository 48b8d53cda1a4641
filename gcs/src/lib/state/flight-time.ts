// How long a plane has been flying, counted by the plane's own clock so that a reload or a lost link changes nothing.
import { load, save } from './stored';

export interface FlightTime {
  seconds: number;
  /** False when this app was opened in mid-flight: `seconds` is then a lower bound. */
  isExact: boolean;
}

/** Moments are seconds since the plane booted. */
interface Flight {
  start_s: number;
  isExact: boolean;
  end_s: number | null;
  /** When the plane booted, in Unix time; a stored flight counts only for the same boot. */
  booted_unix_s: number;
}

/** Two moments of one boot agree by this much: clocks drift, and messages take their time. */
const SAME_BOOT_S = 60;
/** The plane's clock may seem to go back by this much where two links have different delays. */
const BACK_S = 10;

const read = (value: unknown): Flight | null => {
  if (typeof value !== 'object' || value === null) return null;
  const { start_s, isExact, end_s, booted_unix_s } = value as Record<string, unknown>;
  if (typeof start_s !== 'number' || typeof isExact !== 'boolean' || typeof booted_unix_s !== 'number') return null;
  return { start_s, isExact, end_s: typeof end_s === 'number' ? end_s : null, booted_unix_s };
};

export class FlightClock {
  readonly #key: string;
  #flight: Flight | null;
  #wasFlying: boolean | null = null;
  #last_s: number | null = null;

  constructor(key: string) {
    this.#key = `flight.${key}`;
    this.#flight = load<Flight | null>(this.#key, null, read);
  }

  /** `boot_s` is the time since the plane booted; `isFlying` null when it is not known. */
  update(boot_s: number, isFlying: boolean | null, now_unix_s = Date.now() / 1000): FlightTime | null {
    const booted_unix_s = now_unix_s - boot_s;
    if (this.#flight !== null && this.#isOtherBoot(this.#flight, boot_s, booted_unix_s)) {
      this.#keep(null);
      this.#wasFlying = null;
    }
    this.#last_s = boot_s;
    if (isFlying === true && (this.#flight === null || this.#flight.end_s !== null)) {
      this.#keep({ start_s: boot_s, isExact: this.#wasFlying === false, end_s: null, booted_unix_s });
    } else if (isFlying === false && this.#flight !== null && this.#flight.end_s === null) {
      this.#keep({ ...this.#flight, end_s: boot_s });
    }
    if (isFlying !== null) this.#wasFlying = isFlying;
    const flight = this.#flight;
    if (flight === null) return null;
    return { seconds: (flight.end_s ?? boot_s) - flight.start_s, isExact: flight.isExact };
  }

  /** A stored flight is compared by the time of day; later updates by the plane's own clock, as simulations may run faster. */
  #isOtherBoot({ start_s, booted_unix_s }: Flight, boot_s: number, now_booted_unix_s: number): boolean {
    if (boot_s < start_s) return true;
    if (this.#last_s !== null) return boot_s < this.#last_s - BACK_S;
    return Math.abs(now_booted_unix_s - booted_unix_s) > SAME_BOOT_S;
  }

  #keep(flight: Flight | null): void {
    this.#flight = flight;
    save(this.#key, flight);
  }
}
