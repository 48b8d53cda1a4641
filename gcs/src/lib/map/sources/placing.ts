// Painter of what is placed on the map: an offline area, or a picture by its corners; with handles to drag.
import PointerInteraction from 'ol/interaction/Pointer';
import { toLonLat } from 'ol/proj';
import { type LonLat, wrap180_deg } from '$lib/domain/lonlat';
import { type Point, type Quad, quadMapping } from '$lib/domain/projection-quad';
import { type Frame, haloText, type Painter, type Projection, strokeWithEdge, traceLine } from '../frame';
import { toLine, toXY } from '../route-view';

export interface PlacedArea {
  /** Corners in turn, without a repeated one. */
  readonly corners: readonly LonLat[];
  /** Half the width of a corridor along a line, instead of a shape. */
  readonly buffer_m: number | null;
  readonly label: string;
  readonly isDraft: boolean;
}

interface PlacedPicture {
  readonly image: HTMLImageElement;
  /** Top left, top right, bottom right, bottom left of the picture. */
  readonly corners: readonly LonLat[];
  readonly opacity: number;
}

export interface Placing {
  readonly areas: readonly PlacedArea[];
  readonly picture: PlacedPicture | null;
  /** Places that can be dragged, with what is written beside them. */
  readonly handles: readonly { readonly at: LonLat; readonly label: string }[];
  drag(index: number, to: LonLat, isEnd: boolean): void;
}

const NOTHING_PLACED: Placing = { areas: [], picture: null, handles: [], drag: () => undefined };

const HANDLE_PX = 9;
/** The picture is drawn as a grid of this many parallelograms each way. */
const PIECES = 10;

export class PlacingPainter implements Painter {
  placing: Placing = NOTHING_PLACED;
  /** The pieces of a picture lie over each other by a hair: only as a whole can it be made translucent. */
  #whole: CanvasRenderingContext2D | null = null;

  get isVisible(): boolean {
    const { picture, areas, handles } = this.placing;
    return picture !== null || areas.length > 0 || handles.length > 0;
  }

  paint(frame: Frame): void {
    if (this.placing.picture === null) this.#whole = null;
    else {
      this.#whole ??= document.createElement('canvas').getContext('2d');
      if (this.#whole !== null) paintPicture(frame, this.placing.picture, this.#whole);
    }
    for (const area of this.placing.areas) paintArea(frame, area);
    const { context, theme } = frame;
    context.font = `600 12px ${theme.font}`;
    context.textAlign = 'left';
    context.textBaseline = 'middle';
    for (const { at, label } of this.placing.handles) {
      const [x, y] = frame.pixel(toXY(at));
      context.beginPath();
      context.arc(x, y, HANDLE_PX, 0, 2 * Math.PI);
      context.fillStyle = theme.surface;
      context.fill();
      strokeWithEdge(frame, theme.accent, 3, 1);
      haloText(frame, label, x + HANDLE_PX + 5, y);
    }
  }

  /** The handle at a pixel, or `null`. */
  handleAt(frame: Projection, x: number, y: number, tolerance: number): number | null {
    let best: number | null = null;
    let least = Math.max(tolerance, HANDLE_PX);
    this.placing.handles.forEach(({ at }, index) => {
      const [handleX, handleY] = frame.pixel(toXY(at));
      const away = Math.hypot(handleX - x, handleY - y);
      if (away <= least) [best, least] = [index, away];
    });
    return best;
  }
}

function paintArea(frame: Frame, { corners, buffer_m, label, isDraft }: PlacedArea): void {
  const [first] = corners;
  if (first === undefined) return;
  const { context, theme } = frame;
  const colour = isDraft ? theme.accent : theme.muted;
  context.lineCap = 'round';
  context.lineJoin = 'round';
  context.beginPath();
  traceLine(frame, toLine(corners));
  if (buffer_m !== null) {
    // Mercator stretches by 1 / cos(latitude)
    const perPixel_m = frame.resolution * Math.cos((first.lat_deg * Math.PI) / 180);
    context.globalAlpha = 0.3;
    context.strokeStyle = colour;
    context.lineWidth = Math.max(3, (2 * buffer_m) / perPixel_m);
    if (corners.length === 1) context.lineTo(...frame.pixel(toXY(first)));
    context.stroke();
    context.globalAlpha = 1;
  } else {
    context.closePath();
    context.globalAlpha = isDraft ? 0.16 : 0.06;
    context.fillStyle = colour;
    context.fill();
    context.globalAlpha = 1;
    context.setLineDash(isDraft ? [] : [6, 5]);
    strokeWithEdge(frame, colour, isDraft ? 2 : 1.5, 1);
    context.setLineDash([]);
  }
  if (label === '') return;
  context.font = `12px ${theme.font}`;
  context.textAlign = 'left';
  context.textBaseline = 'bottom';
  const [x, y] = frame.pixel(toXY(first));
  haloText(frame, label, x + 4, y - 4, isDraft ? theme.text : theme.muted);
}

function paintPicture(frame: Frame, { image, corners, opacity }: PlacedPicture, whole: CanvasRenderingContext2D): void {
  const [a, b, c, d] = toLine(corners).map((at) => frame.pixel(at));
  if (!a || !b || !c || !d || image.naturalWidth === 0) return;
  const { context, theme } = frame;
  const place = quadMapping([a, b, c, d] satisfies Quad);
  if (place !== null) {
    // a canvas that is given a size is empty
    [whole.canvas.width, whole.canvas.height] = [context.canvas.width, context.canvas.height];
    whole.scale(frame.pixelRatio, frame.pixelRatio);
    for (let row = 0; row < PIECES; row += 1) {
      for (let column = 0; column < PIECES; column += 1) paintPiece(whole, image, place, column, row);
    }
    context.save();
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.globalAlpha = opacity;
    context.drawImage(whole.canvas, 0, 0);
    context.restore();
  }
  context.beginPath();
  [a, b, c, d, a].forEach(([x, y], index) => (index === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  // corners that cross over make no picture
  strokeWithEdge(frame, place === null ? theme.danger : theme.accent, 2, 1);
}

function paintPiece(
  context: CanvasRenderingContext2D,
  image: HTMLImageElement,
  place: (u: number, v: number) => Point,
  column: number,
  row: number,
): void {
  const [width, height] = [image.naturalWidth / PIECES, image.naturalHeight / PIECES];
  const [x, y] = place(column / PIECES, row / PIECES);
  const [rightX, rightY] = place((column + 1) / PIECES, row / PIECES);
  const [downX, downY] = place(column / PIECES, (row + 1) / PIECES);
  context.save();
  context.transform((rightX - x) / width, (rightY - y) / width, (downX - x) / height, (downY - y) / height, x, y);
  // half a pixel over the edge, so that no line shows between the pieces
  context.drawImage(image, column * width, row * height, width, height, 0, 0, width + 0.5, height + 0.5);
  context.restore();
}

/** Dragging of a placing's handles. Goes before what else a drag may do. */
export function handleInteraction(
  painter: PlacingPainter,
  view: () => Projection | null,
  toleranceOf: (event: PointerEvent) => number,
): PointerInteraction {
  let dragged: number | null = null;
  return new PointerInteraction({
    stopDown: (isHandled) => isHandled,
    handleDownEvent: (event) => {
      const original = event.originalEvent as PointerEvent;
      const [x = 0, y = 0] = event.pixel;
      const frame = original.button === 0 ? view() : null;
      dragged = frame === null ? null : painter.handleAt(frame, x, y, toleranceOf(original));
      return dragged !== null;
    },
    handleDragEvent: (event) => {
      if (dragged !== null) painter.placing.drag(dragged, placeOf(event.coordinate), false);
    },
    handleUpEvent: (event) => {
      if (dragged !== null) painter.placing.drag(dragged, placeOf(event.coordinate), true);
      dragged = null;
      return false;
    },
  });
}

function placeOf(coordinate: number[]): LonLat {
  const [lon_deg = 0, lat_deg = 0] = toLonLat(coordinate);
  return { lon_deg: wrap180_deg(lon_deg), lat_deg };
}
