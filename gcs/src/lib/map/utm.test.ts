import { expect, it } from 'vitest';
import { formatPlace, formatUtm, parsePlace, utmZone } from '$lib/domain/coordinates';
import { projectUtm, unprojectUtm } from './utm';

it('knows zones and bands, with the exceptions in the north', () => {
  const zone = (lat_deg: number, lon_deg: number) => {
    const found = utmZone({ lat_deg, lon_deg });
    return found === null ? null : `${found.zone}${found.band}`;
  };
  expect(zone(40.3332, -3.7978)).toBe('30T');
  expect(zone(-33.86, 151.21)).toBe('56H');
  expect([zone(60, 5), zone(78, 8), zone(78, 10), zone(78, 40)]).toEqual(['32V', '31X', '33X', '37X']);
  expect([zone(0, 180), zone(-80, 0), zone(84, 0)]).toEqual(['60N', '31C', '31X']);
  expect([zone(-81, 0), zone(85, 0)]).toEqual([null, null]);
});

it('agrees with the series of Krüger (Karney 2011) to a metre', () => {
  // 432231.83 E, 4465045.61 N and 334416.39 E, −3748074.64 + 10000000 N by that series, third order, in double precision
  expect(formatUtm({ lat_deg: 40.3332, lon_deg: -3.7978 }, projectUtm)).toBe('30T 432232 4465046');
  expect(formatUtm({ lat_deg: -33.86, lon_deg: 151.21 }, projectUtm)).toBe('56H 334416 6251925');
  const [east_m, north_m] = projectUtm({ lat_deg: 0, lon_deg: 3 }, { zone: 31, band: 'N', isNorth: true });
  expect(east_m).toBeCloseTo(500_000, 3);
  expect(north_m).toBeCloseTo(0, 3);
  const [, south_m] = projectUtm({ lat_deg: -0.0001, lon_deg: 3 }, { zone: 31, band: 'M', isNorth: false });
  expect(south_m).toBeCloseTo(9_999_988.9, 0);
});

it('writes a position as chosen, and in degrees where UTM ends', () => {
  const at = { lat_deg: 40.3332, lon_deg: -3.7978 };
  expect(formatPlace(at, 'decimal', projectUtm)).toBe('40.333200, -3.797800');
  expect(formatPlace(at, 'dms', projectUtm)).toBe('40°19′59.5″N 3°47′52.1″W');
  expect(formatPlace({ lat_deg: 88, lon_deg: 0 }, 'utm', projectUtm)).toBe('88.000000, 0.000000');
});

it('reads a position in degrees or UTM', () => {
  for (const at of [
    { lat_deg: 40.3332, lon_deg: -3.7978 },
    { lat_deg: -33.86, lon_deg: 151.21 },
  ]) {
    for (const format of ['decimal', 'dms', 'utm'] as const) {
      const read = parsePlace(formatPlace(at, format, projectUtm), unprojectUtm);
      expect(read?.lat_deg, format).toBeCloseTo(at.lat_deg, 4);
      expect(read?.lon_deg, format).toBeCloseTo(at.lon_deg, 4);
    }
  }
  expect(parsePlace('40.33, -3.79', unprojectUtm)).toEqual({ lat_deg: 40.33, lon_deg: -3.79 });
  // the letter of the hemisphere, as people in the south write it; of the band where the northing is of that
  expect(parsePlace('19S 345000 6300000', unprojectUtm)?.lat_deg).toBeCloseTo(-33.43, 1);
  expect(parsePlace('30S 432412 4000000', unprojectUtm)?.lat_deg).toBeCloseTo(36.14, 1);
  expect(parsePlace('30N 432412 4465123', unprojectUtm)?.lat_deg).toBeCloseTo(40.33, 1);
  expect(parsePlace('30T 0432412 4465123', unprojectUtm)).toEqual(parsePlace('30T 432412 4465123', unprojectUtm));
  for (const text of ['30V 432412 4465123', '19H 345000 4300000']) {
    expect(parsePlace(text, unprojectUtm), text).toBeNull();
  }
  for (const text of ['', 'Madrid', '61T 432412 4465123', '30I 432412 4465123', '30T 4324', '40,33']) {
    expect(parsePlace(text, unprojectUtm), text).toBeNull();
  }
});
