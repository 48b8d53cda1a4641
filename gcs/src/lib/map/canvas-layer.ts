// A layer of the map that is painted by hand, in one canvas, in the order of its painters.
import Layer from 'ol/layer/Layer';
import type { FrameState } from 'ol/Map';
import type Source from 'ol/source/Source';
import type { Insets } from '$lib/domain/sight';
import { type Frame, type Painter, projection, type Theme, type XY } from './frame';

export class CanvasLayer extends Layer<Source> {
  readonly #canvas = document.createElement('canvas');
  readonly #painters: readonly Painter[];
  readonly #look: () => { theme: Theme; insets: Insets };
  /** The map's last frame. */
  #state: FrameState | null = null;
  #painted = '';
  #waiting = 0;

  constructor(painters: readonly Painter[], look: () => { theme: Theme; insets: Insets }, zIndex: number) {
    super({ zIndex });
    this.#painters = painters;
    this.#look = look;
    this.#canvas.style.cssText = 'position:absolute;inset:0;width:100%;height:100%;pointer-events:none';
    this.#canvas.setAttribute('aria-hidden', 'true');
  }

  /** Marks the layer as changed; it is repainted in the next animation frame. The map's other layers are not. */
  touch(): void {
    this.#painted = '';
    this.#waiting ||= requestAnimationFrame(() => this.paintNow());
  }

  /** Repaints the changed layers at once. */
  paintNow(): void {
    cancelAnimationFrame(this.#waiting);
    this.#waiting = 0;
    if (this.#state !== null) this.#paint(this.#state);
  }

  // The map takes a layer without a source for not ready.
  override getSourceState(): 'ready' {
    return 'ready';
  }

  override render(state: FrameState | null): HTMLElement | null {
    this.#state = state;
    if (state === null) return null;
    this.#paint(state);
    return this.#canvas;
  }

  override disposeInternal(): void {
    cancelAnimationFrame(this.#waiting);
    super.disposeInternal();
  }

  #paint({ size, pixelRatio, viewState: { center, resolution } }: FrameState): void {
    const [width = 0, height = 0] = size;
    const [pixelWidth, pixelHeight] = [Math.round(width * pixelRatio), Math.round(height * pixelRatio)];
    const canvas = this.#canvas;
    const view = [...center, resolution, pixelWidth, pixelHeight].join();
    if (view === this.#painted) return;
    this.#painted = view;
    if (canvas.width !== pixelWidth || canvas.height !== pixelHeight) {
      canvas.width = pixelWidth;
      canvas.height = pixelHeight;
    }
    const context = canvas.getContext('2d');
    if (context === null) return;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, pixelWidth, pixelHeight);
    const centre: XY = [center[0] ?? 0, center[1] ?? 0];
    const frame: Frame = {
      ...projection(centre, resolution, { width, height }),
      ...this.#look(),
      context,
      pixelRatio,
    };
    for (const painter of this.#painters) {
      context.setTransform(pixelRatio, 0, 0, pixelRatio, 0, 0);
      context.globalAlpha = 1;
      context.setLineDash([]);
      painter.paint(frame);
    }
  }
}
