// Why a source does not come, in the language in use, with what the server or the service said itself.
import { NO_ANSWER } from '$lib/api/problem';
import type { Problem } from '$lib/api/types';
import { hasText, t } from '$lib/i18n/index.svelte';

export interface FaultWords {
  readonly text: string;
  /** In the words of the service; empty when it said nothing. */
  readonly said: string;
}

export function faultWords(problem: Problem): FaultWords {
  const code = problem.status === NO_ANSWER && !problem.type.startsWith('urn:') ? 'no-answer' : codeOf(problem);
  const key = `maps.fault.${code}`;
  if (code === 'no-answer' && problem.title !== 'No answer') return { text: problem.title, said: problem.detail };
  if (!hasText(key)) return { text: problem.detail || problem.title, said: '' };
  return { text: t(key), said: code === 'no-answer' ? '' : problem.detail };
}

const codeOf = (problem: Problem): string => problem.type.replace(/^urn:vencejo:/, '');
