// Trails, coloured by height. Tens of thousands of points stay fluid: the drawing is kept and only moved while the view
// pans, new points are added to it, and a wide view draws a coarser level of the trail.
import { fromLonLat } from 'ol/proj';
import type { Trail } from '$lib/domain/track';
import { type Frame, type Painter, WORLD_M } from './frame';
import { TRAIL_COLOURS } from './trail-colours';

/** Height at which the scale ends at first; it doubles when a plane flies higher. Metres above home. */
const FIRST_RANGE_M = 120;

/** The drawing extends this far beyond the window, so that a pan does not redraw it. */
const MARGIN_PX = 200;
/** Spacing of the points of level 1, Mercator metres; each level doubles it. */
const LEVEL_SPACING = 8;
const LEVELS = 14;
/** Spare points of a line beyond its trail; when they are used up it is rebuilt. */
const MORE_POINTS = 4096;

interface Line {
  readonly trail: Trail;
  /** `trail.added` when the arrays below were in step with it. */
  seen: number;
  x: Float64Array;
  y: Float64Array;
  count: number;
  /** For each level the points that it draws. */
  levels: Uint32Array[];
  levelCounts: number[];
}

interface Drawing {
  readonly canvas: HTMLCanvasElement;
  originX: number;
  originY: number;
  resolution: number;
  width: number;
  height: number;
  ratio: number;
  isDark: boolean;
  range_m: number;
  /** The generation of the lines that is drawn; when it changes, the drawing starts again. */
  generation: number;
  /** How many points of each trail are drawn. */
  drawn: Map<Trail, number>;
}

export class TrailPainter implements Painter {
  #lines: Line[] = [];
  #drawing: Drawing | null = null;
  #range_m = FIRST_RANGE_M;
  #generation = 0;
  isVisible = true;

  /** Top of the colour scale, metres above home. */
  get range_m(): number {
    return this.#range_m;
  }

  /** Total of points ever added; the picture changes with it. */
  get added(): number {
    return this.#lines.reduce((sum, { trail }) => sum + trail.added, 0);
  }

  setTrails(trails: readonly Trail[]): void {
    const old = this.#lines;
    this.#lines = trails.map((trail) => old.find((line) => line.trail === trail) ?? lineOf(trail));
    this.#generation += 1;
  }

  paint(frame: Frame): void {
    if (!this.isVisible) return;
    for (const line of this.#lines) this.#catchUp(line);
    if (this.#lines.every((line) => line.count < 2)) return;
    const drawing = this.#drawingFor(frame);
    for (const line of this.#lines) this.#extend(drawing, line, frame);
    const { context, pixelRatio } = frame;
    const x = (drawing.originX - frame.centre[0]) / frame.resolution + frame.size.width / 2;
    const y = (frame.centre[1] - drawing.originY) / frame.resolution + frame.size.height / 2;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.drawImage(drawing.canvas, Math.round(x * pixelRatio), Math.round(y * pixelRatio));
  }

  #catchUp(line: Line): void {
    const { trail } = line;
    const news = trail.added - line.seen;
    if (news === 0) return;
    if (news > trail.length || line.count + news > line.x.length) {
      Object.assign(line, lineOf(trail));
      this.#generation += 1;
    }
    for (let index = trail.length - (trail.added - line.seen); index < trail.length; index += 1) {
      append(line, trail, index);
      while (trail.alt_m(index) > this.#range_m) {
        this.#range_m *= 2;
        this.#generation += 1;
      }
    }
    line.seen = trail.added;
  }

  #drawingFor(frame: Frame): Drawing {
    const { size, resolution, pixelRatio, theme, centre } = frame;
    const [width, height] = [size.width + 2 * MARGIN_PX, size.height + 2 * MARGIN_PX];
    const old = this.#drawing;
    if (
      old !== null &&
      old.resolution === resolution &&
      old.width === width &&
      old.height === height &&
      old.ratio === pixelRatio &&
      old.isDark === theme.isDark &&
      old.range_m === this.#range_m &&
      old.generation === this.#generation &&
      Math.abs((old.originX - centre[0]) / resolution + width / 2) <= MARGIN_PX &&
      Math.abs((centre[1] - old.originY) / resolution + height / 2) <= MARGIN_PX
    ) {
      return old;
    }
    const canvas = old?.canvas ?? document.createElement('canvas');
    // setting the size also wipes
    canvas.width = Math.round(width * pixelRatio);
    canvas.height = Math.round(height * pixelRatio);
    this.#drawing = {
      canvas,
      originX: centre[0] - (width / 2) * resolution,
      originY: centre[1] + (height / 2) * resolution,
      resolution,
      width,
      height,
      ratio: pixelRatio,
      isDark: theme.isDark,
      range_m: this.#range_m,
      generation: this.#generation,
      drawn: new Map(),
    };
    return this.#drawing;
  }

  /** Draws the new part of a line. */
  #extend(drawing: Drawing, line: Line, frame: Frame): void {
    const level = levelFor(frame.resolution);
    const indices = level === 0 ? null : (line.levels[level - 1] as Uint32Array);
    const count = level === 0 ? line.count : (line.levelCounts[level - 1] as number);
    const begin = Math.max((drawing.drawn.get(line.trail) ?? 0) - 1, 0);
    drawing.drawn.set(line.trail, count);
    const context = drawing.canvas.getContext('2d');
    if (context === null || count - begin < 2) return;
    context.setTransform(drawing.ratio, 0, 0, drawing.ratio, 0, 0);
    context.lineJoin = 'round';
    context.lineCap = 'round';
    const colours = TRAIL_COLOURS[frame.theme.isDark ? 'dark' : 'light'];
    const scale = 1 / drawing.resolution;
    const centreX = drawing.originX + (drawing.width / 2) * drawing.resolution;
    const at = (index: number): number => (indices === null ? index : (indices[index] as number));
    const px = (point: number): number => {
      const x = line.x[point] as number;
      return (x + Math.round((centreX - x) / WORLD_M) * WORLD_M - drawing.originX) * scale;
    };
    const py = (point: number): number => (drawing.originY - (line.y[point] as number)) * scale;
    const bucket = (point: number): number => {
      const offset = line.trail.length - line.count;
      const part = line.trail.alt_m(Math.max(0, point + offset)) / drawing.range_m;
      return Math.max(0, Math.min(colours.length - 1, Math.floor(part * colours.length)));
    };
    const isOutside = (x0: number, y0: number, x1: number, y1: number): boolean =>
      Math.max(x0, x1) < -4 ||
      Math.min(x0, x1) > drawing.width + 4 ||
      Math.max(y0, y1) < -4 ||
      Math.min(y0, y1) > drawing.height + 4;

    let x0 = px(at(begin));
    let y0 = py(at(begin));
    let colour = -1;
    let isOpen = false;
    const stroke = (): void => {
      if (!isOpen) return;
      context.strokeStyle = colours[colour] as string;
      context.lineWidth = 3;
      context.stroke();
      isOpen = false;
    };
    for (let index = begin + 1; index < count; index += 1) {
      const point = at(index);
      const [x1, y1] = [px(point), py(point)];
      if (isOutside(x0, y0, x1, y1) || Math.abs(x1 - x0) > drawing.width * 4) {
        stroke();
      } else {
        const next = bucket(point);
        if (!isOpen || next !== colour) {
          stroke();
          colour = next;
          context.beginPath();
          context.moveTo(x0, y0);
          isOpen = true;
        }
        context.lineTo(x1, y1);
      }
      [x0, y0] = [x1, y1];
    }
    stroke();
  }
}

function lineOf(trail: Trail): Line {
  const size = Math.min(trail.capacity, 2 * trail.length) + MORE_POINTS;
  return {
    trail,
    seen: trail.added - trail.length,
    x: new Float64Array(size),
    y: new Float64Array(size),
    count: 0,
    levels: Array.from({ length: LEVELS }, () => new Uint32Array(size)),
    levelCounts: new Array<number>(LEVELS).fill(0),
  };
}

function append(line: Line, trail: Trail, index: number): void {
  const [x = 0, y = 0] = fromLonLat([trail.lon_deg(index), trail.lat_deg(index)]);
  const point = line.count;
  line.x[point] = x;
  line.y[point] = y;
  line.count += 1;
  let spacing = LEVEL_SPACING;
  for (let level = 0; level < LEVELS; level += 1, spacing *= 2) {
    const kept = line.levels[level] as Uint32Array;
    const count = line.levelCounts[level] as number;
    const last = count === 0 ? -1 : (kept[count - 1] as number);
    const isFar = last < 0 || Math.hypot(x - (line.x[last] as number), y - (line.y[last] as number)) >= spacing;
    if (!isFar) break;
    kept[count] = point;
    line.levelCounts[level] = count + 1;
  }
}

/** The coarsest level whose points are less than one and a half pixels apart; 0 draws all. */
function levelFor(resolution: number): number {
  const level = Math.floor(Math.log2((resolution * 1.5) / LEVEL_SPACING)) + 1;
  return Math.max(0, Math.min(LEVELS, level));
}
