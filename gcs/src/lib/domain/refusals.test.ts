import { expect, it } from 'vitest';
import { bareReason, refusalOf, type Refusal } from './refusals';

// The first two are from a recording of a real ArduPlane (arm-refused-and-modes.tlog); the others as ArduPilot writes them.
const texts: [string, Refusal | null][] = [
  ['Arm: RTL mode not armable', 'mode-not-armable'],
  ['PreArm: In landing sequence', 'landing-sequence'],
  ['PreArm: DO_LAND_START set and RTL_AUTOLAND disabled', 'landing-needs-rtl-autoland'],
  ['PreArm: GPS 1: Bad fix', 'gps-no-fix'],
  ['PreArm: Need Position Estimate', 'position-unknown'],
  ['PreArm: Compass not calibrated', 'compass-calibrate'],
  ['PreArm: Compasses inconsistent', 'compass-inconsistent'],
  ['PreArm: Accels inconsistent', 'accels-inconsistent'],
  ['PreArm: 3D Accel calibration needed', 'accels-calibrate'],
  ['PreArm: Gyros inconsistent', 'gyros'],
  ['PreArm: AHRS: waiting for home', 'position-unknown'],
  ['PreArm: Battery 1 below minimum arming voltage', 'battery-low'],
  ['PreArm: Throttle (RC3) is not neutral', 'throttle-not-zero'],
  ['PreArm: Hardware safety switch', 'safety-switch'],
  ['PreArm: Radio failsafe on', 'failsafe'],
  ['PreArm: Logging failed', 'logging'],
  ['PreArm: Something nobody wrote yet', null],
];

it.each(texts)('%s', (text, refusal) => expect(refusalOf(text)).toBe(refusal));

it('leaves away what every refusal begins with', () => {
  expect(bareReason('PreArm: GPS 1: Bad fix')).toBe('GPS 1: Bad fix');
  expect(bareReason('Arm: RTL mode not armable')).toBe('RTL mode not armable');
  expect(bareReason('plain')).toBe('plain');
});
