// What items are called.
import { kindOf, type PlanItem } from '$lib/domain/plan';
import { t } from '$lib/i18n/index.svelte';
import { plan } from '$lib/state/plan.svelte';

/** Name of an item's kind; rare commands by the title that the server gives them. Reactive. */
export function kindName(item: PlanItem): string {
  const kind = kindOf(item);
  if (kind !== 'other') return t(`kind.${kind}`);
  const known = plan.commands.find((command) => command.number === item.command);
  return known?.title ?? (item.name.replace(/^MAV_CMD_/, '') || t('kind.other', { number: item.command }));
}
