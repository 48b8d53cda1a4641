/** How people choose to have positions written. */

import { formatDecimal, formatDms, type LonLat, parseLonLat } from './lonlat';

export const COORDINATES = ['decimal', 'dms', 'utm'] as const;
export type CoordinateFormat = (typeof COORDINATES)[number];

/** Letters of the UTM bands from 80° S to 84° N, 8° each (the last 12°), without I and O. */
const BANDS = 'CDEFGHJKLMNPQRSTUVWX';

interface UtmZone {
  readonly zone: number;
  /** MGRS latitude band. */
  readonly band: string;
  readonly isNorth: boolean;
}

/**
 * The UTM zone of a position, with the exceptions of Norway and Svalbard (DMA TM 8358.1, 1989); `null` beyond 80° S and
 * 84° N, where UTM ends.
 */
export function utmZone({ lon_deg, lat_deg }: LonLat): UtmZone | null {
  if (lat_deg < -80 || lat_deg > 84) return null;
  let zone = Math.min(60, Math.floor((lon_deg + 180) / 6) + 1);
  if (lat_deg >= 56 && lat_deg < 64 && lon_deg >= 3 && lon_deg < 12) zone = 32;
  if (lat_deg >= 72 && lon_deg >= 0 && lon_deg < 42) {
    zone = lon_deg < 9 ? 31 : lon_deg < 21 ? 33 : lon_deg < 33 ? 35 : 37;
  }
  const band = BANDS[Math.min(BANDS.length - 1, Math.floor((lat_deg + 80) / 8))] ?? 'X';
  return { zone, band, isNorth: lat_deg >= 0 };
}

/** Projects a position into a zone: easting and northing, metres. */
export type UtmProjection = (at: LonLat, zone: UtmZone) => readonly [east_m: number, north_m: number];

/** `30T 432412 4465123`; where UTM ends, in decimal degrees. */
export function formatUtm(at: LonLat, project: UtmProjection): string {
  const zone = utmZone(at);
  if (zone === null) return formatDecimal(at, 6);
  const [east_m, north_m] = project(at, zone);
  const metres = (value_m: number): string => String(Math.round(value_m));
  return `${zone.zone}${zone.band} ${metres(east_m).padStart(6, '0')} ${metres(north_m).padStart(7, '0')}`;
}

/** Finds the position of easting and northing, metres, in a zone. */
export type UtmUnprojection = (
  east_m: number,
  north_m: number,
  zone: Pick<UtmZone, 'zone' | 'isNorth'>,
) => LonLat | null;

/** How far a position may be outside of its band, degrees: a site at its edge is surveyed in one band. */
const BAND_MARGIN_DEG = 1;

function isInBand({ lat_deg }: LonLat, band: string): boolean {
  const south_deg = -80 + 8 * BANDS.indexOf(band);
  const north_deg = band === 'X' ? 84 : south_deg + 8;
  return lat_deg >= south_deg - BAND_MARGIN_DEG && lat_deg <= north_deg + BAND_MARGIN_DEG;
}

/**
 * Reads a position as people write it (`parseLonLat`), or in UTM: `30T 432412 4465123`. The letter is the band; N and S are the
 * hemisphere where the northing is not of that band. `null` for other text, and for a northing that is not of the letter.
 */
export function parsePlace(text: string, unproject: UtmUnprojection): LonLat | null {
  // receivers write the easting with a zero in front: seven digits as those of the northing
  const utm =
    /^(\d{1,2})\s*([C-HJ-NP-X])[\s,]+(0?\d{6}(?:\.\d+)?)(?:\s*M?E)?[\s,]+(\d{1,8}(?:\.\d+)?)(?:\s*M?N)?$/i.exec(
      text.trim(),
    );
  if (utm === null) return parseLonLat(text);
  const [, zone, letter = '', east_m, north_m] = utm;
  const [number, band] = [Number(zone), letter.toUpperCase()];
  if (number < 1 || number > 60) return null;
  const inHemisphere = (isNorth: boolean): LonLat | null =>
    unproject(Number(east_m), Number(north_m), { zone: number, isNorth });
  const at = inHemisphere(band >= 'N');
  if (at !== null && isInBand(at, band)) return at;
  if (band === 'N') return at;
  return band === 'S' ? inHemisphere(false) : null;
}

export function formatPlace(at: LonLat, format: CoordinateFormat, project: UtmProjection): string {
  if (format === 'dms') return formatDms(at);
  return format === 'utm' ? formatUtm(at, project) : formatDecimal(at, 6);
}
