// The map, behind one door: the rest of the app gives it plain values and hears what people do on it.
import 'ol/ol.css';
import OlMap from 'ol/Map';
import DragPan from 'ol/interaction/DragPan';
import KeyboardPan from 'ol/interaction/KeyboardPan';
import KeyboardZoom from 'ol/interaction/KeyboardZoom';
import MouseWheelZoom from 'ol/interaction/MouseWheelZoom';
import PinchZoom from 'ol/interaction/PinchZoom';
import type { TileLoader } from '$lib/api/maps-tiles';
import type { LonLat } from '$lib/domain/lonlat';
import type { PlanItem } from '$lib/domain/plan';
import { type Moment, placesOf, type Track as RehearsedTrack } from '$lib/domain/rehearsal';
import type { Way } from '$lib/domain/way';
import type { Insets } from '$lib/domain/sight';
import type { Trail } from '$lib/domain/track';
import { AreaPainter, type AreaTexts, type AreaView } from './area-painter';
import { coastLayer, coastStyle } from './base-map';
import { CanvasLayer } from './canvas-layer';
import { CorridorPainter } from './corridor-painter';
import { type FleetMark, FleetPainter } from './fleet-layer';
import { type Painter, readTheme, type Theme } from './frame';
import { type GestureEvents, Gestures, toleranceOf } from './gestures';
import { GridPainter } from './grid-painter';
import { RehearsalPainter } from './rehearsal-painter';
import { RoutePainter, type RouteStatus, type RouteTexts } from './route-painter';
import { EMPTY_ROUTE, routeView, toLine, toXY } from './route-view';
import { RulerPainter } from './ruler-painter';
import { RunwayPainter } from './runway-painter';
import { ScaleBar } from './scale-bar';
import { type ShownSource, type SourceEvents, SourceLayers } from './sources/SourceLayers';
import { handleInteraction, type Placing, PlacingPainter } from './sources/placing';
import { SurveyPainter, type SurveyView } from './survey-painter';
import { TrailPainter } from './trail-painter';
import { HomePainter, type VehicleMark, VehiclePainter } from './vehicle-painter';
import { type FollowMode, type MapViewState, viewAt, ViewControl } from './view-control';

export type { FleetMark, FollowMode, AreaView, SurveyView, RouteStatus, RouteTexts, ShownSource, Placing, VehicleMark };
export type { MapViewState };

interface MapEvents extends GestureEvents {
  /** The view came to rest. */
  viewChange?(view: MapViewState): void;
}

interface MapTexts extends RouteTexts, AreaTexts {
  /** A distance on a scale with steps of that length, for the grid and the scale. */
  distance(value_m: number, step_m: number): string;
  /** The smallest round distance that is not below another. */
  step_m(least_m: number): number;
  /** Length so far and bearing of the last piece. */
  ruler(length_m: number, bearing_deg: number): string;
  /** Where a survey begins. */
  readonly surveyBegin: string;
  readonly letters: { north: string; east: string; south: string; west: string };
}

interface MapOptions {
  readonly target: HTMLElement;
  readonly events: MapEvents;
  readonly sources: SourceEvents;
  readonly tiles: TileLoader;
  readonly view?: MapViewState | null;
}

/** The loader decides which of these come first: a source that hangs must not fill the map's own list of tiles under way. */
const TILES_UNDER_WAY = 64;

export class MapAdapter {
  readonly #map: OlMap;
  /** Where it looks. */
  readonly view: ViewControl;
  readonly #gestures: Gestures;
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
  readonly #scale = new ScaleBar();
  readonly #themeObserver: MutationObserver;
  #theme: Theme = readTheme();
  /** The vehicles' visible state and trail points at the last paint. */
  #seen = '';
  #points = 0;
  /** Whether lines of the plan are guesses, until the core has answered. */
  #isGuess = false;
  /** Visible parts of the plan. */
  #way: Way | null = null;

  constructor({ target, events, view, sources, tiles }: MapOptions) {
    this.#target = target;
    this.#map = new OlMap({
      target,
      view: viewAt(view ?? null),
      layers: [this.#coast, ...this.#layers],
      controls: [this.#scale],
      interactions: [
        new DragPan(),
        new PinchZoom(),
        new MouseWheelZoom({ condition: () => true }),
        new KeyboardPan({ pixelDelta: 96 }),
        new KeyboardZoom(),
      ],
      // an element that takes the keyboard: the map itself
      keyboardEventTarget: target,
      moveTolerance: 4,
      maxTilesLoading: TILES_UNDER_WAY,
    });
    this.view = new ViewControl(this.#map);
    const touch = { touchPlan: () => this.#planLayer.touch(), touchPlanes: () => this.#planeLayer.touch() };
    const hit = {
      areas: this.#areas,
      route: this.#route,
      vehicles: this.#vehicles,
      fleet: this.#fleet,
      ruler: this.#ruler,
    };
    this.#gestures = new Gestures(this.#map, target, this.view, { ...hit, ...touch }, events);
    this.#map.addInteraction(handleInteraction(this.#placing, () => this.view.frame(), toleranceOf));
    this.#map.on('moveend', () => {
      this.#fleet.resolution = this.view.resolution;
      this.#fleetLayer.touch();
      const { state } = this.view;
      if (state !== null) events.viewChange?.(state);
    });
    this.#sources = new SourceLayers(this.#map, tiles, sources, 1);
    this.#coast.setStyle(coastStyle(this.#theme));
    this.#themeObserver = new MutationObserver(() => this.refreshTheme());
    this.#themeObserver.observe(document.documentElement, { attributes: true, attributeFilter: ['data-theme'] });
  }

  destroy(): void {
    this.#gestures.destroy();
    this.#themeObserver.disconnect();
    this.#sources.destroy();
    this.#map.setTarget(undefined);
    this.#map.dispose();
  }

  /** Empty layers are made invisible: without a graphics card each canvas costs in every frame of the window. */
  #layer(zIndex: number, ...painters: readonly Painter[]): CanvasLayer {
    return new CanvasLayer(painters, () => ({ theme: this.#theme, insets: this.view.insets }), zIndex);
  }

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
    if (selected) this.view.keepInSight(selected.ghost?.at ?? selected.at);
    const [frame, points] = [this.view.frame(), this.#trails.added];
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
    this.#grid.stepOf_m = texts.step_m;
    this.#scale.setTexts(texts);
    this.#grid.letters = texts.letters;
    this.#ruler.format = texts.ruler;
    for (const layer of this.#layers) layer.touch();
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
    this.#gestures.cursor = cursor;
    this.#target.style.cursor = cursor;
  }

  refreshTheme(): void {
    this.#theme = readTheme();
    this.#coast.setStyle(coastStyle(this.#theme));
    for (const layer of this.#layers) layer.touch();
  }

  setInsets(insets: Insets): void {
    this.view.insets = insets;
    const style = this.#target.style;
    for (const side of ['top', 'right', 'bottom', 'left'] as const) {
      style.setProperty(`--map-inset-${side}`, `${insets[side]}px`);
    }
    for (const layer of this.#layers) layer.touch();
  }

  setFollow(mode: FollowMode): void {
    this.view.setFollow(mode, this.#vehicles.vehicles.find((vehicle) => vehicle.isSelected)?.at ?? null);
  }
}
