// What a flight leaves of the battery, in words.
import type { BatteryLeft } from '$lib/api/types';
import { t } from '$lib/i18n/index.svelte';
import { duration, number } from '$lib/ui/base/format.svelte';

/** The charge left and the energy used. Reactive. */
export function batteryTold({ empty_s, left_pct }: BatteryLeft, energy_wh: number | null | undefined): string {
  if (empty_s !== null) return t('battery.none', { time: duration(empty_s) });
  return t('battery.left', { left: number(left_pct, 0, '%'), energy: number(energy_wh, 1, 'Wh') });
}

/** Whether less is left than is to be. */
export const isBelowReserve = (battery: BatteryLeft | null | undefined): boolean =>
  battery != null && battery.left_pct < battery.reserve_pct;
