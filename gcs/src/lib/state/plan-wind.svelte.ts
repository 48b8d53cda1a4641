// The wind that a plan is drawn for: what the pilot set, else what the vehicle estimates, else none.
import { MOST_WIND_M_S, type Wind } from '$lib/domain/wind';
import { load, save } from './stored';
import { vehicles } from './vehicles.svelte';

const CALM: Wind = { from_deg: 0, speed_m_s: 0 };

class PlanWindStore {
  #chosen = $state.raw<Wind | null>(load('plan-wind', null, readWind));
  // in steps, as plain numbers: an estimate wanders all the time, and what is drawn from it need not
  #from_deg = $derived(inSteps(vehicles.selected?.groups.wind?.from_deg, 5));
  #speed_m_s = $derived(inSteps(vehicles.selected?.groups.wind?.speed_m_s, 0.5));

  /** The vehicle's own estimate; `null` while it has none. */
  estimated = $derived.by<Wind | null>(() => {
    const [from_deg, speed_m_s] = [this.#from_deg, this.#speed_m_s];
    if (from_deg === null || speed_m_s === null) return null;
    return { from_deg: from_deg % 360, speed_m_s: Math.min(speed_m_s, MOST_WIND_M_S) };
  });
  /** `null` when nobody has set one and the vehicle has none. */
  known = $derived(this.#chosen ?? this.estimated);
  wind = $derived(this.known ?? CALM);
  isChosen = $derived(this.#chosen !== null);

  set({ from_deg, speed_m_s }: Wind): void {
    const kept = Math.min(Math.max(speed_m_s, 0), MOST_WIND_M_S);
    this.#take({ from_deg: ((from_deg % 360) + 360) % 360, speed_m_s: kept });
  }

  /** Back to the vehicle's own. */
  unset(): void {
    this.#take(null);
  }

  #take(wind: Wind | null): void {
    this.#chosen = wind;
    save('plan-wind', wind);
  }
}

function inSteps(value: number | null | undefined, step: number): number | null {
  return value == null || !Number.isFinite(value) ? null : Math.round(value / step) * step;
}

function readWind(value: unknown): Wind | null {
  if (typeof value !== 'object' || value === null) return null;
  const { from_deg, speed_m_s } = value as Record<string, unknown>;
  if (typeof from_deg !== 'number' || typeof speed_m_s !== 'number') return null;
  return from_deg >= 0 && from_deg < 360 && speed_m_s >= 0 && speed_m_s <= MOST_WIND_M_S
    ? { from_deg, speed_m_s }
    : null;
}

export const planWind = new PlanWindStore();
