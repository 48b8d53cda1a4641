/** Whether a plane is on its way down to land: only then can a landing be aborted. */

import { followsMission } from './modes';
import { kindOf, type PlanItem } from './plan';

export interface LandingSigns {
  readonly mode: string | null;
  /** What EXTENDED_SYS_STATE says. */
  readonly landed: string | null;
  readonly isFlying: boolean;
  /** Items on board; `null` when they are not known. */
  readonly items: readonly PlanItem[] | null;
  /** Item in execution, counted from 1. */
  readonly current: number | null;
}

/** Modes that land, whatever the mission says. */
const LANDING_MODES = new Set(['AUTOLAND', 'QLAND']);

/**
 * An ArduPlane aborts a landing only while its current item is one (`Plane::trigger_land_abort`). `null` when that cannot be
 * told: in its mission, when that is not known here.
 */
export function isLanding({ mode, landed, isFlying, items, current }: LandingSigns): boolean | null {
  if (landed === 'landing') return true;
  if (!isFlying || mode === null) return false;
  if (LANDING_MODES.has(mode)) return true;
  if (!followsMission(mode)) return false;
  if (items === null || current === null) return null;
  const item = items[current - 1];
  // 85: MAV_CMD_NAV_VTOL_LAND
  return item !== undefined && (kindOf(item) === 'land' || item.command === 85);
}
