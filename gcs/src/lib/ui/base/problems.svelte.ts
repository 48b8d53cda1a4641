// What went wrong, in the language in use: by the stable code and the fields of the cause that the server gives with a problem.
// A code without a translation, as from a newer server, falls back to the server's English.
import { isNoAnswer } from '$lib/api/problem';
import type { Problem } from '$lib/api/types';
import { hasText, t, translated, type MessageKey } from '$lib/i18n/index.svelte';
import { settings } from '$lib/state/settings.svelte';
import { distance } from './format.svelte';
import { operatorName } from './names';

interface ProblemWords {
  readonly text: string;
  /** What the server adds in English words, where a cause holds some; empty otherwise. */
  readonly said: string;
  /** What to do; empty when that is not known. */
  readonly remedy: string;
}

type Fields = Readonly<Record<string, unknown>>;

/** Fields of a cause that hold English words. */
const WORDS = ['problem', 'expected', 'wanted', 'observed', 'reason', 'step', 'what', 'action'] as const;
/** Causes whose text contains these words already. */
const TOLD = new Set([
  'recorder',
  'not-found',
  'not-confirmed',
  'plan-unknown',
  'only-mission',
  'too-many',
  'command-refused',
  'source-local',
]);
/** What a vehicle shows, or should. */
const SHOWN = ['armed', 'disarmed', 'nothing', 'effect', 'beginning', 'idle', 'mode', 'item'] as const;

export function problemWords(problem: Problem): ProblemWords {
  if (isNoAnswer(problem)) return { text: t('problem.noAnswer'), said: '', remedy: '' };
  const cause = causeOf(problem);
  const key = `problem.${cause?.['code'] ?? ''}`;
  if (cause === null || !hasText(key)) {
    return { text: problem.detail || problem.title, said: '', remedy: problem.remedy ?? '' };
  }
  const remedyKey = [`${key}.${variantOf(cause)}.remedy`, `${key}.remedy`].find(hasText);
  const said = TOLD.has(String(cause['code']))
    ? ''
    : WORDS.map((name) => cause[name])
        .filter(isText)
        .join(' · ');
  return { text: t(key, wordsOf(cause)), said, remedy: remedyKey === undefined ? '' : t(remedyKey, wordsOf(cause)) };
}

function causeOf(problem: Problem): Fields | null {
  const { cause } = problem as { cause?: unknown };
  return typeof cause === 'object' && cause !== null ? (cause as Fields) : null;
}

/** Variant of a cause's remedy: a flag that is set. */
const variantOf = (cause: Fields): string =>
  Object.keys(cause)
    .find((name) => cause[name] === true)
    ?.replaceAll('_', '-') ?? '';

const isText = (value: unknown): value is string => typeof value === 'string' && value !== '';

/** The fields as they are put into a text: names in the language in use, numbers as they are written in it. */
function wordsOf(cause: Fields): Record<string, string> {
  const named: Readonly<Record<string, string>> = {
    act: 'danger',
    plan: 'planName',
    what: 'thing',
    result: 'mavResult',
  };
  return Object.fromEntries(
    Object.entries(cause).map(([name, value]) => {
      const key = `${named[name] ?? ''}.${String(value)}`;
      if (hasText(key)) return [name, t(key)];
      if (typeof value === 'number') return [name, name === 'distance_m' ? distance(value) : numberOf(name, value)];
      if (name === 'wanted' || name === 'observed') return [name, shownWords(String(value))];
      if (name === 'holder' && typeof value === 'string') return [name, operatorName(value)];
      return [name, value === null ? t('value.none') : String(value)];
    }),
  );
}

/** Replaces by the first matching text; results are not looked up again, so a mode may have any name. */
function shownWords(said: string): string {
  for (const shown of SHOWN) {
    const words = translated(`shown.${shown}`, said);
    if (words !== said) return words;
  }
  return said;
}

/** Times and speeds to a tenth; possible coordinates with all their digits. */
function numberOf(name: string, value: number): string {
  return value.toLocaleString(settings.locale, { maximumFractionDigits: name.endsWith('_s') ? 1 : 7 });
}

/** A word of a closed list that the server gives in English; unknown words are shown as they are. */
export function wordOf(list: 'system' | 'failing' | 'uncertainty', word: string): string {
  const key = `${list}.${word}`;
  return hasText(key) ? t(key as MessageKey) : word;
}
