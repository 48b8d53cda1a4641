// What the checks found, in the language and units in use, by the stable code of each finding and its figures.
import type { FindingFix, PlanFinding } from '$lib/api/types';
import { hasText, t } from '$lib/i18n/index.svelte';
import { plan } from '$lib/state/plan.svelte';
import { bearing, distance, duration, height, number, speed } from '$lib/ui/base/format.svelte';
import { kindName, paramName } from './names';

interface FindingWords {
  readonly text: string;
  readonly remedy: string;
}

type Figures = Readonly<Record<string, unknown>>;

/** Figures that distinguish findings of one code. */
const TELLING = ['wanted', 'missing', 'fault'] as const;

/** A finding in words; one that is not known here in the server's own English. */
export function findingWords(finding: PlanFinding): FindingWords {
  // an older server sends none
  const figures: Figures = finding.figures ?? {};
  const variant = variantOf(figures);
  const text = firstText([`finding.${finding.code}.${variant}`, `finding.${finding.code}`]);
  const remedy = firstText([`finding.${finding.code}.${variant}.remedy`, `finding.${finding.code}.remedy`]);
  if (text === undefined || remedy === undefined) return { text: finding.message, remedy: finding.remedy };
  const values = { ...shownFigures(figures), item: subjectOf(finding, figures) };
  const told = t(text, values);
  return { text: `${told.charAt(0).toLocaleUpperCase()}${told.slice(1)}`, remedy: t(remedy, values) };
}

/** What a remedy changes; one that is not known here in the server's own English. */
export function fixWords(fix: FindingFix): string {
  const key = `fix.${fix.does}`;
  const change = hasText(key) ? t(key, { ...shownFigures(fix.with), number: fix.first_item }) : fix.message;
  return t('fix.do', { change });
}

const firstText = (keys: readonly string[]) => keys.find(hasText);

/** Variant of a finding's code: a word, or a flag that is set. */
function variantOf(figures: Figures): string {
  for (const name of TELLING) if (typeof figures[name] === 'string') return figures[name];
  const flag = Object.keys(figures).find((name) => figures[name] === true);
  return flag?.replaceAll('_', '-') ?? '';
}

function subjectOf({ item: number }: PlanFinding, figures: Figures): string {
  const item = number === null ? undefined : plan.items[number - 1];
  if (number !== null) return t('finding.item', { number, name: item === undefined ? '?' : kindName(item) });
  const { rally_point: rally, fence_zone: zone } = figures;
  if (typeof rally === 'number') return t('finding.rally', { number: rally });
  if (zone === undefined) return t('finding.home');
  return typeof zone === 'number' ? t('finding.zone', { number: zone }) : t('finding.returnPoint');
}

/** Figures as the language and the units in use write them. */
function shownFigures(figures: Figures): Record<string, string> {
  const unit = typeof figures['unit'] === 'string' ? figures['unit'] : '';
  return Object.fromEntries(Object.entries(figures).map(([name, value]) => [name, shown(name, value, unit)]));
}

/** Parameters of an item, in the unit that the finding names. */
const OF_ITEM = new Set(['value', 'kept', 'min', 'max']);
/** Lengths that lie upwards. */
const HEIGHTS = new Set(['alt_m', 'alt_rel_home_m', 'drop_m', 'difference_m', 'clearance_m', 'wanted_m']);

function shown(name: string, value: unknown, unit: string): string {
  if (name === 'datum') return value === null ? '' : t(`finding.datum.${value as 'amsl' | 'home' | 'terrain'}`);
  if (value === null && (name === 'min' || name === 'max')) return '…';
  if (typeof value === 'string') return name === 'label' ? paramName(value) : value;
  if (typeof value !== 'number') return t('value.none');
  if (name === 'course_deg') return bearing(value);
  if (HEIGHTS.has(name)) return height(value, isWhole(value) ? 0 : 1);
  if (name.endsWith('_m')) return distance(value);
  if (name.endsWith('_m_s')) return speed(value);
  if (name.endsWith('_pct')) return number(value, 0, '%');
  if (name.endsWith('_wh')) return number(value, 0, 'Wh');
  if (name.endsWith('_s')) return duration(value);
  if (!OF_ITEM.has(name)) return number(value, isWhole(value) ? 0 : 1);
  if (unit === 'm') return height(value, isWhole(value) ? 0 : 1);
  return unit === 'm/s' ? speed(value) : number(value, isWhole(value) ? 0 : 2, unit);
}

const isWhole = (value: number): boolean => Math.abs(value - Math.round(value)) < 1e-9;
