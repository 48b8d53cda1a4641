// Values of parameters and what is told of them, in the language in use.
import type { Parameter } from '$lib/api/types';
import { writeParam } from '$lib/domain/params';
import { unitOf } from '$lib/domain/param-units';
import { i18n, t } from '$lib/i18n/index.svelte';
import { meaningsEn } from '$lib/i18n/param-meanings.en';
import { meaningsEs } from '$lib/i18n/param-meanings.es';
import type { Written } from '$lib/state/param-files.svelte';
import { decimalPoint } from '$lib/state/params.svelte';

const MEANINGS: Record<'en' | 'es', Readonly<Record<string, string>>> = { en: meaningsEn, es: meaningsEs };

/** What the parameter does, where that is known here; empty otherwise. */
export const meaningOf = (name: string): string => MEANINGS[i18n.language][name] ?? '';

/** A value with its unit. */
export function valueWords(value: number, { name, kind }: Pick<Parameter, 'name' | 'kind'>): string {
  const unit = unitOf(name);
  return `${writeParam(value, kind, decimalPoint())}${unit === '' ? '' : unit === '°' ? unit : ` ${unit}`}`;
}

/** How the writing of a file ended. */
export function writtenWords({ set, refused, unheld }: Pick<Written, 'set' | 'refused' | 'unheld'>): string {
  const words = [t(refused > 0 ? 'params.writtenRefused' : 'params.written', { set, refused })];
  if (unheld > 0) words.push(t('params.unheld', { count: unheld }));
  return words.join(' · ');
}
