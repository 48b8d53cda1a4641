/** Flight modes, where the station must know what one does. */

/** Modes in which the vehicle flies its mission: ArduPilot's and PX4's. */
const MISSION_MODES: ReadonlySet<string> = new Set(['AUTO', 'AUTO_MISSION']);

/** Whether the vehicle flies its mission; `null` while its mode is not known. */
export const followsMission = (mode: string | null): boolean | null => (mode === null ? null : MISSION_MODES.has(mode));
