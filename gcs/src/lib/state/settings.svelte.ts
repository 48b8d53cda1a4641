// What a person chose: theme, language, units, rate. Survives a reload.
import { type CoordinateFormat, COORDINATES } from '$lib/domain/coordinates';
import type { LengthUnit, SpeedUnit, Units } from '$lib/domain/units';
import { i18n, type Language } from '$lib/i18n/index.svelte';
import { load, save } from './stored';

export type Theme = 'dark' | 'light';
/** Themes to choose from; `system` follows the browser's. */
export const THEMES = ['system', 'dark', 'light'] as const;
export type ThemeChoice = (typeof THEMES)[number];

/** Telemetry rates on offer, in Hz. */
export const RATES_HZ = [2, 5, 10, 20, 50] as const;

interface Chosen {
  theme: ThemeChoice;
  language: Language;
  length: LengthUnit;
  speed: SpeedUnit;
  coordinates: CoordinateFormat;
  rate_hz: number;
}

const oneOf = <T>(value: unknown, choices: readonly T[], fallback: T): T =>
  choices.includes(value as T) ? (value as T) : fallback;

const browserLanguage = (languages: readonly string[]): Language =>
  languages
    .find((tag) => /^(en|es)\b/i.test(tag))
    ?.toLowerCase()
    .startsWith('es')
    ? 'es'
    : 'en';

const defaults: Chosen = {
  theme: 'system',
  language: browserLanguage(globalThis.navigator?.languages ?? []),
  length: 'm',
  speed: 'm_s',
  coordinates: 'decimal',
  rate_hz: 20,
};

function read(value: unknown): Chosen | null {
  if (typeof value !== 'object' || value === null) return null;
  const stored = value as Partial<Record<keyof Chosen, unknown>>;
  return {
    theme: oneOf(stored.theme, THEMES, defaults.theme),
    language: oneOf(stored.language, ['en', 'es'] as const, defaults.language),
    length: oneOf(stored.length, ['m', 'ft'] as const, defaults.length),
    speed: oneOf(stored.speed, ['m_s', 'kt', 'km_h'] as const, defaults.speed),
    coordinates: oneOf(stored.coordinates, COORDINATES, defaults.coordinates),
    rate_hz: oneOf(stored.rate_hz, RATES_HZ, defaults.rate_hz as (typeof RATES_HZ)[number]),
  };
}

class Settings {
  #chosen = $state<Chosen>(load('settings', defaults, read));
  #systemTheme = $state<Theme>('dark');
  /** The theme in use. */
  shownTheme = $derived(this.#chosen.theme === 'system' ? this.#systemTheme : this.#chosen.theme);

  constructor() {
    i18n.language = this.#chosen.language;
    const dark = globalThis.matchMedia?.('(prefers-color-scheme: dark)');
    const follow = (): void => void (this.#systemTheme = dark.matches ? 'dark' : 'light');
    dark?.addEventListener('change', follow);
    if (dark !== undefined) follow();
  }

  /** The theme that was chosen. */
  get theme(): ThemeChoice {
    return this.#chosen.theme;
  }
  set theme(theme: ThemeChoice) {
    this.#set({ theme });
  }
  get language(): Language {
    return this.#chosen.language;
  }
  set language(language: Language) {
    i18n.language = language;
    this.#set({ language });
  }
  get units(): Units {
    return { length: this.#chosen.length, speed: this.#chosen.speed };
  }
  set units(units: Units) {
    this.#set(units);
  }
  get coordinates(): CoordinateFormat {
    return this.#chosen.coordinates;
  }
  set coordinates(coordinates: CoordinateFormat) {
    this.#set({ coordinates });
  }
  get rate_hz(): number {
    return this.#chosen.rate_hz;
  }
  set rate_hz(rate_hz: number) {
    this.#set({ rate_hz });
  }
  /** How numbers and times are written. */
  get locale(): string {
    return this.#chosen.language === 'es' ? 'es-ES' : 'en-GB';
  }

  #set(change: Partial<Chosen>): void {
    Object.assign(this.#chosen, change);
    save('settings', $state.snapshot(this.#chosen));
  }
}

export const settings = new Settings();
