// The rehearsed flight: the track that the plane would really fly, where it touches down, and the plane at one moment of it.
import type { LonLat } from '$lib/domain/lonlat';
import type { Moment } from '$lib/domain/rehearsal';
import { type Frame, type Painter, strokeWithEdge, traceLine, type XY } from './frame';
import { toXY } from './route-view';
import { paintPlane } from './vehicle-painter';

const NOTHING = { line: [], touchDown: null, glide: [] };

export class RehearsalPainter {
  line: readonly XY[] = [];
  touchDown: LonLat | null = null;
  /** Whether the plan has changed since: drawn thin and pale. */
  isOld = false;
  moment: Moment | null = null;
  /** What the plane in the air still has to fly. */
  ahead: readonly XY[] = [];
  /** The flight from that moment on when something happens, and the ring of ground within gliding range. */
  whatIf: { line: readonly XY[]; touchDown: LonLat | null; glide: readonly XY[] } = NOTHING;

  readonly track: Painter = { paint: (frame) => this.#paintTrack(frame) };
  readonly plane: Painter = { paint: (frame) => this.#paintPlane(frame) };

  #paintTrack(frame: Frame): void {
    const { context, theme } = frame;
    context.lineCap = 'round';
    context.lineJoin = 'round';
    if (this.line.length >= 2) {
      context.beginPath();
      traceLine(frame, this.line);
      if (this.isOld) {
        context.globalAlpha = 0.6;
        context.strokeStyle = theme.rehearsed;
        context.lineWidth = 1.5;
        context.stroke();
      } else strokeWithEdge(frame, theme.rehearsed, 2.5, 1);
      paintCross(frame, this.touchDown, theme.rehearsed);
      context.globalAlpha = 1;
    }
    if (this.ahead.length >= 2) {
      context.beginPath();
      traceLine(frame, this.ahead);
      context.setLineDash([2, 6]);
      strokeWithEdge(frame, theme.rehearsed, 2.5, 1);
      context.setLineDash([]);
    }
    this.#paintWhatIf(frame);
  }

  #paintWhatIf(frame: Frame): void {
    const { context, theme } = frame;
    const { line, touchDown, glide } = this.whatIf;
    if (glide.length > 2) {
      context.beginPath();
      traceLine(frame, glide);
      context.closePath();
      context.globalAlpha = 0.15;
      context.fillStyle = theme.warn;
      context.fill();
      context.globalAlpha = 1;
      strokeWithEdge(frame, theme.warn, 1.5, 1);
    }
    if (line.length < 2) return;
    context.beginPath();
    traceLine(frame, line);
    context.setLineDash([8, 6]);
    strokeWithEdge(frame, theme.warn, 2.5, 1);
    context.setLineDash([]);
    paintCross(frame, touchDown, theme.warn);
  }

  #paintPlane(frame: Frame): void {
    if (this.moment === null) return;
    const [x, y] = frame.pixel(toXY(this.moment.at));
    const { theme } = frame;
    const { heading_deg, bank_deg } = this.moment;
    paintPlane(frame, x, y, heading_deg, { fill: theme.rehearsed, line: theme.surface, scale: 0.9, bank_deg });
  }
}

/** Where the ground is touched. */
function paintCross(frame: Frame, at: LonLat | null, colour: string): void {
  if (at === null) return;
  const { context } = frame;
  const [x, y] = frame.pixel(toXY(at));
  context.beginPath();
  context.moveTo(x - 6, y - 6);
  context.lineTo(x + 6, y + 6);
  context.moveTo(x + 6, y - 6);
  context.lineTo(x - 6, y + 6);
  strokeWithEdge(frame, colour, 3);
}
