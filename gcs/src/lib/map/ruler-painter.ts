// The ruler, the box that selects, and the cross that the keyboard aims with.
import { bearing_deg, distance_m, geodesicLine } from '$lib/domain/geo';
import type { LonLat } from '$lib/domain/lonlat';
import { type Frame, haloText, type Painter, strokeWithEdge, traceLine } from './frame';
import { toLine, toXY } from './route-view';

export class RulerPainter implements Painter {
  points: readonly LonLat[] = [];
  /** Where the next point would be. */
  pointer: LonLat | null = null;
  box: readonly [x0: number, y0: number, x1: number, y1: number] | null = null;
  /** A cross in the middle of the visible area. */
  cross: { x: number; y: number } | null = null;
  /** Writes a length and a bearing: "1.25 km · 045°". */
  format: (length_m: number, bearing_deg: number) => string = () => '';

  paint(frame: Frame): void {
    this.#paintRuler(frame);
    const { context, theme } = frame;
    if (this.box !== null) {
      const [x0, y0, x1, y1] = this.box;
      context.setLineDash([5, 4]);
      context.beginPath();
      context.rect(Math.min(x0, x1), Math.min(y0, y1), Math.abs(x1 - x0), Math.abs(y1 - y0));
      context.fillStyle = theme.accent;
      context.globalAlpha = 0.12;
      context.fill();
      context.globalAlpha = 1;
      strokeWithEdge(frame, theme.accent, 1.5, 1);
      context.setLineDash([]);
    }
    if (this.cross !== null) {
      const { x, y } = this.cross;
      context.beginPath();
      for (const [dx, dy] of [
        [1, 0],
        [-1, 0],
        [0, 1],
        [0, -1],
      ] as const) {
        context.moveTo(x + dx * 5, y + dy * 5);
        context.lineTo(x + dx * 18, y + dy * 18);
      }
      strokeWithEdge(frame, theme.text, 2, 1.5);
    }
  }

  #paintRuler(frame: Frame): void {
    const points = this.pointer && this.points.length > 0 ? [...this.points, this.pointer] : this.points;
    if (points.length === 0) return;
    const { context, theme } = frame;
    context.lineCap = 'round';
    let total_m = 0;
    for (let index = 1; index < points.length; index += 1) {
      const [from, to] = [points[index - 1] as LonLat, points[index] as LonLat];
      context.beginPath();
      traceLine(frame, toLine(geodesicLine(from, to)));
      strokeWithEdge(frame, theme.text, 2);
    }
    context.font = `600 13px ${theme.font}`;
    context.textAlign = 'left';
    context.textBaseline = 'middle';
    points.forEach((at, index) => {
      const before = points[index - 1];
      const [x, y] = frame.pixel(toXY(at));
      context.beginPath();
      context.arc(x, y, 4, 0, 2 * Math.PI);
      context.fillStyle = theme.surface;
      context.fill();
      context.strokeStyle = theme.text;
      context.lineWidth = 2;
      context.stroke();
      if (before === undefined) return;
      total_m += distance_m(before, at);
      haloText(frame, this.format(total_m, bearing_deg(before, at)), x + 10, y);
    });
  }
}
