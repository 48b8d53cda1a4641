import { expect, it } from 'vitest';
import { COMMANDS, gpsFix } from '$lib/domain/core';
import { en, es } from './messages';
import { commandsEs, paramsEs } from './commands.es';

it('has words for every choice and GPS fix of the core', () => {
  const words = COMMANDS.flatMap(({ params }) => params.flatMap(({ choices }) => choices)).map(({ word }) => word);
  const fixes = [...Array(10).keys()].map((fix) => gpsFix(fix).name);
  expect([new Set(words).size, new Set(fixes).size]).toEqual([22, 10]);
  const keys = [...words.map((word) => `choice.${word}`), ...fixes.map((name) => `gps.${name}`)];
  expect(keys.filter((key) => !(key in en) || !(key in es))).toEqual([]);
});

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
