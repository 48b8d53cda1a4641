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
  readonly #version: (() => number | string) | null;
  #drawn = '';

  /** With a `version` the layer is painted anew only when that, or the view, is another. */
  constructor(
    painters: readonly Painter[],
    look: () => { theme: Theme; insets: Insets },
    zIndex: number,
    version: (() => number | string) | null = null,
  ) {
    super({ zIndex });
    this.#painters = painters;
    this.#look = look;
    this.#version = version;
    this.#canvas.style.cssText = 'position:absolute;inset:0;width:100%;height:100%;pointer-events:none';
    this.#canvas.setAttribute('aria-hidden', 'true');
  }

  // The map takes a layer without a source for not ready.
  override getSourceState(): 'ready' {
    return 'ready';
  }

  override render(state: FrameState | null): HTMLElement | null {
    if (state === null) return null;
    const [width = 0, height = 0] = state.size;
    const ratio = state.pixelRatio;
    const [pixelWidth, pixelHeight] = [Math.round(width * ratio), Math.round(height * ratio)];
    const canvas = this.#canvas;
    if (this.#version !== null) {
      const { center, resolution } = state.viewState;
      const signature = [this.#version(), ...center, resolution, pixelWidth, pixelHeight].join();
      if (signature === this.#drawn) return canvas;
      this.#drawn = signature;
    }
    if (canvas.width !== pixelWidth || canvas.height !== pixelHeight) {
      canvas.width = pixelWidth;
      canvas.height = pixelHeight;
    }
    const context = canvas.getContext('2d');
    if (context === null) return canvas;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, pixelWidth, pixelHeight);
    const { center, resolution } = state.viewState;
    const centre: XY = [center[0] ?? 0, center[1] ?? 0];
    const view = projection(centre, resolution, { width, height });
    const frame: Frame = { ...view, ...this.#look(), context, pixelRatio: ratio };
    for (const painter of this.#painters) {
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.globalAlpha = 1;
      context.setLineDash([]);
      painter.paint(frame);
    }
    return canvas;
  }
}
