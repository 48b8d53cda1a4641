// The language in use, and `t()`, which every text goes through.
import { messages, type Language, type MessageKey } from './messages';

export type { Language, MessageKey };

const current = $state<{ language: Language }>({ language: 'en' });

export const i18n = {
  get language(): Language {
    return current.language;
  },
  set language(language: Language) {
    current.language = language;
  },
};

/** The text of `key` in the language in use, with `{name}` replaced by `values.name`. Reactive. */
export function t(key: MessageKey, values: Readonly<Record<string, string | number>> = {}): string {
  return fill(messages[current.language][key], values);
}

/** `text` with each `{name}` replaced; a name without a value stays, so that a test can see it. */
export function fill(text: string, values: Readonly<Record<string, string | number>>): string {
  return text.replace(/\{(\w+)\}/g, (whole, name: string) => (name in values ? String(values[name]) : whole));
}

/**
 * What the server says in English, in the language in use where the catalogue has the very same words, but for the values in
 * them; else as it is.
 */
export function translated(key: string, said: string): string {
  if (!hasText(key)) return said;
  const names: string[] = [];
  const parts = messages.en[key].split(/\{(\w+)\}/).map((part, index) => {
    if (index % 2 === 0) return part.replace(/[.*+?^${}()|[\]\\]/g, '\\$&');
    names.push(part);
    return '(.+)';
  });
  const found = new RegExp(`^${parts.join('')}$`).exec(said);
  return found === null ? said : t(key, Object.fromEntries(names.map((name, index) => [name, found[index + 1] ?? ''])));
}

/** Whether `key` is one of the texts: for keys that are put together from what the server says. */
export function hasText(key: string): key is MessageKey {
  return key in messages.en;
}
