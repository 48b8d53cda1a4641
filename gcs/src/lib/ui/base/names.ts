// Names that the server gives in English, in the language in use; those that people gave stay as they are.
import { t, translated } from '$lib/i18n/index.svelte';

/** Between the name of a ground station and that of its operator. */
const AT = ' · ';

/** An operator's name, after that of a ground station elsewhere; or a number for one without a name. */
export const operatorName = (name: string): string =>
  name === ''
    ? t('control.someone')
    : name
        .split(AT)
        .map((part) => translated('control.station', part))
        .join(AT);

/** A map source's name: translated for a preset whose name was not changed. */
export const sourceName = ({ id, name }: { readonly id: string; readonly name: string }): string =>
  translated(`maps.presetName.${id}`, name);
