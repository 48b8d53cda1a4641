import { expect, it } from 'vitest';
// The table of commands that the server serves; its names are English.
import table from '../../../../crates/flight/src/plan/command.rs?raw';
import { commandsEs, paramsEs } from './commands.es';

const all = (pattern: RegExp): string[] => [...new Set([...table.matchAll(pattern)].map(([, name]) => name ?? ''))];

it('names every command and parameter of the table in Spanish', () => {
  const [titles, labels] = [all(/title: "([^"]+)"/g), all(/\bp\("([^"]+)"/g)];
  expect(titles.length).toBeGreaterThan(60);
  expect(labels.length).toBeGreaterThan(80);
  expect(titles.filter((title) => !(title in commandsEs))).toEqual([]);
  expect(labels.filter((label) => !(label in paramsEs))).toEqual([]);
});
