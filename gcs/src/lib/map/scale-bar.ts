// The scale in the map's corner: a round distance in the units in use.
import type MapEvent from 'ol/MapEvent';
import Control from 'ol/control/Control';
import { toLonLat } from 'ol/proj';

interface ScaleTexts {
  distance(value_m: number, step_m: number): string;
  step_m(least_m: number): number;
}

/** Least length of the bar; the next round distance is at most 2.5 times as long. */
const LEAST_PX = 64;

export class ScaleBar extends Control {
  readonly #bar: HTMLElement;
  #texts: ScaleTexts | null = null;
  #shown = '';

  constructor() {
    const element = document.createElement('div');
    element.className = 'ol-scale-line ol-unselectable';
    super({ element });
    this.#bar = document.createElement('div');
    this.#bar.className = 'ol-scale-line-inner';
    element.append(this.#bar);
  }

  setTexts(texts: ScaleTexts): void {
    this.#texts = texts;
    this.getMap()?.render();
  }

  override render({ frameState }: MapEvent): void {
    if (frameState === null || this.#texts === null) return;
    const { center, resolution } = frameState.viewState;
    const [, lat_deg = 0] = toLonLat(center);
    const perPixel_m = resolution * Math.cos((lat_deg * Math.PI) / 180);
    const length_m = this.#texts.step_m(LEAST_PX * perPixel_m);
    const [width, text] = [`${Math.round(length_m / perPixel_m)}px`, this.#texts.distance(length_m, length_m)];
    if (this.#shown === width + text) return;
    this.#shown = width + text;
    this.#bar.style.width = width;
    this.#bar.textContent = text;
  }
}
