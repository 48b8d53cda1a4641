// The trails of all vehicles. They survive a reload, and stay out of reactive state: there may be 50,000 points.
import { lonLat } from '$lib/domain/lonlat';
import { Trail, TRAIL_POINTS } from '$lib/domain/track';
import { vehicles, type Vehicle } from './vehicles.svelte';

/** How often they are put away, milliseconds; and when the page is left. */
const SAVE_MS = 10_000;
const KEY = 'vencejo.trail.';
/** Points stored of the trail of a vehicle that is no longer followed. */
const LEFT_POINTS = 500;

class Trails {
  readonly #byVehicle = new Map<number, Trail>();
  readonly #listeners = new Set<() => void>();
  #stop: (() => void) | null = null;

  get all(): readonly Trail[] {
    return [...this.#byVehicle.values()];
  }

  /** The trail of a vehicle, once it has one. */
  of(systemId: number): Trail | undefined {
    return this.#byVehicle.get(systemId);
  }

  /** Calls `listener` when there is a trail more or less. */
  onChange(listener: () => void): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  /** Begins to record. Gives a function that ends it. */
  start(): () => void {
    if (this.#stop !== null) return this.#stop;
    const stopListening = vehicles.onFrame((vehicle) => this.#record(vehicle));
    const timer = setInterval(() => this.#save(), SAVE_MS);
    const save = (): void => this.#save();
    window.addEventListener('pagehide', save);
    this.#stop = () => {
      stopListening();
      clearInterval(timer);
      window.removeEventListener('pagehide', save);
      this.#stop = null;
    };
    return this.#stop;
  }

  /** Cuts the trail of a vehicle, as when its replay goes to another place. */
  cut(systemId: number): void {
    const trail = this.#byVehicle.get(systemId);
    if (trail === undefined) return;
    trail.clear();
    for (const listener of this.#listeners) listener();
  }

  clear(): void {
    for (const trail of this.#byVehicle.values()) trail.clear();
    this.#save();
    for (const listener of this.#listeners) listener();
  }

  #record(vehicle: Vehicle): void {
    const { position } = vehicle.groups;
    const at = lonLat(position?.lon_deg, position?.lat_deg);
    // 0/0 is what an autopilot says before it knows where it is
    if (!position || at === null || (at.lat_deg === 0 && at.lon_deg === 0)) return;
    let trail = this.#byVehicle.get(vehicle.systemId);
    if (trail === undefined) {
      this.#letGo();
      trail = new Trail(TRAIL_POINTS);
      // the trail of a recording is that of this replay alone
      if (!vehicle.isRecorded) restore(trail, vehicle.systemId);
      this.#byVehicle.set(vehicle.systemId, trail);
      for (const listener of this.#listeners) listener();
    }
    trail.add(at, position.alt_rel_home_m ?? 0);
  }

  /** Stores and drops the trails of vehicles that are no longer followed: in a large fleet, many may be looked at. */
  #letGo(): void {
    const left = [...this.#byVehicle.keys()].filter((id) => vehicles.get(id) === undefined);
    if (left.length === 0) return;
    for (const id of left) {
      store(this.#byVehicle.get(id) as Trail, id, LEFT_POINTS);
      this.#byVehicle.delete(id);
    }
    for (const listener of this.#listeners) listener();
  }

  #save(): void {
    this.#letGo();
    const share = Math.floor(TRAIL_POINTS / Math.max(1, this.#byVehicle.size));
    for (const [id, trail] of this.#byVehicle) store(trail, id, share);
  }
}

function store(trail: Trail, id: number, points: number): void {
  try {
    sessionStorage.setItem(KEY + id, trail.serialize(points));
  } catch {
    // full or switched off: the trail lives as long as the page
  }
}

function restore(trail: Trail, id: number): void {
  try {
    trail.restore(sessionStorage.getItem(KEY + id) ?? '');
  } catch {
    // switched off
  }
}

export const trails = new Trails();
