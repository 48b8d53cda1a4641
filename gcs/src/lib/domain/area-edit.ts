/**
 * Editing of the areas of a plan: the zones of its fence, the fence's return point and the rally points. Each operation
 * takes them and gives the next ones, and never changes what it took.
 */

import { destination, distance_m } from './geo';
import { type LonLat, rounded } from './lonlat';
import { edgesOf, inserted, middleOf, moved, shifted } from './outline';
import { type Fence, type FenceZone, FRAME, type HeightFrame, type RallyPoint } from './plan';

export interface Areas {
  readonly fence: Fence;
  readonly rally: readonly RallyPoint[];
}

/** A place of an area that can be taken and moved. */
export type AreaHandle =
  | { readonly kind: 'corner'; readonly zone: number; readonly corner: number }
  /** Halfway from a corner to the next: moving it makes a corner there. */
  | { readonly kind: 'edge'; readonly zone: number; readonly corner: number }
  | { readonly kind: 'centre'; readonly zone: number }
  /** On a circle, east of its centre: moving it changes the radius. */
  | { readonly kind: 'radius'; readonly zone: number }
  | { readonly kind: 'return' }
  | { readonly kind: 'rally'; readonly index: number }
  /** At the end of an arrow from a survey's middle: turning it turns the lines. */
  | { readonly kind: 'course'; readonly zone: number };

export interface PlacedHandle {
  readonly handle: AreaHandle;
  readonly at: LonLat;
  /** The ends of the edge that it lies in the middle of. */
  readonly ends?: readonly [LonLat, LonLat];
}

/** Most corners of a polygon: ArduPilot counts them in 8 bits. */
const MAX_CORNERS = 255;
/** Circles smaller than this are a slip of the hand, metres. */
export const MIN_RADIUS_M = 10;
export const MAX_RADIUS_M = 100_000;

export const sameHandle = (a: AreaHandle | null, b: AreaHandle | null): boolean =>
  a === null || b === null ? a === b : JSON.stringify(a) === JSON.stringify(b);

/** The zone that a handle belongs to; `null` for a return or rally point. */
export const zoneOf = (handle: AreaHandle | null): number | null =>
  handle !== null && 'zone' in handle ? handle.zone : null;

/** Middle of a zone: of a circle its centre, of a polygon the mean of its corners. */
export function middleOfZone(zone: FenceZone): LonLat | null {
  return zone.shape === 'circle' ? (zone.points[0] ?? null) : middleOf(zone.points);
}

/** Handles of a polygon's corners, or of the points of a line, and of the middles between them while there may be more. */
export function outlineHandles(
  points: readonly LonLat[],
  isClosed: boolean,
  zone: number,
  most: number,
): PlacedHandle[] {
  const corners = points.map((at, corner): PlacedHandle => ({ handle: { kind: 'corner', zone, corner }, at }));
  const edges = points.length < most ? edgesOf(points, isClosed) : [];
  return [
    ...corners,
    ...edges.map(({ after, middle, ends }): PlacedHandle => {
      return { handle: { kind: 'edge', zone, corner: after }, at: middle, ends };
    }),
  ];
}

/** What can be moved of the fence, in the order in which a pointer takes them: corners before middles. */
export function fenceHandles({ zones, return_point }: Fence): PlacedHandle[] {
  const handles: PlacedHandle[] = [];
  if (return_point !== null) handles.push({ handle: { kind: 'return' }, at: return_point });
  for (const [zone, { shape, points, radius_m }] of zones.entries()) {
    const [first] = points;
    if (first === undefined) continue;
    if (shape === 'circle') {
      handles.push({ handle: { kind: 'radius', zone }, at: destination(first, 90, radius_m ?? 0) });
    } else handles.push(...outlineHandles(points, true, zone, MAX_CORNERS));
    const middle = middleOfZone(zones[zone] as FenceZone);
    if (middle !== null) handles.push({ handle: { kind: 'centre', zone }, at: middle });
  }
  return handles;
}

export const rallyHandles = (rally: readonly RallyPoint[]): PlacedHandle[] =>
  rally.map((at, index) => ({ handle: { kind: 'rally', index }, at }));

interface Moved {
  readonly areas: Areas;
  /** The handle held from now on: an edge that is moved becomes a corner. */
  readonly handle: AreaHandle;
}

/** Takes what a handle stands for from one place to another. */
export function moveHandle(areas: Areas, handle: AreaHandle, from: LonLat, to: LonLat): Moved {
  const { fence, rally } = areas;
  const place = rounded(to);
  const zoned = (zone: number, change: (zone: FenceZone) => FenceZone): Areas => ({
    ...areas,
    fence: withZone(fence, zone, change),
  });
  switch (handle.kind) {
    case 'corner':
      return {
        handle,
        areas: zoned(handle.zone, (zone) => ({ ...zone, points: moved(zone.points, handle.corner, place) })),
      };
    case 'edge': {
      const corner = handle.corner + 1;
      return {
        handle: { kind: 'corner', zone: handle.zone, corner },
        areas: zoned(handle.zone, (zone) => ({ ...zone, points: inserted(zone.points, corner, place) })),
      };
    }
    case 'centre':
      return {
        handle,
        areas: zoned(handle.zone, (zone) => ({ ...zone, points: shifted(zone.points, from, to) })),
      };
    case 'radius':
      return {
        handle,
        areas: zoned(handle.zone, (zone) => {
          const [centre] = zone.points;
          return centre === undefined ? zone : { ...zone, radius_m: within(Math.round(distance_m(centre, to))) };
        }),
      };
    case 'return':
      return {
        handle,
        areas:
          fence.return_point === null
            ? areas
            : { ...areas, fence: { ...fence, return_point: { ...fence.return_point, ...place } } },
      };
    case 'rally':
      return {
        handle,
        areas: {
          ...areas,
          rally: rally.map((point, index) => (index === handle.index ? { ...point, ...place } : point)),
        },
      };
    case 'course':
      return { handle, areas };
  }
}

const within = (radius_m: number): number => Math.min(MAX_RADIUS_M, Math.max(MIN_RADIUS_M, radius_m));

export function withZone(fence: Fence, index: number, change: (zone: FenceZone) => FenceZone): Fence {
  return { ...fence, zones: fence.zones.map((zone, at) => (at === index ? change(zone) : zone)) };
}

export function addCircle(fence: Fence, inclusion: boolean, at: LonLat, radius_m: number): Fence {
  const zone: FenceZone = { inclusion, shape: 'circle', points: [rounded(at)], radius_m: within(Math.round(radius_m)) };
  return { ...fence, zones: [...fence.zones, zone] };
}

export function addPolygon(fence: Fence, inclusion: boolean, corners: readonly LonLat[]): Fence {
  const zone: FenceZone = { inclusion, shape: 'polygon', points: corners.map(rounded), radius_m: null };
  return { ...fence, zones: [...fence.zones, zone] };
}

/** Whether a list of corners makes a polygon. */
export const isPolygon = (corners: readonly LonLat[]): boolean => corners.length >= 3 && corners.length <= MAX_CORNERS;

export const withReturnPoint = (fence: Fence, at: LonLat, alt_rel_home_m: number): Fence => ({
  ...fence,
  return_point: { ...rounded(at), alt_rel_home_m },
});

/** Takes away what a handle stands for: a corner while three are left, else its whole zone. */
export function removeHandle(areas: Areas, handle: AreaHandle): Areas {
  const { fence, rally } = areas;
  switch (handle.kind) {
    case 'corner': {
      const zone = fence.zones[handle.zone];
      if (zone !== undefined && zone.points.length > 3) {
        const points = zone.points.filter((_, index) => index !== handle.corner);
        return { ...areas, fence: withZone(fence, handle.zone, (one) => ({ ...one, points })) };
      }
      return removeZone(areas, handle.zone);
    }
    case 'edge':
    case 'centre':
    case 'radius':
      return removeZone(areas, handle.zone);
    case 'return':
      return { ...areas, fence: { ...fence, return_point: null } };
    case 'rally':
      return { ...areas, rally: rally.filter((_, index) => index !== handle.index) };
    case 'course':
      return areas;
  }
}

const removeZone = (areas: Areas, zone: number): Areas => ({
  ...areas,
  fence: { ...areas.fence, zones: areas.fence.zones.filter((_, index) => index !== zone) },
});

/** Rally heights are kept in whole metres, as ArduPilot stores them. */
export function addRally(rally: readonly RallyPoint[], at: LonLat, alt_m: number, frame: HeightFrame): RallyPoint[] {
  return [...rally, { ...rounded(at), alt_m: Math.round(alt_m), frame: FRAME[frame] }];
}

export function withRally(
  rally: readonly RallyPoint[],
  index: number,
  change: Partial<RallyPoint>,
): readonly RallyPoint[] {
  return rally.map((point, at) => (at === index ? { ...point, ...change } : point));
}

export const isFenceEmpty = (fence: Fence): boolean => fence.zones.length === 0 && fence.return_point === null;
