// Which panels are open, and how much of the window they leave to the map.
import { load, save } from './stored';

const LEFT_PANELS = ['instruments', 'fly'] as const;
const RIGHT_PANELS = ['fleet', 'plan', 'numbers', 'sensors', 'messages', 'params', 'maps', 'settings'] as const;
type LeftPanel = (typeof LEFT_PANELS)[number];
type RightPanel = (typeof RIGHT_PANELS)[number];
export type Panel = LeftPanel | RightPanel;

/** Widths count for text of the usual size: with larger text a window holds as much as a narrower one. */
/** Below this width one panel at a time opens, as a sheet from the bottom. */
const NARROW_PX = 900;
/** Below this height boxes begin folded. */
const LOW_PX = 600;
/** Below this width one dock at a time opens. */
const TIGHT_PX = 1180;

export interface Insets {
  top: number;
  right: number;
  bottom: number;
  left: number;
}

interface Open {
  left: LeftPanel[];
  right: RightPanel | null;
  sheet: Panel | null;
}

const defaults: Open = { left: ['instruments', 'fly'], right: null, sheet: null };

function read(value: unknown): Open | null {
  if (typeof value !== 'object' || value === null) return null;
  const { left, right, sheet } = value as Record<string, unknown>;
  return {
    left: LEFT_PANELS.filter((panel) => Array.isArray(left) && left.includes(panel)),
    right: RIGHT_PANELS.find((panel) => panel === right) ?? null,
    sheet: [...LEFT_PANELS, ...RIGHT_PANELS].find((panel) => panel === sheet) ?? null,
  };
}

/** Boxes over the map that fold to their names. */
export type Box = 'rehearsal' | 'profile' | 'wind';

function readFolds(value: unknown): Partial<Record<Box, boolean>> | null {
  if (typeof value !== 'object' || value === null) return null;
  const folds = value as Record<string, unknown>;
  const known = (['rehearsal', 'profile', 'wind'] as const).filter((box) => typeof folds[box] === 'boolean');
  return Object.fromEntries(known.map((box) => [box, folds[box] === true]));
}

/** How large text is, with 16 px as 1: people set it in their browser. */
function textScale(): number {
  const root = globalThis.document?.documentElement;
  return root === undefined ? 1 : parseFloat(getComputedStyle(root).fontSize) / 16 || 1;
}

const isLeft = (panel: Panel): panel is LeftPanel => (LEFT_PANELS as readonly string[]).includes(panel);

class Layout {
  #open = $state.raw<Open>(load('layout', defaults, read));
  #folds = $state.raw<Partial<Record<Box, boolean>>>(load('folds', {}, readFolds));
  width_px = $state(1280);
  height_px = $state(800);
  /** Whether there are vehicles enough for a list of them: its panel stays away until then. */
  hasFleet = $state(false);
  /** Measured by the shell: what the floating parts cover at each edge. */
  insets = $state.raw<Insets>({ top: 0, right: 0, bottom: 0, left: 0 });
  /** Width of the map's buttons, at its right edge. */
  controlsWidth_px = $state(0);

  /** Read again with the size of the window, which a zoom changes. */
  #scale = $derived.by(() => (this.width_px > 0 ? textScale() : 1));
  /** Whether text is so large that lines of it must be able to wrap everywhere. */
  hasLargeText = $derived(this.#scale >= 1.2);
  #roomy_px = $derived(this.width_px / this.#scale);
  /** A sheet with boxes below it would leave nothing of its panel. */
  isLow = $derived(this.height_px / this.#scale < LOW_PX);
  isNarrow = $derived(this.#roomy_px < NARROW_PX);
  /** Between two docks no map would be left to work on: the right one covers the left one meanwhile. */
  #isTight = $derived(!this.isNarrow && this.#roomy_px < TIGHT_PX);
  left = $derived<readonly LeftPanel[]>(
    this.isNarrow || (this.#isTight && this.#there(this.#open.right) !== null) ? [] : this.#open.left,
  );
  right = $derived<RightPanel | null>(this.isNarrow ? null : this.#there(this.#open.right));
  sheet = $derived<Panel | null>(this.isNarrow ? this.#there(this.#open.sheet) : null);

  #there<P extends Panel>(panel: P | null): P | null {
    return panel === 'fleet' && !this.hasFleet ? null : panel;
  }

  isOpen(panel: Panel): boolean {
    if (this.isNarrow) return this.sheet === panel;
    return isLeft(panel) ? this.left.includes(panel) : this.right === panel;
  }

  /** Whether a box is folded: as it was chosen, else as `unchosen` says. */
  isFolded(box: Box, unchosen = false): boolean {
    return this.#folds[box] ?? unchosen;
  }

  fold(box: Box, isFolded: boolean): void {
    this.#folds = { ...this.#folds, [box]: isFolded };
    save('folds', this.#folds);
  }

  open(panel: Panel): void {
    if (!this.isOpen(panel)) this.toggle(panel);
  }

  close(panel: Panel): void {
    if (this.isOpen(panel)) this.toggle(panel);
  }

  toggle(panel: Panel): void {
    const open = this.#open;
    if (this.isNarrow) this.#set({ ...open, sheet: open.sheet === panel ? null : panel });
    else if (isLeft(panel) && this.#isTight && open.right !== null) {
      this.#set({ ...open, right: null, left: open.left.includes(panel) ? open.left : [...open.left, panel] });
    } else if (isLeft(panel)) {
      const others = open.left.filter((other) => other !== panel);
      this.#set({ ...open, left: others.length < open.left.length ? others : [...others, panel] });
    } else this.#set({ ...open, right: open.right === panel ? null : panel });
  }

  #set(open: Open): void {
    this.#open = open;
    save('layout', open);
  }
}

export const layout = new Layout();
