// The map, behind one door: the rest of the app gives it plain values and hears what people do on it.
import 'ol/ol.css';
import OlMap from 'ol/Map';
import type MapBrowserEvent from 'ol/MapBrowserEvent';
import { unByKey } from 'ol/Observable';
import View, { type AnimationOptions, type FitOptions } from 'ol/View';
import ScaleLine from 'ol/control/ScaleLine';
import { inAndOut, easeOut } from 'ol/easing';
import type { EventsKey } from 'ol/events';
import { boundingExtent } from 'ol/extent';
import DragPan from 'ol/interaction/DragPan';
import KeyboardPan from 'ol/interaction/KeyboardPan';
import KeyboardZoom from 'ol/interaction/KeyboardZoom';
import MouseWheelZoom from 'ol/interaction/MouseWheelZoom';
import PinchZoom from 'ol/interaction/PinchZoom';
import PointerInteraction from 'ol/interaction/Pointer';
import { toLonLat } from 'ol/proj';
import type { AreaHandle } from '$lib/domain/area-edit';
import type { TileLoader } from '$lib/api/maps-tiles';
import { type LonLat, wrap180_deg } from '$lib/domain/lonlat';
import type { PlanItem } from '$lib/domain/plan';
import { type Moment, placesOf, type Track as RehearsedTrack } from '$lib/domain/rehearsal';
import type { Way } from '$lib/domain/way';
import { freeCentre, type Insets, widenFactor } from '$lib/domain/sight';
import { type Box, boxAround, boxCorners } from '$lib/domain/tiling';
import type { Trail } from '$lib/domain/track';
import { AreaPainter, type AreaTexts, type AreaView } from './area-painter';
import { coastLayer, coastStyle } from './base-map';
import { CanvasLayer } from './canvas-layer';
import { CorridorPainter } from './corridor-painter';
import { type FleetMark, FleetPainter } from './fleet-layer';
import { type Painter, projection, type Projection, readTheme, type Theme, WORLD_M, type XY } from './frame';
import { GridPainter } from './grid-painter';
import { RehearsalPainter } from './rehearsal-painter';
import { RoutePainter, type RouteStatus, type RouteTexts } from './route-painter';
import { EMPTY_ROUTE, routeView, toLine, toXY } from './route-view';
import { RulerPainter } from './ruler-painter';
import { RunwayPainter } from './runway-painter';
import { type ShownSource, type SourceEvents, SourceLayers } from './sources/SourceLayers';
import { handleInteraction, type Placing, PlacingPainter } from './sources/placing';
import { SurveyPainter, type SurveyView } from './survey-painter';
import { TrailPainter } from './trail-painter';
import { HomePainter, type VehicleMark, VehiclePainter } from './vehicle-painter';

export type { FleetMark, AreaView, SurveyView, RouteStatus, RouteTexts, ShownSource, Placing, VehicleMark };

/** How the view stands to the selected plane. */
export type FollowMode = 'free' | 'follow' | 'sight';

interface Modifiers {
  /** Ctrl, Cmd or Shift: add to the selection. */
  readonly isAdding: boolean;
}

/** What people do on the map. Item numbers count from 1; pixels from the map's top left. */
interface MapEvents {
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
  /** The view came to rest. */
  viewChange?(view: MapViewState): void;
}

interface MapTexts extends RouteTexts, AreaTexts {
  /** A round distance, for the grid. */
  distance(value_m: number): string;
  /** Length so far and bearing of the last piece. */
  ruler(length_m: number, bearing_deg: number): string;
  /** Where a survey begins. */
  readonly surveyBegin: string;
  readonly letters: { north: string; east: string; south: string; west: string };
}

export interface MapViewState {
  readonly centre: LonLat;
  readonly zoom: number;
}

interface MapOptions {
  readonly target: HTMLElement;
  readonly events: MapEvents;
  readonly sources: SourceEvents;
  readonly tiles: TileLoader;
  readonly view?: MapViewState | null;
}

const MAX_ZOOM = 21;
/** The column of buttons at the map's edge. */
const CONTROLS_PX = 48;
const LONG_PRESS_MS = 550;
const MOVED_PX = 8;
/** Half of a finger's target of 44 px. */
const TOUCH_TOLERANCE_PX = 22;
const MOUSE_TOLERANCE_PX = 10;
/** How long the view is left alone after a move by hand. */
const HANDS_OFF_MS = 4000;
/** The loader decides which of these come first: a source that hangs must not fill the map's own list of tiles under way. */
const TILES_UNDER_WAY = 64;
/** A plane farther off than this many windows is jumped to, not zoomed out to. */
const JUMP_FACTOR = 12;

export class MapAdapter {
  readonly #map: OlMap;
  readonly #view: View;
  readonly #events: MapEvents;
  readonly #target: HTMLElement;
  readonly #coast = coastLayer();
  readonly #sources: SourceLayers;
  readonly #placing = new PlacingPainter();
  readonly #grid = new GridPainter();
  readonly #trails = new TrailPainter();
  readonly #route = new RoutePainter();
  readonly #rehearsal = new RehearsalPainter();
  readonly #corridor = new CorridorPainter();
  readonly #areas = new AreaPainter();
  readonly #runway = new RunwayPainter();
  readonly #survey = new SurveyPainter();
  readonly #home = new HomePainter();
  readonly #vehicles = new VehiclePainter();
  readonly #fleet = new FleetPainter();
  readonly #ruler = new RulerPainter();
  readonly #groundLayer = this.#layer(2, this.#grid, this.#trails);
  readonly #placingLayer = this.#layer(2.5, this.#placing);
  readonly #planLayer = this.#layer(
    3,
    this.#areas,
    this.#runway,
    this.#corridor,
    this.#route.lines,
    this.#rehearsal.track,
    this.#survey,
    this.#route.directions,
    this.#home,
    this.#route.marks,
    this.#areas.marks,
  );
  readonly #fleetLayer = this.#layer(3.5, this.#fleet);
  readonly #planeLayer = this.#layer(4, this.#rehearsal.plane, this.#vehicles, this.#ruler);
  readonly #layers = [this.#groundLayer, this.#placingLayer, this.#planLayer, this.#fleetLayer, this.#planeLayer];
  readonly #scale: ScaleLine;
  readonly #keys: EventsKey[] = [];
  readonly #abort = new AbortController();
  readonly #themeObserver: MutationObserver;
  #theme: Theme = readTheme();
  #insets: Insets = { top: 0, right: 0, bottom: 0, left: 0 };
  #follow: FollowMode = 'sight';
  /** Shows at once what the animation under way comes to. */
  #end: (() => void) | null = null;
  #hasSeenPlane = false;
  #movedByHand_ms = -Infinity;
  #swallowClickUntil_ms = -Infinity;
  /** The vehicles' visible state and trail points at the last paint. */
  #seen = '';
  #points = 0;
  /** Whether lines of the plan are guesses, until the core has answered. */
  #isGuess = false;
  /** Visible parts of the plan. */
  #way: Way | null = null;
  #cursor = '';

  constructor({ target, events, view, sources, tiles }: MapOptions) {
    this.#target = target;
    this.#events = events;
    this.#view = new View({
      center: [...toXY(view?.centre ?? { lon_deg: -3.7, lat_deg: 40.4 })],
      zoom: view?.zoom ?? 3,
      maxZoom: MAX_ZOOM,
      minZoom: 1,
      enableRotation: false,
      smoothExtentConstraint: false,
      constrainResolution: false,
    });
    this.#scale = new ScaleLine({ units: 'metric', minWidth: 80, maxWidth: 160 });
    this.#map = new OlMap({
      target,
      view: this.#view,
      layers: [this.#coast, ...this.#layers],
      controls: [this.#scale],
      interactions: [
        new DragPan(),
        new PinchZoom(),
        new MouseWheelZoom({ condition: () => true }),
        new KeyboardPan({ pixelDelta: 96 }),
        new KeyboardZoom(),
        this.#editInteraction(),
        handleInteraction(this.#placing, () => this.#frame(), toleranceOf),
      ],
      // an element that takes the keyboard: the map itself
      keyboardEventTarget: target,
      moveTolerance: 4,
      maxTilesLoading: TILES_UNDER_WAY,
    });
    this.#sources = new SourceLayers(this.#map, tiles, sources, 1);
    this.#coast.setStyle(coastStyle(this.#theme));
    this.#themeObserver = new MutationObserver(() => this.refreshTheme());
    this.#themeObserver.observe(document.documentElement, { attributes: true, attributeFilter: ['data-theme'] });
    this.#listen();
  }

  destroy(): void {
    this.#abort.abort();
    this.#themeObserver.disconnect();
    this.#sources.destroy();
    unByKey(this.#keys);
    this.#map.setTarget(undefined);
    this.#map.dispose();
  }

  /** Empty layers are made invisible: without a graphics card each canvas costs in every frame of the window. */
  #layer(zIndex: number, ...painters: readonly Painter[]): CanvasLayer {
    return new CanvasLayer(painters, () => ({ theme: this.#theme, insets: this.#insets }), zIndex);
  }

  // --- What is shown ------------------------------------------------------------------------------------------------

  /** Does nothing when it is shown already. */
  setPlan(items: readonly PlanItem[], way: Way): void {
    if (way === this.#way) return;
    this.#way = way;
    const wasGuess = this.#isGuess;
    this.#isGuess = way.stops.some(({ leg }) => leg?.isGuess === true);
    this.#route.route = items.length === 0 ? EMPTY_ROUTE : routeView(items, way);
    // an answer about a dragged item is painted in this frame
    this.#planLayer.touch();
    if (wasGuess && !this.#isGuess) this.#planLayer.paintNow();
  }

  /** The route on the vehicle, where it differs; `null` when it is not shown. */
  setVehiclePlan(items: readonly PlanItem[] | null, way: Way): void {
    this.#route.vehicleRoute = items === null ? EMPTY_ROUTE : routeView(items, way);
    this.#planLayer.touch();
  }

  /** The plan as it would be flown; `null` when it was not rehearsed. */
  setRehearsal(track: RehearsedTrack | null, touchDown: LonLat | null): void {
    this.#rehearsal.line = track === null ? [] : toLine(placesOf(track));
    this.#rehearsal.touchDown = touchDown;
    this.#planLayer.touch();
  }

  setRehearsalOld(isOld: boolean): void {
    this.#rehearsal.isOld = isOld;
    this.#planLayer.touch();
  }

  /** Both sides of where many rehearsed flights pass; nothing when none were asked for. */
  setCorridor(left: readonly LonLat[], right: readonly LonLat[]): void {
    [this.#corridor.left, this.#corridor.right] = [toLine(left), toLine(right)];
    this.#planLayer.touch();
  }

  /** Where the plane is shown in its rehearsal. */
  setMoment(moment: Moment | null): void {
    this.#rehearsal.moment = moment;
    this.#planeLayer.touch();
  }

  /** The rest of the mission that the plane flies now; `null` when it is not known. */
  setAhead(track: RehearsedTrack | null): void {
    this.#rehearsal.ahead = track === null ? [] : toLine(placesOf(track));
    this.#planLayer.touch();
  }

  /** What follows when something happens at that moment; the ground within gliding range is a ring, or empty. */
  setWhatIf(track: RehearsedTrack | null, touchDown: LonLat | null, glide: readonly LonLat[]): void {
    this.#rehearsal.whatIf = { line: track === null ? [] : toLine(placesOf(track)), touchDown, glide: toLine(glide) };
    this.#planLayer.touch();
  }

  setAreas(view: AreaView): void {
    this.#areas.view = view;
    this.#planLayer.touch();
  }

  /** The survey that is open; `null` while none is. */
  setSurvey(view: SurveyView | null): void {
    this.#survey.view = view;
    this.#planLayer.touch();
  }

  /** The ends of the runway that is landed on; empty without one. */
  setRunway(ends: readonly LonLat[]): void {
    this.#runway.ends = ends;
    this.#planLayer.touch();
  }

  setRouteStatus(status: RouteStatus): void {
    this.#route.status = status;
    this.#planLayer.touch();
  }

  setHome(home: LonLat | null): void {
    this.#home.home = home;
    this.#grid.origin = home === null ? null : toXY(home);
    this.#groundLayer.touch();
    this.#planLayer.touch();
  }

  setTarget(at: LonLat | null): void {
    this.#vehicles.target = at;
    this.#planeLayer.touch();
  }

  /** Trails are read where they are; call this when their number changes. */
  setTrails(trails: readonly Trail[]): void {
    this.#trails.setTrails(trails);
    this.#touchGround();
  }

  /** Top of the colour scale of trails, metres above home. */
  get trailRange_m(): number {
    return this.#trails.range_m;
  }

  setVehicles(vehicles: readonly VehicleMark[]): void {
    this.#vehicles.vehicles = vehicles;
    const selected = vehicles.find((vehicle) => vehicle.isSelected);
    if (selected) this.#keepInSight(selected.ghost?.at ?? selected.at);
    const [frame, points] = [this.#frame(), this.#trails.added];
    const seen = frame === null ? '' : this.#vehicles.seen(frame);
    if (seen !== this.#seen || frame === null) this.#planeLayer.touch();
    if (points !== this.#points) this.#touchGround();
    [this.#seen, this.#points] = [seen, points];
  }

  /** Vehicles that are not followed in detail. */
  setFleet(marks: readonly FleetMark[]): void {
    this.#fleet.marks = marks;
    this.#fleetLayer.setVisible(marks.length > 0);
    this.#fleetLayer.touch();
  }

  setRuler(points: readonly LonLat[]): void {
    this.#ruler.points = points;
    this.#planeLayer.touch();
  }

  setTexts(texts: MapTexts): void {
    this.#route.texts = texts;
    this.#areas.texts = texts;
    this.#survey.begin = texts.surveyBegin;
    this.#grid.formatDistance = texts.distance;
    this.#grid.letters = texts.letters;
    this.#ruler.format = texts.ruler;
    for (const layer of this.#layers) layer.touch();
  }

  setUnits(unit: 'm' | 'ft'): void {
    this.#scale.setUnits(unit === 'm' ? 'metric' : 'nautical');
  }

  /** Base map and overlays, bottom to top; with `isFine` a dense screen gets the next finer tiles. */
  setSources(stack: readonly ShownSource[], isFine: boolean): void {
    this.#sources.set(stack, isFine);
  }

  /** Asks again for what did not come, now. */
  retrySource(id: string): void {
    this.#sources.retry(id);
  }

  setPlacing(placing: Placing): void {
    this.#placing.placing = placing;
    this.#placingLayer.setVisible(this.#placing.isVisible);
    this.#placingLayer.touch();
  }

  setLayers(visible: { grid: boolean; trails: boolean }): void {
    this.#grid.isVisible = visible.grid;
    this.#trails.isVisible = visible.trails;
    this.#touchGround();
  }

  #touchGround(): void {
    this.#groundLayer.setVisible(this.#grid.isVisible || (this.#trails.isVisible && this.#trails.added > 0));
    this.#groundLayer.touch();
  }

  setCursor(cursor: '' | 'crosshair'): void {
    this.#cursor = cursor;
    this.#target.style.cursor = cursor;
  }

  refreshTheme(): void {
    this.#theme = readTheme();
    this.#coast.setStyle(coastStyle(this.#theme));
    for (const layer of this.#layers) layer.touch();
  }

  // --- The view -----------------------------------------------------------------------------------------------------

  setInsets(insets: Insets): void {
    this.#insets = insets;
    const style = this.#target.style;
    for (const side of ['top', 'right', 'bottom', 'left'] as const) {
      style.setProperty(`--map-inset-${side}`, `${insets[side]}px`);
    }
    for (const layer of this.#layers) layer.touch();
  }

  setFollow(mode: FollowMode): void {
    this.#follow = mode;
    this.#movedByHand_ms = -Infinity;
    const selected = this.#vehicles.vehicles.find((vehicle) => vehicle.isSelected);
    if (selected && mode !== 'free') {
      if (mode === 'sight') this.#keepInSight(selected.at);
      else this.#centreOn(selected.at, 300);
    }
  }

  zoomBy(steps: number): void {
    this.#endAnimation();
    const view = this.#view;
    const centre = this.#map.getCoordinateFromPixel(this.#freeCentrePixel());
    const zoom = (view.getZoom() ?? 3) + steps;
    this.#movedByHand_ms = performance.now();
    this.#animate({ ...(centre ? { anchor: centre } : {}), zoom, duration: 180, easing: easeOut }, () =>
      view.adjustResolution(view.getResolutionForZoom(zoom) / (view.getResolution() ?? 1), centre),
    );
  }

  /** The position in the middle of what panels leave free. */
  centre(): LonLat {
    return this.#placeAt(this.#freeCentrePixel()) ?? { lon_deg: 0, lat_deg: 0 };
  }

  centreOn(at: LonLat): void {
    this.#movedByHand_ms = performance.now();
    this.#centreOn(at, 300);
  }

  /** Shows all of these positions in what panels leave free. */
  fit(places: readonly LonLat[]): void {
    if (places.length === 0) return;
    this.#movedByHand_ms = performance.now();
    const [width = 0, height = 0] = this.#map.getSize() ?? [];
    const { top, right, bottom, left } = this.#insets;
    const edge = Math.min(60, width * 0.1, height * 0.1);
    // over the date line the shorter way is meant
    const box = boxAround(places);
    if (box === null) return;
    const corners = boxCorners(box).map(toXY);
    const shift = this.#worldShift(corners[0]?.[0] ?? 0);
    const extent = boundingExtent(corners.map(([x, y]) => [x + shift, y]));
    const fit: FitOptions = {
      padding: [top + edge, right + edge + CONTROLS_PX, bottom + edge, left + edge],
      maxZoom: 17,
    };
    this.#endAnimation();
    const end = (): void => this.#view.fit(extent, fit);
    this.#end = end;
    this.#view.fit(extent, { ...fit, duration: 300, callback: () => this.#ended(end) });
  }

  /** Pixel of a position, from the map's top left; `null` before the first frame. */
  pixelOf(at: LonLat): { x: number; y: number } | null {
    const frame = this.#frame();
    if (frame === null) return null;
    const [x, y] = frame.pixel(toXY(at));
    return { x, y };
  }

  /** What panels leave free of the world; `null` before the first frame. */
  visibleBox(): Box | null {
    const [width = 0, height = 0] = this.#map.getSize() ?? [];
    const { top, right, bottom, left } = this.#insets;
    const [x0, y0, x1, y1] = [left, top, Math.max(width - right, left + 1), Math.max(height - bottom, top + 1)];
    const [northWest, southEast] = [this.#placeAt([x0, y0]), this.#placeAt([x1, y1])];
    if (northWest === null || southEast === null) return null;
    const isWhole = (x1 - x0) * (this.#view.getResolution() ?? 1) >= WORLD_M;
    return {
      west_deg: isWhole ? -180 : northWest.lon_deg,
      east_deg: isWhole ? 180 : southEast.lon_deg,
      north_deg: northWest.lat_deg,
      south_deg: southEast.lat_deg,
    };
  }

  #keepInSight(at: LonLat): void {
    const [width = 0, height = 0] = this.#map.getSize() ?? [];
    const frame = this.#frame();
    if (width === 0 || height === 0 || frame === null) return;
    const [x, y] = frame.pixel(toXY(at));
    if (!this.#hasSeenPlane) {
      this.#hasSeenPlane = true;
      const isFar = (this.#view.getZoom() ?? 0) < 11;
      if (this.#follow !== 'free' && (isFar || widenFactor(x, y, { width, height }, this.#insets) > 1)) {
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
    const factor = widenFactor(x, y, { width, height }, this.#insets);
    if (factor === 1) return;
    if (factor > JUMP_FACTOR) {
      this.#centreOn(at, 0);
      return;
    }
    const anchor = this.#map.getCoordinateFromPixel(this.#freeCentrePixel());
    const resolution = (this.#view.getResolution() ?? 1) * factor;
    this.#view.animate({ ...(anchor ? { anchor } : {}), resolution, duration: 500, easing: inAndOut });
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
    const resolution = this.#view.getResolution() ?? 1;
    const [px = 0, py = 0] = this.#freeCentrePixel();
    const [x, y] = toXY(at);
    const center = [x + this.#worldShift(x) - (px - width / 2) * resolution, y + (py - height / 2) * resolution];
    if (duration === 0) this.#view.setCenter(center);
    else this.#animate({ center, duration, easing: inAndOut }, () => this.#view.setCenter(center));
  }

  /** How far the copy of the world that is looked at lies from the first: beyond the date line the view goes on. */
  #worldShift(x: number): number {
    return Math.round(((this.#view.getCenter()?.[0] ?? 0) - x) / WORLD_M) * WORLD_M;
  }

  #freeCentrePixel(): [number, number] {
    const [width = 0, height = 0] = this.#map.getSize() ?? [];
    const { x, y } = freeCentre({ width, height }, this.#insets);
    return [x, y];
  }

  #placeAt(pixel: number[]): LonLat | null {
    const coordinate = this.#map.getCoordinateFromPixel(pixel);
    return coordinate ? placeOf(coordinate) : null;
  }

  /** The view as painters see it, for finding what lies at a pixel. */
  #frame(): Projection | null {
    const [width = 0, height = 0] = this.#map.getSize() ?? [];
    const center = this.#view.getCenter();
    const resolution = this.#view.getResolution();
    if (!center || !resolution || width === 0) return null;
    const centre: XY = [center[0] ?? 0, center[1] ?? 0];
    return projection(centre, resolution, { width, height });
  }

  // --- What people do -----------------------------------------------------------------------------------------------

  #listen(): void {
    const map = this.#map;
    const signal = this.#abort.signal;
    this.#keys.push(
      map.on('click', (event) => this.#click(event as MapBrowserEvent<PointerEvent>)),
      map.on('pointermove', (event) => {
        if (!event.dragging) this.#hover(event as MapBrowserEvent<PointerEvent>);
      }),
      map.on('pointerdrag', () => this.#moved()),
      map.on('moveend', () => {
        const centre = this.#view.getCenter();
        const zoom = this.#view.getZoom();
        this.#fleet.resolution = this.#view.getResolution() ?? 1;
        this.#fleetLayer.touch();
        if (centre && zoom !== undefined) this.#events.viewChange?.({ centre: placeOf(centre), zoom });
      }),
    );
    const viewport = map.getViewport() ?? this.#target;
    viewport.addEventListener('wheel', () => (this.#movedByHand_ms = performance.now()), { signal, passive: true });
    viewport.addEventListener(
      'pointerleave',
      () => {
        this.#events.pointer?.(null);
        this.#ruler.pointer = null;
        this.#planeLayer.touch();
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
    const at = this.#placeAt(pixel);
    if (at !== null) this.#events.menu?.(at, pixel[0] ?? 0, pixel[1] ?? 0);
  }

  #click(event: MapBrowserEvent<PointerEvent>): void {
    if (performance.now() < this.#swallowClickUntil_ms) {
      this.#swallowClickUntil_ms = -Infinity;
      return;
    }
    const frame = this.#frame();
    if (frame === null) return;
    const [x = 0, y = 0] = event.pixel;
    const tolerance = toleranceOf(event.originalEvent);
    const modifiers = modifiersOf(event.originalEvent);
    if (this.#areas.view.isEditing) {
      if (this.#areas.closesSketch(frame, x, y, tolerance)) return this.#events.sketchClose?.();
      const isDrawing = this.#areas.view.sketch.length > 0;
      const found = isDrawing ? null : this.#areas.handleAt(frame, x, y, tolerance);
      if (found !== null) return this.#events.areaClick?.(found.handle);
      return this.#events.click?.(placeOf(event.coordinate), modifiers);
    }
    const item = this.#route.itemAt(frame, x, y, tolerance);
    if (item !== null) return this.#events.itemClick?.(item.number, modifiers);
    const leg = this.#route.handleAt(frame, x, y, tolerance);
    if (leg !== null) return void this.#events.legInsert?.(leg.toIndex, placeOf([...leg.middle]));
    if (!this.#route.status.isEditing) {
      const vehicle = this.#vehicles.vehicleAt(frame, x, y, tolerance);
      if (vehicle !== null) return this.#events.vehicleClick?.(vehicle);
      const together = this.#fleet.at((at) => frame.pixel(at), x, y, tolerance);
      const [first] = together;
      if (together.length > 1) return this.fit(together.map(({ at }) => at));
      if (first !== undefined) return this.#events.vehicleClick?.(first.id);
    }
    this.#events.click?.(placeOf(event.coordinate), modifiers);
  }

  #hover(event: MapBrowserEvent<PointerEvent>): void {
    const at = placeOf(event.coordinate);
    this.#events.pointer?.(at);
    if (this.#ruler.points.length > 0) {
      this.#ruler.pointer = event.originalEvent.pointerType === 'touch' ? null : at;
      this.#planeLayer.touch();
    }
    const isTouch = event.originalEvent.pointerType === 'touch';
    this.#setSketchPointer(isTouch || this.#areas.view.sketch.length === 0 ? null : at);
    const frame = this.#frame();
    if (frame === null) return;
    const [x = 0, y = 0] = event.pixel;
    const isHit =
      (this.#areas.view.isEditing && this.#areas.handleAt(frame, x, y, MOUSE_TOLERANCE_PX) !== null) ||
      this.#route.itemAt(frame, x, y, MOUSE_TOLERANCE_PX) !== null ||
      this.#route.handleAt(frame, x, y, MOUSE_TOLERANCE_PX) !== null;
    this.#target.style.cursor = isHit ? 'pointer' : this.#cursor;
  }

  #setSketchPointer(at: LonLat | null): void {
    if (at === this.#areas.pointer) return;
    this.#areas.pointer = at;
    this.#planLayer.touch();
  }

  #key(event: KeyboardEvent): void {
    if (event.target !== this.#target) return;
    const middle = this.#freeCentrePixel();
    if (event.key === 'Enter') {
      const at = this.#placeAt(middle);
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
    const [x, y] = this.#freeCentrePixel();
    this.#ruler.cross = isShown ? { x, y } : null;
    this.#planeLayer.touch();
  }

  #moved(): void {
    this.#movedByHand_ms = performance.now();
    if (this.#follow === 'follow') this.#events.movedByHand?.();
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
      this.#ruler.box = null;
      this.#planeLayer.touch();
    };
    return new PointerInteraction({
      stopDown: (isHandled) => isHandled,
      handleDownEvent: (event) => {
        const frame = this.#frame();
        if (frame === null || !isMainButton(event)) return false;
        const [x = 0, y = 0] = event.pixel;
        const original = event.originalEvent as PointerEvent;
        const tolerance = toleranceOf(original);
        if (this.#areas.view.isEditing && this.#areas.view.sketch.length === 0) {
          const found = this.#areas.handleAt(frame, x, y, tolerance);
          area = found && { handle: found.handle, from: found.place, isMoved: false };
          return area !== null;
        }
        if (!this.#route.status.isEditing) return false;
        const item = this.#route.itemAt(frame, x, y, tolerance);
        if (item !== null) {
          drag = { number: item.number, from: item.place, legIndex: null, isMoved: false };
          return true;
        }
        const leg = this.#route.handleAt(frame, x, y, tolerance);
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
          this.#ruler.box = [box.x, box.y, x, y];
          this.#planeLayer.touch();
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
        const frame = this.#frame();
        if (box !== null && frame !== null && Math.hypot(x - box.x, y - box.y) > MOVED_PX) {
          const numbers = this.#route.itemsWithin(frame, box.x, box.y, x, y);
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

function placeOf(coordinate: number[]): LonLat {
  const [lon_deg = 0, lat_deg = 0] = toLonLat(coordinate);
  return { lon_deg: wrap180_deg(lon_deg), lat_deg };
}

const toleranceOf = (event: PointerEvent): number =>
  event.pointerType === 'touch' ? TOUCH_TOLERANCE_PX : MOUSE_TOLERANCE_PX;

const modifiersOf = (event: { ctrlKey: boolean; metaKey: boolean; shiftKey: boolean }): Modifiers => ({
  isAdding: event.ctrlKey || event.metaKey || event.shiftKey,
});

function isMainButton(event: MapBrowserEvent): boolean {
  const original = event.originalEvent as PointerEvent;
  return original.button === 0;
}
