import { describe, expect, it } from 'vitest';
import type { TelemetryGroups } from '$lib/api/types';
import { telemetryAt } from '../../../dev/mock/flight';
import { approach, nextAttitude, tapesOf, wrapPi, type AttitudeInput } from './attitude';
import type { Freshness } from './freshness';

const level: AttitudeInput = {
  roll_rad: 0,
  pitch_rad: 0,
  heading_rad: 1,
  roll_rate_rad_s: 0,
  pitch_rate_rad_s: 0,
  yaw_rate_rad_s: 0,
  age_s: 0,
};

describe('nextAttitude', () => {
  it('begins with what the plane said', () => {
    expect(nextAttitude(null, { ...level, roll_rad: 0.5 }, 0)).toMatchObject({ roll_rad: 0.5, heading_rad: 1 });
  });

  it('follows the rates between messages, for a moment only', () => {
    const rolling = { ...level, roll_rate_rad_s: 1 };
    expect(nextAttitude(null, { ...rolling, age_s: 0.1 }, 0).roll_rad).toBeCloseTo(0.1);
    expect(nextAttitude(null, { ...rolling, age_s: 60 }, 0).roll_rad).toBeCloseTo(0.25);
  });

  it('turns the heading with pitch rate while banked', () => {
    const banked = { ...level, roll_rad: Math.PI / 2, pitch_rate_rad_s: 1, age_s: 0.1 };
    expect(nextAttitude(null, banked, 0).heading_rad).toBeCloseTo(1.1);
    expect(nextAttitude(null, banked, 0).pitch_rad).toBeCloseTo(0);
  });

  it('takes the short way around', () => {
    const shown = { roll_rad: 0, pitch_rad: 0, heading_rad: 3.1 };
    const next = nextAttitude(shown, { ...level, heading_rad: -3.1 }, 0.05);
    expect(Math.abs(next.heading_rad)).toBeGreaterThan(3.1);
  });

  it('stays finite at the pole', () => {
    const steep = { ...level, pitch_rad: Math.PI / 2, yaw_rate_rad_s: 3, age_s: 1 };
    expect(Object.values(nextAttitude(null, steep, 0)).every(Number.isFinite)).toBe(true);
  });
});

it('wraps and approaches', () => {
  expect(wrapPi(3 * Math.PI + 0.5)).toBeCloseTo(-Math.PI + 0.5);
  expect(approach(null, 5, 0.01)).toBe(5);
  expect(approach(0, 5, 2)).toBe(5);
  expect(approach(0, 5, 0.1)).toBeGreaterThan(1);
  expect(approach(0, 5, 0.1)).toBeLessThan(5);
});

describe('tapesOf', () => {
  const groups = telemetryAt(100).groups as TelemetryGroups;
  const tapes = (known: TelemetryGroups, ages: Partial<Record<'attitude' | 'hud' | 'position', Freshness>>) =>
    tapesOf(known, (group) => ages[group] ?? 'fresh');

  it('shows no height above the sea where that above home is not known', () => {
    const { position: _, ...rest } = groups;
    expect(tapes(rest, {}).alt_rel_home_m).toBeNull();
    expect(tapes(groups, {}).alt_rel_home_m).toBe(groups.position?.alt_rel_home_m);
  });

  it('goes by the age of each message', () => {
    expect(tapes(groups, { hud: 'stale' })).toMatchObject({ isHudOld: true, isPositionOld: false });
    expect(tapes(groups, { hud: 'lost' })).toMatchObject({ airspeed_m_s: null, throttle_pct: null });
    expect(tapes(groups, { position: 'lost' }).alt_rel_home_m).toBeNull();
    const all = { attitude: 'lost', hud: 'lost', position: 'lost' } as const;
    expect(tapes(groups, all)).toMatchObject({ airspeed_m_s: groups.hud?.airspeed_m_s, isHudOld: true });
  });

  it('knows no heading where none was told', () => {
    const attitude = { ...groups.attitude!, yaw_rad: null };
    expect(tapes({ attitude }, {}).heading_rad).toBeNull();
    expect(tapes({ attitude, hud: groups.hud! }, {}).heading_rad).not.toBeNull();
  });
});
