// Small things that survive a reload. What is read back is untrusted and checked by the caller's `read`.

/** The value stored under `key`, or `fallback` when it is missing or rejected by `read`. */
export function load<T>(key: string, fallback: T, read: (value: unknown) => T | null): T {
  try {
    const text = globalThis.localStorage?.getItem(`vencejo.${key}`);
    if (text == null) return fallback;
    return read(JSON.parse(text)) ?? fallback;
  } catch {
    // Storage may be switched off, or hold what another version wrote.
    return fallback;
  }
}

export function save(key: string, value: unknown): void {
  try {
    globalThis.localStorage?.setItem(`vencejo.${key}`, JSON.stringify(value));
  } catch {
    // Full or switched off: the app works without.
  }
}
