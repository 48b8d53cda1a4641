/** The plan as the API gives and takes it, and what its items mean to a pilot of a plane. */

import { type CommandInfo, commandInfo } from './core';
import { type LonLat, lonLat, rounded } from './lonlat';

export type Params = [
  number | null,
  number | null,
  number | null,
  number | null,
  number | null,
  number | null,
  number | null,
];

export interface PlanItem {
  /** MAV_CMD number. */
  command: number;
  /** MAV_CMD name. */
  name: string;
  /** MAV_FRAME: what the height counts from. */
  frame: number;
  /** Parameters 1 to 4, then latitude and longitude in degrees and height in metres where the command has a place. */
  params: Params;
  autocontinue: boolean;
}

export interface Home {
  lat_deg: number;
  lon_deg: number;
  alt_amsl_m: number;
}

export interface Point {
  lat_deg: number;
  lon_deg: number;
}

export interface FenceZone {
  inclusion: boolean;
  shape: 'polygon' | 'circle';
  points: Point[];
  radius_m: number | null;
}

/** Where a plane goes that left the fence. */
export interface ReturnPoint extends Point {
  alt_rel_home_m: number;
}

export interface Fence {
  zones: FenceZone[];
  return_point: ReturnPoint | null;
}

export interface RallyPoint extends Point {
  alt_m: number;
  frame: number;
}

/** An item of a plan file that stands for several: a survey, a landing pattern…. The server writes it again where its items still are. */
export interface ComplexItem {
  kind: string;
  json: string;
}

/** The vehicle that a `.plan` file was planned for; the server writes the file for the same one. Unknown values are `null`. */
export interface PlannedFor {
  cruise_speed_m_s: number | null;
  hover_speed_m_s: number | null;
  /** MAV_TYPE. */
  vehicle_type: number | null;
  /** MAV_AUTOPILOT. */
  firmware_type: number | null;
}

/** Items never include home: the first item is item 1, as an ArduPilot vehicle counts. */
export interface Plan {
  items: PlanItem[];
  home: Home | null;
  fence: Fence;
  rally: RallyPoint[];
  complex_items?: ComplexItem[];
  planned_for?: PlannedFor | null;
}

export const emptyPlan = (): Plan => ({ items: [], home: null, fence: { zones: [], return_point: null }, rally: [] });

/** Items as they are sent, without the editor's own fields. */
export const plainItems = (items: readonly PlanItem[]): PlanItem[] =>
  items.map(({ command, name, frame, params, autocontinue }) => ({ command, name, frame, params, autocontinue }));

/** MAV_FRAME values that missions use. */
export const FRAME = { amsl: 0, mission: 2, home: 3, terrain: 10 } as const;
export type HeightFrame = 'amsl' | 'home' | 'terrain';

export const COMMAND = {
  waypoint: 16,
  loiter_unlimited: 17,
  loiter_turns: 18,
  loiter_time: 19,
  return_to_launch: 20,
  land: 21,
  takeoff: 22,
  loiter_to_height: 31,
  arc_waypoint: 36,
  /** For other vehicles: an ArduPlane refuses it. */
  spline_waypoint: 82,
  jump: 177,
  change_speed: 178,
  land_start: 189,
} as const;

/** The kinds of items that the editor makes; anything else a plan may hold is `other` and is kept as it is. */
export const KINDS = [
  'waypoint',
  'takeoff',
  'land',
  'loiter_turns',
  'loiter_time',
  'loiter_unlimited',
  'loiter_to_height',
  'arc_waypoint',
  'return_to_launch',
  'change_speed',
  'jump',
] as const;
export type EditableKind = (typeof KINDS)[number];
export type ItemKind = EditableKind | 'other';

const KIND_BY_COMMAND: ReadonlyMap<number, EditableKind> = new Map(KINDS.map((kind) => [COMMAND[kind], kind]));

export const kindOf = (item: PlanItem): ItemKind => KIND_BY_COMMAND.get(item.command) ?? 'other';
/** Whether the editor has a kind for a MAV_CMD. */
export const isKindCommand = (command: number): boolean => KIND_BY_COMMAND.has(command);
/** Whether the vehicle circles there. */
export const isLoiter = (item: PlanItem): boolean => kindOf(item).startsWith('loiter_');
export const isPlacedKind = (kind: EditableKind): boolean => commandInfo(COMMAND[kind])?.has_position === true;

/** Whether x, y and z of the item are latitude, longitude and height. */
export const isPlaced = (item: PlanItem): boolean =>
  commandInfo(item.command)?.has_position ?? (item.frame !== FRAME.mission && positionIn(item) !== null);

/** Where the item is; `null` when it has no place, or none of its own (0/0 means "where the plane is then"). */
export function placeOf(item: PlanItem): LonLat | null {
  return isPlaced(item) ? positionIn(item) : null;
}

function positionIn(item: PlanItem): LonLat | null {
  const at = lonLat(item.params[5], item.params[4]);
  return at !== null && at.lat_deg === 0 && at.lon_deg === 0 ? null : at;
}

/** Height of the item, metres in its own frame; `null` when it has none. */
export const altOf_m = (item: PlanItem): number | null => (isPlaced(item) ? item.params[6] : null);

/** What heights in a MAV_FRAME count from; 5, 6 and 11 are the integer forms of 0, 3 and 10. */
export function heightFrameOfNumber(frame: number): HeightFrame {
  if (frame === FRAME.amsl || frame === 5) return 'amsl';
  if (frame === FRAME.terrain || frame === 11) return 'terrain';
  return 'home';
}

export const heightFrameOf = (item: PlanItem): HeightFrame => heightFrameOfNumber(item.frame);

/**
 * Whether the vehicle flies to the item, as the core has it. A take-off only points; an action has no place; and an arc or a spline is
 * for those that fly it: a plane passes over an arc, and a plan that holds a spline is a copter's.
 */
export function isDestination({ command }: PlanItem, fliesArcs: boolean): boolean {
  if (command === COMMAND.arc_waypoint) return fliesArcs;
  const info = commandInfo(command);
  return info === undefined ? command === COMMAND.spline_waypoint : info.is_destination && info.support !== 'ignored';
}

export interface NewItem {
  readonly at?: LonLat | null;
  readonly alt_m?: number;
  readonly frame?: HeightFrame;
}

/** A new item of a kind, with the parameters that the core offers. */
export const makeItem = (kind: EditableKind, place: NewItem = {}): PlanItem =>
  newItem(commandInfo(COMMAND[kind]) as CommandInfo, place);

function newItem(
  { number, name, has_position, params }: CommandInfo,
  { at = null, alt_m = 0, frame = 'home' }: NewItem,
): PlanItem {
  const [p1 = 0, p2 = 0, p3 = 0, p4 = 0, ...rest] = params.map((param) => param.default ?? 0);
  const place = at === null ? null : rounded(at);
  const [x = 0, y = 0, z = 0] = has_position ? [place?.lat_deg, place?.lon_deg, alt_m] : rest;
  return {
    command: number,
    name: `MAV_CMD_${name}`,
    frame: has_position ? FRAME[frame] : FRAME.mission,
    params: [p1, p2, p3, p4, x, y, z],
    autocontinue: true,
  };
}

export function withParam(item: PlanItem, index: number, value: number | null): PlanItem {
  const params = item.params.map((old, at) => (at === index ? value : old)) as Params;
  return { ...item, params };
}

export function withPlace(item: PlanItem, at: LonLat): PlanItem {
  const place = rounded(at);
  return withParam(withParam(item, 4, place.lat_deg), 5, place.lon_deg);
}

export const withAlt = (item: PlanItem, alt_m: number): PlanItem => withParam(item, 6, alt_m);

/**
 * The item as another command of the table. Place, height and frame stay where both have them; `fallback` stands in when the old
 * one had none. A landing is on the ground: at home's height, and where the height counts from the terrain at that.
 */
export function withCommand(item: PlanItem, command: number, fallback: NewItem): PlanItem {
  const info = commandInfo(command);
  if (info === undefined || item.command === command) return item;
  const at = placeOf(item) ?? fallback.at ?? null;
  const height_m = altOf_m(item) ?? fallback.alt_m ?? 0;
  const alt_m = command === COMMAND.land ? 0 : height_m;
  const made = newItem(info, { ...fallback, at, alt_m });
  const keepsFrame = info.has_position && isPlaced(item) && (command !== COMMAND.land || item.frame === FRAME.terrain);
  return { ...made, frame: keepsFrame ? item.frame : made.frame };
}
