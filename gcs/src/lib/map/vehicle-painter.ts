// Home and the planes: each turned to its heading, and where one that is not heard any more probably is.
import type { LonLat } from '$lib/domain/lonlat';
import type { AttentionLevel } from '$lib/domain/roster';
import { destination } from '$lib/domain/geo';
import {
  type Frame,
  type Pen,
  haloText,
  type Painter,
  type Projection,
  strokeWithEdge,
  traceLine,
  type XY,
} from './frame';
import { toLine, toXY } from './route-view';

export interface VehicleMark {
  readonly id: number;
  /** Shown beside the plane; empty for none. */
  readonly label: string;
  readonly at: LonLat;
  /** Where the nose points, 0 to 360; `null` draws a dot. */
  readonly heading_deg: number | null;
  readonly course_deg: number | null;
  readonly groundspeed_m_s: number | null;
  readonly isSelected: boolean;
  /** Whether the position is old: drawn grey. */
  readonly isStale: boolean;
  /** Whether it comes from a recording: drawn hollow, so that nobody takes it for a live one. */
  readonly isRecorded: boolean;
  /** How urgently it needs attention. */
  readonly level: AttentionLevel;
  /** Where it probably is now, while it is not heard. */
  readonly ghost: {
    readonly at: LonLat;
    readonly heading_deg: number;
    readonly label: string;
    /** The way to there from where it was last heard. */
    readonly path: readonly LonLat[];
  } | null;
}

/** The line ahead of a plane ends where it will be after this time, seconds. */
const AHEAD_S = 10;
/** Slower than this, the course over ground is noise. */
const SLOW_M_S = 3;

export class HomePainter implements Painter {
  home: LonLat | null = null;

  paint(frame: Frame): void {
    if (this.home !== null) paintHome(frame, frame.pixel(toXY(this.home)));
  }
}

export class VehiclePainter implements Painter {
  vehicles: readonly VehicleMark[] = [];
  /** A place that the plane was sent to from the map. */
  target: LonLat | null = null;

  paint(frame: Frame): void {
    if (this.target !== null) paintTarget(frame, frame.pixel(toXY(this.target)));
    for (const vehicle of this.vehicles) if (!vehicle.isSelected) this.#paintVehicle(frame, vehicle);
    for (const vehicle of this.vehicles) if (vehicle.isSelected) this.#paintVehicle(frame, vehicle);
  }

  /** Their visible state to a quarter of a pixel and of a degree: nothing is repainted while it is the same. */
  seen(view: Projection): string {
    const quarters = (value: number): number => Math.round(4 * value);
    const place = (at: LonLat | null): number[] | null => at && view.pixel(toXY(at)).map(quarters);
    const heading = (heading_deg: number | null): number | null => heading_deg && quarters(heading_deg);
    const seen = this.vehicles.map(({ ghost, ...vehicle }) => [
      vehicle.id,
      vehicle.label,
      vehicle.level,
      vehicle.isSelected,
      vehicle.isStale,
      vehicle.isRecorded,
      place(vehicle.at),
      heading(vehicle.heading_deg),
      place(placeAhead(vehicle)),
      ghost && [ghost.label, place(ghost.at), heading(ghost.heading_deg), ghost.path.length],
    ]);
    return JSON.stringify([place(this.target), seen]);
  }

  vehicleAt(frame: Projection, x: number, y: number, tolerance_px: number): number | null {
    for (const vehicle of this.vehicles) {
      const [vx, vy] = frame.pixel(toXY(vehicle.at));
      if (Math.hypot(vx - x, vy - y) <= Math.max(16, tolerance_px)) return vehicle.id;
    }
    return null;
  }

  #paintVehicle(frame: Frame, vehicle: VehicleMark): void {
    const { context, theme } = frame;
    const [x, y] = frame.pixel(toXY(vehicle.at));
    const { ghost } = vehicle;
    const ahead = placeAhead(vehicle);
    if (ghost !== null) {
      const [gx, gy] = frame.pixel(toXY(ghost.at));
      context.setLineDash([4, 6]);
      context.lineJoin = 'round';
      context.beginPath();
      traceLine(frame, toLine(ghost.path));
      strokeWithEdge(frame, theme.estimated, 2, 1);
      paintPlane(frame, gx, gy, ghost.heading_deg, { fill: null, line: theme.estimated, scale: 1 });
      context.setLineDash([]);
      const isUnderName = vehicle.label !== '' && Math.abs(gx - x) < 120 && Math.abs(gy - y) < 16;
      label(frame, ghost.label, gx, isUnderName ? y + 38 : gy + 22, theme.estimated);
    } else if (ahead !== null) {
      context.setLineDash([]);
      context.lineCap = 'round';
      context.beginPath();
      context.moveTo(x, y);
      context.lineTo(...frame.pixel(toXY(ahead)));
      strokeWithEdge(frame, theme.plane, 2, 1);
    }
    const fill = vehicle.isStale
      ? theme.stale
      : { danger: theme.danger, warn: theme.warn, none: theme.plane }[vehicle.level];
    const scale = vehicle.isSelected ? 1 : 0.8;
    if (vehicle.heading_deg === null) {
      context.beginPath();
      context.arc(x, y, 8, 0, 2 * Math.PI);
      strokeWithEdge(frame, fill, 4);
    } else {
      const [inside, line] = vehicle.isRecorded ? [theme.surface, theme.text] : [fill, theme.isDark ? '#000' : '#fff'];
      paintPlane(frame, x, y, vehicle.heading_deg, { fill: inside, line, scale });
      if (vehicle.isRecorded) {
        context.beginPath();
        context.arc(x, y, 23 * scale, 0, 2 * Math.PI);
        context.setLineDash([4, 4]);
        strokeWithEdge(frame, theme.text, 2, 1);
        context.setLineDash([]);
      }
    }
    if (vehicle.label) label(frame, vehicle.label, x, y + 22, vehicle.isSelected ? theme.text : theme.muted);
  }
}

/** Where a plane that is heard and flies will be; `null` for others. */
function placeAhead({ at, isStale, course_deg, groundspeed_m_s }: Omit<VehicleMark, 'ghost'>): LonLat | null {
  const flies = !isStale && groundspeed_m_s !== null && groundspeed_m_s > SLOW_M_S;
  return flies && course_deg !== null ? destination(at, course_deg, groundspeed_m_s * AHEAD_S) : null;
}

function label(frame: Frame, text: string, x: number, y: number, colour: string): void {
  frame.context.font = `600 12px ${frame.theme.font}`;
  frame.context.textAlign = 'center';
  frame.context.textBaseline = 'top';
  haloText(frame, text, x, y, colour);
}

/** Half of the plane's outline as seen from above, nose up, in pixels. */
const OUTLINE: readonly XY[] = [
  [0, -18],
  [2.2, -14],
  [2.6, -6],
  [18, 1],
  [18, 5],
  [2.6, 3],
  [1.8, 11],
  [7, 15],
  [7, 18],
  [0, 16],
];

export function paintPlane(
  frame: Pen,
  x: number,
  y: number,
  heading_deg: number,
  look: { fill: string | null; line: string; scale: number; bank_deg?: number },
): void {
  const { context } = frame;
  context.save();
  context.translate(x, y);
  context.rotate((heading_deg * Math.PI) / 180);
  // from above, banked wings look shorter
  context.scale(look.scale * Math.cos(((look.bank_deg ?? 0) * Math.PI) / 180), look.scale);
  context.beginPath();
  OUTLINE.forEach(([px, py], index) => (index === 0 ? context.moveTo(px, py) : context.lineTo(px, py)));
  [...OUTLINE].reverse().forEach(([px, py]) => context.lineTo(-px, py));
  context.closePath();
  context.lineJoin = 'round';
  if (look.fill === null) {
    context.setLineDash([3, 2]);
    strokeWithEdge(frame, look.line, 2, 1);
  } else {
    context.strokeStyle = look.line;
    context.lineWidth = 3.5;
    context.stroke();
    context.fillStyle = look.fill;
    context.fill();
  }
  context.restore();
}

function paintHome(frame: Frame, [x, y]: XY): void {
  const { context, theme } = frame;
  context.beginPath();
  context.moveTo(x, y - 13);
  context.lineTo(x + 13, y - 2);
  context.lineTo(x + 9, y - 2);
  context.lineTo(x + 9, y + 11);
  context.lineTo(x - 9, y + 11);
  context.lineTo(x - 9, y - 2);
  context.lineTo(x - 13, y - 2);
  context.closePath();
  context.lineJoin = 'round';
  context.strokeStyle = theme.surface;
  context.lineWidth = 5;
  context.stroke();
  context.fillStyle = theme.text;
  context.fill();
  context.fillStyle = theme.surface;
  context.font = `700 12px ${theme.font}`;
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  context.fillText('H', x, y + 4);
}

function paintTarget(frame: Frame, [x, y]: XY): void {
  const { context, theme } = frame;
  context.beginPath();
  context.arc(x, y, 11, 0, 2 * Math.PI);
  for (const [dx, dy] of [
    [1, 0],
    [-1, 0],
    [0, 1],
    [0, -1],
  ] as const) {
    context.moveTo(x + dx * 6, y + dy * 6);
    context.lineTo(x + dx * 17, y + dy * 17);
  }
  strokeWithEdge(frame, theme.ok, 2.5);
}
