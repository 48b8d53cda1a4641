// The maps' part of the stand-in for the server: drawn tiles, one source that fails, an area being fetched, hills.
import type { Area, MapKind, MapSource, Preset } from '../../src/lib/api/maps-types';

const WORLD = 20_037_508.342789244;
const grid = {
  crs: 'EPSG:3857',
  proj4: null,
  extent: null,
  levels: Array.from({ length: 20 }, (_, z) => ({
    resolution: (2 * WORLD) / 256 / 2 ** z,
    origin: [-WORLD, WORLD] as [number, number],
    tile_px: [256, 256] as [number, number],
    size: [2 ** z, 2 ** z] as [number, number],
  })),
  min_level: 0,
  max_level: 19,
};

const state = (status: MapSource['state']['status'], detail: string | null = null): MapSource['state'] => ({
  status,
  detail,
  last_success_at: status === 'ok' ? Date.now() / 1000 - 12 : null,
  last_error_at: status === 'ok' ? null : Date.now() / 1000 - 3,
  last_error: detail,
  cause: null,
  fetched: 412,
  revalidated: 8,
  hits: 3120,
  stale: 0,
  failed: status === 'ok' ? 0 : 17,
  bytes_fetched: 9_120_000,
  cache: { tiles: 4210, bytes: 88_400_000, pinned_tiles: 1206, max_bytes: 500_000_000 },
});

const source = (id: string, name: string, more: Partial<MapSource>): MapSource => ({
  id,
  name,
  kind: 'xyz',
  role: 'base',
  visible: true,
  opacity: 1,
  order: 0,
  min_zoom: null,
  max_zoom: null,
  bounds: null,
  attribution: [],
  attribution_by_view: false,
  logo: null,
  grid,
  tiles_url: `/api/v1/tiles/${id}/{z}/{x}/{y}?v=1`,
  may_cache: true,
  offline: { allowed: true, reason: null },
  needs_key: false,
  has_key: false,
  corners: null,
  state: state('ok'),
  ...more,
});

const sources: MapSource[] = [
  source('pnoa', 'PNOA orthophotos', {
    kind: 'wms',
    attribution: [{ text: 'PNOA cedido por © Instituto Geográfico Nacional', url: 'https://www.ign.es' }],
  }),
  source('osm', 'OpenStreetMap', {
    attribution: [{ text: '© OpenStreetMap contributors', url: 'https://www.openstreetmap.org/copyright' }],
    offline: { allowed: false, reason: 'OpenStreetMap’s tile policy forbids fetching tiles in bulk.' },
  }),
  source('parcels', 'Cadastre: parcels and rights of way', {
    kind: 'wms',
    role: 'overlay',
    opacity: 0.6,
    min_zoom: 14,
    attribution: [{ text: '© Dirección General del Catastro', url: null }],
    state: state('failing', 'LayerNotDefined: the layer CP.CadastralParcel is not offered'),
  }),
  source('terrarium', 'Terrain tiles', { role: 'elevation', attribution: [{ text: 'Mapzen, NASA SRTM', url: null }] }),
];

const preset = (id: string, name: string, description: string, more: Partial<Preset> = {}): Preset => ({
  id,
  name,
  description,
  terms_url: 'https://example.org/terms',
  needs_key: false,
  key_url: null,
  settings: { id, name, kind: 'xyz', url: 'https://example.org/{z}/{x}/{y}.png', attribution: [{ text: `© ${name}` }] },
  ...more,
});

const presets: Preset[] = [
  preset('pnoa', 'PNOA orthophotos (Spain)', 'Spain’s national orthophotos. Attribution as its licence asks.'),
  preset('ign-base', 'IGN base map (Spain)', 'Topographic map of Spain.'),
  preset('google', 'Google satellite', 'Map Tiles API.', {
    needs_key: true,
    key_url: 'https://developers.google.com',
    settings: { id: 'google', name: 'Google satellite', kind: 'google', map_type: 'satellite', attribution: [] },
  }),
];

const KINDS: MapKind[] = [
  {
    kind: 'wms',
    fields: ['url', 'key', 'local_network', 'layers', 'transparent', 'cache'],
    roles: ['base', 'overlay'],
    file_ends: [],
    address_signs: ['service=wms', 'wms'],
    has_capabilities: true,
    needs_key: false,
  },
  {
    kind: 'mbtiles',
    fields: ['path', 'encoding'],
    roles: ['base', 'overlay', 'elevation'],
    file_ends: ['.mbtiles'],
    address_signs: [],
    has_capabilities: false,
    needs_key: false,
  },
];

const start_ms = performance.now();
const areas = (): Area[] => {
  const done = Math.min(2400, Math.round(600 + ((performance.now() - start_ms) / 1000) * 35));
  const shared = { source: 'pnoa', min_level: 12, max_level: 18, created_at: Date.now() / 1000, detail: null };
  const box = { kind: 'box', west_deg: -3.83, south_deg: 40.32, east_deg: -3.77, north_deg: 40.36 } as const;
  return [
    {
      ...shared,
      id: 'a1',
      name: 'Flying field',
      shape: box,
      state: done < 2400 ? 'running' : 'done',
      tiles: 2400,
      done,
      failed: 3,
      bytes: done * 21_000,
      rate_tiles_s: 35,
    },
  ];
};

/** Hills: a height in metres that goes smoothly with the place. */
const hills_m = (lat_deg: number, lon_deg: number): number =>
  660 + 45 * Math.sin(lat_deg * 700) * Math.cos(lon_deg * 500) + 12 * Math.sin(lon_deg * 1900);

async function tile(z: string, x: string, y: string): Promise<Response> {
  const canvas = new OffscreenCanvas(256, 256);
  const context = canvas.getContext('2d');
  if (context === null) return new Response(null, { status: 500 });
  context.fillStyle = `hsl(${((Number(x) * 47 + Number(y) * 31) % 60) + 80} 25% 32%)`;
  context.fillRect(0, 0, 256, 256);
  context.strokeStyle = '#0006';
  context.strokeRect(0, 0, 256, 256);
  context.fillStyle = '#fff9';
  context.font = '13px sans-serif';
  context.fillText(`${z}/${x}/${y}`, 10, 22);
  return new Response(await canvas.convertToBlob(), { headers: { 'content-type': 'image/png' } });
}

/** What the maps' part of the API answers; `null` for what is not of it. */
export async function mapsAnswer(
  method: string,
  path: string,
  body: string,
  json: (value: unknown, status?: number) => Response,
): Promise<Response | null> {
  const problem = (status: number, code: string, detail: string): Response =>
    json({ type: `urn:vencejo:${code}`, title: detail, status, detail }, status);
  const wanted = /^\/tiles\/(\w+)\/(\d+)\/(\d+)\/(\d+)$/.exec(path);
  if (wanted) {
    const [, id = '', z = '', x = '', y = ''] = wanted;
    if (id !== 'parcels') return tile(z, x, y);
    return problem(502, 'source-failed', 'LayerNotDefined: the layer CP.CadastralParcel is not offered');
  }
  if (path === '/maps/sources')
    return json({ sources, file: '/home/pi/.config/vencejo/sources.toml', file_error: null });
  if (path === '/maps/presets') return json(presets);
  if (path === '/maps/kinds') return json(KINDS);
  if (path === '/maps/files') return json([{ path: 'field.mbtiles', bytes: 48_211_000, kind: 'mbtiles' }]);
  if (path === '/maps/areas' && method === 'GET') return json(areas());
  if (path === '/maps/areas/estimate') {
    return json({
      tiles: 3120,
      have: 410,
      bytes: 61_000_000,
      tile_bytes: 22_000,
      tile_bytes_measured: true,
      levels: [],
      max_tiles: 200_000,
      refused: null,
    });
  }
  if (path === '/maps/config') {
    const settings = sources.map(({ id, name, kind, role, attribution }) => ({
      id,
      name,
      kind,
      role,
      attribution,
      url: 'https://example.org/wms',
      layers: ['OI.OrthoimageCoverage'],
      crs: 'EPSG:3857',
    }));
    return json({ sources: settings, cache_max_mb: 2000, folder: '/home/pi/maps', file: '', file_error: null });
  }
  if (path === '/maps/capabilities') {
    return json({
      kind: 'wms',
      version: '1.3.0',
      title: 'Ortofotos máxima actualidad del PNOA',
      abstract: 'Servicio de visualización de las ortofotos de máxima actualidad.',
      formats: ['image/png', 'image/jpeg'],
      layers: [
        {
          name: null,
          title: 'Imágenes',
          depth: 0,
          styles: [],
          crs: [],
          other_crs: 0,
          formats: [],
          matrix_sets: [],
          opaque: false,
        },
        {
          name: 'OI.OrthoimageCoverage',
          title: 'Ortoimágenes',
          depth: 1,
          styles: [{ name: 'default', title: 'Por defecto' }],
          crs: ['EPSG:4326', 'EPSG:25830', 'EPSG:3857'],
          other_crs: 4,
          formats: [],
          matrix_sets: [],
          opaque: true,
        },
        {
          name: 'OI.MosaicElement',
          title: 'Mosaico',
          depth: 1,
          styles: [],
          crs: [],
          other_crs: 2,
          formats: [],
          matrix_sets: [],
          opaque: false,
        },
      ],
    });
  }
  if (path === '/elevation') {
    const { points } = JSON.parse(body) as { points: { lat_deg: number; lon_deg: number }[] };
    return json({
      points: points.map(({ lat_deg, lon_deg }) => ({
        alt_amsl_m: hills_m(lat_deg, lon_deg),
        source: 'terrarium',
        resolution_m: 30,
        datum: 'EGM96',
      })),
    });
  }
  if (path.startsWith('/maps/')) return json(path.endsWith('/check') ? state('ok') : (sources[0] ?? {}));
  return null;
}
