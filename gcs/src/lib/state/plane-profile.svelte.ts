// The airframe that plans are rehearsed with: as the vehicle's parameters tell it, or learned from a flight.
import type { Airframe, PlaneProfile, Problem } from '$lib/api/types';
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

class PlaneProfiles {
  #learned = $state.raw<Learned | null>(load('plane-profile', null, readLearned));
  isLearning = $state(false);
  /** Why nothing was learned. */
  problem = $state.raw<Problem | 'too-short' | null>(null);
  /** What was learned, where it is of the vehicle that is looked at. */
  learned = $derived.by(() => {
    const learned = this.#learned;
    const isOther = learned?.systemId != null && learned.systemId !== vehicles.selected?.systemId;
    return isOther ? null : learned;
  });
  choice = $derived<ProfileChoice>(
    this.learned === null ? 'parameters' : this.learned.systemId === null ? 'recording' : 'flight',
  );
  /** As a rehearsal takes it. */
  asked = $derived<PlaneProfile>(this.learned === null ? {} : { airframe: this.learned.airframe });

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

/** As it was stored; the server refuses an airframe that is none. */
function readLearned(stored: unknown): Learned | null {
  if (typeof stored !== 'object' || stored === null) return null;
  const { airframe, systemId, moments } = stored as Record<string, unknown>;
  const isSystem = systemId === null || typeof systemId === 'number';
  if (typeof airframe !== 'object' || airframe === null || !isSystem || typeof moments !== 'number') return null;
  return { airframe: airframe as Airframe, systemId, moments };
}

export const planeProfile = new PlaneProfiles();
