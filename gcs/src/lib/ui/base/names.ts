// Names that the server gives in English, in the language in use; those that people gave stay as they are.
import { t, translated } from '$lib/i18n/index.svelte';

/** An operator's name, or a number for one without a name. */
export const operatorName = (name: string): string =>
  name === '' ? t('control.someone') : translated('control.station', name);

/** A map source's name: translated for a preset whose name was not changed. */
export const sourceName = ({ id, name }: { readonly id: string; readonly name: string }): string =>
  translated(`maps.presetName.${id}`, name);
