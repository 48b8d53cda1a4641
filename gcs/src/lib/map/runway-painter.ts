// The runway that the mission lands on: a strip with a dashed middle line.
import type { LonLat } from '$lib/domain/lonlat';
import { type Frame, type Painter, traceLine, type XY } from './frame';
import { toLine } from './route-view';

const WIDTH_PX = 10;

export class RunwayPainter implements Painter {
  #line: readonly XY[] = [];

  set ends(ends: readonly LonLat[]) {
    this.#line = toLine(ends);
  }

  paint(frame: Frame): void {
    if (this.#line.length < 2) return;
    const { context, theme } = frame;
    const stroke = (colour: string, width: number): void => {
      context.beginPath();
      traceLine(frame, this.#line);
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.stroke();
    };
    context.lineCap = 'butt';
    stroke(theme.surface, WIDTH_PX + 4);
    stroke(theme.muted, WIDTH_PX);
    context.setLineDash([8, 8]);
    stroke(theme.surface, 2);
    context.setLineDash([]);
  }
}
