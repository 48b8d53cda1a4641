// How long a plane has been flying, counted by the plane's own clock so that a reload or a lost link changes nothing.
import { load, save } from './stored';

export interface FlightTime {
  seconds: number;
  /** False when this app was opened in mid-flight: it has flown at least so long. */
  isExact: boolean;
}

interface Flight {
  start_s: number;
  isExact: boolean;
  end_s: number | null;
}

const read = (value: unknown): Flight | null => {
  if (typeof value !== 'object' || value === null) return null;
  const { start_s, isExact, end_s } = value as Record<string, unknown>;
  if (typeof start_s !== 'number' || typeof isExact !== 'boolean') return null;
  return { start_s, isExact, end_s: typeof end_s === 'number' ? end_s : null };
};

export class FlightClock {
  readonly #key: string;
  #flight: Flight | null;
  #wasFlying: boolean | null = null;

  constructor(key: string) {
    this.#key = `flight.${key}`;
    this.#flight = load<Flight | null>(this.#key, null, read);
  }

  /** `boot_s` is the time since the plane booted; `isFlying` null when it is not known. */
  update(boot_s: number, isFlying: boolean | null): FlightTime | null {
    // A clock that went back: the plane booted anew.
    if (this.#flight !== null && boot_s < (this.#flight.end_s ?? this.#flight.start_s)) this.#keep(null);
    if (isFlying === true && (this.#flight === null || this.#flight.end_s !== null)) {
      this.#keep({ start_s: boot_s, isExact: this.#wasFlying === false, end_s: null });
    } else if (isFlying === false && this.#flight !== null && this.#flight.end_s === null) {
      this.#keep({ ...this.#flight, end_s: boot_s });
    }
    if (isFlying !== null) this.#wasFlying = isFlying;
    const flight = this.#flight;
    if (flight === null) return null;
    return { seconds: (flight.end_s ?? boot_s) - flight.start_s, isExact: flight.isExact };
  }

  #keep(flight: Flight | null): void {
    this.#flight = flight;
    save(this.#key, flight);
  }
}
