import { describe, expect, it } from 'vitest';
import {
  attributionsOf,
  baseOf,
  type Choice,
  guessKind,
  moved,
  newId,
  NO_CHOICE,
  pageLink,
  readChoice,
  shareOf,
  type Source,
  stackOf,
} from './sources';

const source = (id: string, role: Source['role'], more: Partial<Source> = {}): Source => ({
  id,
  name: id,
  role,
  visible: true,
  opacity: 1,
  attribution: [{ text: `© ${id}` }],
  ...more,
});
const ALL = [
  source('hidden', 'base', { visible: false }),
  source('pnoa', 'base'),
  source('osm', 'base'),
  source('roads', 'overlay', { opacity: 0.5 }),
  source('parcels', 'overlay', { visible: false }),
  source('dem', 'elevation'),
];
const stacked = (choice: Choice) => stackOf(ALL, choice, baseOf(ALL, choice, null));
const ids = (stack: readonly { source: Source }[]): string[] => stack.map((one) => one.source.id);

const box = (west_deg: number, south_deg: number, east_deg: number, north_deg: number) => ({
  west_deg,
  south_deg,
  east_deg,
  north_deg,
});

describe('the base map that nobody chose', () => {
  const spain = source('pnoa', 'base', { bounds: box(-18.6, 27.2, 4.8, 44.2) });
  const pacific = source('pacific', 'base', { bounds: box(170, -30, -170, 0) });
  const all = [spain, pacific, source('osm', 'base'), source('esri', 'base')];
  const at = (view: ReturnType<typeof box> | null, sources: readonly Source[] = all) =>
    baseOf(sources, NO_CHOICE, view)?.id;

  it('is the first one that has most of the view, and one of the world elsewhere', () => {
    expect(at(box(-3.8, 40.3, -3.7, 40.4))).toBe('pnoa');
    expect(at(box(-60.1, -34.7, -60, -34.6))).toBe('osm');
    expect(at(box(-100, -60, 100, 75))).toBe('osm');
    expect(at(box(179.9, -17, 180.1, -16.9))).toBe('pacific');
    expect(at(box(-180.1, -17, -179.9, -16.9))).toBe('pacific');
  });

  it('changes where half of the view is beyond the border', () => {
    expect(at(box(3.8, 43, 5.6, 43.5))).toBe('pnoa');
    expect(at(box(4, 43, 6, 43.5))).toBe('osm');
  });

  it('is one of the world while the view is not known, and whichever has most where none has enough', () => {
    expect(at(null)).toBe('osm');
    expect(at(box(-100, -60, 100, 75), [pacific, spain])).toBe('pnoa');
    expect(at(null, [spain])).toBe('pnoa');
  });

  it('never takes the place of one that was chosen', () => {
    expect(baseOf(all, { ...NO_CHOICE, base: 'esri' }, box(-3.8, 40.3, -3.7, 40.4))?.id).toBe('esri');
    expect(baseOf(all, { ...NO_CHOICE, base: '' }, box(-3.8, 40.3, -3.7, 40.4))).toBeNull();
  });
});

it('counts how much of a view lies within bounds', () => {
  expect(shareOf(box(0, 0, 10, 10), box(0, 0, 10, 10))).toBe(1);
  expect(shareOf(box(0, 0, 10, 10), box(5, 5, 20, 20))).toBe(0.25);
  expect(shareOf(box(175, 0, 185, 10), box(-180, 0, -170, 10))).toBe(0.5);
  expect(shareOf(box(-180, -85, 180, 85), box(-180, -85, 180, 85))).toBe(1);
  expect(shareOf(box(0, 0, 0, 0), box(0, 0, 10, 10))).toBe(0);
});

describe('what is shown', () => {
  it('is one base map below the overlays, as the file says', () => {
    expect(ids(stacked(NO_CHOICE))).toEqual(['pnoa', 'roads']);
    expect(stacked(NO_CHOICE)[1]?.opacity).toBe(0.5);
  });

  it('is what a person chose', () => {
    const choice = { base: 'osm', isShown: { roads: false, parcels: true }, opacity: { parcels: 0.25 } };
    expect(stacked(choice).map(({ source, opacity }) => [source.id, opacity])).toEqual([
      ['osm', 1],
      ['parcels', 0.25],
    ]);
    expect(ids(stacked({ ...NO_CHOICE, base: '' }))).toEqual(['roads']);
  });

  it('falls back when a chosen base map is gone', () => {
    expect(baseOf(ALL, { ...NO_CHOICE, base: 'gone' }, null)?.id).toBe('pnoa');
    expect(baseOf([], NO_CHOICE, null)).toBeNull();
  });

  it('survives storage, and nonsense in it', () => {
    const choice = { base: 'osm', isShown: { roads: false }, opacity: { roads: 0.3 } };
    expect(readChoice(JSON.parse(JSON.stringify(choice)))).toEqual(choice);
    expect(readChoice({ base: 7, isShown: { a: 'yes' }, opacity: { a: 3, b: null } })).toEqual(NO_CHOICE);
    expect(readChoice('osm')).toBeNull();
  });
});

describe('attributions', () => {
  it('come each once, uppermost source first', () => {
    const shown = [ALL[1], ALL[3], source('more', 'overlay', { attribution: [{ text: '© pnoa' }, { text: ' ' }] })];
    expect(attributionsOf(shown as Source[]).map((one) => one.text)).toEqual(['© pnoa', '© roads']);
  });

  it('link to pages only', () => {
    expect(pageLink('https://www.ign.es')).toBe('https://www.ign.es');
    for (const url of ['javascript:alert(1)', '//x.org', 'data:text/html,x', '', null])
      expect(pageLink(url)).toBeNull();
  });
});

describe('addresses', () => {
  it('show what they are of', () => {
    const kinds = [
      { kind: 'xyz', address_signs: ['{x}', '{q}'], file_ends: [] },
      { kind: 'wms', address_signs: ['service=wms', 'wms', 'mapserv', '/ows'], file_ends: [] },
      { kind: 'wmts', address_signs: ['service=wmts', 'wmts'], file_ends: [] },
      { kind: 'mbtiles', address_signs: [], file_ends: ['.mbtiles'] },
      { kind: 'geotiff', address_signs: [], file_ends: ['.tif', '.tiff'] },
      { kind: 'image', address_signs: [], file_ends: ['.png', '.jpg'] },
    ] as const;
    const cases: readonly (readonly [string, string | null])[] = [
      ['https://tile.openstreetmap.org/{z}/{x}/{y}.png', 'xyz'],
      ['https://t.example/{q}.jpg', 'xyz'],
      ['https://t.example/wmts?SERVICE=WMTS&TILECOL={X}&TILEROW={Y}', 'xyz'],
      ['https://example.org/geoserver/ows?SERVICE=WMTS', 'wmts'],
      ['https://www.ign.es/wms-inspire/pnoa-ma', 'wms'],
      ['https://www.ign.es/wmts/pnoa-ma?request=GetCapabilities&service=WMTS', 'wmts'],
      ['https://example.org/wmts/1.0.0/WMTSCapabilities.xml', 'wmts'],
      ['https://example.org/geoserver/ows?SERVICE=WMS&REQUEST=GetCapabilities', 'wms'],
      ['http://127.0.0.1/cgi-bin/mapserv?map=/x.map', 'wms'],
      ['field.mbtiles', 'mbtiles'],
      ['ortho.TIF', 'geotiff'],
      ['chart.png', 'image'],
      ['https://example.org/', null],
      ['', null],
    ];
    for (const [address, kind] of cases) expect(guessKind(address, kinds), address).toBe(kind);
  });
});

describe('ids', () => {
  it('are plain and new', () => {
    expect(newId('Ortofotos máxima actualidad (PNOA)', new Set())).toBe('ortofotos-maxima-actualidad-pnoa');
    expect(newId('OSM', new Set(['osm', 'osm-2']))).toBe('osm-3');
    expect(newId('地図', new Set())).toBe('map');
    expect(newId('x'.repeat(80), new Set())).toMatch(/^[a-z0-9-]{1,40}$/);
  });

  it('move within their list', () => {
    expect(moved(['a', 'b', 'c'], 'c', -1)).toEqual(['a', 'c', 'b']);
    expect(moved(['a', 'b', 'c'], 'a', -1)).toEqual(['a', 'b', 'c']);
    expect(moved(['a', 'b', 'c'], 'a', 9)).toEqual(['b', 'c', 'a']);
    expect(moved(['a'], 'x', 1)).toEqual(['a']);
  });
});
