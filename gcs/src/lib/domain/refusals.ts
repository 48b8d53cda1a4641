// Why a vehicle refuses to arm, in plain words: recognises ArduPilot's texts and knows a remedy for the frequent ones.

/** Names of the reasons that are explained; the words are in the languages' files. */
export const REFUSALS = [
  'landing-needs-rtl-autoland',
  'mode-not-armable',
  'landing-sequence',
  'no-mission',
  'gps-no-fix',
  'gps-accuracy',
  'position-unknown',
  'compass-calibrate',
  'compass-inconsistent',
  'accels-calibrate',
  'accels-inconsistent',
  'gyros',
  'ahrs-waiting',
  'airspeed',
  'barometer',
  'battery-low',
  'rc-not-calibrated',
  'throttle-not-zero',
  'safety-switch',
  'failsafe',
  'logging',
  'fence',
  'rally',
  'already-armed',
  'board-voltage',
  'system-initialising',
] as const;
export type Refusal = (typeof REFUSALS)[number];

const PATTERNS: readonly [RegExp, Refusal][] = [
  [/DO_LAND_START.*RTL_AUTOLAND/i, 'landing-needs-rtl-autoland'],
  [/no mission|mission.*(missing|empty)|missing.*mission|AUTO.*mission/i, 'no-mission'],
  [/mode (is )?not armable|not armable/i, 'mode-not-armable'],
  [/in landing sequence/i, 'landing-sequence'],
  [/GPS.*(accuracy|HDOP|speed error|horiz error|vert)/i, 'gps-accuracy'],
  [/GPS.*(bad fix|no fix|not healthy|unhealthy|waiting|not found|no gps|3D)|bad gps|need 3D fix/i, 'gps-no-fix'],
  [
    /need position|position estimate|waiting for home|home not set|no position|EKF.*(not started|pos)/i,
    'position-unknown',
  ],
  [/compass.*(inconsistent|disagree)/i, 'compass-inconsistent'],
  [/compass|mag field/i, 'compass-calibrate'],
  [/accel.*(inconsistent)/i, 'accels-inconsistent'],
  [/accel/i, 'accels-calibrate'],
  [/gyro/i, 'gyros'],
  [/AHRS|EKF|attitude/i, 'ahrs-waiting'],
  [/airspeed/i, 'airspeed'],
  [/baro/i, 'barometer'],
  [/board.*voltage|servo voltage|vcc/i, 'board-voltage'],
  [/batt/i, 'battery-low'],
  [/throttle.*(not|too high|zero|idle|neutral)/i, 'throttle-not-zero'],
  [/\bRC\b|radio calib|RC\d+_/i, 'rc-not-calibrated'],
  [/safety switch|safety/i, 'safety-switch'],
  [/failsafe/i, 'failsafe'],
  [/logging|log(ger)?\b|SD card/i, 'logging'],
  [/fence/i, 'fence'],
  [/rally/i, 'rally'],
  [/already armed/i, 'already-armed'],
  [/initiali[sz]/i, 'system-initialising'],
];

/** The reason that a vehicle's text stands for, null when it is not one that we explain. */
export function refusalOf(text: string): Refusal | null {
  return PATTERNS.find(([pattern]) => pattern.test(text))?.[1] ?? null;
}

/** Whether another mode cures it. */
export function isCuredByMode(refusal: Refusal): boolean {
  return refusal === 'mode-not-armable' || refusal === 'landing-sequence';
}

/** A vehicle's text without the words that every refusal begins with. */
export function bareReason(text: string): string {
  return text.replace(/^\s*(PreArm|Arm|Arming denied)\s*:\s*/i, '').trim();
}
