// Which of an item's parameters 1 to 4 are shown for each kind, under which name and in which unit.
import type { EditableKind } from '$lib/domain/plan';
import type { MessageKey } from '$lib/i18n/index.svelte';

export type FieldUnit = 'length' | 'speed' | 'deg' | 's' | '%' | 'none';

export interface Field {
  /** Index in `params`. */
  readonly index: number;
  readonly label: MessageKey;
  readonly unit: FieldUnit;
  readonly min: number;
  readonly max: number;
  readonly isWhole?: boolean;
}

const RADIUS = { label: 'param.radius', unit: 'length', min: -2550, max: 2550 } as const;
const EXIT = { index: 3, label: 'param.exit', unit: 'none', min: 0, max: 1, isWhole: true } as const;

/** Ranges are those of ArduPlane's storage; the server's checks have the last word. */
export const FIELDS: Record<EditableKind, readonly Field[]> = {
  waypoint: [
    { index: 1, label: 'param.acceptance', unit: 'length', min: 0, max: 255 },
    { index: 2, label: 'param.passBy', unit: 'length', min: 0, max: 255 },
  ],
  takeoff: [{ index: 0, label: 'param.minPitch', unit: 'deg', min: 0, max: 90, isWhole: true }],
  land: [{ index: 0, label: 'param.abortAlt', unit: 'length', min: 0, max: 327 }],
  loiter_turns: [{ index: 0, label: 'param.turns', unit: 'none', min: 0, max: 255 }, { index: 2, ...RADIUS }, EXIT],
  loiter_time: [
    { index: 0, label: 'param.time', unit: 's', min: 0, max: 65_535, isWhole: true },
    { index: 2, label: 'param.direction', unit: 'none', min: -1, max: 1, isWhole: true },
    EXIT,
  ],
  loiter_unlimited: [{ index: 2, ...RADIUS }],
  loiter_to_height: [{ index: 1, ...RADIUS }, EXIT],
  arc_waypoint: [{ index: 0, label: 'param.arcAngle', unit: 'deg', min: -359, max: 359, isWhole: true }],
  return_to_launch: [],
  change_speed: [
    { index: 0, label: 'param.speedType', unit: 'none', min: 0, max: 1, isWhole: true },
    { index: 1, label: 'param.speed', unit: 'speed', min: 0, max: 200 },
    { index: 2, label: 'param.throttle', unit: '%', min: 0, max: 100, isWhole: true },
  ],
  jump: [
    { index: 0, label: 'param.item', unit: 'none', min: 1, max: 65_535, isWhole: true },
    { index: 1, label: 'param.repeats', unit: 'none', min: -1, max: 32_767, isWhole: true },
  ],
};
