// Which of an item's parameters 1 to 4 are shown for each kind, under which name, in which unit, with which choices.
import { commandInfo } from '$lib/domain/core';
import { COMMAND, type EditableKind } from '$lib/domain/plan';
import type { MessageKey } from '$lib/i18n/index.svelte';

export type FieldUnit = 'length' | 'speed' | 'deg' | 's' | '%' | 'none';

export interface Choice {
  readonly value: number;
  readonly label: MessageKey;
}

interface Shown {
  /** Index in `params`. */
  readonly index: number;
  readonly label: MessageKey;
  readonly isWhole?: boolean;
  /** Its sign is the sense of a circle, negative counter-clockwise: shown as two fields. */
  readonly isSigned?: boolean;
  /** Where the core takes values that mean something else, or has no limit. */
  readonly min?: number;
  readonly max?: number;
}

export interface Field extends Shown {
  readonly unit: FieldUnit;
  readonly min: number;
  readonly max: number;
}

const RADIUS = { label: 'param.circleRadius', isSigned: true } as const;
const EXIT = { index: 3, label: 'param.exit', isWhole: true } as const;

const SHOWN: Record<EditableKind, readonly Shown[]> = {
  waypoint: [
    { index: 1, label: 'param.acceptance' },
    { index: 2, label: 'param.passBy' },
  ],
  takeoff: [{ index: 0, label: 'param.minPitch', isWhole: true }],
  land: [{ index: 0, label: 'param.abortAlt' }],
  loiter_turns: [{ index: 0, label: 'param.turns' }, { index: 2, ...RADIUS }, EXIT],
  loiter_time: [
    { index: 0, label: 'param.time', isWhole: true },
    { index: 2, label: 'param.sense', isWhole: true },
    EXIT,
  ],
  loiter_unlimited: [{ index: 2, ...RADIUS }],
  loiter_to_height: [{ index: 1, ...RADIUS }, EXIT],
  arc_waypoint: [{ index: 0, label: 'param.arcAngle', isWhole: true }],
  return_to_launch: [],
  change_speed: [
    { index: 0, label: 'param.speedType', isWhole: true },
    { index: 1, label: 'param.speed', min: 0, max: 200 },
    { index: 2, label: 'param.throttle', min: -1, isWhole: true },
  ],
  jump: [
    { index: 0, label: 'param.item', isWhole: true },
    { index: 1, label: 'param.repeats', isWhole: true },
  ],
};

const UNITS: Readonly<Record<string, FieldUnit>> = { m: 'length', 'm/s': 'speed', '°': 'deg', s: 's', '%': '%' };

/** Unit and range of a command's parameter, as the core's table has them; the server's checks have the last word. */
export function rangeOf(command: number, index: number): Pick<Field, 'unit' | 'min' | 'max'> {
  const param = commandInfo(command)?.params[index];
  return { unit: UNITS[param?.unit ?? ''] ?? 'none', min: param?.min ?? -1e9, max: param?.max ?? 1e9 };
}

/** Which parameters of a kind are shown. */
export const fieldsOf = (kind: EditableKind): readonly Field[] =>
  SHOWN[kind].map((shown) => ({ ...rangeOf(COMMAND[kind], shown.index), ...shown }));

/** The choices of a parameter; `null` for a plain number, or a value outside the choices. */
export function choicesOf(command: number, index: number, value: number | null): readonly Choice[] | null {
  const choices = commandInfo(command)?.params[index]?.choices ?? [];
  if (!choices.some((choice) => choice.value === value)) return null;
  return choices.map((choice) => ({ value: choice.value, label: `choice.${choice.word}` as MessageKey }));
}
