// What the checks found, in the language in use, by the stable code of each finding.
import type { PlanFinding } from '$lib/api/types';
import { findingFigures } from '$lib/domain/finding-figures';
import { hasText, t } from '$lib/i18n/index.svelte';
import { plan } from '$lib/state/plan.svelte';
import { number } from '$lib/ui/base/format.svelte';
import { kindName, paramName } from './names';

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
  const detail = detailOf(finding);
  return {
    text: `${text.charAt(0).toLocaleUpperCase()}${text.slice(1)}${detail === '' ? '' : ` ${detail}`}`,
    remedy: t(remedyKey),
  };
}

/** The figures of a finding, written as the language does. */
function detailOf(finding: PlanFinding): string {
  const key = `finding.${finding.code}.detail`;
  const figures = findingFigures(finding);
  if (figures === null || !hasText(key)) return '';
  const shown = Object.entries(figures).map(([name, value]) => {
    if (name === 'label') return [name, paramName(value)];
    const figure = Number(value);
    return [name, Number.isFinite(figure) ? number(figure, Number.isInteger(figure) ? 0 : 1) : value];
  });
  return t(key, Object.fromEntries(shown));
}
