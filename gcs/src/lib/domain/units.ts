/** Units that people choose to read and type; everything inside the station is metres and metres per second. */

export type LengthUnit = 'm' | 'ft';
export type SpeedUnit = 'm_s' | 'kt' | 'km_h';

export interface Units {
  /** Heights and short lengths. */
  readonly length: LengthUnit;
  readonly speed: SpeedUnit;
}

/** The international foot, exact. */
const M_PER_FT = 0.3048;
/** The international nautical mile, exact. */
const M_PER_NMI = 1852;

const LENGTH_M: Record<LengthUnit, number> = { m: 1, ft: M_PER_FT };
const SPEED_M_S: Record<SpeedUnit, number> = { m_s: 1, kt: M_PER_NMI / 3600, km_h: 1 / 3.6 };

export const LENGTH_SYMBOL: Record<LengthUnit, string> = { m: 'm', ft: 'ft' };
export const SPEED_SYMBOL: Record<SpeedUnit, string> = { m_s: 'm/s', kt: 'kt', km_h: 'km/h' };

export const lengthFrom_m = (value_m: number, unit: LengthUnit): number => value_m / LENGTH_M[unit];
export const lengthTo_m = (value: number, unit: LengthUnit): number => value * LENGTH_M[unit];
export const speedFrom_m_s = (value_m_s: number, unit: SpeedUnit): number => value_m_s / SPEED_M_S[unit];
export const speedTo_m_s = (value: number, unit: SpeedUnit): number => value * SPEED_M_S[unit];

/** Making a formatter costs as much as formatting a hundred numbers, and numbers are shown 20 times a second. */
const formatters = new Map<string, Intl.NumberFormat>();

function formatter(
  locale: string | undefined,
  minimumFractionDigits: number,
  maximumFractionDigits: number,
): Intl.NumberFormat {
  const key = `${locale} ${minimumFractionDigits} ${maximumFractionDigits}`;
  let found = formatters.get(key);
  if (found === undefined) {
    found = new Intl.NumberFormat(locale, { minimumFractionDigits, maximumFractionDigits });
    formatters.set(key, found);
  }
  return found;
}

/** A number for display: `digits` after the point, no negative zero, in the format of the language. */
export function formatNumber(value: number, digits: number, locale?: string): string {
  const text = formatter(locale, digits, digits).format(value);
  return /^[-−][0.,\s]*$/.test(text) ? text.slice(1) : text;
}

/** A height: `80 m`, `262 ft`. */
export function formatHeight(value_m: number, units: Units, locale?: string, digits = 0): string {
  return `${formatNumber(lengthFrom_m(value_m, units.length), digits, locale)} ${LENGTH_SYMBOL[units.length]}`;
}

/** A distance: `840 m`, `3.25 km`; with feet as the unit `2756 ft`, `1.75 nmi`. */
export function formatDistance(value_m: number, units: Units, locale?: string): string {
  const large_m = units.length === 'm' ? 1000 : M_PER_NMI;
  if (Math.abs(value_m) < large_m) return formatHeight(value_m, units, locale);
  const value = value_m / large_m;
  const digits = Math.abs(value) < 10 ? 2 : Math.abs(value) < 100 ? 1 : 0;
  return `${formatNumber(value, digits, locale)} ${units.length === 'm' ? 'km' : 'nmi'}`;
}

/** A distance on a scale, where values are round: `500 m`, `1 km`, `1.5 km`; with feet `500 ft`, `2 nmi`. */
export function formatScale(value_m: number, units: Units, locale?: string): string {
  const large_m = units.length === 'm' ? 1000 : M_PER_NMI;
  const isLarge = Math.abs(value_m) >= large_m * 0.999;
  const value = isLarge ? value_m / large_m : lengthFrom_m(value_m, units.length);
  const symbol = isLarge ? (units.length === 'm' ? 'km' : 'nmi') : LENGTH_SYMBOL[units.length];
  return `${formatter(locale, 0, isLarge ? 2 : 0).format(value)} ${symbol}`;
}

/** A speed: `12.3 m/s`, `24 kt`. */
export function formatSpeed(value_m_s: number, units: Units, locale?: string): string {
  const digits = units.speed === 'm_s' ? 1 : 0;
  return `${formatNumber(speedFrom_m_s(value_m_s, units.speed), digits, locale)} ${SPEED_SYMBOL[units.speed]}`;
}

/** A time: `4:05`, `1:02:09`. */
export function formatDuration(value_s: number): string {
  const whole = Math.max(0, Math.round(value_s));
  const seconds = String(whole % 60).padStart(2, '0');
  const minutes = Math.floor(whole / 60) % 60;
  const hours = Math.floor(whole / 3600);
  return hours > 0 ? `${hours}:${String(minutes).padStart(2, '0')}:${seconds}` : `${minutes}:${seconds}`;
}

/** Digits in groups: `1,500` is one and a half in Madrid and fifteen hundred in London, `1.500` the other way round. */
const GROUPED = /^[-+−]?[1-9]\d{0,2}([.,]\d{3})+$/;

export const isGrouped = (text: string): boolean => GROUPED.test(text.trim());

/** A height, distance or speed as people type it; `null` also of what some would read as a thousand times as much. */
export const parseMeasure = (text: string): number | null => (isGrouped(text) ? null : parseNumber(text));

/** A number as people type it, with a decimal comma or point; `null` for other text. */
export function parseNumber(text: string): number | null {
  const trimmed = text.trim().replace('−', '-').replace(',', '.');
  if (!/^[+-]?(\d+\.?\d*|\.\d+)$/.test(trimmed)) return null;
  return Number(trimmed);
}
