// Parameters of a vehicle: their types, how values are written and typed, groups by prefix, and comparison with a file.
import type { FileParameter, Parameter } from '$lib/api/types';

/** Smallest and largest value of each integer type. */
const INTEGERS: Readonly<Record<string, readonly [min: number, max: number]>> = {
  uint8: [0, 255],
  int8: [-128, 127],
  uint16: [0, 65_535],
  int16: [-32_768, 32_767],
  uint32: [0, 4_294_967_295],
  int32: [-2_147_483_648, 2_147_483_647],
};
const MAX_REAL32 = 3.4028234663852886e38;
/** Digits that distinguish every two numbers of 32 bits. */
const REAL32_DIGITS = 9;
/** Digits that most files are written with, and the relative difference up to which such a value may be the vehicle's: zeros at its end
 * are not counted, so it may have been written with more digits than it shows. */
const FEW_DIGITS = 7;
const SAME_IN_FILE = 1e-6;

export const isWholeType = (kind: string): boolean => kind in INTEGERS;
export const rangeOf = (kind: string): readonly [min: number, max: number] =>
  INTEGERS[kind] ?? [-MAX_REAL32, MAX_REAL32];

/** The value with as many digits as its type has: 0.1 is not 0.10000000149011612. */
export function writeParam(value: number, kind: string, decimalPoint = '.'): string {
  return shortest(value, kind).replace('.', decimalPoint);
}

function shortest(value: number, kind: string): string {
  if (isWholeType(kind)) return String(value);
  for (let digits = 1; digits < REAL32_DIGITS; digits += 1) {
    const rounded = Number(value.toPrecision(digits));
    if (Math.fround(rounded) === Math.fround(value)) return String(rounded);
  }
  return String(Number(value.toPrecision(REAL32_DIGITS)));
}

/** What was typed for a parameter: the value to send, or why it cannot be. */
export type TypedParam =
  | { readonly value: number; readonly fault: null }
  | { readonly value: null; readonly fault: 'number' | 'whole' | 'range' };

/** Reads what a person typed, with a decimal comma or point. An integer has neither: 1.500 may mean fifteen hundred. */
export function readParam(text: string, kind: string): TypedParam {
  const fault = (fault: 'number' | 'whole' | 'range'): TypedParam => ({ value: null, fault });
  const plain = text.trim().replace('−', '-').replace(',', '.');
  if (!/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d{1,3})?$/i.test(plain)) return fault('number');
  const value = Number(plain);
  if (isWholeType(kind) && (plain.includes('.') || !Number.isInteger(value))) return fault('whole');
  const [min, max] = rangeOf(kind);
  return value >= min && value <= max ? { value, fault: null } : fault('range');
}

/** Whether a vehicle that keeps 32 bits keeps both values as the same. */
export function isSameValue(a: number, b: number, kind: string): boolean {
  return isWholeType(kind) ? a === b : Math.fround(a) === Math.fround(b);
}

/** Whether a file's value is the vehicle's, written with the digits that the file has. */
export function isSameInFile(inFile: number, onVehicle: number, kind: string): boolean {
  if (isSameValue(inFile, onVehicle, kind)) return true;
  if (isWholeType(kind)) return false;
  const [mantissa = ''] = Math.abs(inFile).toExponential().split('e');
  const digits = mantissa.replace('.', '').length;
  if (digits > FEW_DIGITS) return Number(onVehicle.toPrecision(digits)) === inFile;
  return Math.abs(inFile - onVehicle) <= SAME_IN_FILE * Math.max(Math.abs(inFile), Math.abs(onVehicle));
}

/** Whether the value is another than the default; `null`: the vehicle gives no default. */
export const isChanged = ({ value, default: usual, kind }: Parameter): boolean | null =>
  usual == null ? null : !isSameValue(value, usual, kind);

/** Whether each word of a search is in the name or in what is told of it. */
export function matches(search: string, name: string, meaning: string): boolean {
  const text = `${name} ${meaning}`.toLocaleLowerCase();
  return search
    .toLocaleLowerCase()
    .split(/\s+/)
    .every((word) => text.includes(word));
}

/** What a parameter is grouped under: its first word without a number. SERVO3_TRIM is with SERVO1_MIN. */
export const prefixOf = (name: string): string => (name.split('_', 1)[0] ?? name).replace(/\d+$/, '') || name;

export interface ParamGroup {
  /** Its prefix; empty: the parameters that are alone with theirs. */
  readonly prefix: string;
  readonly params: readonly Parameter[];
}

/** The order of names: numbers in them count as numbers. */
const collator = new Intl.Collator('en', { numeric: true });
export const byName = (a: { name: string }, b: { name: string }): number => collator.compare(a.name, b.name);

/** Groups by prefix, in order; the single ones last. `prefixes` are those of all parameters, so that a search moves none. */
export function groupsOf(params: readonly Parameter[], prefixes: ReadonlyMap<string, number>): ParamGroup[] {
  const groups = new Map<string, Parameter[]>();
  for (const param of params) {
    const prefix = prefixOf(param.name);
    const key = (prefixes.get(prefix) ?? 0) > 1 ? prefix : '';
    const group = groups.get(key);
    if (group === undefined) groups.set(key, [param]);
    else group.push(param);
  }
  return [...groups]
    .map(([prefix, params]) => ({ prefix, params }))
    .sort((a, b) => Number(a.prefix === '') - Number(b.prefix === '') || collator.compare(a.prefix, b.prefix));
}

/** How many parameters have each prefix. */
export function countPrefixes(params: Iterable<Parameter>): ReadonlyMap<string, number> {
  const counts = new Map<string, number>();
  for (const { name } of params) counts.set(prefixOf(name), (counts.get(prefixOf(name)) ?? 0) + 1);
  return counts;
}

/** A parameter of a file beside the vehicle's. */
export interface ParamDifference {
  readonly name: string;
  readonly inFile: number;
  readonly onVehicle: Parameter;
}

export interface ParamComparison {
  readonly differing: readonly ParamDifference[];
  readonly equal: number;
  /** Names that the vehicle does not have. */
  readonly unknown: readonly string[];
  /** Of what is named twice, the last counts. */
  readonly repeated: readonly string[];
}

export function compareParams(
  file: readonly FileParameter[],
  vehicle: ReadonlyMap<string, Parameter>,
): ParamComparison {
  const inFile = new Map(file.map(({ name, value }) => [name.toUpperCase(), value]));
  const unknown: string[] = [];
  const differing: ParamDifference[] = [];
  for (const [name, value] of inFile) {
    const onVehicle = vehicle.get(name);
    if (onVehicle === undefined) unknown.push(name);
    else if (!isSameInFile(value, onVehicle.value, onVehicle.kind)) differing.push({ name, inFile: value, onVehicle });
  }
  const names = file.map(({ name }) => name.toUpperCase());
  return {
    differing: differing.sort(byName),
    equal: inFile.size - differing.length - unknown.length,
    unknown: unknown.sort(collator.compare),
    repeated: [...new Set(names.filter((name, index) => names.indexOf(name) !== index))],
  };
}

/** Parameters that the page's own texts and an ArduPlane's reasons not to arm name, known before the vehicle's are read. */
export const NAMED: ReadonlySet<string> = new Set([
  ...['BRD_SD_MISSION', 'FENCE_ACTION', 'FENCE_ENABLE', 'FENCE_TYPE', 'MAV_SYSID', 'MIS_OPTIONS', 'RTL_ALTITUDE'],
  ...['RTL_AUTOLAND', 'RTL_CLIMB_MIN', 'SYSID_THISMAV', 'TERRAIN_ENABLE', 'WP_LOITER_RAD', 'WP_RADIUS'],
]);

/** A text cut at the names of parameters in it. */
export interface TextPart {
  readonly text: string;
  readonly isParam: boolean;
}

/** Finds names of parameters in a text; other words in capitals, as of commands, are not. */
export function partsOf(text: string, isParam: (name: string) => boolean): TextPart[] {
  return text
    .split(/\b([A-Z][A-Z0-9]*(?:_[A-Z0-9]+)+)\b/)
    .map((part, index) => ({ text: part, isParam: index % 2 === 1 && isParam(part) }))
    .filter(({ text }) => text !== '');
}

/** Vehicles as ArduPilot's documentation calls them. */
const ARDUPILOT_DOCS: Readonly<Record<string, string>> = {
  plane: 'plane',
  vtol: 'plane',
  copter: 'copter',
  rover: 'rover',
  boat: 'rover',
  sub: 'sub',
};
/** `MAV_AUTOPILOT_ARDUPILOTMEGA` and `MAV_AUTOPILOT_PX4`. */
const ARDUPILOT = 3;
const PX4 = 12;

/** Where the autopilot's makers describe a parameter; `null` for other autopilots and vehicles. */
export function docsOf(name: string, autopilot: number | undefined, kind: string): string | null {
  if (autopilot === PX4) return `https://docs.px4.io/main/en/advanced_config/parameter_reference.html#${name}`;
  const vehicle = ARDUPILOT_DOCS[kind];
  if (autopilot !== ARDUPILOT || vehicle === undefined) return null;
  return `https://ardupilot.org/${vehicle}/docs/parameters.html#${name.toLowerCase().replaceAll('_', '-')}`;
}
