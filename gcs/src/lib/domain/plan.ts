/** The plan as the API gives and takes it, and what its items mean to a pilot of a plane. */

import destinations from './destinations.json';
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

/** Items never include home: the first item is item 1, as an ArduPilot vehicle counts. */
export interface Plan {
  items: PlanItem[];
  home: Home | null;
  fence: Fence;
  rally: RallyPoint[];
  complex_items?: ComplexItem[];
}

export const emptyPlan = (): Plan => ({ items: [], home: null, fence: { zones: [], return_point: null }, rally: [] });

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

const NAME: Record<EditableKind, string> = {
  waypoint: 'MAV_CMD_NAV_WAYPOINT',
  takeoff: 'MAV_CMD_NAV_TAKEOFF',
  land: 'MAV_CMD_NAV_LAND',
  loiter_turns: 'MAV_CMD_NAV_LOITER_TURNS',
  loiter_time: 'MAV_CMD_NAV_LOITER_TIME',
  loiter_unlimited: 'MAV_CMD_NAV_LOITER_UNLIM',
  loiter_to_height: 'MAV_CMD_NAV_LOITER_TO_ALT',
  arc_waypoint: 'MAV_CMD_NAV_ARC_WAYPOINT',
  return_to_launch: 'MAV_CMD_NAV_RETURN_TO_LAUNCH',
  change_speed: 'MAV_CMD_DO_CHANGE_SPEED',
  jump: 'MAV_CMD_DO_JUMP',
};

/** WP_LOITER_RAD of an ArduPlane as it comes: the radius of circles that name none, metres. */
export const DEFAULT_LOITER_RADIUS_M = 60;

/** Parameters 1 to 4 of a new item of each kind. */
const NEW_PARAMS: Record<EditableKind, readonly [number, number, number, number]> = {
  waypoint: [0, 0, 0, 0],
  takeoff: [15, 0, 0, 0],
  land: [0, 0, 0, 0],
  loiter_turns: [1, 0, DEFAULT_LOITER_RADIUS_M, 1],
  loiter_time: [60, 0, 1, 1],
  loiter_unlimited: [0, 0, DEFAULT_LOITER_RADIUS_M, 0],
  loiter_to_height: [0, DEFAULT_LOITER_RADIUS_M, 0, 1],
  arc_waypoint: [90, 0, 0, 0],
  return_to_launch: [0, 0, 0, 0],
  // −1: the throttle stays as it is.
  change_speed: [0, 15, -1, 0],
  jump: [1, 1, 0, 0],
};

const PLACED: ReadonlySet<EditableKind> = new Set([
  'waypoint',
  'takeoff',
  'land',
  'loiter_turns',
  'loiter_time',
  'loiter_unlimited',
  'loiter_to_height',
  'arc_waypoint',
]);

const KIND_BY_COMMAND: ReadonlyMap<number, EditableKind> = new Map(KINDS.map((kind) => [COMMAND[kind], kind]));

export const kindOf = (item: PlanItem): ItemKind => KIND_BY_COMMAND.get(item.command) ?? 'other';
/** Whether the editor has a kind for a MAV_CMD. */
export const isKindCommand = (command: number): boolean => KIND_BY_COMMAND.has(command);
export const isPlacedKind = (kind: ItemKind): boolean => kind !== 'other' && PLACED.has(kind);

/** Whether x, y and z of the item are latitude, longitude and height. */
export function isPlaced(item: PlanItem): boolean {
  const kind = kindOf(item);
  return kind === 'other' ? item.frame !== FRAME.mission && positionIn(item) !== null : PLACED.has(kind);
}

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

/** MAV_CMD numbers of items that a vehicle flies to; a test of the server holds them equal to its own. */
const DESTINATIONS: ReadonlySet<number> = new Set(destinations);

/**
 * Whether the vehicle flies to the item. A take-off only points; an action has no place; and an arc is for those that fly
 * arcs: a plane passes over it.
 */
export function isDestination(item: PlanItem, fliesArcs: boolean): boolean {
  if (item.command === COMMAND.arc_waypoint && !fliesArcs) return false;
  return DESTINATIONS.has(item.command) && (kindOf(item) !== 'other' || placeOf(item) !== null);
}

export interface NewItem {
  readonly at?: LonLat | null;
  readonly alt_m?: number;
  readonly frame?: HeightFrame;
}

/** A new item of a kind, with the parameters it starts with. */
export function makeItem(kind: EditableKind, { at = null, alt_m = 0, frame = 'home' }: NewItem = {}): PlanItem {
  const isPlacedItem = PLACED.has(kind);
  const [p1, p2, p3, p4] = NEW_PARAMS[kind];
  const place = at === null ? null : rounded(at);
  return {
    command: COMMAND[kind],
    name: NAME[kind],
    frame: isPlacedItem ? FRAME[frame] : FRAME.mission,
    params: isPlacedItem
      ? [p1, p2, p3, p4, place?.lat_deg ?? 0, place?.lon_deg ?? 0, alt_m]
      : [p1, p2, p3, p4, 0, 0, 0],
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
 * The item as another kind. Place, height and frame stay where both kinds have them; `fallback` stands in when the
 * old kind had none.
 */
export function withKind(item: PlanItem, kind: EditableKind, fallback: NewItem): PlanItem {
  if (kindOf(item) === kind) return item;
  const at = placeOf(item) ?? fallback.at ?? null;
  const made = makeItem(kind, {
    at,
    alt_m: altOf_m(item) ?? fallback.alt_m ?? 0,
    frame: isPlaced(item) ? heightFrameOf(item) : (fallback.frame ?? 'home'),
  });
  return kind === 'land' ? withAlt(made, 0) : made;
}

/** What is known of a command that the editor has no kind for. */
export interface CommandSpec {
  readonly number: number;
  /** MAV_CMD name. */
  readonly name: string;
  readonly has_position: boolean;
  /** Values that its seven parameters begin with; `null` where none is given. */
  readonly defaults: readonly (number | null)[];
}

/** The item as any command. Place, height and frame stay where both have them; `fallback` stands in for the rest. */
export function withCommand(item: PlanItem, spec: CommandSpec, fallback: NewItem): PlanItem {
  const kind = KIND_BY_COMMAND.get(spec.number);
  if (kind !== undefined) return withKind(item, kind, fallback);
  if (item.command === spec.number) return item;
  const at = placeOf(item) ?? fallback.at ?? null;
  const place = at === null ? null : rounded(at);
  const start = spec.defaults.map((value) => value ?? 0);
  const [p1 = 0, p2 = 0, p3 = 0, p4 = 0, p5 = 0, p6 = 0, p7 = 0] = start;
  return {
    command: spec.number,
    name: spec.name,
    frame: !spec.has_position ? FRAME.mission : isPlaced(item) ? item.frame : FRAME[fallback.frame ?? 'home'],
    params: spec.has_position
      ? [p1, p2, p3, p4, place?.lat_deg ?? 0, place?.lon_deg ?? 0, altOf_m(item) ?? fallback.alt_m ?? 0]
      : [p1, p2, p3, p4, p5, p6, p7],
    autocontinue: item.autocontinue,
  };
}

/** Height of an item above home, metres; `null` when home's height or the terrain is not known. */
export function altRelHome_m(item: PlanItem, home: Home | null): number | null {
  const alt_m = altOf_m(item);
  if (alt_m === null) return null;
  switch (heightFrameOf(item)) {
    case 'home':
      return alt_m;
    case 'amsl':
      return home === null ? null : alt_m - home.alt_amsl_m;
    case 'terrain':
      return null;
  }
}
