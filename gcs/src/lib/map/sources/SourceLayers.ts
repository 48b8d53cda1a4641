// The layers of the map's sources: every source comes as tiles of a grid, from our own server, and is warped where its
// projection differs from the map's. After a failure one tile is tried with growing delays, and once it comes all that failed are asked
// for again; shown ones stay meanwhile.
import type ImageTile from 'ol/ImageTile';
import type OlMap from 'ol/Map';
import type Tile from 'ol/Tile';
import TileState from 'ol/TileState';
import TileLayer from 'ol/layer/Tile';
import type Projection from 'ol/proj/Projection';
import type TileImage from 'ol/source/TileImage';
import TileGrid from 'ol/tilegrid/TileGrid';
import type { TileLoader } from '$lib/api/maps-tiles';
import type { Problem } from '$lib/api/types';
import { GridTiles } from './GridTiles';
import { projectionFor } from './projections';

interface GridLevel {
  readonly resolution: number;
  /** x and y of the top left corner. */
  readonly origin: readonly number[];
  /** Width and height. */
  readonly tile_px: readonly number[];
  /** Columns and rows. */
  readonly size?: readonly number[] | null;
}

export interface Grid {
  readonly crs: string;
  /** West, south, east and north in the system's own units. */
  readonly extent?: readonly number[] | null;
  readonly levels: readonly GridLevel[];
  readonly min_level: number;
  readonly max_level: number;
}

/** A source as it is to be shown. */
export interface ShownSource {
  readonly id: string;
  /** With {z}, {x} and {y}; changes whenever the source's tiles may have changed. */
  readonly tilesUrl: string;
  readonly grid: Grid;
  readonly opacity: number;
  /** Zoom of the map from which it is shown; `null`: always. */
  readonly minZoom: number | null;
}

export interface SourceEvents {
  /** A tile did not come. */
  failed?(id: string, problem: Problem): void;
  /** A tile came as an old copy, since the source failed. */
  stale?(id: string): void;
  /** After a failure everything came. */
  recovered?(id: string): void;
}

/** Waiting times before a failed tile is tried again, seconds; the last goes on. */
const RETRY_S = [5, 10, 20, 40, 60] as const;
/** A source is hidden when the map is coarser than its coarsest level by this factor: it would take thousands of tiles. */
const COARSEST_FACTOR = 8;
/**
 * Coarser levels that are fetched with the one that is looked at. They reach far over the window's edges: where the map is dragged
 * to, there is something already, until the fine tiles come. All of them together are a third of the fine ones.
 */
const COARSER_LEVELS = 4;
/** Pixels of pictures that a layer keeps for when they are looked at again: 384 tiles of 256 px, about 100 MB unpacked. */
const KEPT_PX = 384 * 256 * 256;
/** A window of common size with the levels beside its own is filled by fewer. */
const LEAST_KEPT = 64;

interface Entry {
  readonly key: string;
  /** Aborts the requests in flight when the layer is removed. */
  readonly abort: AbortController;
  layer: TileLayer<TileImage> | null;
  hasFailed: boolean;
  /** Addresses that failed since the last full reload. */
  readonly failed: Set<string>;
  waiting: number;
  attempts: number;
  /** Count of full reloads. */
  rounds: number;
  timer: ReturnType<typeof setTimeout> | undefined;
}

export class SourceLayers {
  readonly #map: OlMap;
  readonly #load: TileLoader;
  readonly #events: SourceEvents;
  readonly #entries = new Map<string, Entry>();
  readonly #zIndex: number;
  #stack: readonly ShownSource[] = [];

  constructor(map: OlMap, load: TileLoader, events: SourceEvents, zIndex: number) {
    this.#map = map;
    this.#load = load;
    this.#events = events;
    this.#zIndex = zIndex;
  }

  /** Shows these, bottom to top. With `isFine`, a dense screen gets tiles of the next finer level. */
  set(stack: readonly ShownSource[], isFine: boolean): void {
    this.#stack = stack;
    const wanted = new Map(stack.map((source) => [source.id, keyOf(source, isFine)]));
    for (const [id, entry] of this.#entries) if (wanted.get(id) !== entry.key) this.#remove(id, entry);
    for (const source of stack) {
      if (!this.#entries.has(source.id)) void this.#add(source, keyOf(source, isFine), isFine);
    }
    this.#arrange();
  }

  /** Asks again for what failed, now. */
  retry(id: string): void {
    const entry = this.#entries.get(id);
    if (entry === undefined) return;
    entry.attempts = 0;
    this.#askAgain(id, entry);
  }

  destroy(): void {
    for (const [id, entry] of this.#entries) this.#remove(id, entry);
  }

  /** Opacity, order and zooms of existing layers. */
  #arrange(): void {
    this.#stack.forEach((source, index) => {
      const layer = this.#entries.get(source.id)?.layer;
      if (!layer) return;
      layer.setZIndex(this.#zIndex + index / (this.#stack.length + 1));
      layer.setOpacity(source.opacity);
      // a layer is hidden at its least zoom itself
      layer.setMinZoom(source.minZoom === null ? Number.NEGATIVE_INFINITY : source.minZoom - 1e-6);
    });
  }

  async #add(source: ShownSource, key: string, isFine: boolean): Promise<void> {
    const entry: Entry = {
      key,
      abort: new AbortController(),
      layer: null,
      hasFailed: false,
      failed: new Set(),
      waiting: 0,
      attempts: 0,
      rounds: 0,
      timer: undefined,
    };
    this.#entries.set(source.id, entry);
    let problem: Problem | null = null;
    try {
      const projection = await projectionFor(source.grid.crs);
      if (this.#entries.get(source.id) !== entry) return;
      if (projection !== null) entry.layer = this.#layer(source, projection, entry, isFine);
      else problem = ownFault('map-crs', source.grid.crs);
    } catch (error) {
      // a grid that cannot be, or the part of the app that warps did not come
      problem = ownFault('map-source', String(error));
    }
    if (problem !== null) this.#events.failed?.(source.id, problem);
    if (entry.layer === null) return;
    this.#arrange();
    this.#map.addLayer(entry.layer);
  }

  #layer(source: ShownSource, projection: Projection, entry: Entry, isFine: boolean): TileLayer<TileImage> {
    const { grid, tilesUrl } = source;
    const levels = grid.levels.slice(0, grid.max_level + 1);
    const coarsest = levels[grid.min_level] ?? levels[0];
    if (coarsest === undefined) throw new Error('a grid without levels');
    const density = isFine ? 2 : 1;
    const sizes = levels.map((level) => level.size);
    const tileGrid = new TileGrid({
      resolutions: levels.map((level) => level.resolution * density),
      origins: levels.map((level) => [...level.origin]),
      tileSizes: levels.map(({ tile_px: [width = 256, height = 256] }) => [width / density, height / density]),
      minZoom: grid.min_level,
      ...(grid.extent && { extent: [...grid.extent] }),
      ...(sizes.every((size) => size != null) && { sizes: sizes.map((size) => [...(size ?? [])]) }),
    });
    // The newer ol/source/ImageTile warps with WebGL, which many a tablet has not; this one warps on a plain canvas.
    const tiles = new GridTiles({
      projection,
      tileGrid,
      tilePixelRatio: density,
      wrapX: true,
      transition: 0,
      tileUrlFunction: ([z = 0, x = 0, y = 0]) => fill(tilesUrl, z, x, y),
      tileLoadFunction: (tile, address) => void this.#fetch(source.id, entry, tile as ImageTile, address),
    });
    const [width = 256, height = 256] = coarsest.tile_px;
    return new TileLayer({
      source: tiles,
      preload: COARSER_LEVELS,
      cacheSize: Math.max(LEAST_KEPT, Math.round(KEPT_PX / (width * height))),
      maxResolution: coarsest.resolution * (projection.getMetersPerUnit() ?? 1) * COARSEST_FACTOR,
    });
  }

  async #fetch(id: string, entry: Entry, tile: ImageTile, address: string): Promise<void> {
    entry.waiting += 1;
    const answer = await this.#load(id, address, entry.abort.signal);
    entry.waiting -= 1;
    if (answer.kind === 'ended') return;
    if (answer.kind === 'none') end(tile, TileState.EMPTY);
    else if (answer.kind === 'failed') {
      end(tile, TileState.ERROR);
      this.#failed(id, entry, address, answer.problem);
    } else {
      if (answer.isStale) this.#events.stale?.(id);
      const picture = await decode(answer.picture);
      if (picture !== null) tile.setImage(picture);
      else {
        end(tile, TileState.ERROR);
        this.#failed(id, entry, address, ownFault('map-picture', `${answer.picture.type}, ${answer.picture.size} B`));
      }
    }
    if (entry.waiting === 0 && entry.failed.size === 0 && entry.hasFailed && this.#entries.get(id) === entry) {
      entry.hasFailed = false;
      entry.attempts = 0;
      this.#events.recovered?.(id);
    }
  }

  #failed(id: string, entry: Entry, address: string, problem: Problem): void {
    if (this.#entries.get(id) !== entry) return;
    entry.hasFailed = true;
    entry.failed.add(address);
    this.#events.failed?.(id, problem);
    this.#tryLater(id, entry);
  }

  #tryLater(id: string, entry: Entry): void {
    if (entry.timer !== undefined || this.#entries.get(id) !== entry) return;
    const wait_s = RETRY_S[Math.min(entry.attempts, RETRY_S.length - 1)] as number;
    entry.timer = setTimeout(() => {
      entry.timer = undefined;
      // not visible: fetched when it is shown again
      if (document.hidden) this.#tryLater(id, entry);
      else void this.#try(id, entry);
    }, wait_s * 1000);
  }

  /** One tile tells whether the source is there again; another one each time, for one alone may be missing for good. */
  async #try(id: string, entry: Entry): Promise<void> {
    const addresses = [...entry.failed];
    const address = addresses[entry.attempts % addresses.length];
    const answer = address === undefined ? null : await this.#load(id, address, entry.abort.signal);
    // it was asked for meanwhile, or removed
    if (answer?.kind === 'ended' || entry.timer !== undefined || this.#entries.get(id) !== entry) return;
    if (answer?.kind === 'failed') {
      entry.attempts += 1;
      this.#events.failed?.(id, answer.problem);
      this.#tryLater(id, entry);
    } else this.#askAgain(id, entry);
  }

  #askAgain(id: string, entry: Entry): void {
    clearTimeout(entry.timer);
    entry.timer = undefined;
    entry.attempts += 1;
    entry.rounds += 1;
    entry.failed.clear();
    const source = entry.layer?.getSource();
    const shown = this.#stack.find((one) => one.id === id);
    if (!source || !shown) return;
    // with a new key all tiles are fetched again; the old ones are shown until then
    source.setTileUrlFunction(([z = 0, x = 0, y = 0]) => fill(shown.tilesUrl, z, x, y), `${entry.rounds}`);
  }

  #remove(id: string, entry: Entry): void {
    clearTimeout(entry.timer);
    entry.abort.abort();
    this.#entries.delete(id);
    if (entry.layer === null) return;
    const { layer } = entry;
    this.#map.removeLayer(layer);
    // A frame in which it was drawn looks for its coarser tiles in a timer of its own, which must find it whole.
    setTimeout(() => {
      layer.getSource()?.dispose();
      layer.dispose();
    }, 0);
  }
}

/** What the map itself cannot do with what came. */
const ownFault = (kind: 'map-crs' | 'map-source' | 'map-picture', detail: string): Problem => ({
  type: `urn:vencejo:${kind}`,
  title: kind,
  status: 0,
  detail,
});

const keyOf = ({ tilesUrl, grid }: ShownSource, isFine: boolean): string => JSON.stringify([tilesUrl, grid, isFine]);

const fill = (template: string, z: number, x: number, y: number): string =>
  template.replace('{z}', String(z)).replace('{x}', String(x)).replace('{y}', String(y));

/** Ends a tile that has no picture, unless the map gave it up meanwhile. */
function end(tile: Tile, state: typeof TileState.EMPTY | typeof TileState.ERROR): void {
  if (tile.getState() === TileState.LOADING) tile.setState(state);
}

/** The decoded picture, ready to be painted without a pause; `null` for invalid data. */
async function decode(picture: Blob): Promise<HTMLImageElement | null> {
  const address = URL.createObjectURL(picture);
  const image = new Image();
  image.src = address;
  try {
    await image.decode();
    return image;
  } catch {
    return null;
  } finally {
    URL.revokeObjectURL(address);
  }
}
