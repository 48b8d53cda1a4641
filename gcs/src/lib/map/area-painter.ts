// Fence and rally points: zones to stay in and out of, the polygon being drawn, and the places that can be moved.
import { type AreaHandle, type PlacedHandle, sameHandle, zoneOf } from '$lib/domain/area-edit';
import { circle, geodesicLine } from '$lib/domain/geo';
import type { LonLat } from '$lib/domain/lonlat';
import type { Fence, RallyPoint } from '$lib/domain/plan';
import { type Frame, haloText, type Painter, type Projection, strokeWithEdge, traceLine, type XY } from './frame';
import { toLine, toXY } from './route-view';

export interface AreaView {
  readonly fence: Fence;
  readonly rally: readonly RallyPoint[];
  /** What the vehicle has, where that is another; `null` when it is not shown. */
  readonly vehicleFence: Fence | null;
  readonly vehicleRally: readonly RallyPoint[] | null;
  /** What can be moved now; empty while nothing of this is edited. */
  readonly handles: readonly PlacedHandle[];
  readonly selected: AreaHandle | null;
  /** Corners so far of a polygon that is being drawn. */
  readonly sketch: readonly LonLat[];
  /** Whether clicks on the map are for areas. */
  readonly isEditing: boolean;
}

export interface AreaTexts {
  /** Names a zone: "1 · stay inside". */
  zone(number: number, isInclusion: boolean): string;
}

export const NO_AREAS: AreaView = {
  fence: { zones: [], return_point: null },
  rally: [],
  vehicleFence: null,
  vehicleRally: null,
  handles: [],
  selected: null,
  sketch: [],
  isEditing: false,
};

/** A zone as it is drawn. */
interface DrawnZone {
  readonly isInclusion: boolean;
  readonly line: readonly XY[];
  /** Its northernmost point: there it is named. */
  readonly top: XY;
}

const HANDLE_PX = { corner: 8, radius: 8, centre: 9, edge: 6, return: 12, rally: 13 } as const;

export class AreaPainter implements Painter {
  texts: AreaTexts = { zone: () => '' };
  /** Where the next corner would be. */
  pointer: LonLat | null = null;
  #view: AreaView = NO_AREAS;
  #zones: readonly DrawnZone[] = [];
  #vehicleZones: readonly DrawnZone[] = [];
  #handles: readonly { readonly handle: AreaHandle; readonly place: LonLat; readonly at: XY }[] = [];

  get view(): AreaView {
    return this.#view;
  }
  set view(view: AreaView) {
    if (view.fence !== this.#view.fence) this.#zones = drawn(view.fence);
    if (view.vehicleFence !== this.#view.vehicleFence)
      this.#vehicleZones = view.vehicleFence ? drawn(view.vehicleFence) : [];
    if (view.handles !== this.#view.handles) {
      this.#handles = view.handles.map(({ handle, at }) => ({ handle, place: at, at: toXY(at) }));
    }
    this.#view = view;
  }

  paint(frame: Frame): void {
    const { context, theme } = frame;
    context.setLineDash([2, 5]);
    for (const zone of this.#vehicleZones) {
      context.beginPath();
      traceLine(frame, zone.line);
      context.strokeStyle = theme.muted;
      context.lineWidth = 2;
      context.stroke();
    }
    context.setLineDash([]);
    const selectedZone = zoneOf(this.#view.selected);
    for (const [index, zone] of this.#zones.entries()) this.#paintZone(frame, zone, index, index === selectedZone);
  }

  /** What lies above the route: points, the drawing, and what can be moved. */
  readonly marks: Painter = { paint: (frame) => this.#paintMarks(frame) };

  #paintMarks(frame: Frame): void {
    const { theme } = frame;
    this.#paintSketch(frame);
    for (const point of this.#view.vehicleRally ?? []) pin(frame, frame.pixel(toXY(point)), 'R', theme.muted, false);
    this.#view.rally.forEach((point, index) => {
      const isSelected = this.#view.selected?.kind === 'rally' && this.#view.selected.index === index;
      pin(frame, frame.pixel(toXY(point)), `R${index + 1}`, theme.estimated, isSelected);
    });
    const { return_point } = this.#view.fence;
    if (return_point !== null) {
      pin(frame, frame.pixel(toXY(return_point)), 'F', theme.ok, this.#view.selected?.kind === 'return');
    }
    for (const { handle, at } of this.#handles) this.#paintHandle(frame, handle, frame.pixel(at));
  }

  /** What can be moved at a pixel: the nearest; corners before the middles of edges. */
  handleAt(
    frame: Projection,
    x: number,
    y: number,
    tolerance_px: number,
  ): { handle: AreaHandle; place: LonLat } | null {
    let best: { handle: AreaHandle; place: LonLat } | null = null;
    let nearest = Infinity;
    for (const { handle, place, at } of this.#handles) {
      const [hx, hy] = frame.pixel(at);
      const distance = Math.hypot(hx - x, hy - y);
      if (distance > Math.max(HANDLE_PX[handle.kind], tolerance_px)) continue;
      if (handle.kind === 'edge' && !this.#hasRoom(frame, handle)) continue;
      const rank = distance + (handle.kind === 'edge' ? 6 : 0);
      if (rank < nearest) [best, nearest] = [{ handle, place }, rank];
    }
    return best;
  }

  /** Whether a pixel is on the first corner of the drawing: a click there closes it. */
  closesSketch(frame: Projection, x: number, y: number, tolerance_px: number): boolean {
    const [first] = this.#view.sketch;
    if (first === undefined || this.#view.sketch.length < 3) return false;
    const [fx, fy] = frame.pixel(toXY(first));
    return Math.hypot(fx - x, fy - y) <= Math.max(10, tolerance_px);
  }

  /** Halfway handles of short edges would hide the corners. */
  #hasRoom(frame: Projection, handle: AreaHandle & { kind: 'edge' }): boolean {
    const points = this.#view.fence.zones[handle.zone]?.points ?? [];
    const [from, to] = [points[handle.corner], points[(handle.corner + 1) % points.length]];
    if (from === undefined || to === undefined) return false;
    const [a, b] = [frame.pixel(toXY(from)), frame.pixel(toXY(to))];
    return Math.hypot(a[0] - b[0], a[1] - b[1]) > 56;
  }

  #paintZone(frame: Frame, zone: DrawnZone, index: number, isSelected: boolean): void {
    const { context, theme } = frame;
    const colour = zone.isInclusion ? theme.ok : theme.danger;
    context.lineJoin = 'round';
    context.beginPath();
    traceLine(frame, zone.line);
    if (!zone.isInclusion) hatch(frame, colour);
    context.beginPath();
    traceLine(frame, zone.line);
    // stayed out of: dashed and hatched; stayed in: one whole line
    context.setLineDash(zone.isInclusion ? [] : [8, 5]);
    strokeWithEdge(frame, colour, isSelected ? 4 : 2.5, 1.5);
    context.setLineDash([]);
    context.font = `600 12px ${theme.font}`;
    context.textAlign = 'center';
    context.textBaseline = 'bottom';
    const [x, y] = frame.pixel(zone.top);
    haloText(frame, this.texts.zone(index + 1, zone.isInclusion), x, y - 10, isSelected ? theme.text : colour);
  }

  #paintSketch(frame: Frame): void {
    const { sketch } = this.#view;
    if (sketch.length === 0) return;
    const { context, theme } = frame;
    const corners = this.pointer === null ? sketch : [...sketch, this.pointer];
    context.setLineDash([6, 4]);
    context.beginPath();
    traceLine(frame, border(corners, corners.length > 2));
    strokeWithEdge(frame, theme.accent, 2.5, 1.5);
    context.setLineDash([]);
    sketch.forEach((corner, index) => {
      const [x, y] = frame.pixel(toXY(corner));
      // the first is larger: a click on it closes
      dot(frame, x, y, index === 0 && sketch.length >= 3 ? 9 : 5, index === 0 && sketch.length >= 3);
    });
  }

  #paintHandle(frame: Frame, handle: AreaHandle, [x, y]: XY): void {
    const isSelected = sameHandle(handle, this.#view.selected);
    switch (handle.kind) {
      case 'corner':
        dot(frame, x, y, 7, isSelected);
        break;
      case 'edge':
        if (this.#hasRoom(frame, handle)) plus(frame, x, y);
        break;
      case 'radius':
        dot(frame, x, y, 7, isSelected);
        break;
      case 'centre':
        cross(frame, x, y, zoneOf(this.#view.selected) === handle.zone);
        break;
      default:
    }
  }
}

/** A closed line over the corners, bent as the ground is. */
function border(corners: readonly LonLat[], isClosed = true): XY[] {
  const points = corners.flatMap((from, index) => {
    const to = corners[(index + 1) % corners.length] as LonLat;
    const isLast = index === corners.length - 1;
    return isLast && !isClosed ? [from] : geodesicLine(from, to).slice(0, -1);
  });
  const [first] = corners;
  return toLine(isClosed && first !== undefined ? [...points, first] : points);
}

function drawn({ zones }: Fence): DrawnZone[] {
  return zones.flatMap(({ inclusion, shape, points, radius_m }) => {
    const [first] = points;
    if (first === undefined) return [];
    const line = shape === 'circle' ? toLine(circle(first, radius_m ?? 0, 96)) : border(points);
    const top = line.reduce((best, point) => (point[1] > best[1] ? point : best));
    return [{ isInclusion: inclusion, line, top }];
  });
}

/** Fills the current path with slanted lines. */
function hatch({ context, size }: Frame, colour: string): void {
  context.save();
  context.clip();
  context.beginPath();
  for (let x = -size.height; x < size.width; x += 14) {
    context.moveTo(x, size.height);
    context.lineTo(x + size.height, 0);
  }
  context.strokeStyle = colour;
  context.globalAlpha = 0.3;
  context.lineWidth = 2;
  context.stroke();
  context.restore();
}

function dot({ context, theme }: Frame, x: number, y: number, radius: number, isFull: boolean): void {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fillStyle = isFull ? theme.accent : theme.surface;
  context.fill();
  context.strokeStyle = isFull ? theme.text : theme.accent;
  context.lineWidth = 2;
  context.stroke();
}

function plus(frame: Frame, x: number, y: number): void {
  dot(frame, x, y, 6, false);
  const { context } = frame;
  context.beginPath();
  context.moveTo(x - 3, y);
  context.lineTo(x + 3, y);
  context.moveTo(x, y - 3);
  context.lineTo(x, y + 3);
  context.stroke();
}

/** Four arrows: the whole zone is moved here. */
function cross({ context, theme }: Frame, x: number, y: number, isSelected: boolean): void {
  context.beginPath();
  context.rect(x - 8, y - 8, 16, 16);
  context.fillStyle = isSelected ? theme.accent : theme.surface;
  context.fill();
  context.strokeStyle = theme.accent;
  context.lineWidth = 2;
  context.stroke();
  context.beginPath();
  context.moveTo(x - 5, y);
  context.lineTo(x + 5, y);
  context.moveTo(x, y - 5);
  context.lineTo(x, y + 5);
  context.strokeStyle = isSelected ? theme.surface : theme.accent;
  context.stroke();
}

/** A diamond with a letter. */
function pin(frame: Frame, [x, y]: XY, text: string, colour: string, isSelected: boolean): void {
  const { context, theme } = frame;
  const r = 15;
  const outline = (): void => {
    context.beginPath();
    context.moveTo(x, y - r);
    context.lineTo(x + r, y);
    context.lineTo(x, y + r);
    context.lineTo(x - r, y);
    context.closePath();
  };
  outline();
  context.lineJoin = 'round';
  context.strokeStyle = isSelected ? theme.text : theme.surface;
  context.lineWidth = isSelected ? 8 : 5;
  context.stroke();
  outline();
  context.fillStyle = isSelected ? colour : theme.surface;
  context.fill();
  context.strokeStyle = colour;
  context.lineWidth = 2.5;
  context.stroke();
  context.fillStyle = isSelected ? theme.surface : theme.text;
  context.font = `700 ${text.length > 2 ? 9 : 11}px ${theme.font}`;
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  context.fillText(text, x, y + 0.5);
}
