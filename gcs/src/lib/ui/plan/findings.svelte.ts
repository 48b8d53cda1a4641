// What the checks found, in the language in use, by the stable code of each finding.
import type { PlanFinding } from '$lib/api/types';
import { hasText, t } from '$lib/i18n/index.svelte';
import { plan } from '$lib/state/plan.svelte';
import { kindName } from './names';

export interface FindingWords {
  readonly text: string;
  readonly remedy: string;
}

/** A finding in words; one that is not known here in the server's own English. */
export function findingWords(finding: PlanFinding): FindingWords {
  const key = `finding.${finding.code}`;
  const remedyKey = `${key}.remedy`;
  if (!hasText(key) || !hasText(remedyKey)) return { text: finding.message, remedy: finding.remedy };
  const item = finding.item === null ? undefined : plan.items[finding.item - 1];
  const name =
    item === undefined ? t('finding.home') : t('finding.item', { number: finding.item ?? '', name: kindName(item) });
  const text = t(key, { item: name });
  return { text: text.charAt(0).toLocaleUpperCase() + text.slice(1), remedy: t(remedyKey) };
}
