// The map's sources: the server's list, the user's choices, and failures.
import { SvelteMap } from 'svelte/reactivity';
import { MapsApi } from '$lib/api/maps';
import type { Attribution, MapKind, MapSource, SourceSettings } from '$lib/api/maps-types';
import { problemFrom } from '$lib/api/problem';
import type { Problem } from '$lib/api/types';
import {
  attributionsOf,
  baseOf,
  chosenBaseOf,
  type Choice,
  isShown,
  moved,
  NO_CHOICE,
  opacityOf,
  readChoice,
  stackOf,
} from '$lib/domain/sources';
import type { Box } from '$lib/domain/tiling';
import { station } from './station.svelte';
import { load, save } from './stored';
import { theMap } from './the-map';

export const mapsApi = new MapsApi();

/** The list is not asked for more often than this, however much fails. */
const RELOAD_MS = 3000;

/** A shown source that fails. */
export interface Failing {
  readonly source: MapSource;
  readonly problem: Problem;
  /** Old pictures are shown in place of new ones. */
  readonly isStale: boolean;
}

class Maps {
  sources = $state.raw<readonly MapSource[]>([]);
  /** The kinds of sources that the server knows; they stay the same. */
  kinds = $state.raw<readonly MapKind[]>([]);
  /** Whether sources of a kind have a setting. */
  takes = (kind: MapKind['kind'], field: keyof SourceSettings): boolean =>
    this.kinds.some((one) => one.kind === kind && one.fields.includes(field));
  /** The server's folder of them, for editing by hand; empty when it is not reported. */
  file = $state('');
  fileError = $state<string | null>(null);
  isLoaded = $state(false);
  /** The line of attributions lies along the map's lower edge; everything else stays above it. Pixels. */
  attributionHeight_px = $state(0);
  /** Which part of the panel is looked at. */
  tab = $state<'layers' | 'offline' | 'terrain'>('layers');
  /** Why the list is not known. */
  problem = $state.raw<Problem | null>(null);
  /** The last visible part of the world; `null` before the map reports it. */
  #view = $state.raw<Box | null>(null);

  #choice = $state.raw<Choice>(load('maps', NO_CHOICE, readChoice));
  #isFine = $state(load('maps-fine', false, (value) => (typeof value === 'boolean' ? value : null)));
  readonly #faults = new SvelteMap<string, Problem>();
  readonly #dismissed = new SvelteMap<string, string>();
  readonly #ofView = new SvelteMap<string, readonly Attribution[]>();
  #loadedAt_ms = -Infinity;
  #timer: ReturnType<typeof setTimeout> | undefined;

  base = $derived(baseOf(this.sources, this.#choice, this.#view));
  /** The base map that a person chose; `null` for none, and for the one that fits the view. */
  chosenBase = $derived(chosenBaseOf(this.sources, this.#choice));
  isBaseByView = $derived(this.#choice.base !== '' && this.chosenBase === null);
  bases = $derived(this.sources.filter((source) => source.role === 'base'));
  /** Uppermost first, as people read a list of layers. */
  overlays = $derived(this.sources.filter((source) => source.role === 'overlay').toReversed());
  elevations = $derived(this.sources.filter((source) => source.role === 'elevation'));
  #stack = $derived(stackOf(this.sources, this.#choice, this.base));
  /** What the map draws, bottom to top. */
  shown = $derived(
    this.#stack.flatMap(({ source, opacity }) =>
      source.grid == null
        ? []
        : [
            {
              id: source.id,
              tilesUrl: source.tiles_url,
              grid: source.grid,
              opacity,
              minZoom: source.min_zoom ?? null,
            },
          ],
    ),
  );
  attributions = $derived(
    attributionsOf(
      this.#stack.map(({ source }) => ({ attribution: this.#ofView.get(source.id) ?? source.attribution })),
    ),
  );
  /** Google's terms want its name on the map. */
  hasGoogle = $derived(this.#stack.some(({ source }) => source.logo === 'google'));
  failing = $derived(this.#stack.flatMap(({ source }) => this.#failingOf(source) ?? []));
  /** Those that were not dismissed. */
  notices = $derived(this.failing.filter(({ source, problem }) => this.#dismissed.get(source.id) !== problem.detail));

  get isFine(): boolean {
    return this.#isFine;
  }
  set isFine(isFine: boolean) {
    this.#isFine = isFine;
    save('maps-fine', isFine);
  }

  isShown = (source: MapSource): boolean =>
    source.role === 'base' ? this.base?.id === source.id : isShown(source, this.#choice);
  opacityOf = (source: MapSource): number => opacityOf(source, this.#choice);

  /** Shows a base map, or with `null` none. */
  setBase(id: string | null): void {
    this.#choose({ base: id ?? '' });
  }

  /** Shows the base map that fits the view. */
  setBaseByView(): void {
    this.#choose({ base: null });
  }

  setShown(id: string, isShown: boolean): void {
    this.#choose({ isShown: { ...this.#choice.isShown, [id]: isShown } });
  }

  setOpacity(id: string, opacity: number): void {
    this.#choose({ opacity: { ...this.#choice.opacity, [id]: opacity } });
  }

  /** Moves an overlay up (1) or down (−1) among the overlays. */
  async move(id: string, by: number): Promise<void> {
    const ids = this.sources.filter((source) => source.role === 'overlay').map((source) => source.id);
    this.#take(await mapsApi.putOrder(moved(ids, id, by)));
  }

  /** Saves a source; a new one is shown, and what failed of it is asked for again. */
  async put(settings: SourceSettings): Promise<MapSource> {
    const isNew = !this.sources.some((source) => source.id === settings.id);
    const saved = await mapsApi.putSource(settings);
    this.#faults.delete(saved.id);
    await this.load();
    if (isNew && saved.role === 'base') this.setBase(saved.id);
    else if (isNew && saved.role === 'overlay') this.setShown(saved.id, true);
    // what was refused before waits in the map to be asked again
    theMap.retryTiles(saved.id);
    return saved;
  }

  async remove(id: string, alsoCache: boolean): Promise<void> {
    await mapsApi.removeSource(id, alsoCache);
    this.#faults.delete(id);
    await this.load();
  }

  /** Fetches one tile, bypassing the cache; returns the problem or `null`. */
  async check(source: MapSource): Promise<Problem | null> {
    const state = await mapsApi.check(source.id);
    await this.load();
    if (state.status !== 'ok') return problemOfState(state);
    theMap.retryTiles(source.id);
    return null;
  }

  /** Asks for what did not come. An operator's wish goes past the server's own waiting time too. */
  async tryAgain(source: MapSource): Promise<void> {
    if (station.isOperator) await mapsApi.check(source.id).catch(() => undefined);
    theMap.retryTiles(source.id);
    await this.load();
  }

  async load(): Promise<void> {
    clearTimeout(this.#timer);
    this.#timer = undefined;
    this.#loadedAt_ms = performance.now();
    try {
      if (this.kinds.length === 0) this.kinds = await mapsApi.kinds();
      this.#take(await mapsApi.sources());
      this.problem = null;
    } catch (error) {
      this.problem = problemFrom(error);
    }
  }

  /** Notes the view: for choosing a base map that covers it, and for attributions that depend on the place. */
  async lookAt(view: Box, zoom: number): Promise<void> {
    this.#view = view;
    for (const { source } of this.#stack) {
      if (!source.attribution_by_view) continue;
      try {
        const { attribution } = await mapsApi.attribution(source.id, view, Math.round(zoom));
        this.#ofView.set(source.id, [...source.attribution, ...attribution]);
      } catch {
        // the source's own attribution stays; failures are reported by its tiles
      }
    }
  }

  // --- Reports of the map -------------------------------------------------------------------------------------------

  tileFailed(id: string, problem: Problem): void {
    if (this.#faults.get(id)?.detail !== problem.detail) this.#faults.set(id, problem);
    this.#loadSoon();
  }

  tileWasStale(): void {
    this.#loadSoon();
  }

  recovered(id: string): void {
    this.#faults.delete(id);
    this.#dismissed.delete(id);
    this.#loadSoon();
  }

  dismiss({ source, problem }: Failing): void {
    this.#dismissed.set(source.id, problem.detail);
  }

  failingOf = (source: MapSource): Failing | null => this.#failingOf(source);

  #failingOf(source: MapSource): Failing | null {
    const { status } = source.state;
    const fault = this.#faults.get(source.id);
    if (fault !== undefined) return { source, problem: fault, isStale: false };
    if (status === 'ok' || status === 'unused') return null;
    return { source, problem: problemOfState(source.state), isStale: status === 'failing' || status === 'offline' };
  }

  #take({ sources, file, file_error }: { sources: MapSource[]; file: string; file_error?: string | null }): void {
    // unchanged entries keep their identity, so that the map keeps their layers
    const known = new Map(this.sources.map((source) => [source.id, source]));
    this.sources = sources.map((source) => {
      const old = known.get(source.id);
      return old !== undefined && JSON.stringify(old) === JSON.stringify(source) ? old : source;
    });
    this.file = file;
    this.fileError = file_error ?? null;
    this.isLoaded = true;
    for (const id of this.#faults.keys()) if (!sources.some((source) => source.id === id)) this.#faults.delete(id);
  }

  #loadSoon(): void {
    this.#timer ??= setTimeout(
      () => void this.load(),
      Math.max(300, this.#loadedAt_ms + RELOAD_MS - performance.now()),
    );
  }

  #choose(change: Partial<Choice>): void {
    this.#choice = { ...this.#choice, ...change };
    save('maps', this.#choice);
  }
}

function problemOfState({ status, detail, last_error, cause }: MapSource['state']): Problem {
  // for sources set aside the status is enough
  const said = status === 'set_aside' ? '' : (detail ?? last_error ?? '');
  const type = `urn:vencejo:source-${status}`;
  return { type, title: status, status: 0, detail: said, ...(cause != null && { cause }) };
}

export const maps = new Maps();
