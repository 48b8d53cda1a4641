// Makes a coordinate system known to OpenLayers, when a source needs it.
import {
  addCoordinateTransforms,
  addProjection,
  fromLonLat as toMercator,
  get as getProjection,
  toLonLat as fromMercator,
} from 'ol/proj';
import Projection from 'ol/proj/Projection';
import { type Crs, crsOf } from '$lib/domain/projection';
import type { CrsTransform } from '$lib/domain/projection-transform';

/** The system that map libraries know and everything is turned through. */
const GEOGRAPHIC = 'EPSG:4326';
const VIEW = 'EPSG:3857';
const NOWHERE = [Number.NaN, Number.NaN];

/** The projection of a code, known from now on; `null` when the map cannot warp it. */
export async function projectionFor(code: string): Promise<Projection | null> {
  const crs = crsOf(code);
  if (crs === null) return null;
  const known = getProjection(crs.code);
  if (known !== null) return known;
  // loaded when it is needed: most people never do
  const { crsTransform } = await import('$lib/domain/projection-transform');
  return getProjection(crs.code) ?? register(crs, crsTransform(crs));
}

function register(crs: Crs, { fromLonLat, toLonLat }: CrsTransform): Projection {
  const isGeographic = crs.kind === 'geographic';
  const projection = new Projection({
    code: crs.code,
    units: isGeographic ? 'degrees' : 'm',
    // so that it goes around the world as EPSG:4326 does
    ...(isGeographic && { extent: [-180, -90, 180, 90], global: true }),
  });
  addProjection(projection);
  const forward = (at: readonly number[]): number[] => {
    const [lon_deg = Number.NaN, lat_deg = Number.NaN] = at;
    return [...(fromLonLat({ lon_deg, lat_deg }) ?? NOWHERE)];
  };
  const inverse = (xy: readonly number[]): number[] => {
    const [x = Number.NaN, y = Number.NaN] = xy;
    const place = Number.isFinite(x) && Number.isFinite(y) ? toLonLat([x, y]) : null;
    return place === null ? NOWHERE : [place.lon_deg, place.lat_deg];
  };
  addCoordinateTransforms(GEOGRAPHIC, projection, forward, inverse);
  addCoordinateTransforms(
    VIEW,
    projection,
    (xy: number[]) => forward(fromMercator(xy)),
    (xy: number[]) => {
      const place = inverse(xy);
      return Number.isFinite(place[0]) ? toMercator(place) : NOWHERE;
    },
  );
  return projection;
}
