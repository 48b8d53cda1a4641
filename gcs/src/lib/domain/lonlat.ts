/** A position on the WGS-84 ellipsoid, and how people write one. */

export interface LonLat {
  /** Longitude in degrees, −180 to 180, east positive. */
  readonly lon_deg: number;
  /** Latitude in degrees, −90 to 90, north positive. */
  readonly lat_deg: number;
}

/** Wraps an angle to −180 (included) to 180 (excluded) degrees. */
export function wrap180_deg(angle_deg: number): number {
  const wrapped = ((((angle_deg + 180) % 360) + 360) % 360) - 180;
  return wrapped === 0 ? 0 : wrapped;
}

/** Wraps an angle to 0 (included) to 360 (excluded) degrees. */
export function wrap360_deg(angle_deg: number): number {
  return ((angle_deg % 360) + 360) % 360;
}

/** The position as fine as a vehicle keeps it: 1e-7 degrees, about a centimetre. */
export function rounded(at: LonLat): LonLat {
  const round = (value: number): number => Math.round(value * 1e7) / 1e7;
  return { lon_deg: round(wrap180_deg(at.lon_deg)), lat_deg: round(at.lat_deg) };
}

export function isLonLat(lon_deg: number, lat_deg: number): boolean {
  return Number.isFinite(lon_deg) && Number.isFinite(lat_deg) && Math.abs(lat_deg) <= 90 && Math.abs(lon_deg) <= 180;
}

/** A position from two values that may be absent or out of range: `null` when they are not a position. */
export function lonLat(lon_deg: number | null | undefined, lat_deg: number | null | undefined): LonLat | null {
  if (lon_deg == null || lat_deg == null || !isLonLat(lon_deg, lat_deg)) return null;
  return { lon_deg, lat_deg };
}

export function sameLonLat(a: LonLat, b: LonLat): boolean {
  return Math.abs(a.lat_deg - b.lat_deg) < 5e-8 && Math.abs(wrap180_deg(a.lon_deg - b.lon_deg)) < 5e-8;
}

/** `40.3355555, -3.7966666`: latitude first, as people and map services write it; a decimal point in every language. */
export function formatDecimal(at: LonLat, digits = 7): string {
  return `${at.lat_deg.toFixed(digits)}, ${at.lon_deg.toFixed(digits)}`;
}

/** `40°20′08.0″N 3°47′48.0″W`. */
export function formatDms(at: LonLat): string {
  return `${formatAngle(at.lat_deg, 'lat')} ${formatAngle(at.lon_deg, 'lon')}`;
}

type Axis = 'lat' | 'lon';
const LETTERS = { lat: ['N', 'S'], lon: ['E', 'W'] } as const;

/** One of its angles, with so many decimals of a second: `40°20′08.0″N`. */
export function formatAngle(value_deg: number, axis: Axis, digits = 1): string {
  const parts = 10 ** digits;
  const whole = Math.round(Math.abs(value_deg) * 3600 * parts);
  const seconds = (whole % (60 * parts)) / parts;
  const minutes = Math.floor(whole / (60 * parts)) % 60;
  const degrees = Math.floor(whole / (3600 * parts));
  const pad = (text: string, length: number): string => text.padStart(length, '0');
  const letter = LETTERS[axis][value_deg < 0 ? 1 : 0];
  return `${degrees}°${pad(String(minutes), 2)}′${pad(seconds.toFixed(digits), digits + 3)}″${letter}`;
}

/** Reads one angle as people write it, `40°20′08″N` or `40.3355`; `null` when it is none, or of the other axis. */
export function parseAngle(text: string, axis: Axis): number | null {
  const read = angle(text.trim().toUpperCase());
  return read === null || (read.axis !== null && read.axis !== axis) ? null : read.value_deg;
}

/**
 * Reads a position as people paste it: `40.33, -3.79`, `40,33; -3,79`, `40°20′08″N 3°47′48″W`, `N40.33 W3.79`.
 * Latitude comes first unless hemisphere letters say otherwise. `null` when it is not a position, and where it may be one angle:
 * `40,33` is 40.33 with a decimal comma, and `40 33` may be degrees and minutes.
 */
export function parseLonLat(text: string): LonLat | null {
  const parts = split(text.trim().toUpperCase());
  if (parts === null) return null;
  const [first, second] = parts.map(angle);
  if (first == null || second == null) return null;
  const isSwapped = first.axis === 'lon' || second.axis === 'lat';
  if (first.axis !== null && first.axis === second.axis) return null;
  const [lat, lon] = isSwapped ? [second, first] : [first, second];
  return lonLat(lon.value_deg, lat.value_deg);
}

function split(text: string): [string, string] | null {
  if (text.length > 100 || angle(text) !== null) return null;
  const attempts = [
    text.split(/\s*;\s*/),
    text.split(/\s*,\s+/),
    text.match(/^(.*[NS])\s*,?\s*(.*[EWO])$/)?.slice(1) ?? [],
    text.match(/^(.*[EWO])\s*,?\s*(.*[NS])$/)?.slice(1) ?? [],
    text.match(/^([NS].*?)\s*,?\s*([EWO].*)$/)?.slice(1) ?? [],
    text.split(','),
    text.split(/\s+/),
  ];
  for (const parts of attempts) {
    const [first, second] = parts;
    if (parts.length === 2 && first && second && angle(first) && angle(second)) return [first, second];
  }
  return null;
}

function angle(text: string): { value_deg: number; axis: Axis | null } | null {
  const letter = text.match(/[NSEWO]/g) ?? [];
  if (letter.length > 1) return null;
  const match = text
    .replace(/[NSEWO]/, '')
    .trim()
    .replaceAll(',', '.')
    .replace('−', '-')
    .match(/^([+-]?)(\d+\.?\d*|\.\d+)(?:\s*[°º\s]\s*(\d+(?:\.\d+)?)(?:\s*['′’\s]\s*(\d+(?:\.\d+)?))?)?\s*["″”'′’°º]*$/);
  if (!match) return null;
  const [, sign, degrees = '', minutes = '', seconds = ''] = match;
  // only the last of them has decimals
  if ((degrees.includes('.') && minutes !== '') || (minutes.includes('.') && seconds !== '')) return null;
  if (Number(minutes) >= 60 || Number(seconds) >= 60) return null;
  const magnitude = Number(degrees) + Number(minutes) / 60 + Number(seconds) / 3600;
  // O is oeste, Spanish for west
  const isNegative = sign === '-' || /[SWO]/.test(letter[0] ?? '');
  const axis = letter[0] === undefined ? null : /[NS]/.test(letter[0]) ? 'lat' : 'lon';
  return { value_deg: isNegative ? -magnitude : magnitude, axis };
}
