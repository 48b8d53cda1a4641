// Draws the attitude indicator with its tapes on a canvas. Knows nothing of vehicles: it gets numbers and colours.

export type Context = CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D;

export interface Picture {
  roll_rad: number;
  pitch_rad: number;
  /** Null when not known. */
  heading_rad: number | null;
  /** In the units shown; null when not known. */
  airspeed: number | null;
  altitude: number | null;
  climb_m_s: number | null;
  /** Whether airspeed and climb are old, and the altitude. */
  isHudOld: boolean;
  isPositionOld: boolean;
}

export interface Words {
  speedUnit: string;
  lengthUnit: string;
  /** Writes a climb without its unit. */
  climb: (value_m_s: number) => string;
  north: string;
  east: string;
  south: string;
  west: string;
  /** Across the instrument when its values are old. */
  old: string;
  /** In place of the horizon before the first attitude. */
  none: string;
}

export interface Colours {
  sky: string;
  ground: string;
  horizon: string;
  tape: string;
  text: string;
  box: string;
  muted: string;
  symbol: string;
  accent: string;
  danger: string;
  font: string;
}

const DEG = Math.PI / 180;
/** Opacity of a tape whose value is old. */
const FADED = 0.45;

export function readColours(element: Element): Colours {
  const style = getComputedStyle(element);
  const get = (name: string) => style.getPropertyValue(`--${name}`).trim();
  return {
    sky: get('color-sky'),
    ground: get('color-ground'),
    horizon: get('color-horizon'),
    tape: get('color-tape'),
    text: get('color-instrument'),
    box: get('color-instrument-box'),
    muted: get('color-text-muted'),
    symbol: get('color-plane-symbol'),
    accent: get('color-accent'),
    danger: get('color-danger'),
    font: get('font') || 'sans-serif',
  };
}

export function drawInstrument(
  context: Context,
  width: number,
  height: number,
  picture: Picture | null,
  words: Words,
  colours: Colours,
  isOld: boolean,
): void {
  context.save();
  context.clearRect(0, 0, width, height);
  context.lineCap = 'butt';
  context.textBaseline = 'middle';
  const heading_h = 40;
  const tape_w = Math.min(62, width * 0.2);
  const body_h = height - heading_h;
  if (isOld) context.filter = 'grayscale(1)';
  drawHorizon(context, width, body_h, picture, words.none, colours);
  context.globalAlpha = picture?.isHudOld ? FADED : 1;
  drawTape(context, 0, 0, tape_w, body_h, picture?.airspeed ?? null, {
    step: 5,
    perStep: body_h / 6,
    isLeft: true,
    least: 0,
    unit: words.speedUnit,
    colours,
  });
  context.globalAlpha = picture?.isPositionOld ? FADED : 1;
  const step = words.lengthUnit === 'ft' ? 50 : 10;
  drawTape(context, width - tape_w, 0, tape_w, body_h, picture?.altitude ?? null, {
    step,
    perStep: body_h / 6,
    isLeft: false,
    least: Number.NEGATIVE_INFINITY,
    unit: words.lengthUnit,
    colours,
  });
  context.globalAlpha = picture?.isHudOld ? FADED : 1;
  drawClimb(context, width - tape_w, body_h, picture?.climb_m_s ?? null, words, colours);
  context.globalAlpha = isOld ? FADED : 1;
  drawHeading(context, 0, body_h, width, heading_h, picture?.heading_rad ?? null, words, colours);
  context.globalAlpha = 1;
  context.filter = 'none';
  if (isOld) drawOld(context, width, body_h, words.old, colours);
  context.restore();
}

function drawHorizon(
  context: Context,
  width: number,
  height: number,
  picture: Picture | null,
  none: string,
  colours: Colours,
): void {
  const cx = width / 2;
  const cy = height / 2;
  // About 50 degrees of pitch fit in the window.
  const perDegree = height / 50;
  context.save();
  context.beginPath();
  context.rect(0, 0, width, height);
  context.clip();
  if (picture === null) {
    context.fillStyle = colours.muted;
    context.globalAlpha = 0.25;
    context.fillRect(0, 0, width, height);
    context.globalAlpha = 1;
    context.font = `600 13px ${colours.font}`;
    context.textAlign = 'center';
    context.fillText(none, cx, cy);
    context.restore();
    return;
  }
  context.translate(cx, cy);
  context.rotate(-picture.roll_rad);
  const pitch_deg = picture.pitch_rad / DEG;
  const far = width + height;
  // The horizon stays at the edge of the window when it is beyond: up and down are always seen.
  const limit = height * 0.46;
  const y0 = Math.max(-limit, Math.min(limit, pitch_deg * perDegree));
  context.fillStyle = colours.sky;
  context.fillRect(-far, -far, 2 * far, far + y0);
  context.fillStyle = colours.ground;
  context.fillRect(-far, y0, 2 * far, far);
  context.strokeStyle = colours.horizon;
  context.lineWidth = 2;
  line(context, -far, y0, far, y0);

  context.font = `600 11px ${colours.font}`;
  context.fillStyle = colours.horizon;
  context.textAlign = 'center';
  const nearest = Math.round(pitch_deg / 5) * 5;
  for (let mark = Math.max(-90, nearest - 20); mark <= Math.min(90, nearest + 20); mark += 5) {
    if (mark === 0) continue;
    const y = (pitch_deg - mark) * perDegree;
    if (Math.abs(y) > height * 0.36) continue;
    const half = mark % 10 === 0 ? 26 : 13;
    context.lineWidth = 1.5;
    line(context, -half, y, half, y);
    if (mark % 10 === 0) {
      context.fillText(String(Math.abs(mark)), -half - 11, y);
      context.fillText(String(Math.abs(mark)), half + 11, y);
    }
  }

  // Roll scale: turns with the horizon, the pointer stands still.
  const radius = Math.min(width * 0.27, height * 0.42);
  context.strokeStyle = colours.horizon;
  for (const mark of [-60, -45, -30, -20, -10, 0, 10, 20, 30, 45, 60]) {
    const angle = (mark - 90) * DEG;
    const length = mark % 30 === 0 ? 10 : 6;
    context.lineWidth = mark === 0 ? 3 : 1.5;
    line(
      context,
      Math.cos(angle) * radius,
      Math.sin(angle) * radius,
      Math.cos(angle) * (radius + length),
      Math.sin(angle) * (radius + length),
    );
  }
  context.rotate(picture.roll_rad);
  context.fillStyle = colours.symbol;
  context.strokeStyle = '#000000';
  context.lineWidth = 1;
  polygon(context, [
    [0, -radius + 1],
    [-7, -radius + 12],
    [7, -radius + 12],
  ]);
  context.fill();
  context.stroke();

  // The plane itself, with a dark edge so that it stands out on sky and ground alike.
  for (const [stroke, line_w] of [
    ['#000000', 6],
    [colours.symbol, 3.5],
  ] as const) {
    context.strokeStyle = stroke;
    context.lineWidth = line_w;
    context.lineJoin = 'round';
    context.beginPath();
    context.moveTo(-44, 0);
    context.lineTo(-16, 0);
    context.lineTo(-8, 9);
    context.lineTo(0, 0);
    context.lineTo(8, 9);
    context.lineTo(16, 0);
    context.lineTo(44, 0);
    context.stroke();
  }
  context.restore();
}

interface Tape {
  step: number;
  /** Pixels between two labelled marks. */
  perStep: number;
  isLeft: boolean;
  least: number;
  unit: string;
  colours: Colours;
}

function drawTape(
  context: Context,
  x: number,
  y: number,
  width: number,
  height: number,
  value: number | null,
  { step, perStep, isLeft, least, unit, colours }: Tape,
): void {
  const cy = y + height / 2;
  context.save();
  context.beginPath();
  context.rect(x, y, width, height);
  context.clip();
  context.fillStyle = colours.tape;
  context.fillRect(x, y, width, height);
  const edge = isLeft ? x + width : x;
  const inward = isLeft ? -1 : 1;
  context.strokeStyle = colours.text;
  context.fillStyle = colours.text;
  context.textAlign = isLeft ? 'right' : 'left';
  if (value !== null) {
    context.font = `12px ${colours.font}`;
    const first = Math.ceil((value - (height / 2 / perStep) * step) / step) * step;
    for (let mark = first; mark <= value + (height / 2 / perStep) * step; mark += step) {
      if (mark < least) continue;
      const at = cy - ((mark - value) / step) * perStep;
      context.lineWidth = 1.5;
      line(context, edge, at, edge + inward * 7, at);
      const isClear = Math.abs(at - cy) > 20 && at > y + 24 && at < y + height - 8;
      if (isClear) context.fillText(figure(mark), edge + inward * 11, at);
      const between = at - perStep / 2;
      context.lineWidth = 1;
      if (mark + step / 2 >= least) line(context, edge, between, edge + inward * 4, between);
    }
  }
  // Name and unit, over the marks.
  context.fillStyle = colours.tape;
  context.fillRect(x, y, width, 18);
  context.fillStyle = colours.text;
  context.font = `11px ${colours.font}`;
  context.textAlign = 'center';
  context.fillText(unit, x + width / 2, y + 9, width - 4);
  // The value in a box that points at the scale.
  const box_h = 28;
  const tip = edge;
  const base = edge + inward * 7;
  const back = isLeft ? x : x + width;
  context.fillStyle = colours.box;
  context.strokeStyle = colours.text;
  context.lineWidth = 1.5;
  polygon(context, [
    [tip, cy],
    [base, cy - 7],
    [base, cy - box_h / 2],
    [back, cy - box_h / 2],
    [back, cy + box_h / 2],
    [base, cy + box_h / 2],
    [base, cy + 7],
  ]);
  context.fill();
  context.stroke();
  context.fillStyle = colours.text;
  context.font = `600 17px ${colours.font}`;
  context.textAlign = 'center';
  context.fillText(value === null ? '–' : figure(value), (base + back) / 2, cy + 1, width - 12);
  context.restore();
}

/** Climb, as an arrow at the height tape, and in figures below it. */
function drawClimb(
  context: Context,
  x: number,
  height: number,
  climb_m_s: number | null,
  words: Words,
  colours: Colours,
): void {
  const width = 16;
  const cy = height / 2;
  context.save();
  context.fillStyle = colours.tape;
  context.fillRect(x - width, 0, width, height);
  context.strokeStyle = colours.text;
  context.fillStyle = colours.text;
  context.lineWidth = 1;
  /** Full deflection: 5 m/s, or 1000 ft/min. */
  const full_m_s = words.lengthUnit === 'ft' ? 5.08 : 5;
  const half = height / 2 - 22;
  for (const part of [-1, -0.6, -0.2, 0.2, 0.6, 1])
    line(context, x - width, cy - part * half, x - width + 5, cy - part * half);
  line(context, x - width, cy, x, cy);
  if (climb_m_s !== null) {
    const tip = cy - Math.max(-1, Math.min(1, climb_m_s / full_m_s)) * half;
    context.fillStyle = colours.accent;
    context.fillRect(x - width + 5, Math.min(cy, tip), width - 7, Math.abs(tip - cy));
    context.fillStyle = colours.text;
    context.font = `600 11px ${colours.font}`;
    context.textAlign = 'right';
    const figures = words.climb(Math.abs(climb_m_s));
    const isStill = !/[1-9]/.test(figures);
    const text = `${isStill ? '' : climb_m_s > 0 ? '+' : '−'}${figures}`;
    const text_w = context.measureText(text).width + 8;
    context.fillStyle = colours.tape;
    context.fillRect(x - text_w, height - 18, text_w, 18);
    context.fillStyle = colours.text;
    context.fillText(text, x - 4, height - 9);
  }
  context.restore();
}

function drawHeading(
  context: Context,
  x: number,
  y: number,
  width: number,
  height: number,
  heading_rad: number | null,
  words: Words,
  colours: Colours,
): void {
  context.save();
  context.beginPath();
  context.rect(x, y, width, height);
  context.clip();
  context.fillStyle = colours.box;
  context.fillRect(x, y, width, height);
  const cx = x + width / 2;
  context.strokeStyle = colours.text;
  context.fillStyle = colours.text;
  context.lineWidth = 1;
  context.textAlign = 'center';
  if (heading_rad !== null) {
    const heading = (((heading_rad / DEG) % 360) + 360) % 360;
    const perDegree = width / 90;
    const first = Math.ceil((heading - 50) / 5) * 5;
    for (let mark = first; mark <= heading + 50; mark += 5) {
      const at = cx + (mark - heading) * perDegree;
      const degrees = ((mark % 360) + 360) % 360;
      line(context, at, y, at, y + (mark % 10 === 0 ? 8 : 5));
      if (mark % 30 !== 0 || Math.abs(at - cx) < 46) continue;
      const letter = { 0: words.north, 90: words.east, 180: words.south, 270: words.west }[degrees];
      context.font = `${letter === undefined ? '' : '600 '}13px ${colours.font}`;
      context.fillText(letter ?? String(degrees).padStart(3, '0'), at, y + 22);
    }
    context.fillStyle = colours.box;
    context.lineWidth = 1.5;
    polygon(context, [
      [cx, y + 1],
      [cx - 7, y + 9],
      [cx - 27, y + 9],
      [cx - 27, y + 35],
      [cx + 27, y + 35],
      [cx + 27, y + 9],
      [cx + 7, y + 9],
    ]);
    context.fill();
    context.stroke();
    context.fillStyle = colours.text;
    context.font = `600 17px ${colours.font}`;
    context.fillText(`${String(Math.round(heading) % 360).padStart(3, '0')}°`, cx + 2, y + 23);
  }
  context.restore();
}

function drawOld(context: Context, width: number, height: number, text: string, colours: Colours): void {
  context.save();
  context.strokeStyle = colours.danger;
  context.lineWidth = 3;
  line(context, 0, 0, width, height);
  line(context, width, 0, 0, height);
  context.font = `600 16px ${colours.font}`;
  context.textAlign = 'center';
  const text_w = context.measureText(text).width + 20;
  context.fillStyle = colours.box;
  context.fillRect(width / 2 - text_w / 2, height * 0.28 - 14, text_w, 28);
  context.strokeRect(width / 2 - text_w / 2, height * 0.28 - 14, text_w, 28);
  context.fillStyle = colours.danger;
  context.fillText(text, width / 2, height * 0.28);
  context.restore();
}

/** A whole number with a true minus, and no minus before zero. */
function figure(value: number): string {
  const whole = Math.round(value);
  return whole < 0 ? `−${-whole}` : String(Math.abs(whole));
}

function line(context: Context, x1: number, y1: number, x2: number, y2: number): void {
  context.beginPath();
  context.moveTo(x1, y1);
  context.lineTo(x2, y2);
  context.stroke();
}

function polygon(context: Context, points: readonly (readonly [number, number])[]): void {
  context.beginPath();
  for (const [x, y] of points) context.lineTo(x, y);
  context.closePath();
}
