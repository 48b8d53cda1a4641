/** What the core says of every plan, without being asked; written by `cargo run -p vencejo-server --example core_facts`. */

import core from './core.json';

/** An ArduPlane as it comes. */
export const USUAL_PLANE: {
  /** Radius of circles that name none, metres (WP_LOITER_RAD). */
  readonly loiter_radius_m: number;
  /** Metres per second (AIRSPEED_CRUISE). */
  readonly airspeed_m_s: number;
} = core.plane;

/** How old a value or a vehicle's last word may be, seconds: older than `stale_s` it is marked, older than `lost_s` it says nothing. */
export const AGES: { readonly stale_s: number; readonly lost_s: number } = core.ages;

/** Limits from which a value needs attention: battery left and messages lost on a link, percent. */
export const ATTENTION_FROM: {
  readonly battery_low_pct: number;
  readonly battery_critical_pct: number;
  readonly loss_notable_pct: number;
  readonly loss_high_pct: number;
} = core.attention;

const FIXES: Readonly<Record<string, { readonly name: string; readonly is_3d: boolean }>> = core.fixes;

/** The meaning of a GPS_FIX_TYPE; numbers unknown to MAVLink count as no fix. */
export const gpsFix = (fix: number): { readonly name: string; readonly is_3d: boolean } =>
  FIXES[String(fix)] ?? { name: 'unknown fix', is_3d: false };

export type VehicleKind = 'plane' | 'copter' | 'vtol' | 'rover' | 'boat' | 'sub' | 'other';

const KINDS: Readonly<Record<string, string>> = core.kinds;

/** What a MAV_TYPE is. */
export const vehicleKind = (mav_type: number | null): VehicleKind =>
  (KINDS[String(mav_type)] ?? 'other') as VehicleKind;

/** A value of a parameter that is one of a few, and the word for what it stands for. */
export interface CommandChoice {
  readonly value: number;
  readonly word: string;
}

export interface CommandParam {
  /** English; empty when the command does not use the parameter. */
  readonly label: string;
  readonly unit: string;
  readonly min: number | null;
  readonly max: number | null;
  /** What a new item begins with; `null`: nothing but 0. */
  readonly default: number | null;
  /** Its values, where it is one of a few; empty where it is a number. */
  readonly choices: readonly CommandChoice[];
}

export interface CommandInfo {
  /** MAV_CMD number. */
  readonly number: number;
  /** Its name, without MAV_CMD_. */
  readonly name: string;
  /** English. */
  readonly title: string;
  readonly category: string;
  /** What an ArduPlane makes of it in a mission. */
  readonly support: string;
  /** Whether x, y and z are latitude, longitude and height. */
  readonly has_position: boolean;
  readonly is_destination: boolean;
  readonly params: readonly CommandParam[];
}

export const COMMANDS: readonly CommandInfo[] = core.commands;

const BY_NUMBER: ReadonlyMap<number, CommandInfo> = new Map(COMMANDS.map((info) => [info.number, info]));

/** `undefined` for what an ArduPlane takes in no list. */
export const commandInfo = (number: number): CommandInfo | undefined => BY_NUMBER.get(number);
