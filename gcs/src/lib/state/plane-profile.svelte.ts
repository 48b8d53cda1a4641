// The plane that plans are rehearsed with: its airframe as the vehicle's parameters tell it, or learned from a flight, and what is
// said of its battery.
import type { Airframe, BatterySettings, PlaneProfile, Problem } from '$lib/api/types';
import { load, save } from './stored';
import { api, problemFrom } from './station.svelte';
import { vehicles } from './vehicles.svelte';

/** From the flight of the vehicle as it is followed, or from a recording. */
export type ProfileChoice = 'parameters' | 'flight' | 'recording';

interface Learned {
  readonly airframe: Airframe;
  /** Of the vehicle that it was learned of; `null`: of a recording. */
  readonly systemId: number | null;
  readonly moments: number;
}

/** Battery data entered by the user; what is `null` or absent is as the plane reports it. The charge at the start is measured, not entered. */
export type SaidOfBattery = Partial<Omit<BatterySettings, 'charge_pct'>>;
const NOTHING_SAID: BatterySettings = {
  capacity_mah: null,
  voltage_v: null,
  charge_pct: null,
  reserve_pct: null,
  power_cruise_w: null,
};
const SAID = ['capacity_mah', 'voltage_v', 'power_cruise_w', 'reserve_pct'] as const;
/** Key of the battery when no vehicle is selected. */
const NO_VEHICLE = 'none';

class PlaneProfiles {
  #learned = $state.raw<Learned | null>(load('plane-profile', null, readLearned));
  isLearning = $state(false);
  /** Why nothing was learned. */
  problem = $state.raw<Problem | 'too-short' | null>(null);
  /** The learned profile, if it applies to the selected vehicle. */
  learned = $derived.by(() => {
    const learned = this.#learned;
    const isOther = learned?.systemId != null && learned.systemId !== vehicles.selected?.systemId;
    return isOther ? null : learned;
  });
  choice = $derived<ProfileChoice>(
    this.learned === null ? 'parameters' : this.learned.systemId === null ? 'recording' : 'flight',
  );
  #batteries = $state.raw<Readonly<Record<string, SaidOfBattery>>>(load('batteries', {}, readBatteries));
  #own = $state.raw<{ systemId: number; battery: SaidOfBattery } | null>(null);
  #whose = $derived(String(vehicles.selected?.systemId ?? NO_VEHICLE));
  /** Battery data entered for the selected vehicle. */
  battery = $derived<SaidOfBattery>(this.#batteries[this.#whose] ?? {});
  /** That vehicle's own parameters, as last read. */
  ownBattery = $derived<SaidOfBattery>(
    this.#own?.systemId === vehicles.selected?.systemId ? (this.#own?.battery ?? {}) : {},
  );
  /** As a rehearsal takes it. */
  asked = $derived<PlaneProfile>({
    ...(this.learned === null ? {} : { airframe: this.learned.airframe }),
    ...(SAID.some((key) => this.battery[key] != null) ? { battery: { ...NOTHING_SAID, ...this.battery } } : {}),
  });

  sayOfBattery(battery: SaidOfBattery): void {
    this.#batteries = { ...this.#batteries, [this.#whose]: battery };
    save('batteries', this.#batteries);
  }

  /** Reads the vehicle's battery parameters; on failure nothing is known. */
  async readOwnBattery(): Promise<void> {
    const systemId = vehicles.selected?.systemId;
    if (systemId === undefined) return;
    try {
      const { capacity_mah, voltage_v, reserve_pct, airframe } = await api.vehicleProfile(systemId);
      const { power_cruise_w } = airframe;
      this.#own = { systemId, battery: { capacity_mah, voltage_v, reserve_pct, power_cruise_w } };
    } catch {
      this.#own = null;
    }
  }

  useParameters(): void {
    this.problem = null;
    this.#keep(null);
  }

  /** Learns from the flight of the vehicle, as far as it was followed; whether it taught anything. */
  async learnFromFlight(): Promise<boolean> {
    const systemId = vehicles.selected?.systemId;
    if (systemId === undefined) return false;
    return this.#learn(async () => {
      const { learned } = await api.vehicleProfile(systemId);
      return learned === null ? null : { airframe: learned.airframe, moments: learned.moments, systemId };
    });
  }

  /** Learns from a recording. */
  async learnFromRecording(file: Blob): Promise<boolean> {
    return this.#learn(async () => {
      const { airframe, moments } = await api.learnPlane(file, vehicles.selected?.systemId);
      return { airframe, moments, systemId: null };
    });
  }

  async #learn(ask: () => Promise<Learned | null>): Promise<boolean> {
    if (this.isLearning) return false;
    this.isLearning = true;
    this.problem = null;
    try {
      const learned = await ask();
      if (learned === null) this.problem = 'too-short';
      else this.#keep(learned);
      return learned !== null;
    } catch (error) {
      this.problem = problemFrom(error);
      return false;
    } finally {
      this.isLearning = false;
    }
  }

  #keep(learned: Learned | null): void {
    this.#learned = learned;
    save('plane-profile', learned);
  }
}

/** As it was stored; the server refuses an invalid airframe. */
function readLearned(stored: unknown): Learned | null {
  if (typeof stored !== 'object' || stored === null) return null;
  const { airframe, systemId, moments } = stored as Record<string, unknown>;
  const isSystem = systemId === null || typeof systemId === 'number';
  if (typeof airframe !== 'object' || airframe === null || !isSystem || typeof moments !== 'number') return null;
  return { airframe: airframe as Airframe, systemId, moments };
}

/** As they were stored, numbers only; the server refuses values out of range. */
function readBatteries(stored: unknown): Record<string, SaidOfBattery> | null {
  if (typeof stored !== 'object' || stored === null) return null;
  const read = Object.entries(stored).map(([whose, battery]) => {
    const said = (typeof battery === 'object' && battery !== null ? battery : {}) as Record<string, unknown>;
    return [
      whose,
      Object.fromEntries(SAID.flatMap((key) => (typeof said[key] === 'number' ? [[key, said[key]]] : []))),
    ];
  });
  return Object.fromEntries(read) as Record<string, SaidOfBattery>;
}

export const planeProfile = new PlaneProfiles();
