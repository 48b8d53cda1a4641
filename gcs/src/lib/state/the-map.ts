// What the map does for the rest of the app, while there is one.
import type { LonLat } from '$lib/domain/lonlat';
import type { Box } from '$lib/domain/tiling';

export interface MapActs {
  /** The position at the middle of the map; `null` without a map. */
  readonly centre: () => LonLat | null;
  /** The area that panels leave visible; `null` without a map. */
  readonly visibleBox: () => Box | null;
  /** Moves the map so that a position is in its middle. */
  readonly show: (at: LonLat) => void;
  /** Looks at a place that may be far away. */
  readonly goTo: (at: LonLat) => void;
  /** Brings positions into sight. */
  readonly fit: (positions: readonly LonLat[]) => void;
  /** Asks for the tiles of a source again. */
  readonly retryTiles: (source: string) => void;
}

const NO_MAP: MapActs = {
  centre: () => null,
  visibleBox: () => null,
  show: () => undefined,
  goTo: () => undefined,
  fit: () => undefined,
  retryTiles: () => undefined,
};

class TheMap implements MapActs {
  #acts = NO_MAP;

  /** Registers the current map; call the returned function before that map is destroyed. */
  attach(acts: MapActs): () => void {
    this.#acts = acts;
    return () => {
      // a newer map may have taken its place
      if (this.#acts === acts) this.#acts = NO_MAP;
    };
  }

  centre = (): LonLat | null => this.#acts.centre();
  visibleBox = (): Box | null => this.#acts.visibleBox();
  show = (at: LonLat): void => this.#acts.show(at);
  goTo = (at: LonLat): void => this.#acts.goTo(at);
  fit = (positions: readonly LonLat[]): void => this.#acts.fit(positions);
  retryTiles = (source: string): void => this.#acts.retryTiles(source);
}

export const theMap = new TheMap();
