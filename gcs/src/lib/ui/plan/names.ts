// What items, commands and their parameters are called, in the language in use.
import { type CommandInfo, commandInfo } from '$lib/domain/core';
import { kindOf, type PlanItem } from '$lib/domain/plan';
import { commandsEs, paramsEs } from '$lib/i18n/commands.es';
import { hasText, i18n, t } from '$lib/i18n/index.svelte';

/** Name of an item's kind; rarer commands by the title in the core's table. Reactive. */
export function kindName(item: PlanItem): string {
  const kind = kindOf(item);
  if (kind !== 'other') return t(`kind.${kind}`);
  const known = commandInfo(item.command);
  if (known !== undefined) return titleOf(known);
  return item.name.replace(/^MAV_CMD_/, '') || t('kind.other', { number: item.command });
}

function titleOf({ title }: CommandInfo): string {
  return i18n.language === 'es' ? (commandsEs[title] ?? title) : title;
}

/** Name of a command, with what an ordinary ArduPlane makes of it. */
export function commandName(command: CommandInfo): string {
  const name = titleOf(command);
  if (command.support === 'ignored') return t('plan.ignored', { name });
  return command.support === 'needs_vtol' ? t('plan.needsVtol', { name }) : name;
}

/** Name of a parameter that the core's table gives in English. */
export const paramName = (label: string): string => (i18n.language === 'es' ? (paramsEs[label] ?? label) : label);

/** What a complex item is called, such as a survey. Reactive. */
export function complexName(kind: string): string {
  const key = `complex.${kind}`;
  return hasText(key) ? t(key) : kind;
}

/** "Items 4 to 65", by their numbers. Reactive. */
export function rangeOf(first: number, last: number): string {
  return first === last ? t('plan.number', { number: first }) : t('survey.items', { first, last });
}
