/** Units that people choose to read and type; everything inside the station is metres and metres per second. */

import { niceStep } from './profile';

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
  useGrouping: 'auto' | false = 'auto',
): Intl.NumberFormat {
  const key = `${locale} ${minimumFractionDigits} ${maximumFractionDigits} ${useGrouping}`;
  let found = formatters.get(key);
  if (found === undefined) {
    found = new Intl.NumberFormat(locale, { minimumFractionDigits, maximumFractionDigits, useGrouping });
    formatters.set(key, found);
  }
  return found;
}

/** A number for display: `digits` after the point, no negative zero, in the format of the language. */
export function formatNumber(value: number, digits: number, locale?: string): string {
  const text = formatter(locale, digits, digits).format(value);
  return /^[-−][0.,\s]*$/.test(text) ? text.slice(1) : text;
}

/** A number to be edited: no more digits than needed, at most `digits`, and none in groups. */
export const editedNumber = (value: number, digits: number, locale?: string): string =>
  formatter(locale, 0, digits, false).format(Number(value.toFixed(digits)) || 0);

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

/** From this distance on a scale in feet is one in nautical miles. */
const NMI_SCALE_M = 0.5 * M_PER_NMI;
/** Steps of a scale in feet are at most this long. */
const FT_SCALE_M = 2000 * M_PER_FT;

/** The smallest step of a scale that is not below `least_m`, round in the units in use: 500 m, 2 km; 2000 ft, 0.5 nmi. */
export function scaleStep_m(least_m: number, units: Units): number {
  if (units.length === 'm') return niceStep(least_m);
  if (least_m <= FT_SCALE_M) return lengthTo_m(niceStep(lengthFrom_m(least_m, 'ft')), 'ft');
  return Math.max(NMI_SCALE_M, niceStep(least_m / M_PER_NMI) * M_PER_NMI);
}

/** A distance on a scale with these steps: `500 m`, `1.5 km`; with feet `6000 ft`, `1.5 nmi`. */
export function formatScale(value_m: number, step_m: number, units: Units, locale?: string): string {
  const isFeet = units.length === 'ft';
  const isLarge = isFeet ? step_m >= NMI_SCALE_M * 0.999 : Math.abs(value_m) >= 999;
  const value = isLarge ? value_m / (isFeet ? M_PER_NMI : 1000) : lengthFrom_m(value_m, units.length);
  const symbol = isLarge ? (isFeet ? 'nmi' : 'km') : LENGTH_SYMBOL[units.length];
  return `${formatter(locale, 0, isLarge ? 2 : 0).format(value)} ${symbol}`;
}

/** A length near one that was chosen in metres, as somebody who reads feet would choose it: 80 m is 250 ft. */
export function roundLength_m(value_m: number, unit: LengthUnit): number {
  if (unit === 'm') return value_m;
  const value = lengthFrom_m(value_m, unit);
  const step = value >= 100 ? 50 : 10;
  return lengthTo_m(Math.round(value / step) * step, unit);
}

/** A length in whole units, for fields that are typed into. */
export const wholeLength_m = (value_m: number, unit: LengthUnit): number =>
  lengthTo_m(Math.round(lengthFrom_m(value_m, unit)), unit);

/** Climbing is read in the unit of heights: m/s, or feet per minute. */
export const climbSymbol = ({ length }: Units): string => (length === 'm' ? 'm/s' : 'ft/min');
export const climbFrom_m_s = (value_m_s: number, { length }: Units): number =>
  length === 'm' ? value_m_s : lengthFrom_m(value_m_s, length) * 60;

/** Climb without its unit: `1.2`; in feet per minute in tens. */
export function climbFigure(value_m_s: number, units: Units, locale?: string): string {
  const value = climbFrom_m_s(value_m_s, units);
  return units.length === 'm'
    ? formatNumber(value, 1, locale)
    : formatter(locale, 0, 0, false).format(Math.round(value / 10) * 10 || 0);
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

/** How long something takes, where seconds may not matter: `4:05`, `21 h 23 min`. */
export function formatSpan(value_s: number): string {
  const minutes = Math.round(value_s / 60);
  return value_s < 3600 ? formatDuration(value_s) : `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
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
