// What a painter gets to draw one frame with: the canvas, the view and the colours of the theme.
import type { Size, Insets } from '$lib/domain/sight';

/** A position in Web Mercator metres (EPSG:3857), the map's projection. */
export type XY = readonly [x: number, y: number];

/** Width of the world in Web Mercator. */
export const WORLD_M = 2 * Math.PI * 6_378_137;

export interface Theme {
  readonly isDark: boolean;
  readonly font: string;
  readonly surface: string;
  readonly text: string;
  readonly muted: string;
  readonly land: string;
  readonly coast: string;
  readonly grid: string;
  readonly gridText: string;
  readonly accent: string;
  readonly onAccent: string;
  readonly ok: string;
  readonly warn: string;
  readonly danger: string;
  readonly estimated: string;
  readonly rehearsed: string;
  readonly plane: string;
  readonly stale: string;
}

/** Colours and fonts for painting. */
export interface Pen {
  readonly context: CanvasRenderingContext2D;
  readonly theme: Theme;
}

/** Where positions are in the window. */
export interface Projection {
  readonly size: Size;
  readonly centre: XY;
  /** Mercator metres in a pixel. */
  readonly resolution: number;
  /** Pixel of a position, on the copy of the world that is nearest to the middle of the view. */
  pixel(at: XY): XY;
}

export interface Frame extends Projection {
  readonly context: CanvasRenderingContext2D;
  /** Parts that panels cover, pixels. */
  readonly insets: Insets;
  readonly pixelRatio: number;
  readonly theme: Theme;
}

export function projection(centre: XY, resolution: number, size: Size): Projection {
  return {
    size,
    centre,
    resolution,
    pixel: ([x, y]) => {
      const copy = Math.round((centre[0] - x) / WORLD_M) * WORLD_M;
      return [(x + copy - centre[0]) / resolution + size.width / 2, (centre[1] - y) / resolution + size.height / 2];
    },
  };
}

export interface Painter {
  paint(frame: Frame): void;
}

export function readTheme(): Theme {
  const style = getComputedStyle(document.documentElement);
  const token = (name: string): string => style.getPropertyValue(`--${name}`).trim() || '#888';
  return {
    isDark: style.getPropertyValue('color-scheme').includes('dark'),
    font: style.getPropertyValue('--font').trim() || 'sans-serif',
    surface: token('color-surface'),
    text: token('color-text'),
    muted: token('color-text-muted'),
    land: token('color-land'),
    coast: token('color-coast'),
    grid: token('color-grid'),
    gridText: token('color-text-muted'),
    accent: token('color-accent'),
    onAccent: token('color-on-accent'),
    ok: token('color-ok'),
    warn: token('color-warn'),
    danger: token('color-danger'),
    estimated: token('color-estimated'),
    rehearsed: token('color-rehearsed'),
    plane: token('color-plane-symbol'),
    stale: token('color-stale'),
  };
}

/** Text with an edge of the surface's colour, so that it can be read on any map. */
export function haloText(frame: Pen, text: string, x: number, y: number, colour = frame.theme.text): void {
  const { context, theme } = frame;
  context.lineJoin = 'round';
  context.lineWidth = 4;
  context.strokeStyle = theme.surface;
  context.strokeText(text, x, y);
  context.fillStyle = colour;
  context.fillText(text, x, y);
}

/** Strokes the current path twice: an edge of the surface's colour below the line itself. */
export function strokeWithEdge(frame: Pen, colour: string, width: number, edge = 2): void {
  const { context, theme } = frame;
  const dash = context.getLineDash();
  context.setLineDash([]);
  context.strokeStyle = theme.surface;
  context.globalAlpha = 0.75;
  context.lineWidth = width + 2 * edge;
  context.stroke();
  context.globalAlpha = 1;
  context.setLineDash(dash);
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.stroke();
}

/** Adds a line of positions to the current path. */
export function traceLine(frame: Frame, points: readonly XY[]): void {
  points.forEach((at, index) => {
    const [x, y] = frame.pixel(at);
    if (index === 0) frame.context.moveTo(x, y);
    else frame.context.lineTo(x, y);
  });
}
