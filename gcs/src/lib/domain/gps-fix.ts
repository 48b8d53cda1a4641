// What a GPS fix is worth (GPS_FIX_TYPE of MAVLink).

export type FixName = 'noGps' | 'noFix' | '2d' | '3d' | 'dgps' | 'rtkFloat' | 'rtkFixed';

const NAMES: readonly FixName[] = ['noGps', 'noFix', '2d', '3d', 'dgps', 'rtkFloat', 'rtkFixed', 'rtkFixed', '3d'];

export const fixName = (fix: number): FixName => NAMES[fix] ?? 'noFix';

/** A position in three dimensions. */
export const isFix3d = (fix: number): boolean => fix >= 3;
