/** The area or line of a survey while it is edited on the map, and where its lines begin. */

import { type AreaHandle, outlineHandles, type PlacedHandle } from './area-edit';
import { bearing_deg, destination, distance_m } from './geo';
import { type LonLat, sameLonLat } from './lonlat';
import { inserted, middleOf, moved, shifted, without } from './outline';

/** As many corners as the core takes. */
const MOST_PLACES = 1000;
/** Width of a new corridor, metres. */
export const NEW_WIDTH_M = 100;
/** Step in which a course is turned, degrees. */
const TURN_DEG = 1;

interface SurveyShape {
  readonly places: readonly LonLat[];
  /** Of a corridor, metres; `null`: the places are the corners of an area. */
  readonly width_m: number | null;
}

export const leastPlaces = ({ width_m }: Pick<SurveyShape, 'width_m'>): number => (width_m === null ? 3 : 2);

/** What can be moved; of an area also the course of its lines, by the end of an arrow that reaches beyond the corners. */
export function surveyHandles(shape: SurveyShape, course_deg: number | null): PlacedHandle[] {
  const isArea = shape.width_m === null;
  const handles = outlineHandles(shape.places, isArea, 0, MOST_PLACES);
  const centre = middleOf(shape.places);
  if (centre === null) return handles;
  if (isArea) handles.push({ handle: { kind: 'centre', zone: 0 }, at: centre });
  if (isArea && course_deg !== null)
    handles.push({ handle: { kind: 'course', zone: 0 }, at: turner(shape, course_deg) });
  return handles;
}

/** The end of the arrow that shows the course of the lines. */
export function turner({ places }: SurveyShape, course_deg: number): LonLat {
  const centre = middleOf(places) as LonLat;
  const far_m = Math.max(...places.map((place) => distance_m(centre, place)));
  return destination(centre, course_deg, 1.25 * far_m);
}

interface SurveyMove {
  /** The handle held from now on: an edge that is moved becomes a corner. */
  readonly handle: AreaHandle;
  readonly change: Partial<SurveyShape & { readonly course_deg: number }>;
}

/** Takes what a handle stands for from one place to another; `null` for a handle that surveys do not have. */
export function moveSurvey(shape: SurveyShape, handle: AreaHandle, from: LonLat, to: LonLat): SurveyMove | null {
  const { places } = shape;
  switch (handle.kind) {
    case 'corner':
      return { handle, change: { places: moved(places, handle.corner, to) } };
    case 'edge': {
      const corner = handle.corner + 1;
      return { handle: { kind: 'corner', zone: 0, corner }, change: { places: inserted(places, corner, to) } };
    }
    case 'centre':
      return { handle, change: { places: shifted(places, from, to) } };
    case 'course': {
      const centre = middleOf(places);
      if (centre === null || sameLonLat(centre, to)) return null;
      return { handle, change: { course_deg: (Math.round(bearing_deg(centre, to) / TURN_DEG) * TURN_DEG) % 360 } };
    }
    default:
      return null;
  }
}

/** The places without a corner; `null` when too few would be left, or the handle is no corner. */
export function withoutCorner(shape: SurveyShape, handle: AreaHandle): LonLat[] | null {
  if (handle.kind !== 'corner' || shape.places.length <= leastPlaces(shape)) return null;
  return without(shape.places, handle.corner);
}
