// What a vehicle is called, everywhere in the page.
import type { VehicleKind } from '$lib/domain/core';
import { t } from '$lib/i18n/index.svelte';

export interface Named {
  readonly systemId: number;
  readonly kind: VehicleKind;
  /** The server's name for one that is far away or recorded; it is unique. */
  readonly remoteName: string | null;
  readonly isRecorded: boolean;
}

/** Its name, in the language in use. Reactive. */
export function vehicleName({ systemId, kind, remoteName, isRecorded }: Named): string {
  const name = remoteName ?? `${t(`vehicle.${kind}`)} ${systemId}`;
  // the server's own word for a recording, and its number where several are alike
  return isRecorded ? t('replay.named', { name: name.replace(/ \(replay( \d+)?\)$/, '$1') }) : name;
}
