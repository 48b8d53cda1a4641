import { feature } from 'topojson-client';
import type { Topology } from 'topojson-specification';
import { expect, it } from 'vitest';
import world from 'world-atlas/land-110m.json';
import { type Corner, unwrapPolygon, unwrapRing } from './coast';

/** The longest edge, degrees of longitude, of those that do not lie along the map's edge at a pole. */
const longest = (ring: readonly Corner[]): number =>
  Math.max(
    0,
    ...ring.slice(1).map(([lon_deg, lat_deg], index) => {
      const [before_deg, beforeLat_deg] = ring[index] as Corner;
      const isEdge = Math.abs(lat_deg) > 85 && Math.abs(beforeLat_deg) > 85;
      return isEdge ? 0 : Math.abs(lon_deg - before_deg);
    }),
  );

it('goes on over the date line, on both sides of the world', () => {
  const ring: Corner[] = [
    [170, 60],
    [-170, 60],
    [-170, 70],
    [170, 70],
    [170, 60],
  ];
  expect(unwrapRing(ring).map(([lon_deg]) => lon_deg)).toEqual([170, 190, 190, 170, 170]);
  expect(unwrapPolygon([ring]).map(([one]) => one?.[0]?.[0])).toEqual([170, -190]);
});

it('draws no line across the world but along the edge, at the pole', () => {
  const land = feature(world as unknown as Topology, (world as unknown as Topology).objects['land']!);
  const parts = land.type === 'FeatureCollection' ? land.features : [land];
  let checked = 0;
  for (const { geometry } of parts) {
    if (geometry.type !== 'MultiPolygon') continue;
    for (const rings of geometry.coordinates as unknown as Corner[][][]) {
      for (const ring of unwrapPolygon(rings).flat()) {
        expect(longest(ring)).toBeLessThan(180);
        expect(ring[0]).toEqual(ring.at(-1));
        checked += 1;
      }
    }
  }
  expect(checked).toBeGreaterThan(100);
});
