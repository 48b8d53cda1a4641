/** The same 635 lines and 500 map coordinates that the Rust core is held to: tests/fixtures/geodesy, made by others. */
import { describe, expect, it } from 'vitest';
import geodesicsCsv from '../../../../tests/fixtures/geodesy/geodesics.csv?raw';
import projectionsCsv from '../../../../tests/fixtures/geodesy/projections.csv?raw';
import { bearing_deg, between, destination, distance_m, geodesicLine } from './geo';
import { wrap180_deg } from './lonlat';
import { crsOf } from './projection';
import { crsTransform } from './projection-transform';

const rows = (csv: string): string[][] =>
  csv
    .trim()
    .split('\n')
    .slice(1)
    .map((row) => row.split(','));

const TOLERANCE_M = 1e-3;

describe('geodesics by GeographicLib for Python', () => {
  const lines = rows(geodesicsCsv).map(([kind = '', ...values]) => ({ kind, values: values.map(Number) }));

  it('have the same lengths and ends', () => {
    expect(lines.length).toBeGreaterThanOrEqual(500);
    let worst_m = 0;
    for (const { values } of lines) {
      const [lat1, lon1, lat2, lon2, azi1, , s12, thirdLat, thirdLon] = values as [
        number,
        number,
        number,
        number,
        number,
        number,
        number,
        number,
        number,
      ];
      const from = { lat_deg: lat1, lon_deg: lon1 };
      const to = { lat_deg: lat2, lon_deg: lon2 };
      const third = { lat_deg: thirdLat, lon_deg: thirdLon };
      const bearing = bearing_deg(from, to);
      worst_m = Math.max(
        worst_m,
        Math.abs(distance_m(from, to) - s12),
        distance_m(destination(from, bearing, s12), to),
        distance_m(destination(from, azi1, s12 / 3), third),
      );
      // Nearly antipodal places have two ways of one length.
      if (Math.abs(wrap180_deg(bearing - azi1)) < 1e-6) {
        worst_m = Math.max(worst_m, distance_m(between(from, to, 1 / 3), third));
        const line = geodesicLine(from, to, Math.max(s12 / 5, 1));
        const whole_m = line.slice(1).reduce((sum, at, index) => sum + distance_m(line[index]!, at), 0);
        worst_m = Math.max(worst_m, Math.abs(whole_m - s12));
      }
    }
    expect(worst_m).toBeLessThan(TOLERANCE_M);
  });
});

describe('map coordinates by PROJ', () => {
  it('are the same both ways', () => {
    let checked = 0;
    let worst_m = 0;
    for (const row of rows(projectionsCsv)) {
      const [epsg, lat_deg, lon_deg, x, y] = row.map(Number) as [number, number, number, number, number];
      const crs = crsOf(`EPSG:${epsg}`);
      if (crs === null) throw new Error(`EPSG:${epsg} is not known`);
      const { fromLonLat, toLonLat } = crsTransform(crs);
      const at = { lat_deg, lon_deg };
      const found = fromLonLat(at);
      const back = toLonLat([x, y]);
      if (found === null || back === null) continue;
      worst_m = Math.max(worst_m, Math.hypot(found[0] - x, found[1] - y), distance_m(back, at));
      checked += 1;
    }
    expect(checked).toBeGreaterThanOrEqual(450);
    expect(worst_m).toBeLessThan(TOLERANCE_M);
  });
});
