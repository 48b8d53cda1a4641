/**
 * Map coordinates ↔ positions in every system that a source may come in, by proj4: the full Krüger series for UTM
 * (Poder & Engsager, "etmerc"), so it holds far outside a zone too. Loaded only when a source needs it.
 */

import proj4 from 'proj4';
import { type LonLat, wrap180_deg } from './lonlat';
import { type Crs, MERCATOR_HALF_M, MERCATOR_LIMIT_DEG } from './projection';

export type CrsXY = readonly [x: number, y: number];

export interface CrsTransform {
  /** `null` where the system has no place for a position. */
  fromLonLat(at: LonLat): CrsXY | null;
  /** `null` where a coordinate is outside what the system describes. */
  toLonLat(xy: CrsXY): LonLat | null;
}

const RAD = Math.PI / 180;
const A_M = MERCATOR_HALF_M / Math.PI;

/** EPSG:3857: Snyder, Map Projections (USGS 1395), equations 7-1 and 7-2, on the sphere with WGS 84's semi-major axis. */
const webMercator: CrsTransform = {
  fromLonLat: ({ lon_deg, lat_deg }) =>
    Math.abs(lat_deg) > MERCATOR_LIMIT_DEG + 1e-9
      ? null
      : [A_M * lon_deg * RAD, A_M * Math.asinh(Math.tan(lat_deg * RAD))],
  toLonLat: ([x, y]) => ({ lon_deg: wrap180_deg(x / A_M / RAD), lat_deg: Math.atan(Math.sinh(y / A_M)) / RAD }),
};

export function crsTransform(crs: Crs): CrsTransform {
  if (crs.kind === 'web-mercator') return webMercator;
  if (crs.kind === 'geographic') {
    return {
      fromLonLat: ({ lon_deg, lat_deg }) => [lon_deg, lat_deg],
      toLonLat: ([x, y]) => (Math.abs(y) <= 90 ? { lon_deg: wrap180_deg(x), lat_deg: y } : null),
    };
  }
  const { forward, inverse } = proj4('EPSG:4326', crs.proj4 ?? crs.code);
  return {
    fromLonLat: ({ lon_deg, lat_deg }) => {
      const [x = Number.NaN, y = Number.NaN] = forward([lon_deg, lat_deg]);
      return Number.isFinite(x) && Number.isFinite(y) ? [x, y] : null;
    },
    toLonLat: ([x, y]) => {
      const [lon_deg = Number.NaN, lat_deg = Number.NaN] = inverse([x, y]);
      return Number.isFinite(lon_deg) && Math.abs(lat_deg) <= 90 ? { lon_deg: wrap180_deg(lon_deg), lat_deg } : null;
    },
  };
}
