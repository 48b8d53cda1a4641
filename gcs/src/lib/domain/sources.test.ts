import { describe, expect, it } from 'vitest';
import {
  attributionsOf,
  baseOf,
  guessKind,
  moved,
  newId,
  NO_CHOICE,
  pageLink,
  readChoice,
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
const ids = (stack: readonly { source: Source }[]): string[] => stack.map((one) => one.source.id);

describe('what is shown', () => {
  it('is one base map below the overlays, as the file says', () => {
    expect(ids(stackOf(ALL, NO_CHOICE))).toEqual(['pnoa', 'roads']);
    expect(stackOf(ALL, NO_CHOICE)[1]?.opacity).toBe(0.5);
  });

  it('is what a person chose', () => {
    const choice = { base: 'osm', isShown: { roads: false, parcels: true }, opacity: { parcels: 0.25 } };
    expect(stackOf(ALL, choice).map(({ source, opacity }) => [source.id, opacity])).toEqual([
      ['osm', 1],
      ['parcels', 0.25],
    ]);
    expect(ids(stackOf(ALL, { ...NO_CHOICE, base: '' }))).toEqual(['roads']);
  });

  it('falls back when a chosen base map is gone', () => {
    expect(baseOf(ALL, { ...NO_CHOICE, base: 'gone' })?.id).toBe('pnoa');
    expect(baseOf([], NO_CHOICE)).toBeNull();
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
    const kinds: readonly (readonly [string, ReturnType<typeof guessKind>])[] = [
      ['https://tile.openstreetmap.org/{z}/{x}/{y}.png', 'xyz'],
      ['https://t.example/{q}.jpg', 'xyz'],
      ['https://www.ign.es/wms-inspire/pnoa-ma', 'wms'],
      ['https://www.ign.es/wmts/pnoa-ma?request=GetCapabilities&service=WMTS', 'wmts'],
      ['https://example.org/wmts/1.0.0/WMTSCapabilities.xml', 'wmts'],
      ['https://example.org/geoserver/ows?SERVICE=WMS&REQUEST=GetCapabilities', 'wms'],
      ['http://127.0.0.1/cgi-bin/mapserv?map=/x.map', 'wms'],
      ['field.mbtiles', 'mbtiles'],
      ['field.pmtiles', 'pmtiles'],
      ['ortho.TIF', 'geotiff'],
      ['chart.png', 'image'],
      ['https://example.org/', null],
      ['', null],
    ];
    for (const [address, kind] of kinds) expect(guessKind(address), address).toBe(kind);
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
