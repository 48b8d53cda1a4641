// Where the camera's window is: moved and sized by pointer and by keyboard, and kept within the page.
import { cameras } from '$lib/state/camera.svelte';
import { layout } from '$lib/state/layout.svelte';

/** Pixels that an arrow key moves the window, or its corner. */
const STEP = 24;
const ARROWS: Readonly<Record<string, readonly [number, number]>> = {
  ArrowLeft: [-STEP, 0],
  ArrowRight: [STEP, 0],
  ArrowUp: [0, -STEP],
  ArrowDown: [0, STEP],
};

export class WindowPlace {
  isFullscreen = $state(false);
  isFloating = $derived(!layout.isNarrow && !cameras.isSwapped && !this.isFullscreen);
  #room = $derived({ width: layout.width_px, height: layout.height_px });
  /** Where the window is in fact: a room that became smaller takes it along. */
  box = $derived.by(() => {
    const { x, y, width, height } = cameras.box;
    const fits = { width: Math.min(width, this.#room.width), height: Math.min(height, this.#room.height) };
    return {
      x: Math.max(0, Math.min(x, this.#room.width - fits.width)),
      y: Math.max(0, Math.min(y, this.#room.height - fits.height)),
      ...fits,
    };
  });

  move = (event: PointerEvent): void => {
    if ((event.target as HTMLElement).closest('button, select')) return;
    const from = this.box;
    this.#drag(event, (dx, dy) => this.#put({ ...from, x: from.x + dx, y: from.y + dy }));
  };

  resize = (event: PointerEvent): void => {
    const from = this.box;
    this.#drag(event, (dx, dy) => this.#put({ ...from, width: from.width + dx, height: from.height + dy }));
  };

  /** An arrow moves the window, with Shift its lower right corner. */
  keydown = (event: KeyboardEvent): void => {
    const arrow = ARROWS[event.key];
    if (arrow === undefined || !this.isFloating) return;
    event.preventDefault();
    const [dx, dy] = arrow;
    const { x, y, width, height } = this.box;
    this.#put(
      event.shiftKey ? { x, y, width: width + dx, height: height + dy } : { x: x + dx, y: y + dy, width, height },
    );
  };

  #put(box: Parameters<typeof cameras.place>[0]): void {
    cameras.place(box, this.#room.width, this.#room.height);
  }

  #drag(event: PointerEvent, apply: (dx: number, dy: number) => void): void {
    if (event.button !== 0 || !this.isFloating) return;
    const target = event.currentTarget as HTMLElement;
    const { clientX: x, clientY: y } = event;
    target.setPointerCapture(event.pointerId);
    const ended = new AbortController();
    const { signal } = ended;
    target.addEventListener('pointermove', (event) => apply(event.clientX - x, event.clientY - y), { signal });
    for (const end of ['pointerup', 'pointercancel']) target.addEventListener(end, () => ended.abort(), { signal });
  }
}
