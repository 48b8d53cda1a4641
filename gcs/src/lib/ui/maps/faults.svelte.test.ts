import { afterEach, expect, it } from 'vitest';
import type { Cause, Problem } from '$lib/api/types';
import { i18n } from '$lib/i18n/index.svelte';
import { faultWords, keptWords } from './faults.svelte';

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
    text: 'No se llega a la fuente.',
    why: 'No se conoce el nombre tile.example.org: no hay red, o la dirección está mal.',
    said: '',
  });
  expect(faultWords(problem({ ...offline, why: 'refused' })).why).toBe('tile.example.org rechaza la conexión.');
  expect(faultWords(problem({ code: 'source-timeout', service, waited_s: 15 }))).toMatchObject({
    why: 'tile.example.org no respondió en 15 s.',
    said: '',
  });
});

it('says that an address inside the network was not asked, and by which setting it would be', () => {
  i18n.language = 'es';
  const local = { code: 'source-local', service: '10.0.0.7:8080', is_permissible: true, problem: 'x' } as const;
  const told = { text: 'No se le pregunta: su dirección es de esta red.', said: '' };
  expect(faultWords(problem(local))).toMatchObject(told);
  // of the source's state
  expect(faultWords({ ...problem(local), type: 'urn:vencejo:source-failing' })).toMatchObject(told);
  expect(faultWords(problem(local)).why).toContain('«El servicio está en esta red local»');
  expect(faultWords(problem({ ...local, is_permissible: false })).why).toContain('nunca');
});

it('says that a copy is shown, or that there is none of all, and never both', () => {
  const offline = problem({ code: 'source-offline', service, problem: 'x', retry_s: 5, why: 'refused' });
  expect(keptWords({ problem: offline, isStale: true })).toBe('Tiles from the cache are shown.');
  expect(keptWords({ problem: offline, isStale: false })).toBe('Some tiles here are not in the cache.');
  const status = { type: 'source-offline', title: 'offline', status: 0, detail: '' };
  expect(`${faultWords(status).text} ${keptWords({ problem: status, isStale: true })}`).toBe(
    'The source is not reached. Tiles from the cache are shown.',
  );
  const failed = problem({ code: 'source-failed', service, status: 500, problem: 'x' });
  expect(keptWords({ problem: failed, isStale: false })).toBe('');
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
