// The planned route: legs with their directions, numbered items, circles, landing approaches, and progress.
import { type Frame, haloText, type Painter, type Projection, strokeWithEdge, traceLine, type XY } from './frame';
import { EMPTY_ROUTE, type RouteItem, type RouteLeg, type RouteView } from './route-view';

/** How the items of a route stand. Numbers count from 1. */
export interface RouteStatus {
  readonly selection: ReadonlySet<number>;
  readonly reached: ReadonlySet<number>;
  readonly current: number | null;
  /** Whether legs show their handles. */
  readonly isEditing: boolean;
  /** Items drawn as dots without a number, their legs without handles: they belong to a survey that is edited as a whole. */
  readonly quiet: ReadonlySet<number> | 'all';
}

export interface RouteTexts {
  /** Names an approach: "1:12 · 4.6°". */
  approach(drop_m: number, length_m: number): string;
}

const BADGE_PX = 12;
/** Legs shorter than this have no room for a handle or an arrow. */
const HANDLE_FROM_PX = 64;
const ARROW_FROM_PX = 40;

export class RoutePainter {
  route: RouteView = EMPTY_ROUTE;
  /** The route on the vehicle, where it differs from the one being edited. */
  vehicleRoute: RouteView = EMPTY_ROUTE;
  status: RouteStatus = {
    selection: new Set(),
    reached: new Set(),
    current: null,
    isEditing: false,
    quiet: new Set(),
  };
  texts: RouteTexts = { approach: () => '' };

  /** What lies below home and items. */
  readonly lines: Painter = { paint: (frame) => this.#paintLines(frame) };
  /** Direction arrows, handles, and labels of approaches. */
  readonly directions: Painter = { paint: (frame) => this.#paintDirections(frame) };
  readonly marks: Painter = { paint: (frame) => this.#paintItems(frame) };

  #paintLines(frame: Frame): void {
    this.#paintVehicleRoute(frame);
    for (const circle of this.route.circles) this.#paintCircle(frame, circle);
    for (const jump of this.route.jumps) this.#paintJump(frame, jump.from, jump.to);
    this.#paintLegs(frame);
  }

  #paintDirections(frame: Frame): void {
    for (const leg of this.route.legs) if (isInSight(frame, leg)) this.#paintDirection(frame, leg);
    for (const approach of this.route.approaches) {
      const [x, y] = frame.pixel(approach.middle);
      if (approach.length_m / frame.resolution < 110) continue;
      frame.context.font = `600 12px ${frame.theme.font}`;
      frame.context.textAlign = 'center';
      frame.context.textBaseline = 'bottom';
      const text = this.texts.approach(approach.drop_m, approach.length_m);
      const { is_doubtful: isBad } = approach;
      haloText(frame, isBad ? `⚠ ${text}` : text, x, y - 12, isBad ? frame.theme.warn : frame.theme.text);
    }
  }

  /** The item at a pixel, the topmost first. */
  itemAt(frame: Projection, x: number, y: number, tolerance_px: number): RouteItem | null {
    let best: RouteItem | null = null;
    let nearest = Math.max(BADGE_PX, tolerance_px);
    for (const item of this.route.items) {
      const [ix, iy] = frame.pixel(item.at);
      const distance = Math.hypot(ix - x, iy - y);
      const isBetter =
        distance < nearest || (distance === nearest && best !== null && this.status.selection.has(item.number));
      if (isBetter) [best, nearest] = [item, distance];
    }
    return best;
  }

  /** The leg whose handle is at a pixel. */
  handleAt(frame: Projection, x: number, y: number, tolerance_px: number): RouteLeg | null {
    let best: RouteLeg | null = null;
    let nearest = Math.max(9, tolerance_px);
    for (const leg of this.route.legs) {
      if (!this.#isHandled(frame, leg)) continue;
      const [hx, hy] = frame.pixel(leg.middle);
      const distance = Math.hypot(hx - x, hy - y);
      if (distance < nearest) [best, nearest] = [leg, distance];
    }
    return best;
  }

  #isQuiet(number: number): boolean {
    return this.status.quiet === 'all' || this.status.quiet.has(number);
  }

  #isHandled(frame: Projection, leg: RouteLeg): boolean {
    // between two items of one survey none is put by hand
    const isInside = this.#isQuiet(leg.toIndex) && this.#isQuiet(leg.toIndex + 1);
    return this.status.isEditing && !isInside && hasHandle(frame, leg);
  }

  itemsWithin(frame: Projection, x0: number, y0: number, x1: number, y1: number): number[] {
    const [left, right] = [Math.min(x0, x1), Math.max(x0, x1)];
    const [top, bottom] = [Math.min(y0, y1), Math.max(y0, y1)];
    return this.route.items
      .filter((item) => {
        const [x, y] = frame.pixel(item.at);
        return x >= left && x <= right && y >= top && y <= bottom;
      })
      .map((item) => item.number);
  }

  #paintVehicleRoute(frame: Frame): void {
    const { context, theme } = frame;
    if (this.vehicleRoute.legs.length === 0) return;
    context.setLineDash([2, 5]);
    context.lineCap = 'butt';
    context.beginPath();
    for (const leg of this.vehicleRoute.legs) traceLine(frame, leg.line);
    context.strokeStyle = theme.muted;
    context.lineWidth = 2;
    context.stroke();
    context.setLineDash([]);
    for (const item of this.vehicleRoute.items) {
      const [x, y] = frame.pixel(item.at);
      context.beginPath();
      context.arc(x, y, 4, 0, 2 * Math.PI);
      context.fillStyle = theme.surface;
      context.fill();
      context.strokeStyle = theme.muted;
      context.stroke();
    }
  }

  /** Legs that look alike are one path: a mission of hundreds of items costs a few strokes. */
  #paintLegs(frame: Frame): void {
    const { context } = frame;
    const groups = new Map<string, { look: LegLook; legs: RouteLeg[] }>();
    for (const leg of this.route.legs) {
      if (!isInSight(frame, leg)) continue;
      const look = this.#lookOf(frame, leg);
      const key = `${look.colour} ${look.width} ${look.dash.join()}`;
      const group = groups.get(key);
      if (group) group.legs.push(leg);
      else groups.set(key, { look, legs: [leg] });
    }
    for (const { look, legs } of groups.values()) {
      context.setLineDash(look.dash);
      context.lineCap = look.dash.length === 0 ? 'round' : 'butt';
      context.lineJoin = 'round';
      context.beginPath();
      for (const leg of legs) traceLine(frame, leg.line);
      strokeWithEdge(frame, look.colour, look.width, 1.5);
    }
    context.setLineDash([]);
  }

  #lookOf({ theme }: Frame, leg: RouteLeg): LegLook {
    const isCurrent = this.status.current === leg.toIndex + 1;
    const isFlown = this.status.reached.has(leg.toIndex + 1) && !isCurrent;
    return {
      colour: isCurrent ? theme.ok : isFlown ? theme.muted : leg.kind === 'approach' ? theme.warn : theme.accent,
      width: isCurrent ? 5 : 3,
      dash: leg.isGuess ? [2, 6] : leg.kind === 'takeoff' ? [10, 6] : leg.kind === 'return' ? [3, 6] : [],
    };
  }

  #paintDirection(frame: Frame, leg: RouteLeg): void {
    const last = leg.line.length - 1;
    const [from, to] = [frame.pixel(leg.line[0] as XY), frame.pixel(leg.line[last] as XY)];
    if (Math.hypot(to[0] - from[0], to[1] - from[1]) < ARROW_FROM_PX) return;
    const { colour } = this.#lookOf(frame, leg);
    const isHandled = this.#isHandled(frame, leg);
    // where a handle sits in the middle, arrows stand beside it
    for (const part of isHandled ? [0.3, 0.75] : [0.55]) {
      const position = part * last;
      const index = Math.min(Math.floor(position), last - 1);
      const [a, b] = [frame.pixel(leg.line[index] as XY), frame.pixel(leg.line[index + 1] as XY)];
      const rest = position - index;
      const [x, y] = [a[0] + (b[0] - a[0]) * rest, a[1] + (b[1] - a[1]) * rest];
      arrow(frame, x, y, Math.atan2(b[1] - a[1], b[0] - a[0]), colour);
    }
    if (isHandled) this.#paintHandle(frame, leg.middle);
  }

  #paintHandle(frame: Frame, at: XY): void {
    const { context, theme } = frame;
    const [x, y] = frame.pixel(at);
    context.beginPath();
    context.arc(x, y, 8, 0, 2 * Math.PI);
    context.fillStyle = theme.surface;
    context.fill();
    context.strokeStyle = theme.accent;
    context.lineWidth = 2;
    context.stroke();
    context.beginPath();
    context.moveTo(x - 4, y);
    context.lineTo(x + 4, y);
    context.moveTo(x, y - 4);
    context.lineTo(x, y + 4);
    context.stroke();
  }

  #paintCircle(frame: Frame, circle: RouteView['circles'][number]): void {
    const { context, theme } = frame;
    const isCurrent = this.status.current === circle.number;
    const colour = isCurrent ? theme.ok : this.status.reached.has(circle.number) ? theme.muted : theme.accent;
    context.setLineDash(circle.isOwnRadius ? [] : [6, 6]);
    context.beginPath();
    traceLine(frame, circle.line);
    strokeWithEdge(frame, colour, isCurrent ? 4 : 2, 1.5);
    context.setLineDash([]);
    // points run clockwise from north
    for (const part of [0.125, 0.625]) {
      const index = Math.floor(part * (circle.line.length - 1));
      const [a, b] = [frame.pixel(circle.line[index] as XY), frame.pixel(circle.line[index + 1] as XY)];
      const angle = Math.atan2(b[1] - a[1], b[0] - a[0]) + (circle.isClockwise ? 0 : Math.PI);
      arrow(frame, a[0], a[1], angle, colour);
    }
  }

  #paintJump(frame: Frame, from: XY, to: XY): void {
    const { context, theme } = frame;
    const [a, b] = [frame.pixel(from), frame.pixel(to)];
    const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    const control: XY = [(a[0] + b[0]) / 2 - dy * 0.25, (a[1] + b[1]) / 2 + dx * 0.25];
    context.setLineDash([4, 4]);
    context.beginPath();
    context.moveTo(a[0], a[1]);
    context.quadraticCurveTo(control[0], control[1], b[0], b[1]);
    strokeWithEdge(frame, theme.muted, 2, 1);
    context.setLineDash([]);
    const middle: XY = [(a[0] + b[0]) / 4 + control[0] / 2, (a[1] + b[1]) / 4 + control[1] / 2];
    arrow(frame, middle[0], middle[1], Math.atan2(dy, dx), theme.muted);
  }

  #paintItems(frame: Frame): void {
    const { context, theme, size } = frame;
    const taken = new Set<number>();
    const cell = (x: number, y: number): number => Math.floor(x / 22) * 4096 + Math.floor(y / 22);
    // the selected and the current come first where there is no room for all
    const { selection, current, reached } = this.status;
    const rank = (item: RouteItem): number => (selection.has(item.number) ? 0 : item.number === current ? 1 : 2);
    const visible = this.route.items
      .map((item) => ({ item, at: frame.pixel(item.at) }))
      .filter(({ at: [x, y] }) => x > -20 && y > -20 && x < size.width + 20 && y < size.height + 20)
      .sort((a, b) => rank(a.item) - rank(b.item) || a.item.number - b.item.number);
    const shown = visible.filter(({ item, at: [x, y] }) => {
      if (this.#isQuiet(item.number) && !selection.has(item.number) && item.number !== current) return false;
      const key = cell(x, y);
      if (taken.has(key)) return false;
      taken.add(key);
      return true;
    });
    const isShown = new Set(shown);
    for (const one of visible) {
      if (isShown.has(one)) continue;
      context.beginPath();
      context.arc(one.at[0], one.at[1], 3, 0, 2 * Math.PI);
      context.fillStyle = theme.accent;
      context.fill();
    }
    for (const { item, at } of shown.reverse()) {
      const [x, y] = at;
      const isSelected = selection.has(item.number);
      const isCurrent = current === item.number;
      const isReached = reached.has(item.number) && !isCurrent;
      const colour = isCurrent ? theme.ok : isReached ? theme.muted : item.kind === 'land' ? theme.warn : theme.accent;
      context.beginPath();
      outline(context, item.kind, x, y, BADGE_PX);
      context.lineJoin = 'round';
      if (isSelected) {
        context.strokeStyle = theme.text;
        context.lineWidth = 9;
        context.stroke();
      }
      context.strokeStyle = theme.surface;
      context.lineWidth = 5;
      context.stroke();
      context.fillStyle = isSelected || isCurrent ? colour : theme.surface;
      context.fill();
      context.strokeStyle = colour;
      context.lineWidth = 2.5;
      context.stroke();
      context.fillStyle = isSelected || isCurrent ? theme.surface : theme.text;
      context.textAlign = 'center';
      context.textBaseline = 'middle';
      const text = String(item.number);
      context.font = `700 ${text.length > 2 ? 10 : 12}px ${theme.font}`;
      const shift = item.kind === 'takeoff' ? 2 : item.kind === 'land' ? -2 : 0;
      context.fillText(text, x, y + 0.5 + shift);
      if (isReached) tick(frame, x + 10, y - 10);
    }
  }
}

interface LegLook {
  readonly colour: string;
  readonly width: number;
  readonly dash: number[];
}

/** Whether anything of a leg may lie in the window. */
function isInSight(frame: Projection, leg: RouteLeg): boolean {
  let [left, top, right, bottom] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const at of leg.line) {
    const [x, y] = frame.pixel(at);
    [left, right] = [Math.min(left, x), Math.max(right, x)];
    [top, bottom] = [Math.min(top, y), Math.max(bottom, y)];
  }
  const edge = 20;
  const { width, height } = frame.size;
  return right > -edge && bottom > -edge && left < width + edge && top < height + edge;
}

function hasHandle(frame: Projection, leg: RouteLeg): boolean {
  if (leg.kind === 'return') return false;
  const [from, to] = [frame.pixel(leg.line[0] as XY), frame.pixel(leg.line.at(-1) as XY)];
  return Math.hypot(to[0] - from[0], to[1] - from[1]) >= HANDLE_FROM_PX;
}

/** Shapes distinguish kinds without colour: up for take-off, down for landing, a square for circling. */
function outline(context: CanvasRenderingContext2D, kind: RouteItem['kind'], x: number, y: number, r: number): void {
  switch (kind) {
    case 'takeoff':
      polygon(context, [
        [x, y - r * 1.3],
        [x + r * 1.2, y + r * 0.9],
        [x - r * 1.2, y + r * 0.9],
      ]);
      break;
    case 'land':
      polygon(context, [
        [x, y + r * 1.3],
        [x - r * 1.2, y - r * 0.9],
        [x + r * 1.2, y - r * 0.9],
      ]);
      break;
    case 'loiter_turns':
    case 'loiter_time':
    case 'loiter_unlimited':
    case 'loiter_to_height':
      context.rect(x - r * 0.9, y - r * 0.9, r * 1.8, r * 1.8);
      break;
    default:
      context.arc(x, y, r, 0, 2 * Math.PI);
  }
}

function polygon(context: CanvasRenderingContext2D, points: readonly XY[]): void {
  points.forEach(([x, y], index) => (index === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  context.closePath();
}

function arrow(frame: Frame, x: number, y: number, angle_rad: number, colour: string): void {
  const { context, theme } = frame;
  context.save();
  context.translate(x, y);
  context.rotate(angle_rad);
  context.beginPath();
  polygon(context, [
    [8, 0],
    [-6, 6],
    [-3, 0],
    [-6, -6],
  ]);
  context.lineJoin = 'round';
  context.strokeStyle = theme.surface;
  context.lineWidth = 3;
  context.stroke();
  context.fillStyle = colour;
  context.fill();
  context.restore();
}

function tick(frame: Frame, x: number, y: number): void {
  const { context, theme } = frame;
  context.beginPath();
  context.arc(x, y, 7, 0, 2 * Math.PI);
  context.fillStyle = theme.ok;
  context.fill();
  context.beginPath();
  context.moveTo(x - 3.5, y);
  context.lineTo(x - 1, y + 3);
  context.lineTo(x + 4, y - 3);
  context.strokeStyle = theme.surface;
  context.lineWidth = 2;
  context.stroke();
}
