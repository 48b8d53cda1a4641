/** Distances, bearings and shapes on the WGS-84 ellipsoid: Karney, "Algorithms for geodesics" (2013), by GeographicLib. */

import geodesic from 'geographiclib-geodesic';
import { type LonLat, wrap180_deg, wrap360_deg } from './lonlat';

const { Geodesic } = geodesic;
const WGS84 = Geodesic.WGS84;

/** Length of the geodesic between two positions, metres. */
export function distance_m(from: LonLat, to: LonLat): number {
  const { s12 } = WGS84.Inverse(from.lat_deg, from.lon_deg, to.lat_deg, to.lon_deg, Geodesic.DISTANCE);
  return s12 ?? 0;
}

/** Bearing at `from` of the geodesic to `to`, 0 to 360 degrees clockwise from true north. */
export function bearing_deg(from: LonLat, to: LonLat): number {
  const { azi1 } = WGS84.Inverse(from.lat_deg, from.lon_deg, to.lat_deg, to.lon_deg, Geodesic.AZIMUTH);
  return wrap360_deg(azi1 ?? 0);
}

/** Where one is after going `distance_m` along the geodesic that leaves `from` with `bearing_deg`. */
export function destination(from: LonLat, bearing_deg: number, distance_m: number): LonLat {
  const { lat2, lon2 } = WGS84.Direct(from.lat_deg, from.lon_deg, bearing_deg, distance_m);
  return { lat_deg: lat2 ?? from.lat_deg, lon_deg: wrap180_deg(lon2 ?? from.lon_deg) };
}

/** The point of the geodesic that lies at `part` (0 to 1) of the way. */
export function between(from: LonLat, to: LonLat, part: number): LonLat {
  const inverse = WGS84.Inverse(from.lat_deg, from.lon_deg, to.lat_deg, to.lon_deg);
  return destination(from, inverse.azi1 ?? 0, (inverse.s12 ?? 0) * part);
}

/**
 * Points of the geodesic between two positions, ends included. On a map a short leg is straight to the eye; a long
 * one bends, so it gets a point at least every `step_m`.
 */
export function geodesicLine(from: LonLat, to: LonLat, step_m = 20_000): LonLat[] {
  const inverse = WGS84.Inverse(from.lat_deg, from.lon_deg, to.lat_deg, to.lon_deg);
  const length_m = inverse.s12 ?? 0;
  const pieces = Math.min(Math.ceil(length_m / step_m), 512);
  const points: LonLat[] = [from];
  for (let index = 1; index < pieces; index += 1) {
    points.push(destination(from, inverse.azi1 ?? 0, (length_m * index) / pieces));
  }
  points.push(to);
  return points;
}

/** A closed circle around a position; the first point is repeated at the end. */
export function circle(centre: LonLat, radius_m: number, points = 64): LonLat[] {
  return Array.from({ length: points + 1 }, (_, index) =>
    destination(centre, ((index % points) * 360) / points, Math.abs(radius_m)),
  );
}

/** How far `to` lies north and east of `from`, metres; for short distances, as along the bearing of the geodesic. */
export function offset_m(from: LonLat, to: LonLat): { north_m: number; east_m: number } {
  const inverse = WGS84.Inverse(from.lat_deg, from.lon_deg, to.lat_deg, to.lon_deg);
  const azimuth_rad = ((inverse.azi1 ?? 0) * Math.PI) / 180;
  const distance = inverse.s12 ?? 0;
  return { north_m: distance * Math.cos(azimuth_rad), east_m: distance * Math.sin(azimuth_rad) };
}
