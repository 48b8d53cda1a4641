// Values as people read them, in the language and the units that were chosen. Reactive.
import { gpsFix } from '$lib/domain/core';
import { formatPlace } from '$lib/domain/coordinates';
import type { LonLat } from '$lib/domain/lonlat';
import {
  climbFigure,
  climbSymbol,
  formatDistance,
  formatDuration,
  formatHeight,
  formatNumber,
  formatSpan,
  formatSpeed,
  LENGTH_SYMBOL,
  SPEED_SYMBOL,
} from '$lib/domain/units';
import type { Wind } from '$lib/domain/wind';
import { type MessageKey, t } from '$lib/i18n/index.svelte';
import { projectUtm } from '$lib/map/utm';
import { settings } from '$lib/state/settings.svelte';

type Maybe = number | null | undefined;

const show = (value: Maybe, format: (value: number) => string): string =>
  value == null || !Number.isFinite(value) ? t('value.none') : format(value);

export const number = (value: Maybe, digits = 0, unit = ''): string =>
  show(value, (value) => formatNumber(value, digits, settings.locale) + (unit === '' ? '' : ` ${unit}`));
export const degrees = (value: Maybe, digits = 0): string => show(value, (value) => `${number(value, digits)}°`);
/** Three figures, as headings are read: 007°. */
export const bearing = (value: Maybe): string =>
  show(value, (value) => `${String(((Math.round(value) % 360) + 360) % 360).padStart(3, '0')}°`);
/** What a GPS_FIX_TYPE is called. */
export const fixWord = (fix: number): string => t(`gps.${gpsFix(fix).name}` as MessageKey);
export const percent = (value: Maybe, digits = 0): string => number(value, digits, '%');
export const height = (value_m: Maybe, digits = 0): string =>
  show(value_m, (value) => formatHeight(value, settings.units, settings.locale, digits));
export const speed = (value_m_s: Maybe): string =>
  show(value_m_s, (value) => formatSpeed(value, settings.units, settings.locale));
/** How fast it climbs: `1.2 m/s`, `240 ft/min`. */
export const climb = (value_m_s: Maybe): string =>
  show(value_m_s, (value) => `${climbFigure(value, settings.units, settings.locale)} ${climbSymbol(settings.units)}`);
export const distance = (value_m: Maybe): string =>
  show(value_m, (value) => formatDistance(value, settings.units, settings.locale));
export const windWord = ({ from_deg, speed_m_s }: Wind): string =>
  speed_m_s === 0 ? t('wind.calm') : t('wind.value', { speed: speed(speed_m_s), bearing: bearing(from_deg) });
export const duration = (value_s: Maybe): string => show(value_s, formatDuration);
export const span = (value_s: Maybe): string => show(value_s, formatSpan);

/** An age: tenths while young, then seconds, then minutes. */
export const age = (value_s: Maybe): string =>
  show(value_s, (value) => {
    if (value < 10) return number(value, 1, 's');
    return value < 90 ? number(value, 0, 's') : formatDuration(value);
  });

/** A position as it was chosen to be written: degrees, degrees with minutes and seconds, or UTM. */
export const place = (at: LonLat): string => formatPlace(at, settings.coordinates, projectUtm);

export const lengthUnit = (): string => LENGTH_SYMBOL[settings.units.length];
export const speedUnit = (): string => SPEED_SYMBOL[settings.units.speed];

/** The time of day, with the day when it is not today's. */
export const moment = (at: Date): string =>
  at.toDateString() === new Date().toDateString()
    ? timeOfDay(at)
    : `${at.toLocaleDateString(settings.locale, { dateStyle: 'medium' })}, ${timeOfDay(at)}`;
export const timeOfDay = (at: Date): string =>
  at.toLocaleTimeString(settings.locale, { hour: '2-digit', minute: '2-digit', second: '2-digit', hour12: false });
