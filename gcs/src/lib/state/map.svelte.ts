// The state of the map view: visible layers, following, and the pointer's tool.
import type { LonLat } from '$lib/domain/lonlat';
import { load, save } from './stored';

export type FollowMode = 'free' | 'follow' | 'sight';
type MapTool = 'none' | 'ruler';

interface Look {
  follow: FollowMode;
  hasGrid: boolean;
  hasTrails: boolean;
}

const defaults: Look = {
  follow: 'sight',
  hasGrid: true,
  hasTrails: true,
};

function read(value: unknown): Look | null {
  if (typeof value !== 'object' || value === null) return null;
  const stored = value as Partial<Record<keyof Look, unknown>>;
  const flag = (one: unknown, fallback: boolean): boolean => (typeof one === 'boolean' ? one : fallback);
  return {
    follow: (['free', 'follow', 'sight'] as const).find((mode) => mode === stored.follow) ?? defaults.follow,
    hasGrid: flag(stored.hasGrid, defaults.hasGrid),
    hasTrails: flag(stored.hasTrails, defaults.hasTrails),
  };
}

class MapLook {
  #look = $state<Look>(load('map', defaults, read));
  tool = $state<MapTool>('none');
  /** Whether a place to look at is being typed. */
  isGoingTo = $state(false);
  ruler = $state.raw<readonly LonLat[]>([]);
  /** Where the pointer is. */
  pointer = $state.raw<LonLat | null>(null);
  /** The place that the plane was last sent to from the map. */
  target = $state.raw<LonLat | null>(null);
  /** Top of the colour scale of trails, metres above home. */
  trailRange_m = $state(0);

  get follow(): FollowMode {
    return this.#look.follow;
  }
  set follow(follow: FollowMode) {
    this.#set({ follow });
  }
  get hasGrid(): boolean {
    return this.#look.hasGrid;
  }
  set hasGrid(hasGrid: boolean) {
    this.#set({ hasGrid });
  }
  get hasTrails(): boolean {
    return this.#look.hasTrails;
  }
  set hasTrails(hasTrails: boolean) {
    this.#set({ hasTrails });
  }

  setTool(tool: MapTool): void {
    this.tool = tool;
    this.ruler = [];
  }

  #set(change: Partial<Look>): void {
    Object.assign(this.#look, change);
    save('map', $state.snapshot(this.#look));
  }
}

export const mapLook = new MapLook();
