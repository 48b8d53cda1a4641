// Sizes and levels as people read them.
import type { MapSource } from '$lib/api/maps-types';
import { groundResolution_m } from '$lib/domain/tiling';
import { formatHeight, formatNumber, type Units } from '$lib/domain/units';

const STEPS = ['B', 'kB', 'MB', 'GB', 'TB'] as const;

/** `3.4 MB`: decimal multiples, as disks are sold. */
export function formatBytes(bytes: number, locale?: string): string {
  const power = Math.min(STEPS.length - 1, bytes < 1 ? 0 : Math.floor(Math.log10(bytes) / 3));
  const value = bytes / 1000 ** power;
  return `${formatNumber(value, power === 0 || value >= 100 ? 0 : 1, locale)} ${STEPS[power]}`;
}

/** How fine a level of a source is on the ground: `0.6 m`. */
export function formatResolution(
  grid: NonNullable<MapSource['grid']>,
  level: number,
  lat_deg: number,
  units: Units,
  locale?: string,
): string {
  const m = groundResolution_m(grid.crs, grid.levels[level]?.resolution ?? Number.NaN, lat_deg);
  return formatHeight(m, units, locale, m < 1 ? 2 : m < 10 ? 1 : 0);
}
