// Where nine in ten of many rehearsed flights pass.
import { type Frame, type Painter, traceLine, type XY } from './frame';

export class CorridorPainter implements Painter {
  left: readonly XY[] = [];
  right: readonly XY[] = [];

  paint(frame: Frame): void {
    const { context, theme } = frame;
    context.fillStyle = theme.rehearsed;
    context.globalAlpha = 0.2;
    // piece by piece: where the way crosses itself the whole outline would leave holes
    context.beginPath();
    for (let index = 1; index < this.left.length; index += 1) {
      const [a, b, c, d] = [this.left[index - 1], this.left[index], this.right[index], this.right[index - 1]];
      if (a === undefined || b === undefined || c === undefined || d === undefined) break;
      traceLine(frame, [a, b, c, d]);
      context.closePath();
    }
    context.fill('nonzero');
    context.globalAlpha = 1;
  }
}
