// Easting and northing, by the map library's own projection.
import { makeProjection, makeTransforms } from 'ol/proj/utm';
import type { UtmProjection } from '$lib/domain/coordinates';

type Transform = (input: number[], output?: number[], dimension?: number) => number[];

const forwards = new Map<string, Transform>();

/** EPSG:326zz in the north, EPSG:327zz in the south (WGS 84). */
export const projectUtm: UtmProjection = ({ lon_deg, lat_deg }, { zone, isNorth }) => {
  const code = `EPSG:${(isNorth ? 32_600 : 32_700) + zone}`;
  let forward = forwards.get(code);
  if (forward === undefined) {
    const projection = makeProjection(code);
    const transforms = projection === null ? null : makeTransforms(projection);
    if (transforms === null) throw new Error(`no projection ${code}`);
    forward = transforms.forward as Transform;
    forwards.set(code, forward);
  }
  const [east_m = 0, north_m = 0] = forward([lon_deg, lat_deg], undefined, 2);
  return [east_m, north_m];
};
