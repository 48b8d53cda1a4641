import { describe, expect, it } from 'vitest';
import { en, es, type MessageKey } from './messages';

const placeholders = (text: string) => [...text.matchAll(/\{(\w+)\}/g)].map((match) => match[1]).sort();

describe('texts', () => {
  it('exist in both languages under the same keys', () => {
    expect(Object.keys(en).length).toBeGreaterThan(0);
    expect(Object.keys(es).sort()).toEqual(Object.keys(en).sort());
  });

  it('name buttons as they are called', () => {
    const quoted = { en: /“([^{”]+)”/g, es: /«([^{»]+)»/g };
    const isNoButton = (name: string): boolean => name === '—' || name.startsWith('vencejo ');
    for (const [texts, pattern] of [
      [en, quoted.en],
      [es, quoted.es],
    ] as const)
      for (const [key, text] of Object.entries(texts))
        for (const [, name = ''] of text.matchAll(pattern))
          if (!isNoButton(name)) expect(Object.values(texts), key).toContain(name);
  });

  it('are not empty and take the same values', () => {
    for (const key of Object.keys(en) as MessageKey[]) {
      expect(es[key].trim(), key).not.toBe('');
      expect(en[key].trim(), key).not.toBe('');
      expect(placeholders(es[key]), key).toEqual(placeholders(en[key]));
    }
  });
});
