// Why a source fails, in the language in use, with the service's own message.
import { isNoAnswer } from '$lib/api/problem';
import type { Cause, Problem } from '$lib/api/types';
import { hasText, t } from '$lib/i18n/index.svelte';

interface FaultWords {
  readonly text: string;
  /** Details from the figures of the cause; empty without any. */
  readonly why: string;
  /** In the words of the service or of the system, mostly English; empty where they would add nothing. */
  readonly said: string;
}

export function faultWords(problem: Problem): FaultWords {
  if (isNoAnswer(problem)) return { text: t('problem.noAnswer'), why: '', said: '' };
  const why = whyOf(problem.cause);
  // a source that fails for this was not asked at all
  const key = `maps.fault.${problem.cause?.code === 'source-local' ? problem.cause.code : codeOf(problem)}`;
  if (hasText(key)) return { text: t(key), why, said: saidOf(problem) };
  return problem.type.startsWith('urn:')
    ? { text: problem.detail || problem.title, why, said: '' }
    : { text: problem.title, why, said: problem.detail };
}

/** What is still shown of a failing source; empty where that is not known. */
export function keptWords({ problem, isStale }: { problem: Problem; isStale: boolean }): string {
  if (isStale) return t('maps.whyStale');
  return codeOf(problem) === 'source-offline' ? t('maps.whyMissing') : '';
}

const codeOf = (problem: Problem): string => problem.type.replace(/^urn:vencejo:/, '');

function whyOf(cause: Cause | undefined): string {
  switch (cause?.code) {
    case 'source-offline': {
      // a newer server may know more reasons
      const key = `maps.why.${cause.why}`;
      return hasText(key) ? t(key, { service: cause.service }) : '';
    }
    case 'source-local':
      return t(cause.is_permissible ? 'maps.why.local' : 'maps.why.localNever', {
        service: cause.service,
        setting: t('maps.localNetwork'),
      });
    case 'source-timeout':
      return t('maps.why.timeout', { service: cause.service, waited_s: cause.waited_s });
    case 'source-failed': {
      const { service, status } = cause;
      if (status == null) return '';
      return t(status === 401 || status === 403 ? 'maps.why.key' : 'maps.why.status', { service, status });
    }
    default:
      return '';
  }
}

/** Remaining details beyond the cause's code and figures. */
function saidOf({ cause, detail }: Problem): string {
  switch (cause?.code) {
    case 'source-offline':
    case 'source-local':
    case 'source-timeout':
    case 'source-key':
    case 'source-busy':
    case 'no-source':
      return '';
    case 'source-failed':
    case 'source-invalid':
      return cause.problem;
    default:
      return detail;
  }
}
