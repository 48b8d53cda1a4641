/** Outlines of land on a flat map: without the lines that a jump over the date line would draw across the world. */

/** Longitude and latitude, degrees. */
export type Corner = readonly [lon_deg: number, lat_deg: number];

/** Poles lie at infinity on a Mercator map; land that reaches farther is cut here. */
const LAST_LAT_DEG = 85.06;

/**
 * The ring with longitudes that go on over 180° instead of jumping, so that its edges stay short. One that goes round a pole
 * is closed along the map's edge there.
 */
export function unwrapRing(ring: readonly Corner[]): [number, number][] {
  let shift_deg = 0;
  const line = ring.map(([lon_deg, lat_deg], index): [number, number] => {
    const before = ring[index - 1];
    if (before && lon_deg - before[0] > 180) shift_deg -= 360;
    if (before && lon_deg - before[0] < -180) shift_deg += 360;
    return [lon_deg + shift_deg, Math.max(-LAST_LAT_DEG, Math.min(LAST_LAT_DEG, lat_deg))];
  });
  const [first, last] = [line[0], line.at(-1)];
  if (first && last && Math.abs(last[0] - first[0]) > 180) {
    const edge_deg = Math.sign(line.reduce((sum, [, lat_deg]) => sum + lat_deg, 0)) * LAST_LAT_DEG;
    line.push([last[0], edge_deg], [first[0], edge_deg], [first[0], first[1]]);
  }
  return line;
}

/** A polygon unwrapped, with its copy on the other side of the world where it reaches over the date line. */
export function unwrapPolygon(rings: readonly (readonly Corner[])[]): [number, number][][][] {
  const flat = rings.map(unwrapRing);
  const lons = (flat[0] ?? []).map(([lon_deg]) => lon_deg);
  const shift_deg = Math.max(...lons) > 180 ? -360 : Math.min(...lons) < -180 ? 360 : 0;
  if (shift_deg === 0) return [flat];
  return [flat, flat.map((ring) => ring.map(([lon_deg, lat_deg]) => [lon_deg + shift_deg, lat_deg]))];
}
