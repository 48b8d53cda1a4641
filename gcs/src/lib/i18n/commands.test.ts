import { expect, it } from 'vitest';
import { COMMANDS } from '$lib/domain/core';
import { commandsEs, paramsEs } from './commands.es';

it('names every command and parameter of the core in Spanish', () => {
  const titles = COMMANDS.map(({ title }) => title);
  const labels = new Set(
    COMMANDS.flatMap(({ params }) => params.map(({ label }) => label)).filter((one) => one !== ''),
  );
  expect(titles.length).toBeGreaterThan(60);
  expect(labels.size).toBeGreaterThan(80);
  expect(titles.filter((title) => !(title in commandsEs))).toEqual([]);
  expect([...labels].filter((label) => !(label in paramsEs))).toEqual([]);
});
