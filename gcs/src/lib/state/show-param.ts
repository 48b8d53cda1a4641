// Parameters that are named elsewhere in the page.
import { NAMED } from '$lib/domain/params';
import { layout } from './layout.svelte';
import { paramFiles } from './param-files.svelte';
import { params } from './params.svelte';

/** Whether a word is the name of a parameter of the selected vehicle, as far as that is known. Reactive. */
export const isParam = (name: string): boolean =>
  params.selected !== null && (params.selected.get(name) !== undefined || NAMED.has(name));

/** Opens the panel of the parameters with this one. The comparison with a file gives way to it, unless that is being written. */
export function showParam(name: string): void {
  if (paramFiles.writing === null) paramFiles.close();
  params.search = name;
  params.selected?.want(name);
  layout.open('params');
}
