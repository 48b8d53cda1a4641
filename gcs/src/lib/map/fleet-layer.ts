// Vehicles that are not followed in detail: each turned to its heading, those near each other as one mark with their number.
import Feature from 'ol/Feature';
import Point from 'ol/geom/Point';
import { get as projectionOf } from 'ol/proj';
import Cluster from 'ol/source/Cluster';
import VectorSource from 'ol/source/Vector';
import type { LonLat } from '$lib/domain/lonlat';
import { ATTENTION_LEVELS, type AttentionLevel } from '$lib/domain/roster';
import { type Frame, haloText, type Painter, type XY } from './frame';
import { toXY } from './route-view';
import { paintPlane } from './vehicle-painter';

export interface FleetMark {
  readonly id: number;
  readonly label: string;
  readonly at: LonLat;
  /** Where the nose points, 0 to 360; `null` draws a dot. */
  readonly heading_deg: number | null;
  readonly level: AttentionLevel;
  /** Whether it is not heard: drawn grey. */
  readonly isStale: boolean;
}

/** Marks nearer to each other than this are one. */
const TOGETHER_PX = 34;
/** Below this resolution, metres per pixel, vehicles are drawn one by one. */
const APART_M_PER_PX = 8;
/** Closer than this each has its name. */
const NAMED_M_PER_PX = 25;
/** Space taken by a name; names that would overlap are left out, as the list has them. */
const NAME_PX = { width: 56, height: 14 };
/** How far a mark and its name extend beyond their position. */
const EDGE_PX = 60;

export class FleetPainter implements Painter {
  readonly #source = new VectorSource<Feature<Point>>();
  readonly #cluster = new Cluster<Feature<Point>>({ distance: TOGETHER_PX, source: this.#source });

  set marks(marks: readonly FleetMark[]) {
    this.#source.clear(true);
    this.#source.addFeatures(marks.map((mark) => new Feature({ geometry: new Point([...toXY(mark.at)]), mark })));
  }

  /** Clusters the vehicles again when the view has come to rest. */
  set resolution(m_per_px: number) {
    const distance_px = m_per_px < APART_M_PER_PX ? 0 : TOGETHER_PX;
    if (this.#cluster.getDistance() !== distance_px) this.#cluster.setDistance(distance_px);
    const mercator = projectionOf('EPSG:3857');
    if (mercator !== null) this.#cluster.loadFeatures(mercator.getExtent(), m_per_px, mercator);
  }

  paint(frame: Frame): void {
    const { width, height } = frame.size;
    const named: XY[] = [];
    for (const feature of this.#cluster.getFeatures()) {
      const [x, y] = frame.pixel(placeOf(feature));
      const isIn = x > -EDGE_PX && y > -EDGE_PX && x < width + EDGE_PX && y < height + EDGE_PX;
      if (!isIn) continue;
      const marks = marksOf(feature);
      paint(frame, marks, x, y);
      const [only] = marks.length === 1 ? marks : [];
      if (only === undefined || frame.resolution >= NAMED_M_PER_PX) continue;
      if (named.some(([nx, ny]) => Math.abs(nx - x) < NAME_PX.width && Math.abs(ny - y) < NAME_PX.height)) continue;
      named.push([x, y]);
      frame.context.font = `600 11px ${frame.theme.font}`;
      frame.context.textAlign = 'center';
      frame.context.textBaseline = 'top';
      haloText(frame, only.label, x, y + 20, frame.theme.muted);
    }
  }

  /** The vehicles of the mark nearest to a pixel; empty without one. */
  at(pixelOf: (at: XY) => XY, x: number, y: number, tolerance_px: number): readonly FleetMark[] {
    let nearest: readonly FleetMark[] = [];
    let nearest_px = Math.max(18, tolerance_px);
    for (const feature of this.#cluster.getFeatures()) {
      const [px, py] = pixelOf(placeOf(feature));
      const distance_px = Math.hypot(px - x, py - y);
      if (distance_px <= nearest_px) [nearest, nearest_px] = [marksOf(feature), distance_px];
    }
    return nearest;
  }
}

const marksOf = (feature: { get(key: string): unknown }): readonly FleetMark[] =>
  ((feature.get('features') ?? []) as Feature[]).map((one) => one.get('mark') as FleetMark);

function placeOf(feature: Feature): XY {
  const [x = 0, y = 0] = (feature.getGeometry() as Point | undefined)?.getCoordinates() ?? [];
  return [x, y];
}

function paint({ context, theme }: Frame, marks: readonly FleetMark[], px: number, py: number): void {
  const [first] = marks;
  if (first === undefined) return;
  const worst = ATTENTION_LEVELS.find((level) => marks.some((mark) => mark.level === level)) ?? 'none';
  const colour = { danger: theme.danger, warn: theme.warn, none: theme.plane }[worst];
  const edge = theme.isDark ? '#000' : '#fff';
  if (marks.length > 1) {
    const radius = 11 + 3 * Math.min(4, Math.log10(marks.length) * 2);
    context.beginPath();
    context.arc(px, py, radius, 0, 2 * Math.PI);
    context.fillStyle = theme.surface;
    context.fill();
    context.strokeStyle = worst === 'none' ? theme.muted : colour;
    context.lineWidth = worst === 'none' ? 2 : 4;
    context.stroke();
    context.font = `700 12px ${theme.font}`;
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    context.fillStyle = theme.text;
    context.fillText(String(marks.length), px, py + 1);
  } else {
    const fill = first.isStale ? theme.stale : colour;
    if (worst !== 'none') {
      // a ring as well: in the dark theme a warning has nearly the plane's own colour
      context.beginPath();
      context.arc(px, py, 17, 0, 2 * Math.PI);
      context.strokeStyle = colour;
      context.lineWidth = 3;
      context.stroke();
    }
    if (first.heading_deg === null) {
      context.beginPath();
      context.arc(px, py, 7, 0, 2 * Math.PI);
      context.fillStyle = fill;
      context.fill();
      context.strokeStyle = edge;
      context.lineWidth = 2;
      context.stroke();
    } else paintPlane({ context, theme }, px, py, first.heading_deg, { fill, line: edge, scale: 0.7 });
  }
}
