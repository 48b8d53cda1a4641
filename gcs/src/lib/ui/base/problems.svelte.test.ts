import { expect, test } from 'vitest';
import { i18n } from '$lib/i18n/index.svelte';
import { problemWords } from './problems.svelte';

const problemOf = (cause: object) =>
  problemWords({ type: '', title: '', status: 504, detail: '', cause } as unknown as Parameters<
    typeof problemWords
  >[0]);

test('times are told to a tenth, coordinates as far as they are known', () => {
  const cause = {
    code: 'not-confirmed',
    command: 'DO_SET_MODE',
    wanted: 'mode AUTO',
    observed: 'nothing',
    within_s: 6.1707869,
  };
  expect(problemOf(cause).text).toBe(
    'The vehicle agreed, but after 6.2 s it shows: nothing. It should show: mode AUTO.',
  );
  expect(problemOf({ code: 'not-on-earth', lat_deg: 91.1234567, lon_deg: 0 }).text).toContain('91.1234567');
});

test('swapped coordinates are suspected only of an item that is in reach with them', () => {
  const cause = { code: 'out-of-reach', item: 3, distance_m: 260_000 };
  const remedies = [false, true].map((is_swapped) => problemOf({ ...cause, is_swapped }).remedy);
  expect(remedies.map((remedy) => remedy.includes('swapped'))).toEqual([false, true]);
  expect(remedies).not.toContain('');
});

test('what a vehicle shows is told in the language in use', () => {
  i18n.language = 'es';
  const cause = {
    code: 'not-confirmed',
    command: 'DO_SET_MODE',
    wanted: 'mode AUTO',
    observed: 'nothing',
    within_s: 6.5,
  };
  expect(problemOf(cause).text).toContain('muestra: nada. Debería mostrar: modo AUTO.');
  i18n.language = 'en';
});
