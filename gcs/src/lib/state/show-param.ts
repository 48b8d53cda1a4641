// Parameters that are named elsewhere in the page.
import { NAMED } from '$lib/domain/params';
import { layout } from './layout.svelte';
import { params } from './params.svelte';

/** Whether a word is the name of a parameter of the selected vehicle, as far as that is known. Reactive. */
export const isParam = (name: string): boolean =>
  params.selected !== null && (params.selected.get(name) !== undefined || NAMED.has(name));

/** Opens the panel of the parameters with this one. */
export function showParam(name: string): void {
  params.search = name;
  params.selected?.begin(name);
  layout.open('params');
}
