import { afterEach, describe, expect, it } from 'vitest';
import { operatorName, sourceName } from '$lib/ui/base/names';
import presets from '../../../../crates/maps/src/presets.rs?raw';
import { i18n } from './index.svelte';
import { en } from './messages';

afterEach(() => (i18n.language = 'en'));

describe('names that the server gives in English', () => {
  it('are said in the language in use', () => {
    expect(operatorName('station 2')).toBe('station 2');
    i18n.language = 'es';
    expect(operatorName('station 2')).toBe('estación 2');
    expect(operatorName('')).toBe('Otro operador');
    expect(sourceName({ id: 'pnoa', name: 'PNOA orthophotos (Spain)' })).toBe('Ortofotos PNOA (España)');
  });

  it('stay as they are when a person gave them', () => {
    i18n.language = 'es';
    for (const name of ['Ana', 'my station 2', 'station', 'station\n2']) expect(operatorName(name)).toBe(name);
    expect(sourceName({ id: 'pnoa', name: 'Our orthophotos' })).toBe('Our orthophotos');
    expect(sourceName({ id: 'field', name: 'station 2' })).toBe('station 2');
  });

  it('are those that the server has', () => {
    const ours = Object.entries(en).filter(([key]) => key.startsWith('maps.presetName.'));
    expect(ours.length).toBeGreaterThan(4);
    expect(ours.filter(([, name]) => !presets.includes(`"${name}"`))).toEqual([]);
  });
});
