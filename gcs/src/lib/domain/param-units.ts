// Units of the parameters that the core flies, rehearses and checks with; it has no others' units.

const BY_UNIT: Readonly<Record<string, readonly string[]>> = {
  m: [
    ...['ALT_SLOPE_MIN', 'FENCE_ALT_MAX', 'FENCE_ALT_MIN', 'FENCE_RADIUS', 'FENCE_RETALT', 'LAND_FLARE_ALT'],
    ...['LAND_PF_ALT', 'RTL_ALTITUDE', 'RTL_CLIMB_MIN', 'RTL_RADIUS', 'TERRAIN_SPACING', 'TKOFF_ALT', 'TKOFF_LVL_ALT'],
    ...['WP_LOITER_RAD', 'WP_MAX_RADIUS', 'WP_RADIUS'],
  ],
  km: ['RALLY_LIMIT_KM'],
  'm/s': [
    ...['AIRSPEED_CRUISE', 'AIRSPEED_MAX', 'AIRSPEED_MIN', 'LAND_PF_ARSPD', 'MIN_GROUNDSPEED', 'TECS_CLMB_MAX'],
    ...['TECS_LAND_ARSPD', 'TECS_SINK_MAX', 'TECS_SINK_MIN', 'TKOFF_ROTATE_SPD'],
  ],
  'm/s²': ['TKOFF_THR_MINACC'],
  '°': [
    ...['LAND_PITCH_DEG', 'LEVEL_ROLL_LIMIT', 'NAVL1_LIM_BANK', 'PTCH_LIM_MAX_DEG', 'PTCH_LIM_MIN_DEG'],
    ...['PTCH_TRIM_DEG', 'ROLL_LIMIT_DEG'],
  ],
  s: [...['BATT_LOW_TIMER', 'FS_LONG_TIMEOUT', 'FS_SHORT_TIMEOUT', 'LAND_FLARE_SEC', 'NAVL1_PERIOD', 'RC_FS_TIMEOUT']],
  V: ['BATT_CRT_VOLT', 'BATT_LOW_VOLT'],
  mAh: ['BATT_CAPACITY', 'BATT_CRT_MAH', 'BATT_LOW_MAH'],
  '%': ['THR_MAX', 'THR_MIN', 'TKOFF_THR_MAX', 'TRIM_THROTTLE'],
  kB: ['BRD_SD_MISSION'],
};

const UNITS = new Map(Object.entries(BY_UNIT).flatMap(([unit, names]) => names.map((name) => [name, unit] as const)));

/** The unit's symbol; empty where it has none or it is not known. */
export const unitOf = (name: string): string => UNITS.get(name) ?? '';
