// Why a source does not come, in the language in use, with what the server or the service said itself.
import { isNoAnswer } from '$lib/api/problem';
import type { Problem } from '$lib/api/types';
import { hasText, t } from '$lib/i18n/index.svelte';

export interface FaultWords {
  readonly text: string;
  /** In the words of the service; empty when it said nothing. */
  readonly said: string;
}

export function faultWords(problem: Problem): FaultWords {
  if (isNoAnswer(problem)) return { text: t('problem.noAnswer'), said: '' };
  const key = `maps.fault.${codeOf(problem)}`;
  if (hasText(key)) return { text: t(key), said: problem.detail };
  return problem.type.startsWith('urn:')
    ? { text: problem.detail || problem.title, said: '' }
    : { text: problem.title, said: problem.detail };
}

const codeOf = (problem: Problem): string => problem.type.replace(/^urn:vencejo:/, '');
