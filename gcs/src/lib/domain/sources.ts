/** Sources of map pictures: which are shown, in what order, with what attribution; and what a pasted address is. */

import type { Box } from './tiling';

export interface Attribution {
  readonly text: string;
  readonly url?: string | null;
}

export interface Source {
  readonly id: string;
  readonly name: string;
  readonly role: 'base' | 'overlay' | 'elevation';
  /** Overlays: shown unless hidden by the user. Base maps: the default when none was chosen. */
  readonly visible: boolean;
  /** Outside of them it has nothing; absent: it has the whole world. */
  readonly bounds?: Box | null;
  readonly opacity: number;
  readonly attribution: readonly Attribution[];
}

/** What a person chose to see; a source that is not named is shown as its file says. */
export interface Choice {
  /** Id of the base map, empty for none, `null` for the one that fits the view. */
  readonly base: string | null;
  readonly isShown: Readonly<Record<string, boolean>>;
  readonly opacity: Readonly<Record<string, number>>;
}

export const NO_CHOICE: Choice = { base: null, isShown: {}, opacity: {} };

/** Reads a stored choice; `null` when it is invalid. */
export function readChoice(value: unknown): Choice | null {
  if (typeof value !== 'object' || value === null) return null;
  const { base, isShown, opacity } = value as Record<string, unknown>;
  const record = <T>(from: unknown, isRight: (one: unknown) => one is T): Record<string, T> =>
    typeof from === 'object' && from !== null
      ? Object.fromEntries(Object.entries(from).filter((entry): entry is [string, T] => isRight(entry[1])))
      : {};
  return {
    base: typeof base === 'string' ? base : null,
    isShown: record(isShown, (one): one is boolean => typeof one === 'boolean'),
    opacity: record(opacity, (one): one is number => typeof one === 'number' && one >= 0 && one <= 1),
  };
}

/** A base map that has less of a view than this share leaves most of it empty. */
const LEAST_SHARE = 0.5;

/** The base map that a person chose; `null` where it was none, or is gone. */
export const chosenBaseOf = <S extends Source>(sources: readonly S[], choice: Choice): S | null =>
  sources.find((source) => source.role === 'base' && source.id === choice.base) ?? null;

/**
 * The base map in use: the one chosen; else the first visible one that has most of the view, so that one of a country is
 * shown in that country and one of the world elsewhere. While the view is not known, one of the world.
 */
export function baseOf<S extends Source>(sources: readonly S[], choice: Choice, view: Box | null): S | null {
  if (choice.base === '') return null;
  const offered = sources.filter((source) => source.role === 'base' && source.visible);
  const share = (source: S): number => (source.bounds == null ? 1 : view === null ? 0 : shareOf(view, source.bounds));
  const most = Math.max(...offered.map(share));
  return (
    chosenBaseOf(sources, choice) ?? offered.find((source) => share(source) >= Math.min(LEAST_SHARE, most)) ?? null
  );
}

/** How much of a view lies within bounds, 0 to 1, counted in degrees. Either may lie across the date line. */
export function shareOf(view: Box, bounds: Box): number {
  const overlap = (fromA: number, toA: number, fromB: number, toB: number): number =>
    Math.max(0, Math.min(toA, toB) - Math.max(fromA, fromB));
  const width_deg = eastOf(view) - view.west_deg;
  const height_deg = view.north_deg - view.south_deg;
  if (!(width_deg > 0 && height_deg > 0)) return 0;
  const across_deg = [-360, 0, 360]
    .map((turn) => overlap(view.west_deg, eastOf(view), bounds.west_deg + turn, eastOf(bounds) + turn))
    .reduce((sum, part) => sum + part, 0);
  const up_deg = overlap(view.south_deg, view.north_deg, bounds.south_deg, bounds.north_deg);
  return Math.min(1, across_deg / width_deg) * (up_deg / height_deg);
}

const eastOf = ({ west_deg, east_deg }: Box): number => (east_deg < west_deg ? east_deg + 360 : east_deg);

export const isShown = (source: Source, choice: Choice): boolean => choice.isShown[source.id] ?? source.visible;
export const opacityOf = (source: Source, choice: Choice): number => choice.opacity[source.id] ?? source.opacity;

/** What is drawn, bottom to top. */
export function stackOf<S extends Source>(
  sources: readonly S[],
  choice: Choice,
  base: S | null,
): { source: S; opacity: number }[] {
  const overlays = sources.filter((source) => source.role === 'overlay' && isShown(source, choice));
  return [...(base === null ? [] : [base]), ...overlays].map((source) => ({
    source,
    opacity: opacityOf(source, choice),
  }));
}

/** All attributions, each once, in the order of the sources from the top: what covers most of the map comes first. */
export function attributionsOf(sources: readonly { attribution: readonly Attribution[] }[]): Attribution[] {
  const found = new Map<string, Attribution>();
  for (const one of sources.toReversed().flatMap((source) => source.attribution)) {
    if (one.text.trim() !== '' && !found.has(one.text)) found.set(one.text, one);
  }
  return [...found.values()];
}

/** A link to a page, never a script: `null` for anything but http and https. */
export function pageLink(url: string | null | undefined): string | null {
  return url != null && /^https?:\/\//i.test(url) ? url : null;
}

/** What a kind of source says of addresses and files of it. */
interface KindSigns<Kind extends string> {
  readonly kind: Kind;
  readonly address_signs: readonly string[];
  readonly file_ends: readonly string[];
}

/**
 * What kind of source an address or a file's name is, as far as it shows; `null` when it does not. Placeholders tell most, then what a
 * query says, then the end of a file's name, and words of the path least.
 */
export function guessKind<Kind extends string>(text: string, kinds: readonly KindSigns<Kind>[]): Kind | null {
  const address = text.trim().toLowerCase();
  const [path = ''] = address.split(/[?#]/);
  const bySign = (isOf: (sign: string) => boolean, within: string) =>
    kinds.find(({ address_signs }) => address_signs.some((sign) => isOf(sign) && within.includes(sign)));
  const found =
    bySign((sign) => sign.startsWith('{'), address) ??
    bySign((sign) => sign.includes('='), address) ??
    kinds.find(({ file_ends }) => file_ends.some((end) => path.endsWith(end))) ??
    bySign(() => true, path);
  return found?.kind ?? null;
}

/** A free id for a new source, made of its name in lower-case ASCII letters. */
export function newId(name: string, taken: ReadonlySet<string>): string {
  const plain =
    name
      .normalize('NFD')
      .replace(/\p{M}/gu, '')
      .toLowerCase()
      .replace(/[^a-z0-9]+/g, '-')
      .replace(/^-+|-+$/g, '')
      .slice(0, 34)
      .replace(/-+$/, '') || 'map';
  for (let number = 1; ; number += 1) {
    const id = number === 1 ? plain : `${plain}-${number}`;
    if (!taken.has(id)) return id;
  }
}

/** The ids with one moved by `by` places, clamped to the ends. */
export function moved(ids: readonly string[], id: string, by: number): string[] {
  const from = ids.indexOf(id);
  if (from < 0) return [...ids];
  const rest = ids.filter((one) => one !== id);
  return rest.toSpliced(Math.max(0, Math.min(rest.length, from + by)), 0, id);
}
