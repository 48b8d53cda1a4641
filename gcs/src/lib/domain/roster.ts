// The fleet list: merging row updates, searching, sorting.
import { ATTENTION_FROM } from './core';
import { freshness } from './freshness';

/** What a list shows of a vehicle; null is not known. */
export interface RosterRow {
  readonly id: number;
  readonly remote_name: string | null;
  readonly mav_type: number | null;
  /** Whether it comes from a recording. */
  readonly is_recorded: boolean | null;
  readonly mode: string | null;
  readonly is_armed: boolean | null;
  readonly is_on_ground: boolean | null;
  readonly lat_deg: number | null;
  readonly lon_deg: number | null;
  readonly alt_rel_home_m: number | null;
  readonly heading_deg: number | null;
  readonly airspeed_m_s: number | null;
  readonly battery_pct: number | null;
  /** On the station's clock. */
  readonly heard_s: number | null;
  readonly loss_pct: number | null;
  readonly is_reached: boolean | null;
  readonly is_contested: boolean | null;
  /** The links to a silent autopilot of which the station on board is heard. */
  readonly silence: string | null;
  readonly holder: string | null;
  readonly is_held_here: boolean | null;
  readonly requested_by: string | null;
  readonly is_requested_here: boolean | null;
  readonly is_revoked: boolean | null;
  readonly item: number | null;
  readonly items: number | null;
  readonly is_complete: boolean | null;
  readonly target_off_m: number | null;
  readonly may_be_mixed: boolean | null;
  readonly alarm: { readonly severity: number; readonly text: string; readonly time_s: number } | null;
}

/** A row update: absent fields are unchanged. */
export type RosterChange = { readonly id: number } & {
  readonly [Name in keyof RosterRow]?: RosterRow[Name] | undefined;
};

const NEW: Omit<RosterRow, 'id'> = {
  remote_name: null,
  mav_type: null,
  is_recorded: null,
  mode: null,
  is_armed: null,
  is_on_ground: null,
  lat_deg: null,
  lon_deg: null,
  alt_rel_home_m: null,
  heading_deg: null,
  airspeed_m_s: null,
  battery_pct: null,
  heard_s: null,
  loss_pct: null,
  is_reached: null,
  is_contested: null,
  silence: null,
  holder: null,
  is_held_here: null,
  requested_by: null,
  is_requested_here: null,
  is_revoked: null,
  item: null,
  items: null,
  is_complete: null,
  target_off_m: null,
  may_be_mixed: null,
  alarm: null,
};

/** A row after a change of it. */
export const changedRow = (row: RosterRow | undefined, change: RosterChange): RosterRow =>
  ({ ...(row ?? NEW), ...change }) as RosterRow;

/** Whether another ground station has control of it. */
export const isHeldElsewhere = (row: RosterRow): boolean => row.holder !== null && row.is_held_here === false;

/** Whether another ground station asks for the control that we have of it. */
export const isWanted = (row: RosterRow): boolean => row.is_held_here === true && row.requested_by !== null;

/** Reasons why a vehicle needs attention, the most urgent first. */
const ATTENTION = [
  'lost',
  'silent',
  'target',
  'battery-critical',
  'alarm',
  'unreached',
  'contested',
  'stale',
  'loss',
  'battery-low',
  'mixed',
  'wanted',
  'held',
  'revoked',
  'warning',
] as const;
export type Attention = (typeof ATTENTION)[number];

export const ATTENTION_LEVELS = ['danger', 'warn', 'none'] as const;
/** How urgent it is, the most urgent first. */
export type AttentionLevel = (typeof ATTENTION_LEVELS)[number];

const DANGERS: ReadonlySet<Attention> = new Set([
  'lost',
  'silent',
  'target',
  'battery-critical',
  'alarm',
  'unreached',
  'contested',
]);
/** `MAV_SEVERITY` error; higher numbers are only warnings. */
const ERROR = 3;

/** Reasons why a vehicle with news of this age needs attention, the most urgent first; empty when nothing is wrong, and for a recording. */
export function attentionTo(row: RosterRow, age_s: number | null): Attention[] {
  // nothing can be done about what is past
  if (row.is_recorded === true) return [];
  const fresh = freshness(age_s);
  const { battery_critical_pct, battery_low_pct, loss_high_pct } = ATTENTION_FROM;
  const is: Record<Attention, boolean> = {
    lost: fresh === 'lost' && row.silence === null && row.is_revoked !== true,
    silent: row.silence !== null,
    target: row.target_off_m !== null,
    'battery-critical': row.battery_pct !== null && row.battery_pct < battery_critical_pct,
    alarm: row.alarm !== null && row.alarm.severity <= ERROR,
    unreached: row.is_reached === false && fresh !== 'lost',
    contested: row.is_contested === true,
    stale: fresh === 'stale',
    loss: row.loss_pct !== null && row.loss_pct >= loss_high_pct,
    'battery-low':
      row.battery_pct !== null && row.battery_pct >= battery_critical_pct && row.battery_pct < battery_low_pct,
    mixed: row.may_be_mixed === true,
    wanted: isWanted(row),
    held: isHeldElsewhere(row),
    revoked: row.is_revoked === true,
    warning: row.alarm !== null && row.alarm.severity > ERROR,
  };
  return ATTENTION.filter((reason) => is[reason]);
}

export function levelOf(reasons: readonly Attention[]): AttentionLevel {
  const [first] = reasons;
  if (first === undefined) return 'none';
  return DANGERS.has(first) ? 'danger' : 'warn';
}

/** A row with derived values. */
export interface Listed {
  readonly row: RosterRow;
  readonly name: string;
  readonly age_s: number | null;
  readonly attention: readonly Attention[];
  /** Where it stands among all by name. */
  readonly place: number;
  /** What a search looks through: name, id, mode, holder, texts. */
  readonly words: () => string;
}

/** Whether what is shown of it is old; nothing ages in a recording. */
export function isOld({ row, age_s }: Listed): boolean {
  const fresh = freshness(age_s);
  return row.is_recorded !== true && (row.silence !== null || fresh === 'stale' || fresh === 'lost');
}

const GONE: ReadonlySet<Attention> = new Set(['lost', 'revoked']);
/** Whether it is not heard any more: lost, or out of the fleet. */
export const isGone = ({ attention }: Listed): boolean => attention.some((why) => GONE.has(why));
/** Whether it answers no command. */
export const isMute = (one: Listed): boolean => isGone(one) || one.row.silence !== null;

export type RosterOrder = 'attention' | 'name';

const plain = (text: string): string =>
  text
    .normalize('NFD')
    .replace(/\p{Diacritic}/gu, '')
    .toLowerCase();

/** Those in which every word of `search` is found, without regard to case and accents. */
export function found(listed: readonly Listed[], search: string): Listed[] {
  const words = plain(search)
    .split(/\s+/)
    .filter((word) => word !== '');
  return words.length === 0
    ? [...listed]
    : listed.filter((one) => {
        const text = plain(one.words());
        return words.every((word) => text.includes(word));
      });
}

const rank = ({ attention: [first] }: Listed): number =>
  first === undefined ? ATTENTION.length : ATTENTION.indexOf(first);

/** The place of each among all by name, then by id. */
export function placesByName(named: readonly { readonly id: number; readonly name: string }[]): Map<number, number> {
  const { compare } = new Intl.Collator('en', { numeric: true });
  const sorted = [...named].sort((a, b) => compare(a.name, b.name) || a.id - b.id);
  return new Map(sorted.map(({ id }, place) => [id, place]));
}

/** The most urgent first, or by name alone; those that are alike by name. */
export function inOrder(listed: readonly Listed[], order: RosterOrder): Listed[] {
  const byName = (a: Listed, b: Listed): number => a.place - b.place;
  const compare = order === 'name' ? byName : (a: Listed, b: Listed): number => rank(a) - rank(b) || byName(a, b);
  return [...listed].sort(compare);
}

/** What a vehicle is called in a stored group: its name far away, its system id at a link. */
export const keyOf = (row: RosterRow): string => row.remote_name ?? `#${row.id}`;

/** The same order as before, new rows last, so that no row moves from under the pointer. */
export function keptOrder(before: readonly number[], listed: readonly Listed[]): Listed[] {
  const byId = new Map(listed.map((one) => [one.row.id, one]));
  const kept = before.flatMap((id) => byId.get(id) ?? []);
  const known = new Set(before);
  return [...kept, ...listed.filter(({ row }) => !known.has(row.id))];
}
