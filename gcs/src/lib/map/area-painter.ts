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
  /** What is on the vehicle, where it differs; `null` when it is not shown. */
  readonly vehicleFence: Fence | null;
  readonly vehicleRally: readonly RallyPoint[] | null;
  /** What can be moved now; empty while nothing of this is edited. */
  readonly handles: readonly PlacedHandle[];
  readonly selected: AreaHandle | null;
  /** Corners so far of a polygon that is being drawn, or points of a line. */
  readonly sketch: readonly LonLat[];
  readonly isSketchLine: boolean;
  /** Whether clicks on the map are for areas. */
  readonly isEditing: boolean;
}

export interface AreaTexts {
  /** Names a zone: "1 · stay inside". */
  zone(number: number, isInclusion: boolean): string;
}

const NO_AREAS: AreaView = {
  fence: { zones: [], return_point: null },
  rally: [],
  vehicleFence: null,
  vehicleRally: null,
  handles: [],
  selected: null,
  sketch: [],
  isSketchLine: false,
  isEditing: false,
};

/** Something that can be moved, as it is drawn. */
interface Drawn {
  readonly handle: AreaHandle;
  readonly place: LonLat;
  readonly at: XY;
  /** The ends of the edge that it is in the middle of. */
  readonly ends: readonly [XY, XY] | null;
}

/** A zone as it is drawn. */
interface DrawnZone {
  readonly isInclusion: boolean;
  readonly line: readonly XY[];
  /** Its northernmost point: there it is named. */
  readonly top: XY;
}

const HANDLE_PX = { corner: 8, radius: 8, centre: 9, edge: 6, return: 12, rally: 13, course: 11 } as const;

export class AreaPainter implements Painter {
  texts: AreaTexts = { zone: () => '' };
  /** Where the next corner would be. */
  pointer: LonLat | null = null;
  #view: AreaView = NO_AREAS;
  #zones: readonly DrawnZone[] = [];
  #vehicleZones: readonly DrawnZone[] = [];
  #handles: readonly Drawn[] = [];

  get view(): AreaView {
    return this.#view;
  }
  set view(view: AreaView) {
    if (view.fence !== this.#view.fence) this.#zones = drawn(view.fence);
    if (view.vehicleFence !== this.#view.vehicleFence)
      this.#vehicleZones = view.vehicleFence ? drawn(view.vehicleFence) : [];
    if (view.handles !== this.#view.handles) {
      this.#handles = view.handles.map(({ handle, at, ends }) => {
        return { handle, place: at, at: toXY(at), ends: ends ? [toXY(ends[0]), toXY(ends[1])] : null };
      });
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
    for (const drawn of this.#handles) this.#paintHandle(frame, drawn);
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
    for (const { handle, place, at, ends } of this.#handles) {
      const [hx, hy] = frame.pixel(at);
      const distance = Math.hypot(hx - x, hy - y);
      if (distance > Math.max(HANDLE_PX[handle.kind], tolerance_px) || !hasRoom(frame, ends)) continue;
      const rank = distance + (handle.kind === 'edge' ? 6 : 0);
      if (rank < nearest) [best, nearest] = [{ handle, place }, rank];
    }
    return best;
  }

  /** Whether a pixel is on the corner of the drawing that ends it when it is clicked: of a line the last, else the first. */
  closesSketch(frame: Projection, x: number, y: number, tolerance_px: number): boolean {
    const at = this.#closing;
    if (at === null) return false;
    const [cx, cy] = frame.pixel(toXY(at));
    return Math.hypot(cx - x, cy - y) <= Math.max(10, tolerance_px);
  }

  get #closing(): LonLat | null {
    const { sketch, isSketchLine } = this.#view;
    if (sketch.length < (isSketchLine ? 2 : 3)) return null;
    return (isSketchLine ? sketch.at(-1) : sketch[0]) ?? null;
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
    const { sketch, isSketchLine } = this.#view;
    if (sketch.length === 0) return;
    const { context, theme } = frame;
    const corners = this.pointer === null ? sketch : [...sketch, this.pointer];
    context.setLineDash([6, 4]);
    context.beginPath();
    traceLine(frame, border(corners, corners.length > 2 && !isSketchLine));
    strokeWithEdge(frame, theme.accent, 2.5, 1.5);
    context.setLineDash([]);
    for (const corner of sketch) {
      const [x, y] = frame.pixel(toXY(corner));
      // larger: a click on it closes
      const isClosing = corner === this.#closing;
      dot(frame, x, y, isClosing ? 9 : 5, isClosing);
    }
  }

  #paintHandle(frame: Frame, { handle, at, ends }: Drawn): void {
    const [x, y] = frame.pixel(at);
    const isSelected = sameHandle(handle, this.#view.selected);
    switch (handle.kind) {
      case 'corner':
        dot(frame, x, y, 7, isSelected);
        break;
      case 'edge':
        if (hasRoom(frame, ends)) plus(frame, x, y);
        break;
      case 'radius':
        dot(frame, x, y, 7, isSelected);
        break;
      case 'centre':
        cross(frame, x, y, zoneOf(this.#view.selected) === handle.zone);
        break;
      case 'course':
        turner(frame, x, y, isSelected);
        break;
      default:
    }
  }
}

/** Halfway handles of short edges would hide the corners. */
function hasRoom(frame: Projection, ends: Drawn['ends']): boolean {
  if (ends === null) return true;
  const [a, b] = [frame.pixel(ends[0]), frame.pixel(ends[1])];
  return Math.hypot(a[0] - b[0], a[1] - b[1]) > 56;
}

/** A closed line over the corners, bent as the ground is. */
export function border(corners: readonly LonLat[], isClosed = true): XY[] {
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

/** A ring with an arrow around it: the handle that turns the lines. */
function turner(frame: Frame, x: number, y: number, isSelected: boolean): void {
  const { context, theme } = frame;
  dot(frame, x, y, 10, isSelected);
  context.beginPath();
  context.arc(x, y, 5, -0.4 * Math.PI, 1.2 * Math.PI);
  context.moveTo(x + 5, y - 7);
  context.lineTo(x + 1.5, y - 4.8);
  context.lineTo(x + 4.5, y - 1.5);
  context.strokeStyle = isSelected ? theme.surface : theme.accent;
  context.lineWidth = 1.5;
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
