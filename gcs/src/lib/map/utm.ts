// Easting and northing, by the map library's own projection.
import { makeProjection, makeTransforms } from 'ol/proj/utm';
import type { UtmProjection, UtmUnprojection } from '$lib/domain/coordinates';
import { lonLat } from '$lib/domain/lonlat';

type Transform = (input: number[], output?: number[], dimension?: number) => number[];

interface Transforms {
  readonly forward: Transform;
  readonly inverse: Transform;
}

const known = new Map<string, Transforms>();

/** EPSG:326zz in the north, EPSG:327zz in the south (WGS 84). */
function transformsOf({ zone, isNorth }: { readonly zone: number; readonly isNorth: boolean }): Transforms {
  const code = `EPSG:${(isNorth ? 32_600 : 32_700) + zone}`;
  let found = known.get(code);
  if (found === undefined) {
    const projection = makeProjection(code);
    const transforms = projection === null ? null : makeTransforms(projection);
    if (transforms === null) throw new Error(`no projection ${code}`);
    found = transforms as Transforms;
    known.set(code, found);
  }
  return found;
}

export const projectUtm: UtmProjection = ({ lon_deg, lat_deg }, zone) => {
  const [east_m = 0, north_m = 0] = transformsOf(zone).forward([lon_deg, lat_deg], undefined, 2);
  return [east_m, north_m];
};

export const unprojectUtm: UtmUnprojection = (east_m, north_m, zone) => {
  const [lon_deg, lat_deg] = transformsOf(zone).inverse([east_m, north_m], undefined, 2);
  return lonLat(lon_deg, lat_deg);
};
