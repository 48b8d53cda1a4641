// What people do on the map: clicks and taps, dragging of items and corners, the box that selects, the menu, and the keyboard.
import type OlMap from 'ol/Map';
import type MapBrowserEvent from 'ol/MapBrowserEvent';
import { unByKey } from 'ol/Observable';
import type { EventsKey } from 'ol/events';
import PointerInteraction from 'ol/interaction/Pointer';
import type { AreaHandle } from '$lib/domain/area-edit';
import type { LonLat } from '$lib/domain/lonlat';
import type { AreaPainter } from './area-painter';
import type { FleetPainter } from './fleet-layer';
import type { RoutePainter } from './route-painter';
import type { RulerPainter } from './ruler-painter';
import type { VehiclePainter } from './vehicle-painter';
import { placeOf, type ViewControl } from './view-control';

interface Modifiers {
  /** Ctrl, Cmd or Shift: add to the selection. */
  readonly isAdding: boolean;
}

/** What people do on the map. Item numbers count from 1; pixels from the map's top left. */
export interface GestureEvents {
  /** A click or tap beside everything, or Enter while the map has the keyboard. */
  click?(at: LonLat, modifiers: Modifiers): void;
  itemClick?(number: number, modifiers: Modifiers): void;
  vehicleClick?(id: number): void;
  /** Several in a row while an item is dragged; the last has `isEnd`. */
  itemDrag?(number: number, from: LonLat, to: LonLat, isEnd: boolean): void;
  /** A handle was clicked, or drawn aside: then drags of the new item follow. Gives the number of the new item. */
  legInsert?(toIndex: number, at: LonLat): number | null;
  /** A corner, circle, return or rally point was clicked. */
  areaClick?(handle: AreaHandle): void;
  /** Called repeatedly during a drag; the last call has `isEnd`. Returns the handle held from now on. */
  areaDrag?(handle: AreaHandle, from: LonLat, to: LonLat, isEnd: boolean): AreaHandle;
  /** The first corner of the polygon being drawn was clicked, or the last of a line, or Enter pressed on it: it is done. */
  sketchClose?(): void;
  boxSelect?(numbers: readonly number[], modifiers: Modifiers): void;
  /** Right click, long press, or the menu key. */
  menu?(at: LonLat, x: number, y: number): void;
  pointer?(at: LonLat | null): void;
  /** The view was moved by hand: following ends. */
  movedByHand?(): void;
}
/** What lies on the map, and is hit. */
interface Hit {
  readonly areas: AreaPainter;
  readonly route: RoutePainter;
  readonly vehicles: VehiclePainter;
  readonly fleet: FleetPainter;
  readonly ruler: RulerPainter;
  touchPlan(): void;
  touchPlanes(): void;
}

const LONG_PRESS_MS = 550;
const MOVED_PX = 8;
/** Half of a finger's target of 44 px. */
const TOUCH_TOLERANCE_PX = 22;
const MOUSE_TOLERANCE_PX = 10;

export class Gestures {
  readonly #map: OlMap;
  readonly #target: HTMLElement;
  readonly #view: ViewControl;
  readonly #on: Hit;
  readonly #events: GestureEvents;
  readonly #keys: EventsKey[] = [];
  readonly #abort = new AbortController();
  #swallowClickUntil_ms = -Infinity;
  /** Of the pointer where it is over nothing. */
  cursor: '' | 'crosshair' = '';

  constructor(map: OlMap, target: HTMLElement, view: ViewControl, on: Hit, events: GestureEvents) {
    this.#map = map;
    this.#target = target;
    this.#view = view;
    this.#on = on;
    this.#events = events;
    map.addInteraction(this.#editInteraction());
    this.#listen();
  }

  destroy(): void {
    this.#abort.abort();
    unByKey(this.#keys);
  }

  #listen(): void {
    const map = this.#map;
    const signal = this.#abort.signal;
    this.#keys.push(
      map.on('click', (event) => this.#click(event as MapBrowserEvent<PointerEvent>)),
      map.on('pointermove', (event) => {
        if (!event.dragging) this.#hover(event as MapBrowserEvent<PointerEvent>);
      }),
      map.on('pointerdrag', () => this.#moved()),
    );
    const viewport = map.getViewport() ?? this.#target;
    viewport.addEventListener('wheel', () => this.#view.movedByHand(), { signal, passive: true });
    viewport.addEventListener(
      'pointerleave',
      () => {
        this.#events.pointer?.(null);
        this.#on.ruler.pointer = null;
        this.#on.touchPlanes();
        this.#setSketchPointer(null);
      },
      { signal },
    );
    viewport.addEventListener(
      'contextmenu',
      (event) => {
        event.preventDefault();
        if (event.button !== 2) return;
        this.#openMenu(map.getEventPixel(event));
      },
      { signal },
    );
    this.#listenForLongPress(viewport, signal);
    const target = this.#target;
    target.addEventListener('keydown', (event) => this.#key(event), { signal });
    target.addEventListener('focus', () => this.#showCross(target.matches(':focus-visible')), { signal });
    target.addEventListener('blur', () => this.#showCross(false), { signal });
  }

  #listenForLongPress(viewport: HTMLElement, signal: AbortSignal): void {
    let timer: ReturnType<typeof setTimeout> | undefined;
    let start: [number, number] | null = null;
    const stop = (): void => {
      clearTimeout(timer);
      start = null;
    };
    const options = { signal, capture: true };
    viewport.addEventListener(
      'pointerdown',
      (event) => {
        stop();
        this.#swallowClickUntil_ms = -Infinity;
        if (event.pointerType !== 'touch' || !event.isPrimary) return;
        start = [event.clientX, event.clientY];
        const pixel = this.#map.getEventPixel(event);
        timer = setTimeout(() => {
          // However long the finger stays, the click of its release is ignored.
          this.#swallowClickUntil_ms = Infinity;
          this.#openMenu(pixel);
        }, LONG_PRESS_MS);
      },
      options,
    );
    viewport.addEventListener(
      'pointermove',
      (event) => {
        if (start && Math.hypot(event.clientX - start[0], event.clientY - start[1]) > MOVED_PX) stop();
      },
      options,
    );
    const release = (): void => {
      stop();
      if (this.#swallowClickUntil_ms === Infinity) this.#swallowClickUntil_ms = performance.now() + 1000;
    };
    for (const type of ['pointerup', 'pointercancel'] as const) viewport.addEventListener(type, release, options);
  }

  #openMenu(pixel: number[]): void {
    const at = this.#view.placeAt(pixel);
    if (at !== null) this.#events.menu?.(at, pixel[0] ?? 0, pixel[1] ?? 0);
  }

  #click(event: MapBrowserEvent<PointerEvent>): void {
    if (performance.now() < this.#swallowClickUntil_ms) {
      this.#swallowClickUntil_ms = -Infinity;
      return;
    }
    const frame = this.#view.frame();
    if (frame === null) return;
    const [x = 0, y = 0] = event.pixel;
    const tolerance = toleranceOf(event.originalEvent);
    const modifiers = modifiersOf(event.originalEvent);
    if (this.#on.areas.view.isEditing) {
      if (this.#on.areas.closesSketch(frame, x, y, tolerance)) return this.#events.sketchClose?.();
      const isDrawing = this.#on.areas.view.sketch.length > 0;
      const found = isDrawing ? null : this.#on.areas.handleAt(frame, x, y, tolerance);
      if (found !== null) return this.#events.areaClick?.(found.handle);
      return this.#events.click?.(placeOf(event.coordinate), modifiers);
    }
    const item = this.#on.route.itemAt(frame, x, y, tolerance);
    if (item !== null) return this.#events.itemClick?.(item.number, modifiers);
    const leg = this.#on.route.handleAt(frame, x, y, tolerance);
    if (leg !== null) return void this.#events.legInsert?.(leg.toIndex, placeOf([...leg.middle]));
    if (!this.#on.route.status.isEditing) {
      const vehicle = this.#on.vehicles.vehicleAt(frame, x, y, tolerance);
      if (vehicle !== null) return this.#events.vehicleClick?.(vehicle);
      const together = this.#on.fleet.at((at) => frame.pixel(at), x, y, tolerance);
      const [first] = together;
      if (together.length > 1) return this.#view.fit(together.map(({ at }) => at));
      if (first !== undefined) return this.#events.vehicleClick?.(first.id);
    }
    this.#events.click?.(placeOf(event.coordinate), modifiers);
  }

  #hover(event: MapBrowserEvent<PointerEvent>): void {
    const at = placeOf(event.coordinate);
    this.#events.pointer?.(at);
    if (this.#on.ruler.points.length > 0) {
      this.#on.ruler.pointer = event.originalEvent.pointerType === 'touch' ? null : at;
      this.#on.touchPlanes();
    }
    const isTouch = event.originalEvent.pointerType === 'touch';
    this.#setSketchPointer(isTouch || this.#on.areas.view.sketch.length === 0 ? null : at);
    const frame = this.#view.frame();
    if (frame === null) return;
    const [x = 0, y = 0] = event.pixel;
    const isHit =
      (this.#on.areas.view.isEditing && this.#on.areas.handleAt(frame, x, y, MOUSE_TOLERANCE_PX) !== null) ||
      this.#on.route.itemAt(frame, x, y, MOUSE_TOLERANCE_PX) !== null ||
      this.#on.route.handleAt(frame, x, y, MOUSE_TOLERANCE_PX) !== null;
    this.#target.style.cursor = isHit ? 'pointer' : this.cursor;
  }

  #setSketchPointer(at: LonLat | null): void {
    if (at === this.#on.areas.pointer) return;
    this.#on.areas.pointer = at;
    this.#on.touchPlan();
  }

  #key(event: KeyboardEvent): void {
    if (event.target !== this.#target) return;
    const middle = this.#view.freeCentrePixel();
    if (event.key === 'Enter') {
      const at = this.#view.placeAt(middle);
      if (at !== null) this.#events.click?.(at, modifiersOf(event));
    } else if (event.key === 'ContextMenu' || (event.key === 'F10' && event.shiftKey)) {
      this.#openMenu(middle);
    } else {
      if (event.key.startsWith('Arrow')) this.#moved();
      this.#showCross(true);
      return;
    }
    event.preventDefault();
  }

  #showCross(isShown: boolean): void {
    const [x, y] = this.#view.freeCentrePixel();
    this.#on.ruler.cross = isShown ? { x, y } : null;
    this.#on.touchPlanes();
  }

  #moved(): void {
    this.#view.movedByHand();
    if (this.#view.isFollowing) this.#events.movedByHand?.();
  }

  /** Dragging of items and of handles on legs, and the box that selects. */
  #editInteraction(): PointerInteraction {
    let drag: { number: number | null; from: LonLat; legIndex: number | null; isMoved: boolean } | null = null;
    let area: { handle: AreaHandle; from: LonLat; isMoved: boolean } | null = null;
    let box: { x: number; y: number } | null = null;
    const end = (): void => {
      drag = null;
      area = null;
      box = null;
      this.#on.ruler.box = null;
      this.#on.touchPlanes();
    };
    return new PointerInteraction({
      stopDown: (isHandled) => isHandled,
      handleDownEvent: (event) => {
        const frame = this.#view.frame();
        if (frame === null || !isMainButton(event)) return false;
        const [x = 0, y = 0] = event.pixel;
        const original = event.originalEvent as PointerEvent;
        const tolerance = toleranceOf(original);
        if (this.#on.areas.view.isEditing && this.#on.areas.view.sketch.length === 0) {
          const found = this.#on.areas.handleAt(frame, x, y, tolerance);
          area = found && { handle: found.handle, from: found.place, isMoved: false };
          return area !== null;
        }
        if (!this.#on.route.status.isEditing) return false;
        const item = this.#on.route.itemAt(frame, x, y, tolerance);
        if (item !== null) {
          drag = { number: item.number, from: item.place, legIndex: null, isMoved: false };
          return true;
        }
        const leg = this.#on.route.handleAt(frame, x, y, tolerance);
        if (leg !== null) {
          drag = { number: null, from: placeOf([...leg.middle]), legIndex: leg.toIndex, isMoved: false };
          return true;
        }
        if (original.shiftKey) {
          box = { x, y };
          return true;
        }
        return false;
      },
      handleDragEvent: (event) => {
        const [x = 0, y = 0] = event.pixel;
        if (box !== null) {
          this.#on.ruler.box = [box.x, box.y, x, y];
          this.#on.touchPlanes();
          return;
        }
        const to = placeOf(event.coordinate);
        if (area !== null) {
          this.#events.pointer?.(to);
          area.handle = this.#events.areaDrag?.(area.handle, area.from, to, false) ?? area.handle;
          area.from = to;
          area.isMoved = true;
          return;
        }
        if (drag === null) return;
        this.#events.pointer?.(to);
        if (!drag.isMoved && drag.legIndex !== null) {
          drag.number = this.#events.legInsert?.(drag.legIndex, to) ?? null;
          drag.from = to;
        }
        drag.isMoved = true;
        if (drag.number !== null) this.#events.itemDrag?.(drag.number, drag.from, to, false);
        drag.from = to;
      },
      handleUpEvent: (event) => {
        const [x = 0, y = 0] = event.pixel;
        const frame = this.#view.frame();
        if (box !== null && frame !== null && Math.hypot(x - box.x, y - box.y) > MOVED_PX) {
          const numbers = this.#on.route.itemsWithin(frame, box.x, box.y, x, y);
          this.#events.boxSelect?.(numbers, modifiersOf(event.originalEvent as PointerEvent));
        } else if (area?.isMoved) {
          this.#events.areaDrag?.(area.handle, area.from, placeOf(event.coordinate), true);
        } else if (drag?.isMoved && drag.number !== null) {
          const to = placeOf(event.coordinate);
          this.#events.itemDrag?.(drag.number, drag.from, to, true);
        }
        end();
        return false;
      },
    });
  }
}

export const toleranceOf = (event: PointerEvent): number =>
  event.pointerType === 'touch' ? TOUCH_TOLERANCE_PX : MOUSE_TOLERANCE_PX;

const modifiersOf = (event: { ctrlKey: boolean; metaKey: boolean; shiftKey: boolean }): Modifiers => ({
  isAdding: event.ctrlKey || event.metaKey || event.shiftKey,
});

function isMainButton(event: MapBrowserEvent): boolean {
  const original = event.originalEvent as PointerEvent;
  return original.button === 0;
}
