import { afterEach, expect, it } from 'vitest';
import type { Cause, Problem } from '$lib/api/types';
import { i18n } from '$lib/i18n/index.svelte';
import { faultWords } from './faults.svelte';

afterEach(() => (i18n.language = 'en'));

const problem = (cause: Cause): Problem => ({
  type: `urn:vencejo:${cause.code}`,
  title: 'A title',
  status: 502,
  detail: 'what the server says in English',
  cause,
});
const service = 'tile.example.org';

it('says by code and figures why a source does not come, and nothing of it in English', () => {
  i18n.language = 'es';
  const offline = { code: 'source-offline', service, problem: 'failed to lookup address', retry_s: 5 } as const;
  expect(faultWords(problem({ ...offline, why: 'name_unknown' }))).toEqual({
    text: 'No hay red, y de este lugar no hay nada guardado.',
    why: 'No se conoce el nombre tile.example.org: no hay red, o la dirección está mal.',
    said: '',
  });
  expect(faultWords(problem({ ...offline, why: 'refused' })).why).toBe('tile.example.org rechaza la conexión.');
  expect(faultWords(problem({ code: 'source-timeout', service, waited_s: 15 }))).toMatchObject({
    why: 'tile.example.org no respondió en 15 s.',
    said: '',
  });
});

it('adds what a service says itself', () => {
  const failed = (status: number | null) =>
    faultWords(problem({ code: 'source-failed', service, status, problem: 'Invalid layer(s)' }));
  expect(failed(403)).toMatchObject({ said: 'Invalid layer(s)' });
  expect(failed(403).why).toContain('check the key');
  expect(failed(500).why).toBe('tile.example.org answers with HTTP status 500.');
  expect(failed(null)).toMatchObject({ why: '', said: 'Invalid layer(s)' });
});

it('says what it can of a reason that it does not know', () => {
  const newer = { code: 'source-offline', service, problem: 'x', retry_s: 5, why: 'sunspots' } as unknown as Cause;
  expect(faultWords(problem(newer))).toMatchObject({ why: '' });
  const set_aside = { type: 'urn:vencejo:source-set_aside', title: 'set_aside', status: 0, detail: '' };
  expect(faultWords(set_aside)).toMatchObject({ why: '', said: '' });
});
