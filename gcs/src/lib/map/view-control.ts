// Where the map looks: it follows the selected plane, shows positions that are asked for, and keeps them in what panels leave free.
import type OlMap from 'ol/Map';
import View, { type AnimationOptions, type FitOptions } from 'ol/View';
import { inAndOut, easeOut } from 'ol/easing';
import { boundingExtent } from 'ol/extent';
import { toLonLat } from 'ol/proj';
import { type LonLat, wrap180_deg } from '$lib/domain/lonlat';
import { freeCentre, type Insets, insetsBeside, narrowFactor, type Rect, widenFactor } from '$lib/domain/sight';
import { type Box, boxAround, boxCorners } from '$lib/domain/tiling';
import { projection, type Projection, WORLD_M, type XY } from './frame';
import { toXY } from './route-view';

/** How the view stands to the selected plane. */
export type FollowMode = 'free' | 'follow' | 'sight';

export interface MapViewState {
  readonly centre: LonLat;
  readonly zoom: number;
}

const MAX_ZOOM = 21;
/** Of a place that is gone to: some kilometres. */
const PLACE_ZOOM = 14;
/** How long the view is left alone after a move by hand. */
const HANDS_OFF_MS = 4000;
/** A view that was widened stays so until the plane has needed less of it for this long. */
const NARROWS_AFTER_MS = 15_000;
/** A plane farther off than this many windows is jumped to, not zoomed out to. */
const JUMP_FACTOR = 12;

/** The view to begin with. */
export const viewAt = (state: MapViewState | null): View =>
  new View({
    center: [...toXY(state?.centre ?? { lon_deg: -3.7, lat_deg: 40.4 })],
    zoom: state?.zoom ?? 3,
    maxZoom: MAX_ZOOM,
    minZoom: 1,
    enableRotation: false,
    smoothExtentConstraint: false,
    constrainResolution: false,
  });

export function placeOf(coordinate: number[]): LonLat {
  const [lon_deg = 0, lat_deg = 0] = toLonLat(coordinate);
  return { lon_deg: wrap180_deg(lon_deg), lat_deg };
}

export class ViewControl {
  readonly #map: OlMap;
  readonly #view: View;
  /** Parts that panels cover, pixels. */
  insets: Insets = { top: 0, right: 0, bottom: 0, left: 0 };
  #follow: FollowMode = 'sight';
  /** Shows at once what the animation under way comes to. */
  #end: (() => void) | null = null;
  #hasSeenPlane = false;
  #movedByHand_ms = -Infinity;
  /** The resolution that somebody chose, while the view is wider to keep the plane in sight. */
  #chosen: number | null = null;
  /** Since when the plane has needed less than this wider view. */
  #narrowable_ms: number | null = null;
  /** What lies over the map beside the panels, pixels of it. */
  covers: () => readonly Rect[] = () => [];

  constructor(map: OlMap) {
    this.#map = map;
    this.#view = map.getView();
  }

  get isFollowing(): boolean {
    return this.#follow === 'follow';
  }

  get resolution(): number {
    return this.#view.getResolution() ?? 1;
  }

  /** `null` before the map has a size. */
  get state(): MapViewState | null {
    const [centre, zoom] = [this.#view.getCenter(), this.#view.getZoom()];
    return centre && zoom !== undefined ? { centre: placeOf(centre), zoom } : null;
  }

  /** Follows a plane that is there `at`; `null` when there is none yet. */
  setFollow(mode: FollowMode, at: LonLat | null): void {
    this.#follow = mode;
    this.#movedByHand_ms = -Infinity;
    this.#chosen = null;
    if (at === null || mode === 'free') return;
    if (mode === 'sight') this.keepInSight(at);
    else this.#centreOn(at, 300);
  }

  /** Leaves the view alone for a while. */
  movedByHand(): void {
    this.#movedByHand_ms = performance.now();
    this.#chosen = null;
  }

  zoomBy(steps: number): void {
    this.#endAnimation();
    const view = this.#view;
    const anchor = this.#freeCentre();
    const zoom = (view.getZoom() ?? 3) + steps;
    this.movedByHand();
    this.#animate({ anchor, zoom, duration: 180, easing: easeOut }, () =>
      view.adjustResolution(view.getResolutionForZoom(zoom) / (view.getResolution() ?? 1), anchor),
    );
  }

  /** The position in the middle of what panels leave free. */
  centre(): LonLat {
    return placeOf(this.#freeCentre());
  }

  centreOn(at: LonLat): void {
    this.movedByHand();
    this.#centreOn(at, 300);
  }

  /** Looks at a place that may be far away: near enough to see what is there. */
  goTo(at: LonLat): void {
    this.movedByHand();
    this.#endAnimation();
    this.#view.setZoom(Math.max(this.#view.getZoom() ?? 0, PLACE_ZOOM));
    this.#centreOn(at, 0);
  }

  /** Shows all of these positions in what panels leave free. */
  fit(places: readonly LonLat[]): void {
    if (places.length === 0) return;
    this.movedByHand();
    const [width = 0, height = 0] = this.#map.getSize() ?? [];
    const edge = Math.min(60, width * 0.1, height * 0.1);
    // over the date line the shorter way is meant
    const box = boxAround(places);
    if (box === null) return;
    const corners = boxCorners(box).map(toXY);
    const shift = this.#worldShift(corners[0]?.[0] ?? 0);
    const extent = boundingExtent(corners.map(([x, y]) => [x + shift, y]));
    const [west = 0, south = 0, east = 0, north = 0] = extent;
    const shape = { width: east - west, height: north - south };
    const { top, right, bottom, left } = insetsBeside(this.covers(), shape, { width, height }, this.insets);
    const fit: FitOptions = { padding: [top + edge, right + edge, bottom + edge, left + edge], maxZoom: 17 };
    this.#endAnimation();
    const end = (): void => this.#view.fit(extent, fit);
    this.#end = end;
    this.#view.fit(extent, { ...fit, duration: 300, callback: () => this.#ended(end) });
  }

  /** What panels leave free of the world; `null` before the first frame. */
  visibleBox(): Box | null {
    const [width = 0, height = 0] = this.#map.getSize() ?? [];
    const { top, right, bottom, left } = this.insets;
    const [x0, y0, x1, y1] = [left, top, Math.max(width - right, left + 1), Math.max(height - bottom, top + 1)];
    const [northWest, southEast] = [this.placeAt([x0, y0]), this.placeAt([x1, y1])];
    if (northWest === null || southEast === null) return null;
    const isWhole = (x1 - x0) * this.resolution >= WORLD_M;
    return {
      west_deg: isWhole ? -180 : northWest.lon_deg,
      east_deg: isWhole ? 180 : southEast.lon_deg,
      north_deg: northWest.lat_deg,
      south_deg: southEast.lat_deg,
    };
  }

  /** Moves the view, as it follows the plane that is there. */
  keepInSight(at: LonLat): void {
    const [width = 0, height = 0] = this.#map.getSize() ?? [];
    const frame = this.frame();
    if (width === 0 || height === 0 || frame === null) return;
    const [x, y] = frame.pixel(toXY(at));
    if (!this.#hasSeenPlane) {
      this.#hasSeenPlane = true;
      const isFar = (this.#view.getZoom() ?? 0) < 11;
      if (this.#follow !== 'free' && (isFar || widenFactor(x, y, { width, height }, this.insets) > 1)) {
        if (isFar) this.#view.setZoom(16);
        this.#centreOn(at, 0);
      }
      return;
    }
    if (this.#follow === 'free') return;
    if (this.#follow === 'follow') {
      if (!this.#view.getAnimating() && !this.#view.getInteracting()) this.#centreOn(at, 0);
      return;
    }
    const isHeld = this.#view.getInteracting() || performance.now() - this.#movedByHand_ms < HANDS_OFF_MS;
    if (this.#view.getAnimating() || isHeld) return;
    const factor = widenFactor(x, y, { width, height }, this.insets);
    if (factor > JUMP_FACTOR) {
      this.#centreOn(at, 0);
      return;
    }
    if (factor > 1) {
      this.#narrowable_ms = null;
      this.#chosen ??= this.resolution;
      this.#scaleBy(factor);
      return;
    }
    if (this.#chosen === null) return;
    const less = narrowFactor(x, y, { width, height }, this.insets, this.#chosen / this.resolution);
    const now_ms = performance.now();
    if (less === 1) this.#narrowable_ms = null;
    else if ((this.#narrowable_ms ??= now_ms) <= now_ms - NARROWS_AFTER_MS) {
      this.#narrowable_ms = null;
      this.#scaleBy(less);
    }
  }

  /** About the middle of what panels leave free. */
  #scaleBy(factor: number): void {
    const resolution = this.resolution * factor;
    this.#view.animate({ anchor: this.#freeCentre(), resolution, duration: 500, easing: inAndOut });
  }

  /** Starts an animation; `end` jumps to its final state. */
  #animate(animation: AnimationOptions, end: () => void): void {
    this.#end = end;
    this.#view.animate(animation, () => this.#ended(end));
  }

  #ended(end: () => void): void {
    if (this.#end === end) this.#end = null;
  }

  /** A second press or zoom during an animation starts from its final state. */
  #endAnimation(): void {
    const end = this.#end;
    this.#end = null;
    this.#view.cancelAnimations();
    end?.();
  }

  #centreOn(at: LonLat, duration: number): void {
    if (duration > 0) this.#endAnimation();
    const [width = 0, height = 0] = this.#map.getSize() ?? [];
    const resolution = this.resolution;
    const [px = 0, py = 0] = this.freeCentrePixel();
    const [x, y] = toXY(at);
    const center = [x + this.#worldShift(x) - (px - width / 2) * resolution, y + (py - height / 2) * resolution];
    if (duration === 0) this.#view.setCenter(center);
    else this.#animate({ center, duration, easing: inAndOut }, () => this.#view.setCenter(center));
  }

  /** How far the copy of the world that is looked at lies from the first: beyond the date line the view goes on. */
  #worldShift(x: number): number {
    return Math.round(((this.#view.getCenter()?.[0] ?? 0) - x) / WORLD_M) * WORLD_M;
  }

  /** The middle of what panels leave free. */
  freeCentrePixel(): [number, number] {
    const [width = 0, height = 0] = this.#map.getSize() ?? [];
    const { x, y } = freeCentre({ width, height }, this.insets);
    return [x, y];
  }

  /** The same as a coordinate: where the view is now, which may not have been painted yet. */
  #freeCentre(): [number, number] {
    const [width = 0, height = 0] = this.#map.getSize() ?? [];
    const [px, py] = this.freeCentrePixel();
    const [x = 0, y = 0] = this.#view.getCenter() ?? [];
    return [x + (px - width / 2) * this.resolution, y - (py - height / 2) * this.resolution];
  }

  /** The position at a pixel of what was painted last; `null` before the first frame. */
  placeAt(pixel: number[]): LonLat | null {
    const coordinate = this.#map.getCoordinateFromPixel(pixel);
    return coordinate ? placeOf(coordinate) : null;
  }

  /** The view as painters see it, for finding what lies at a pixel. */
  frame(): Projection | null {
    const [width = 0, height = 0] = this.#map.getSize() ?? [];
    const center = this.#view.getCenter();
    const resolution = this.#view.getResolution();
    if (!center || !resolution || width === 0) return null;
    const centre: XY = [center[0] ?? 0, center[1] ?? 0];
    return projection(centre, resolution, { width, height });
  }
}
