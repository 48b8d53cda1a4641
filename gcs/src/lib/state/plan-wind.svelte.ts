// The wind: what a vehicle estimates, which its flight is in; and what a plan is drawn for, which a pilot may set instead.
import { MOST_WIND_M_S, type Wind } from '$lib/domain/wind';
import { load, save } from './stored';
import { type Vehicle, vehicles } from './vehicles.svelte';

export const CALM: Wind = { from_deg: 0, speed_m_s: 0 };

/** A wind that a pilot has set. */
interface Chosen extends Wind {
  readonly set_unix_ms: number;
}

/** A vehicle's own estimate, in steps, since it wanders all the time; `null` while it has none. */
export function estimateOf(vehicle: Vehicle | null): Wind | null {
  const { wind } = vehicle?.groups ?? {};
  const [from_deg, speed_m_s] = [inSteps(wind?.from_deg, 5), inSteps(wind?.speed_m_s, 0.5)];
  if (from_deg === null || speed_m_s === null) return null;
  return { from_deg: from_deg % 360, speed_m_s: Math.min(speed_m_s, MOST_WIND_M_S) };
}

class PlanWindStore {
  #chosen = $state.raw<Chosen | null>(load('plan-wind', null, readChosen));
  // as plain numbers, so that what is drawn from an estimate that stays the same is not drawn again
  #from_deg = $derived(estimateOf(vehicles.selected)?.from_deg ?? null);
  #speed_m_s = $derived(estimateOf(vehicles.selected)?.speed_m_s ?? null);

  /** The estimate of the selected vehicle. */
  estimated = $derived.by<Wind | null>(() => {
    const [from_deg, speed_m_s] = [this.#from_deg, this.#speed_m_s];
    return from_deg === null || speed_m_s === null ? null : { from_deg, speed_m_s };
  });
  /** `null` when none was set and the vehicle has no estimate. */
  known = $derived.by<Wind | null>(() => {
    if (this.#chosen === null) return this.estimated;
    const { from_deg, speed_m_s } = this.#chosen;
    return { from_deg, speed_m_s };
  });
  wind = $derived(this.known ?? CALM);
  isChosen = $derived(this.#chosen !== null);
  /** When it was set. It is kept across days, so its age is shown. */
  setAt = $derived(this.#chosen === null ? null : new Date(this.#chosen.set_unix_ms));

  set({ from_deg, speed_m_s }: Wind): void {
    const kept = Math.min(Math.max(speed_m_s, 0), MOST_WIND_M_S);
    this.#take({ from_deg: ((from_deg % 360) + 360) % 360, speed_m_s: kept, set_unix_ms: Date.now() });
  }

  /** Back to the vehicle's own. */
  unset(): void {
    this.#take(null);
  }

  #take(wind: Chosen | null): void {
    this.#chosen = wind;
    save('plan-wind', wind);
  }
}

function inSteps(value: number | null | undefined, step: number): number | null {
  return value == null || !Number.isFinite(value) ? null : Math.round(value / step) * step;
}

function readChosen(value: unknown): Chosen | null {
  if (typeof value !== 'object' || value === null) return null;
  const { from_deg, speed_m_s, set_unix_ms } = value as Record<string, unknown>;
  if (typeof from_deg !== 'number' || typeof speed_m_s !== 'number' || typeof set_unix_ms !== 'number') return null;
  return from_deg >= 0 && from_deg < 360 && speed_m_s >= 0 && speed_m_s <= MOST_WIND_M_S
    ? { from_deg, speed_m_s, set_unix_ms }
    : null;
}

export const planWind = new PlanWindStore();
