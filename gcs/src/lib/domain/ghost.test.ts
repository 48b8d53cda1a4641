import { describe, expect, it } from 'vitest';
import { bearing_deg, distance_m } from './geo';
import { wrap180_deg } from './lonlat';
import { GHOST_LIMIT_S, deadReckon, type LastKnown } from './ghost';

const last: LastKnown = {
  at: { lat_deg: 40.3332, lon_deg: -3.7978 },
  course_deg: 90,
  heading_deg: 80,
  groundspeed_m_s: 20,
  turn_rate_deg_s: 0,
};

describe('deadReckon', () => {
  it('goes straight on with course and ground speed, not with the heading', () => {
    const ghost = deadReckon(last, 30);
    expect(distance_m(last.at, ghost.at)).toBeCloseTo(600, 3);
    expect(bearing_deg(last.at, ghost.at)).toBeCloseTo(90, 3);
    expect(ghost).toMatchObject({ course_deg: 90, heading_deg: 80, elapsed_s: 30, reach_m: 600 });
  });

  it('goes round a circle and is back after one turn', () => {
    const circling = { ...last, turn_rate_deg_s: 12 };
    expect(distance_m(last.at, deadReckon(circling, 30).at)).toBeLessThan(0.01);
    const half = deadReckon(circling, 15);
    // Diameter of the circle: 2 v / omega.
    expect(distance_m(last.at, half.at)).toBeCloseTo((2 * 20) / ((12 * Math.PI) / 180), 3);
    expect(bearing_deg(last.at, half.at)).toBeCloseTo(180, 3);
    expect(half.course_deg).toBeCloseTo(270, 6);
  });

  it('turns left with a negative rate', () => {
    const half = deadReckon({ ...last, turn_rate_deg_s: -12 }, 15);
    expect(Math.abs(wrap180_deg(bearing_deg(last.at, half.at)))).toBeLessThan(0.001);
  });

  it('stays where it is on the ground, at time zero, and after its limit', () => {
    expect(deadReckon({ ...last, groundspeed_m_s: 0.4 }, 100).at).toEqual(last.at);
    expect(deadReckon(last, 0).at).toEqual(last.at);
    expect(deadReckon(last, -1).at).toEqual(last.at);
    expect(deadReckon(last, GHOST_LIMIT_S + 500).at).toEqual(deadReckon(last, GHOST_LIMIT_S).at);
  });
});
