// A survey that is open: its area or strip, the lines with the pictures on them, where it begins, and ground that no picture shows.
import { geodesicLine } from '$lib/domain/geo';
import type { LonLat } from '$lib/domain/lonlat';
import { border } from './area-painter';
import { type Frame, haloText, type Painter, strokeWithEdge, traceLine, type XY } from './frame';
import { toLine, toXY } from './route-view';

export interface SurveyView {
  readonly places: readonly LonLat[];
  /** Whether the places are the corners of an area, not the points of a line. */
  readonly isClosed: boolean;
  readonly lines: readonly (readonly LonLat[])[];
  readonly photos: readonly LonLat[];
  /** Ground that no picture shows: squares of this side about their middle. */
  readonly holes: readonly { readonly at: LonLat; readonly side_m: number }[];
  /** From the middle to the handle that turns the lines. */
  readonly arrow: readonly [LonLat, LonLat] | null;
  /** Whether the lines are those of an area as it was a moment ago. */
  readonly isOld: boolean;
}

/** Pictures nearer to each other than this are not drawn one by one. */
const APART_PX = 5;
/** At the equator a Mercator metre is one; elsewhere this many of them make one on the ground. */
const stretch = (at: LonLat): number => 1 / Math.cos((at.lat_deg * Math.PI) / 180);

interface Drawn {
  readonly outline: readonly XY[];
  readonly lines: readonly (readonly XY[])[];
  readonly photos: readonly XY[];
  readonly holes: readonly { readonly at: XY; readonly side: number }[];
  readonly arrow: readonly XY[];
}

export class SurveyPainter implements Painter {
  /** What stands at the beginning of the first line. */
  begin = '';
  #view: SurveyView | null = null;
  #drawn: Drawn | null = null;

  set view(view: SurveyView | null) {
    this.#view = view;
    this.#drawn = view && {
      outline: view.isClosed ? border(view.places) : border(view.places, false),
      lines: view.lines.map((line) => toLine(line.flatMap((from, index) => bent(from, line[index + 1])))),
      photos: view.photos.map(toXY),
      holes: view.holes.map(({ at, side_m }) => ({ at: toXY(at), side: side_m * stretch(at) })),
      arrow: view.arrow?.map(toXY) ?? [],
    };
  }

  paint(frame: Frame): void {
    if (this.#drawn === null || this.#view === null) return;
    const { context, theme } = frame;
    const { outline, lines, photos, holes, arrow } = this.#drawn;
    const [first] = outline;
    context.lineJoin = 'round';
    context.lineCap = 'round';
    if (first !== undefined) {
      context.beginPath();
      traceLine(frame, outline);
      if (this.#view.isClosed) {
        context.globalAlpha = 0.12;
        context.fillStyle = theme.accent;
        context.fill();
        context.globalAlpha = 1;
      }
      strokeWithEdge(frame, theme.accent, 2.5, 1.5);
    }
    if (arrow.length === 2) {
      context.beginPath();
      traceLine(frame, arrow);
      context.setLineDash([3, 4]);
      strokeWithEdge(frame, theme.accent, 1.5, 1);
      context.setLineDash([]);
    }
    for (const { at, side } of holes) {
      const [x, y] = frame.pixel(at);
      const half = Math.max(4, side / frame.resolution / 2);
      context.beginPath();
      context.rect(x - half, y - half, 2 * half, 2 * half);
      context.globalAlpha = 0.35;
      context.fillStyle = theme.danger;
      context.fill();
      context.globalAlpha = 1;
    }
    context.globalAlpha = this.#view.isOld ? 0.5 : 1;
    for (const line of lines) {
      context.beginPath();
      traceLine(frame, line);
      strokeWithEdge(frame, theme.ok, 2.5, 1);
    }
    context.globalAlpha = this.#view.isOld ? 0.5 : 1;
    this.#paintPhotos(frame, photos);
    this.#paintBegin(frame, lines);
    context.globalAlpha = 1;
  }

  #paintPhotos(frame: Frame, photos: readonly XY[]): void {
    const { context, theme } = frame;
    const pixels = photos.map((at) => frame.pixel(at));
    const [a, b] = pixels;
    if (a === undefined || b === undefined || Math.hypot(a[0] - b[0], a[1] - b[1]) < APART_PX) return;
    context.beginPath();
    for (const [x, y] of pixels) {
      context.moveTo(x + 2, y);
      context.arc(x, y, 2, 0, 2 * Math.PI);
    }
    context.fillStyle = theme.text;
    context.fill();
  }

  /** A point at the beginning of the first line, with an arrow along it. */
  #paintBegin(frame: Frame, lines: readonly (readonly XY[])[]): void {
    const [from, to] = lines[0] ?? [];
    if (from === undefined || to === undefined) return;
    const { context, theme } = frame;
    const [x, y] = frame.pixel(from);
    const [tx, ty] = frame.pixel(to);
    const angle = Math.atan2(ty - y, tx - x);
    context.save();
    context.translate(x, y);
    context.rotate(angle);
    context.beginPath();
    context.moveTo(16, 0);
    context.lineTo(-4, 8);
    context.lineTo(0, 0);
    context.lineTo(-4, -8);
    context.closePath();
    context.fillStyle = theme.ok;
    context.strokeStyle = theme.surface;
    context.lineWidth = 2;
    context.stroke();
    context.fill();
    context.restore();
    context.font = `600 12px ${theme.font}`;
    context.textAlign = 'center';
    context.textBaseline = 'bottom';
    haloText(frame, this.begin, x, y - 10, theme.ok);
  }
}

const bent = (from: LonLat, to: LonLat | undefined): LonLat[] =>
  to === undefined ? [from] : geodesicLine(from, to).slice(0, -1);
