import { describe, expect, it } from 'vitest';
import { boxAround, boxCorners, boxOf, groundResolution_m, levelFor } from './tiling';
import { MERCATOR_HALF_M } from './projection';

describe('levels', () => {
  it('are as fine on the ground as they are', () => {
    // OpenStreetMap's published table of zoom levels, metres in a pixel at the equator
    const pixel = (zoom: number): number => (2 * MERCATOR_HALF_M) / 256 / 2 ** zoom;
    expect(groundResolution_m('EPSG:3857', pixel(0), 0)).toBeCloseTo(156_543.03, 1);
    expect(groundResolution_m('EPSG:3857', pixel(17), 0)).toBeCloseTo(1.1943, 4);
    expect(groundResolution_m('EPSG:3857', pixel(17), 60)).toBeCloseTo(0.5972, 4);
    expect(groundResolution_m('EPSG:25830', 0.5, 40)).toBe(0.5);
    expect(groundResolution_m('EPSG:4326', 0.001, 40)).toBeCloseTo(111.13, 2);
  });

  it('are found by how fine they should be', () => {
    const levels = Array.from({ length: 20 }, (_, z) => ({ resolution: 156_543.033928041 / 2 ** z }));
    const grid = { crs: 'EPSG:3857', levels, min_level: 2, max_level: 18 };
    expect(levelFor(grid, 1.3, 0)).toBe(16);
    expect(levelFor(grid, 1.1, 0)).toBe(17);
    expect(levelFor(grid, 0.001, 0)).toBe(18);
    expect(levelFor(grid, 1e9, 0)).toBe(2);
  });
});

describe('boxes', () => {
  const at = (lon_deg: number, lat_deg: number) => ({ lon_deg, lat_deg });

  it('take the shorter way around the world', () => {
    expect(boxOf(at(-4, 41), at(-3, 40))).toEqual({ west_deg: -4, east_deg: -3, south_deg: 40, north_deg: 41 });
    expect(boxOf(at(-179, 1), at(179, -1))).toMatchObject({ west_deg: 179, east_deg: -179 });
  });

  it('have corners in turn, going on over the date line', () => {
    expect(boxCorners({ west_deg: 179, east_deg: -179, south_deg: -1, north_deg: 1 })).toEqual([
      at(179, 1),
      at(181, 1),
      at(181, -1),
      at(179, -1),
    ]);
  });

  it('hold places tightly, on either side of the date line', () => {
    expect(boxAround([at(-4, 41), at(-3, 40), at(-3.5, 42)])).toEqual({
      west_deg: -4,
      east_deg: -3,
      south_deg: 40,
      north_deg: 42,
    });
    expect(boxAround([at(179, 1), at(-178, 2), at(179.5, 0)])).toMatchObject({ west_deg: 179, east_deg: -178 });
    expect(boxAround([at(10, 5)])).toMatchObject({ west_deg: 10, east_deg: 10 });
    expect(boxAround([])).toBeNull();
  });
});
