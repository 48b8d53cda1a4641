import { describe, expect, it } from 'vitest';
import { bearing_deg, between, circle, destination, distance_m, geodesicLine, offset_m } from './geo';
import {
  formatDecimal,
  formatAngle,
  formatDms,
  lonLat,
  type LonLat,
  parseAngle,
  parseLonLat,
  rounded,
  wrap180_deg,
  wrap360_deg,
} from './lonlat';

const MADRID: LonLat = { lon_deg: -3.7978, lat_deg: 40.3332 };

describe('geodesics', () => {
  it('knows the lengths that GeographicLib publishes', () => {
    // the example of GeographicLib's documentation: Wellington to Salamanca
    const wellington = { lat_deg: -41.32, lon_deg: 174.81 };
    const salamanca = { lat_deg: 40.96, lon_deg: -5.5 };
    expect(distance_m(wellington, salamanca)).toBeCloseTo(19_959_679.267, 2);
  });

  it('goes there and finds the way back', () => {
    for (const bearing of [0.001, 37, 90, 180, 271]) {
      const there = destination(MADRID, bearing, 1234.5);
      expect(distance_m(MADRID, there)).toBeCloseTo(1234.5, 5);
      expect(bearing_deg(MADRID, there)).toBeCloseTo(bearing, 6);
    }
  });

  it('crosses the date line', () => {
    const west = { lat_deg: 0, lon_deg: 179.9 };
    const east = { lat_deg: 0, lon_deg: -179.9 };
    expect(distance_m(west, east)).toBeLessThan(23_000);
    expect(Math.abs(between(west, east, 0.5).lon_deg)).toBeCloseTo(180, 9);
  });

  it('bends a long leg and leaves a short one alone', () => {
    const near = destination(MADRID, 45, 900);
    expect(geodesicLine(MADRID, near)).toEqual([MADRID, near]);
    const far = destination(MADRID, 45, 900_000);
    const line = geodesicLine(MADRID, far);
    expect(line).toHaveLength(46);
    const pieces_m = line.slice(1).map((at, index) => distance_m(line[index]!, at));
    expect(pieces_m.reduce((sum, one) => sum + one)).toBeCloseTo(900_000, 0);
  });

  it('closes circles of the radius asked for, whatever its sign', () => {
    const points = circle(MADRID, -80, 16);
    expect(points).toHaveLength(17);
    expect(points[0]).toEqual(points[16]);
    for (const point of points) expect(distance_m(MADRID, point)).toBeCloseTo(80, 6);
  });

  it('splits an offset into north and east', () => {
    const offset = offset_m(MADRID, destination(MADRID, 90, 300));
    expect(offset.east_m).toBeCloseTo(300, 3);
    expect(offset.north_m).toBeCloseTo(0, 3);
  });
});

describe('positions', () => {
  it('wraps angles', () => {
    expect(wrap180_deg(190)).toBe(-170);
    expect(wrap180_deg(-180)).toBe(-180);
    expect(wrap360_deg(-90)).toBe(270);
    expect(Object.is(wrap180_deg(360), 0)).toBe(true);
  });

  it('takes no position for one', () => {
    expect(lonLat(null, 40)).toBeNull();
    expect(lonLat(Number.NaN, 40)).toBeNull();
    expect(lonLat(0, 90.1)).toBeNull();
    expect(rounded({ lon_deg: 3.123456789, lat_deg: -1.00000004 })).toEqual({ lon_deg: 3.1234568, lat_deg: -1 });
  });

  it.each([
    ['40.3332, -3.7978'],
    ['40.3332 -3.7978'],
    ['40,3332; -3,7978'],
    ['40,3332, -3,7978'],
    ['40.3332N 3.7978W'],
    ['3.7978 O, 40.3332 N'],
    ['N40.3332 W3.7978'],
    ['40°19′59.52″N 3°47′52.08″W'],
    ['40° 19\' 59.52" N, 3° 47\' 52.08" W'],
    ['40 19 59.52 N 3 47 52.08 W'],
  ])('reads %s', (text) => {
    const at = parseLonLat(text);
    expect(at?.lat_deg).toBeCloseTo(40.3332, 6);
    expect(at?.lon_deg).toBeCloseTo(-3.7978, 6);
  });

  it.each(['40.33,33', '40.33 33', '40, 33', '40; 33', '40,-3'])('reads %s as two numbers', (text) => {
    expect(parseLonLat(text)).not.toBeNull();
  });

  it.each(['40,33', '-40,33', '40,33 N', '40,33°', '40 33', '40 33,5', '40° 33′'])(
    'does not take %s, which may be one number, for a position',
    (text) => expect(parseLonLat(text)).toBeNull(),
  );

  it.each(['', '40', 'hello', '91, 0', '40.1N 3.2N', '40, 3, 2', '40°61′N 3°W', 'x'.repeat(200)])(
    'does not read %j',
    (text) => expect(parseLonLat(text)).toBeNull(),
  );

  it('writes what it reads', () => {
    expect(formatDecimal(MADRID)).toBe('40.3332000, -3.7978000');
    expect(formatDms(MADRID)).toBe('40°19′59.5″N 3°47′52.1″W');
    expect(formatAngle(MADRID.lon_deg, 'lon', 4)).toMatch(/^3°47′52\.\d{4}″W$/);
    for (const [axis, value_deg] of [['lat', -33.1234567] as const, ['lon', 179.9999999] as const]) {
      expect(parseAngle(formatAngle(value_deg, axis, 4), axis)).toBeCloseTo(value_deg, 7);
      expect(parseAngle(String(value_deg), axis)).toBe(value_deg);
    }
    expect(parseAngle('3°47′52″W', 'lat')).toBeNull();
    expect(['−3.79', '40.', '.5', '-,5'].map((text) => parseAngle(text, 'lat'))).toEqual([-3.79, 40, 0.5, -0.5]);
    expect(formatDms({ lat_deg: -0.99999999, lon_deg: 0 })).toBe('1°00′00.0″S 0°00′00.0″E');
  });
});
