import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import early from '../../../public/theme.js?raw';

const root = { dataset: {} as { theme?: string } };
let system: EventTarget & { matches: boolean };
let kept: Record<string, string> = {};

beforeEach(() => {
  kept = {};
  system = Object.assign(new EventTarget(), { matches: true });
  vi.resetModules();
  vi.stubGlobal('matchMedia', () => system);
  vi.stubGlobal('document', { documentElement: root });
  vi.stubGlobal('localStorage', {
    getItem: (key: string) => kept[key] ?? null,
    setItem: (key: string, value: string) => (kept[key] = value),
  });
});
afterEach(() => vi.unstubAllGlobals());

function systemIs(theme: 'dark' | 'light'): void {
  system.matches = theme === 'dark';
  system.dispatchEvent(new Event('change'));
}

describe('the theme', () => {
  const cases: [string | null, string, string][] = [
    [null, 'dark', 'light'],
    ['{"theme":"system"}', 'dark', 'light'],
    ['{"theme":"dark"}', 'dark', 'dark'],
    ['{"theme":"light"}', 'light', 'light'],
    ['{"theme":"mauve"}', 'dark', 'light'],
    ['nonsense', 'dark', 'light'],
  ];
  it.each(cases)('stored as %s is the same before the first paint and after', async (stored, dark, light) => {
    if (stored !== null) kept['vencejo.settings'] = stored;
    for (const [theme, expected] of [
      ['dark', dark],
      ['light', light],
    ] as const) {
      systemIs(theme);
      new Function(early)();
      vi.resetModules();
      const { settings } = await import('./settings.svelte');
      expect([root.dataset.theme, settings.shownTheme]).toEqual([expected, expected]);
    }
  });

  it('follows the system until one is chosen', async () => {
    systemIs('dark');
    const { settings } = await import('./settings.svelte');
    systemIs('light');
    expect([settings.theme, settings.shownTheme]).toEqual(['system', 'light']);
    settings.theme = 'light';
    systemIs('dark');
    expect(settings.shownTheme).toBe('light');
    settings.theme = 'system';
    expect(settings.shownTheme).toBe('dark');
  });
});
