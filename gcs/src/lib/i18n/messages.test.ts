import { describe, expect, it } from 'vitest';
import { en, es, type MessageKey } from './messages';

const placeholders = (text: string) => [...text.matchAll(/\{(\w+)\}/g)].map((match) => match[1]).sort();

describe('texts', () => {
  it('exist in both languages under the same keys', () => {
    expect(Object.keys(en).length).toBeGreaterThan(0);
    expect(Object.keys(es).sort()).toEqual(Object.keys(en).sort());
  });

  it('are not empty and take the same values', () => {
    for (const key of Object.keys(en) as MessageKey[]) {
      expect(es[key].trim(), key).not.toBe('');
      expect(en[key].trim(), key).not.toBe('');
      expect(placeholders(es[key]), key).toEqual(placeholders(en[key]));
    }
  });
});
