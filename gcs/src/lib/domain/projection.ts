/**
 * The coordinate reference systems that a map's source may come in, and where the map's own one ends.
 *
 * The view is always in Web Mercator (EPSG:3857). What comes in another system is warped into it, by the definitions
 * given here; axes are always x = east or longitude, y = north or latitude, whatever order a protocol writes them in.
 */

export interface Crs {
  /** As services name it: `EPSG:25830`. */
  readonly code: string;
  readonly kind: 'web-mercator' | 'geographic' | 'utm' | 'polar';
  /** For `utm` 1 to 60; absent otherwise. */
  readonly zone: number | null;
  readonly hemisphere: 'north' | 'south' | null;
  /** ETRS89 and WGS 84 differ by less than a metre, which is below what an orthophoto promises. */
  readonly datum: 'WGS 84' | 'ETRS89';
  /** The definition in the language of PROJ; `null` for the two that every map library knows. */
  readonly proj4: string | null;
}

/** Latitude at which Web Mercator's square ends: atan(sinh π). Beyond, this map has no place for a position. */
export const MERCATOR_LIMIT_DEG = (Math.atan(Math.sinh(Math.PI)) * 180) / Math.PI;

/** Half the width of the world in Web Mercator, metres: π times the semi-major axis of WGS 84. */
export const MERCATOR_HALF_M = Math.PI * 6_378_137;

export const isOnMercator = (lat_deg: number): boolean => Math.abs(lat_deg) <= MERCATOR_LIMIT_DEG;

const ETRS89 = '+ellps=GRS80 +towgs84=0,0,0,0,0,0,0';

/** Other names of the same system. */
const SAME: Readonly<Record<string, string>> = {
  'EPSG:900913': 'EPSG:3857',
  'EPSG:3785': 'EPSG:3857',
  'EPSG:102100': 'EPSG:3857',
  'CRS:84': 'EPSG:4326',
  'OGC:CRS84': 'EPSG:4326',
};

/** The EPSG code in any of the ways in which services write it: `EPSG:25830`, `urn:ogc:def:crs:EPSG::25830`, `CRS:84`. */
export function crsCode(text: string): string {
  const written = text.trim().toUpperCase();
  const urn = /^URN:(?:X-)?OGC:DEF:CRS:(EPSG|OGC|CRS):[^:]*:(\w+)$/.exec(written);
  const url = /\/DEF\/CRS\/(EPSG|OGC|CRS)\/[^/]*\/(\w+)$/.exec(written);
  const [, authority, code] = urn ?? url ?? [];
  const plain = authority === undefined ? written : code === 'CRS84' ? 'CRS:84' : `${authority}:${code}`;
  return SAME[plain] ?? plain;
}

/** What is known of a system; `null` when the map cannot warp it. */
export function crsOf(text: string): Crs | null {
  const code = crsCode(text);
  const number = Number(/^EPSG:(\d{4,5})$/.exec(code)?.[1] ?? Number.NaN);
  const plain = { code, zone: null, hemisphere: null, datum: 'WGS 84', proj4: null } as const;
  if (number === 3857) return { ...plain, kind: 'web-mercator' };
  if (number === 4326) return { ...plain, kind: 'geographic' };
  if (number === 4258)
    return { ...plain, kind: 'geographic', datum: 'ETRS89', proj4: `+proj=longlat ${ETRS89} +no_defs` };
  if (number > 32600 && number <= 32660) return utm(code, number - 32600, 'north', 'WGS 84');
  if (number > 32700 && number <= 32760) return utm(code, number - 32700, 'south', 'WGS 84');
  if (number >= 25828 && number <= 25838) return utm(code, number - 25800, 'north', 'ETRS89');
  const polar = POLAR[number];
  if (polar)
    return {
      ...plain,
      kind: 'polar',
      hemisphere: polar[0],
      proj4: `+proj=stere ${polar[1]} +datum=WGS84 +units=m +no_defs`,
    };
  return null;
}

/** Polar stereographic systems in use, by their EPSG code. */
const POLAR: Readonly<Record<number, readonly ['north' | 'south', string]>> = {
  3031: ['south', '+lat_0=-90 +lat_ts=-71 +lon_0=0 +x_0=0 +y_0=0'],
  3413: ['north', '+lat_0=90 +lat_ts=70 +lon_0=-45 +x_0=0 +y_0=0'],
  3995: ['north', '+lat_0=90 +lat_ts=71 +lon_0=0 +x_0=0 +y_0=0'],
};

function utm(code: string, zone: number, hemisphere: 'north' | 'south', datum: Crs['datum']): Crs {
  const south = hemisphere === 'south' ? ' +south' : '';
  const shape = datum === 'ETRS89' ? ETRS89 : '+datum=WGS84';
  return {
    code,
    kind: 'utm',
    zone,
    hemisphere,
    datum,
    proj4: `+proj=utm +zone=${zone}${south} ${shape} +units=m +no_defs`,
  };
}

/** The system to ask a service for, of those it offers: as few warps as can be, then the least distortion. */
export function preferredCrs(offered: readonly string[], lon_deg: number | null = null): Crs | null {
  const known = offered.map(crsOf).filter((crs): crs is Crs => crs !== null);
  const zone = lon_deg === null ? null : Math.min(60, Math.floor((lon_deg + 180) / 6) + 1);
  const rank = (crs: Crs): number =>
    crs.kind === 'web-mercator' ? 0 : crs.kind === 'geographic' ? 1 : crs.kind === 'utm' && crs.zone === zone ? 2 : 3;
  return known.reduce<Crs | null>((best, crs) => (best === null || rank(crs) < rank(best) ? crs : best), null);
}
