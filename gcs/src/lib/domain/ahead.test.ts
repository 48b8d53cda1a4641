import { describe, expect, it } from 'vitest';
import { batteryLeft_pct, expectedAt } from './ahead';

// 1,112 m northward to item 2 in 60 s, climbing, then as far eastward to item 3
const track = {
  time_s: [10, 70, 130],
  lat_deg: [40, 40.01, 40.01],
  lon_deg: [-3, -3, -2.987],
  height_m: [50, 80, 80],
  ground_m: [null, null, null],
  airspeed_m_s: [],
  groundspeed_m_s: [],
  bank_deg: [],
  heading_deg: [],
  item: [2, 3, 3],
};

describe('what was expected', () => {
  it('is the moment of the same leg', () => {
    const half = expectedAt(track, { lat_deg: 40.005, lon_deg: -3.0003 }, 2);
    expect(half?.time_s).toBeCloseTo(40, 0);
    expect(half?.height_m).toBeCloseTo(65, 0);
    expect(expectedAt(track, { lat_deg: 40.0101, lon_deg: -2.99 }, 3)?.time_s).toBeCloseTo(116, 0);
  });

  it('is nothing away from that leg', () => {
    expect(expectedAt(track, { lat_deg: 40.005, lon_deg: -3.01 }, 2)).toBeNull();
    expect(expectedAt(track, { lat_deg: 40.005, lon_deg: -3 }, 4)).toBeNull();
  });
});

describe('what is left of the battery', () => {
  it('goes on as it went', () => {
    expect(batteryLeft_pct(90, 80, 100, 300)).toBe(50);
    expect(batteryLeft_pct(90, 80, 100, 3000)).toBe(0);
  });

  it('is not known of a beginning', () => {
    expect(batteryLeft_pct(90, 89, 100, 300)).toBeNull();
  });
});
