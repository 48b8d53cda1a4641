import { beforeEach, describe, expect, it, vi } from 'vitest';
import type { MapSource, MapSources } from '$lib/api/maps-types';
import { maps } from './maps.svelte';
import { theMap } from './the-map';

const grid: MapSource['grid'] = {
  crs: 'EPSG:3857',
  proj4: null,
  extent: null,
  levels: [],
  min_level: 0,
  max_level: 0,
};
const ok: MapSource['state'] = {
  status: 'ok',
  detail: null,
  cause: null,
  last_success_at: null,
  last_error_at: null,
  last_error: null,
  fetched: 0,
  revalidated: 0,
  hits: 0,
  stale: 0,
  failed: 0,
  bytes_fetched: 0,
  cache: null,
};
const source = (id: string, more: Partial<MapSource> = {}): MapSource => ({
  id,
  name: id,
  kind: 'xyz',
  role: 'base',
  visible: true,
  opacity: 1,
  order: 0,
  attribution: [{ text: `© ${id}` }],
  attribution_by_view: false,
  grid,
  tiles_url: `/api/v1/tiles/${id}/{z}/{x}/{y}?v=1`,
  may_cache: true,
  offline: { allowed: true, reason: null },
  min_zoom: null,
  max_zoom: null,
  bounds: null,
  logo: null,
  corners: null,
  needs_key: false,
  has_key: false,
  state: ok,
  ...more,
});
const failing = (id: string, detail: string): MapSource =>
  source(id, { state: { ...source(id).state, status: 'failing', detail } });

let answer: MapSources = { sources: [], file: '', file_error: null };
const problem = (detail: string) => ({ type: 'urn:vencejo:source-failed', title: 'No', status: 502, detail });

beforeEach(async () => {
  vi.stubGlobal('fetch', async () => new Response(JSON.stringify(answer)));
  answer = {
    sources: [source('pnoa'), source('osm'), source('roads', { role: 'overlay', opacity: 0.5 })],
    file: '',
    file_error: null,
  };
  await maps.load();
  for (const { id } of answer.sources) maps.recovered(id);
});

const shown = () => maps.shown.map(({ id, opacity }) => [id, opacity]);

describe('map sources', () => {
  it('are drawn as the station says until a person chooses', () => {
    expect(shown()).toEqual([
      ['pnoa', 1],
      ['roads', 0.5],
    ]);
    maps.setBase('osm');
    maps.setShown('roads', false);
    expect(shown()).toEqual([['osm', 1]]);
    maps.setBase(null);
    maps.setShown('roads', true);
    maps.setOpacity('roads', 0.25);
    expect(shown()).toEqual([['roads', 0.25]]);
    maps.setBase('pnoa');
  });

  it('have the base map of the view until a person chooses, and keep that', async () => {
    const bounds = { west_deg: -18.6, south_deg: 27.2, east_deg: 4.8, north_deg: 44.2 };
    answer = { sources: [source('pnoa', { bounds }), source('osm')], file: '', file_error: null };
    await maps.load();
    maps.setBaseByView();
    await maps.lookAt({ west_deg: 12.4, south_deg: 41.8, east_deg: 12.6, north_deg: 42 }, 13);
    expect(shown()).toEqual([['osm', 1]]);
    expect(maps.attributions.map(({ text }) => text)).toEqual(['© osm']);
    await maps.lookAt({ west_deg: -3.8, south_deg: 40.3, east_deg: -3.7, north_deg: 40.4 }, 13);
    expect(shown()).toEqual([['pnoa', 1]]);
    expect(maps.isBaseByView).toBe(true);
    maps.setBase('osm');
    expect(shown()).toEqual([['osm', 1]]);
    expect(maps.isBaseByView).toBe(false);
    maps.setBase('pnoa');
  });

  it('stay the same objects while they are the same, so that no layer is made anew', async () => {
    const before = maps.sources;
    answer = { sources: [structuredClone(before[0] as MapSource), failing('osm', 'gone')], file: '', file_error: null };
    await maps.load();
    expect(maps.sources[0]).toBe(before[0]);
    expect(maps.sources[1]).not.toBe(before[1]);
  });

  it('are named while they are shown, and their failures told until they are over', async () => {
    expect(maps.attributions.map(({ text }) => text)).toContain('© pnoa');
    expect(maps.notices).toEqual([]);
    maps.tileFailed('pnoa', problem('LayerNotDefined'));
    maps.tileFailed('osm', problem('not shown, not told'));
    expect(maps.notices.map((one) => [one.source.id, one.problem.detail])).toEqual([['pnoa', 'LayerNotDefined']]);
    maps.dismiss(maps.notices[0]!);
    expect(maps.notices).toEqual([]);
    expect(maps.failing).toHaveLength(1);
    // a new reason is reported again
    maps.tileFailed('pnoa', problem('timeout'));
    expect(maps.notices).toHaveLength(1);
    maps.recovered('pnoa');
    expect(maps.failing).toEqual([]);
  });

  it('that the station keeps old pictures of are told as such', async () => {
    answer = { sources: [failing('pnoa', 'HTTP 500')], file: '', file_error: null };
    await maps.load();
    expect(maps.failing).toMatchObject([{ isStale: true, problem: { detail: 'HTTP 500' } }]);
  });

  it('without a grid are not drawn, and say why', async () => {
    const state = { ...source('x').state, status: 'key_missing' as const, detail: 'needs a key' };
    answer = { sources: [source('google', { grid: null, state })], file: '', file_error: null };
    maps.setBase('google');
    await maps.load();
    expect(maps.shown).toEqual([]);
    expect(maps.failing).toMatchObject([{ isStale: false, problem: { detail: 'needs a key' } }]);
  });

  it('are asked again for what failed once they are saved', async () => {
    const retryTiles = vi.spyOn(theMap, 'retryTiles');
    maps.tileFailed('pnoa', problem('refused'));
    vi.stubGlobal('fetch', async (_: string, { method }: RequestInit) => {
      expect(retryTiles).not.toHaveBeenCalled();
      return new Response(JSON.stringify(method === 'PUT' ? source('pnoa') : answer));
    });
    await maps.put({ id: 'pnoa', name: 'pnoa', kind: 'xyz', local_network: true });
    expect(retryTiles).toHaveBeenCalledExactlyOnceWith('pnoa');
    expect(maps.failing).toEqual([]);
  });

  it('that cannot be listed say why, and those known stay', async () => {
    vi.stubGlobal('fetch', async () => {
      throw new TypeError('offline');
    });
    await maps.load();
    expect(maps.problem?.status).toBe(0);
    expect(maps.sources.length).toBeGreaterThan(0);
  });
});
