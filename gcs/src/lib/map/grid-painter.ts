// The grid: metres from home (or from a round position) when near, degrees when far.
import { fromLonLat, toLonLat } from 'ol/proj';
import type { Frame, Painter, XY } from './frame';
import { haloText } from './frame';

/** Approximate distance between lines, pixels. */
const SPACING_PX = 130;
/** Metre grids are true near their origin only; beyond this step the grid is one of degrees. */
const MAX_STEP_M = 20_000;

export class GridPainter implements Painter {
  /** Where metres count from. */
  origin: XY | null = null;
  /** Writes a distance: 1000 → "1 km". */
  formatDistance: (value_m: number, step_m: number) => string = (value_m) => `${value_m} m`;
  /** The smallest round distance that is not below another. */
  stepOf_m: (least_m: number) => number = (least_m) => least_m;
  /** Letters of the four directions. */
  letters = { north: 'N', east: 'E', south: 'S', west: 'W' };
  isVisible = true;

  paint(frame: Frame): void {
    if (!this.isVisible) return;
    const [, lat_deg = 0] = toLonLat([...frame.centre]);
    // Mercator stretches by 1 / cos(latitude)
    const stretch = 1 / Math.max(Math.cos((lat_deg * Math.PI) / 180), 0.05);
    const step_m = this.stepOf_m((SPACING_PX * frame.resolution) / stretch);
    frame.context.font = `11px ${frame.theme.font}`;
    frame.context.strokeStyle = frame.theme.grid;
    frame.context.lineWidth = 1;
    if (step_m <= MAX_STEP_M) this.#metres(frame, step_m, stretch);
    else this.#degrees(frame);
  }

  #metres(frame: Frame, step_m: number, stretch: number): void {
    const origin = this.origin ?? roundOrigin(frame.centre);
    // near the origin its own latitude makes the metres true; elsewhere that of the view does
    const [, originLat_deg = 0] = toLonLat([...origin]);
    const isNear = Math.hypot(frame.centre[0] - origin[0], frame.centre[1] - origin[1]) < 200_000;
    const scale = isNear ? 1 / Math.cos((originLat_deg * Math.PI) / 180) : stretch;
    const label = (value_m: number, plus: string, minus: string): string =>
      Math.abs(value_m) < step_m / 2
        ? '0'
        : `${this.formatDistance(Math.abs(value_m), step_m)} ${value_m > 0 ? plus : minus}`;
    const step = step_m * scale;
    const xs = lines(frame.centre[0] - origin[0], (frame.size.width / 2) * frame.resolution, step);
    const ys = lines(frame.centre[1] - origin[1], (frame.size.height / 2) * frame.resolution, step);
    this.#draw(
      frame,
      xs.map((index) => ({
        at: frame.pixel([origin[0] + index * step, frame.centre[1]])[0],
        text: this.origin ? label(index * step_m, this.letters.east, this.letters.west) : '',
      })),
      ys.map((index) => ({
        at: frame.pixel([frame.centre[0], origin[1] + index * step])[1],
        text: this.origin ? label(index * step_m, this.letters.north, this.letters.south) : '',
      })),
    );
  }

  #degrees(frame: Frame): void {
    const perDegree = fromLonLat([1, 0])[0] ?? 1;
    const wanted = (SPACING_PX * frame.resolution) / perDegree;
    const step = [0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 45].find((one) => one >= wanted) ?? 45;
    const digits = step < 1 ? 1 : 0;
    const half = [(frame.size.width / 2) * frame.resolution, (frame.size.height / 2) * frame.resolution] as const;
    const xs = lines(frame.centre[0] / perDegree, half[0] / perDegree, step);
    const south = toLonLat([0, frame.centre[1] - half[1]])[1] ?? -85;
    const north = toLonLat([0, frame.centre[1] + half[1]])[1] ?? 85;
    const ys = lines((south + north) / 2, (north - south) / 2, step).filter((index) => Math.abs(index * step) < 85);
    const wrap = (value: number): number => ((((value + 180) % 360) + 360) % 360) - 180;
    this.#draw(
      frame,
      xs.map((index) => {
        const lon_deg = wrap(index * step);
        return {
          at: (index * step * perDegree - frame.centre[0]) / frame.resolution + frame.size.width / 2,
          text: `${Math.abs(lon_deg).toFixed(digits)}°${lon_deg === 0 ? '' : lon_deg > 0 ? this.letters.east : this.letters.west}`,
        };
      }),
      ys.map((index) => ({
        at: frame.pixel([frame.centre[0], fromLonLat([0, index * step])[1] ?? 0])[1],
        text: `${Math.abs(index * step).toFixed(digits)}°${index === 0 ? '' : index > 0 ? this.letters.north : this.letters.south}`,
      })),
    );
  }

  #draw(frame: Frame, columns: readonly Line[], rows: readonly Line[]): void {
    const { context, size, insets, theme } = frame;
    context.beginPath();
    for (const { at } of columns) {
      context.moveTo(Math.round(at) + 0.5, 0);
      context.lineTo(Math.round(at) + 0.5, size.height);
    }
    for (const { at } of rows) {
      context.moveTo(0, Math.round(at) + 0.5);
      context.lineTo(size.width, Math.round(at) + 0.5);
    }
    context.stroke();
    const [left, right] = [insets.left + 6, size.width - insets.right];
    const [top, bottom] = [insets.top + 6, size.height - insets.bottom - 56];
    context.textAlign = 'center';
    context.textBaseline = 'top';
    for (const { at, text } of columns) {
      if (text && at > left + 60 && at < right - 24) haloText(frame, text, at, top, theme.gridText);
    }
    context.textAlign = 'left';
    context.textBaseline = 'middle';
    for (const { at, text } of rows) {
      if (text && at > top + 24 && at < bottom) haloText(frame, text, left, at, theme.gridText);
    }
  }
}

interface Line {
  readonly at: number;
  readonly text: string;
}

/** Multiples of `step` within `half` of `centre`, as whole numbers of steps; never more than a screen can show. */
function lines(centre: number, half: number, step: number): number[] {
  const first = Math.ceil((centre - half) / step);
  const count = Math.min(Math.max(0, Math.floor((centre + half) / step) - first + 1), 200);
  return Array.from({ length: count }, (_, index) => first + index);
}

/** Without a home the grid hangs on a position that does not change with small moves of the view. */
function roundOrigin([x, y]: XY): XY {
  const step = 1_000_000;
  return [Math.round(x / step) * step, Math.round(y / step) * step];
}
