import fc from 'fast-check';
import { describe, expect, it } from 'vitest';
import { crsCode, crsOf, isOnMercator, MERCATOR_HALF_M, MERCATOR_LIMIT_DEG, preferredCrs } from './projection';
import { crsTransform, type CrsXY } from './projection-transform';
import { wrap180_deg } from './lonlat';

/** Positions in each system by PROJ 9.5.1 (pyproj 3.7.2), which shares no code with proj4js: code, lon, lat, x, y. */
const PROJ: readonly (readonly [string, number, number, number, number])[] = [
  ['EPSG:25830', -3.7978, 40.3332, 432231.8269, 4465045.6077],
  ['EPSG:25830', -8.9, 43.1, 19824.7771, 4788843.3235],
  ['EPSG:25830', 3.9, 39.95, 1089661.8463, 4445067.2466],
  ['EPSG:25828', -17.9, 28.66, 216555.0203, 3173759.7233],
  ['EPSG:25838', 47.2, 69.9, 584363.1929, 7756242.7004],
  ['EPSG:32601', -179.99, 51.9, 294300.0313, 5754141.4049],
  ['EPSG:32660', 179.99, 51.9, 705699.9687, 5754141.4049],
  ['EPSG:32760', -179.95, -16.8, 825123.0239, 8140066.893],
  ['EPSG:32733', 15.5, -79.9, 509788.6553, 1129533.6284],
  ['EPSG:32633', 12.0, 83.9, 464424.3198, 9317856.4661],
  ['EPSG:32631', 3.0, 0.0, 500000.0, 0.0],
  ['EPSG:32719', -70.6, -33.4, 351205.0646, 6303223.7507],
  ['EPSG:3857', -3.7978, 40.3332, -422769.1621, 4914480.7934],
  ['EPSG:3857', 179.9999, 85.0, 20037497.2108, 19971868.8804],
  ['EPSG:3857', -120.5, -84.9, -13413998.6406, -19845401.3355],
  ['EPSG:3031', 166.7, -77.85, 304792.0965, -1289361.3032],
  ['EPSG:3413', 15.6, 78.2, 1117433.7219, -629641.5432],
  ['EPSG:3995', -150.0, 89.5, -27163.276, 47048.1741],
];

/** Every system on offer. */
const OFFERED = [
  ...[3857, 4326, 4258, 3031, 3413, 3995],
  ...Array.from({ length: 60 }, (_, index) => 32601 + index),
  ...Array.from({ length: 60 }, (_, index) => 32701 + index),
  ...Array.from({ length: 11 }, (_, index) => 25828 + index),
].map((number) => `EPSG:${number}`);

function known(code: string) {
  const crs = crsOf(code);
  if (crs === null) throw new Error(`${code} is not offered`);
  return { crs, ...crsTransform(crs) };
}

describe('systems', () => {
  it('are known by all names that services give them', () => {
    for (const name of ['EPSG:25830', 'epsg:25830', 'urn:ogc:def:crs:EPSG::25830', 'urn:ogc:def:crs:EPSG:6.9:25830']) {
      expect(crsCode(name), name).toBe('EPSG:25830');
    }
    expect(crsCode('http://www.opengis.net/def/crs/EPSG/0/25830')).toBe('EPSG:25830');
    expect(['CRS:84', 'urn:ogc:def:crs:OGC:1.3:CRS84'].map(crsCode)).toEqual(['EPSG:4326', 'EPSG:4326']);
    expect(crsCode('EPSG:900913')).toBe('EPSG:3857');
  });

  it('that the map cannot warp are refused', () => {
    for (const name of ['EPSG:27700', 'EPSG:32600', 'EPSG:32661', 'EPSG:25827', 'AUTO2:42001', '', 'EPSG:']) {
      expect(crsOf(name), name).toBeNull();
    }
  });

  it('are chosen for the fewest warps', () => {
    expect(preferredCrs(['EPSG:4326', 'EPSG:25830', 'EPSG:3857'])?.code).toBe('EPSG:3857');
    expect(preferredCrs(['EPSG:25829', 'EPSG:25830', 'EPSG:23030'], -3.7)?.code).toBe('EPSG:25830');
    expect(preferredCrs(['EPSG:27700'])).toBeNull();
  });
});

describe('map coordinates', () => {
  it('agree with PROJ to a millimetre', () => {
    for (const [code, lon_deg, lat_deg, x, y] of PROJ) {
      const { fromLonLat, toLonLat } = known(code);
      const [ourX, ourY] = fromLonLat({ lon_deg, lat_deg }) ?? [NaN, NaN];
      expect(Math.hypot(ourX - x, ourY - y), `${code} ${lat_deg} ${lon_deg}`).toBeLessThan(1e-3);
      const back = toLonLat([x, y]);
      expect(back?.lat_deg).toBeCloseTo(lat_deg, 7);
      expect(wrap180_deg((back?.lon_deg ?? NaN) - lon_deg)).toBeCloseTo(0, 7);
    }
  });

  it('come back to the same pixel, in every system, anywhere in it', () => {
    let compared = 0;
    for (const code of OFFERED) {
      const { crs, fromLonLat, toLonLat } = known(code);
      const falseNorthing = crs.hemisphere === 'south' ? 1e7 : 0;
      const unit = crs.kind === 'geographic' ? 1 / 111_320 : 1;
      const where = {
        'web-mercator': { lon: [-180, 180], lat: [-85.05, 85.05] },
        geographic: { lon: [-180, 180], lat: [-90, 90] },
        // a zone, and two more to each side: orthophotos of a whole country come in one zone
        utm: {
          lon: [(crs.zone ?? 0) * 6 - 198, (crs.zone ?? 0) * 6 - 168],
          lat: crs.hemisphere === 'south' ? [-84, 8] : [-8, 84],
        },
        polar: { lon: [-180, 180], lat: crs.hemisphere === 'south' ? [-89.99, -50] : [50, 89.99] },
      }[crs.kind] as { lon: [number, number]; lat: [number, number] };
      fc.assert(
        fc.property(
          fc.double({ min: where.lon[0], max: where.lon[1], noNaN: true }),
          fc.double({ min: where.lat[0], max: where.lat[1], noNaN: true }),
          // a centimetre to ten kilometres in a pixel
          fc.double({ min: -2, max: 4, noNaN: true }),
          fc.tuple(fc.integer({ min: -4000, max: 4000 }), fc.integer({ min: -4000, max: 4000 })),
          (lon, lat_deg, power, [right, down]) => {
            const resolution = 10 ** power * unit;
            const at = fromLonLat({ lon_deg: wrap180_deg(lon), lat_deg });
            expect(at).not.toBeNull();
            const [centreX, centreY] = at as CrsXY;
            const pixel: CrsXY = [centreX + right * resolution, centreY - down * resolution];
            const place = toLonLat(pixel);
            if (place === null) return;
            // a pixel of a wide view may lie where the system ends, or beyond where it folds back
            const isInside =
              crs.kind === 'geographic' ||
              (crs.kind === 'web-mercator' && Math.abs(pixel[1]) <= MERCATOR_HALF_M) ||
              (crs.kind === 'utm' &&
                Math.abs(pixel[0] - 500_000) < 3e6 &&
                Math.abs(pixel[1] - falseNorthing) < 9.4e6) ||
              (crs.kind === 'polar' && Math.hypot(...pixel) < 6e6);
            if (!isInside) return;
            const back = fromLonLat(place);
            expect(back, `${code} ${pixel}`).not.toBeNull();
            const [x, y] = back as CrsXY;
            const world =
              crs.kind === 'web-mercator' ? 2 * MERCATOR_HALF_M : crs.kind === 'geographic' ? 360 : Infinity;
            const worlds = Number.isFinite(world) ? Math.round((pixel[0] - x) / world) * world : 0;
            expect(Math.hypot(x + worlds - pixel[0], y - pixel[1]) / resolution).toBeLessThanOrEqual(0.01);
            compared += 1;
          },
        ),
        { numRuns: 40, seed: 20_261_121 },
      );
    }
    expect(compared).toBeGreaterThan(OFFERED.length * 20);
  });

  it('end where Web Mercator ends', () => {
    expect(MERCATOR_LIMIT_DEG).toBeCloseTo(85.051129, 6);
    const { fromLonLat } = known('EPSG:3857');
    expect(fromLonLat({ lon_deg: 0, lat_deg: MERCATOR_LIMIT_DEG })?.[1]).toBeCloseTo(MERCATOR_HALF_M, 3);
    expect(fromLonLat({ lon_deg: 0, lat_deg: 86 })).toBeNull();
    expect([85, -85, 85.06, -90].map(isOnMercator)).toEqual([true, true, false, false]);
  });
});
