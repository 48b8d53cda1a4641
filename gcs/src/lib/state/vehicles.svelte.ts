// The vehicles: their newest telemetry with its age, and which is selected.
import { SvelteMap } from 'svelte/reactivity';
import type {
  FlightParameters,
  GroupName,
  MissionProgress,
  PlanKind,
  PlanState,
  StatusText,
  TelemetryChanges,
  TelemetryGroups,
  VehicleState,
  VehicleSummary,
} from '$lib/api/types';
import type { Replay } from '$lib/api/replays';
import { vehicleKind } from '$lib/domain/core';
import { freshness, type Freshness } from '$lib/domain/freshness';
import { deadReckon, followTrack, type Ghost, type LastKnown } from '$lib/domain/ghost';
import { lonLat, wrap360_deg } from '$lib/domain/lonlat';
import { countUnseen, WARNING } from '$lib/domain/messages';
import type { Track } from '$lib/domain/rehearsal';
import { isStopped, positionAfter } from '$lib/domain/replay';
import { PLANE_ROUTE, type RouteOptions } from '$lib/domain/way';
import { clock } from './clock.svelte';
import { FlightClock, type FlightTime } from './flight-time';
import { FrameQueue } from './frames';
import { SensorHistory } from './sensors';
import { vehicleName } from './vehicle-name';

/** Texts kept per vehicle; the oldest fall out. */
const TEXTS_KEPT = 1000;
/** `MAV_AUTOPILOT_ARDUPILOTMEGA`. */
const ARDUPILOT = 3;
/** A rehearsal older than this when the vehicle was lost is not used for its ghost, seconds. */
const REST_LASTS_S = 10;

export interface Text {
  id: number;
  severity: number;
  text: string;
  /** When it arrived, seconds on the station's clock; of a replay, the position in its recording. */
  time_s: number;
  /** Of a replay, when it was recorded, seconds since 1970; null when that is not known, and for other vehicles. */
  unix_s: number | null;
  /** Time of day at which it was recorded, or else arrived. */
  at: Date;
  /** Whether it came after this page began to follow the vehicle. */
  isNews: boolean;
}

/** How well a vehicle is heard. */
interface LinkQuality {
  /** Id of the link that it is reached over. */
  id: number | null;
  loss_pct: number | null;
  round_trip_ms: number | null;
}

interface TelemetryChange {
  groups: TelemetryChanges;
  progress: MissionProgress | null;
  /** Monotonic time at which each group had arrived. */
  heardAt_ms: Partial<Record<GroupName, number>>;
}

/** The telemetry in a message. */
interface Told {
  groups: TelemetryChanges;
  progress?: MissionProgress | null;
}

export class Vehicle {
  readonly systemId: number;
  /** The newest of every group; replaced, never changed, at most once a frame. */
  groups = $state.raw<TelemetryGroups>({});
  heardAt_ms = $state.raw<Readonly<Partial<Record<GroupName, number>>>>({});
  progress = $state.raw<MissionProgress | null>(null);
  /** Whether it hears us; null when that is not known. */
  isReached = $state<boolean | null>(null);
  /** Where a second vehicle with the same system id is heard; commands do not go there. */
  rival = $state<string | null>(null);
  /** The links to its silent autopilot, in English, of which the station on board is heard. */
  silence = $state<string | null>(null);
  /** Whether it asks for the ground's altitude where no map of the server knows it. */
  lacksTerrain = $state(false);
  planStates = $state.raw<Readonly<Record<PlanKind, PlanState>> | null>(null);
  modeNames = $state.raw<readonly string[]>([]);
  /** Its properties that determine the path of a plan. */
  route = $state.raw<RouteOptions>(PLANE_ROUTE);
  /** Whether its return finds a landing by DO_LAND_START (RTL_AUTOLAND); null when that is not known. */
  findsLanding = $state<boolean | null>(null);
  texts = $state.raw<readonly Text[]>([]);
  /** How well it is heard; null before it is known. */
  link = $state.raw<LinkQuality | null>(null);
  flightTime = $state.raw<FlightTime | null>(null);
  /** Monotonic time at which anything of it was last heard. */
  lastHeard_ms = $state.raw<number | null>(null);

  /** Whether it comes from a recording, be it a replay or a link that plays one. */
  isRecorded = $state(false);
  /** The replay that it belongs to, as it was known at a monotonic time. */
  replay = $state.raw<{ readonly is: Replay; readonly at_ms: number } | null>(null);
  /** Since when its replay stands still: then nothing ages. */
  #stopped_ms = $state<number | null>(null);

  /** The rest of its mission as rehearsed from where it was at a monotonic time; null where that is not known. */
  rest = $state.raw<{ readonly track: Track; readonly from_ms: number } | null>(null);

  readonly sensors = new SensorHistory();
  #flightClock: FlightClock;
  /** Server time (`time_s`) minus our monotonic time, for the time of day of past texts. */
  #serverOffset_s: number | null = null;
  #nextText = 1;
  /** Whether the texts from before it was followed are here. */
  #hasPastTexts = false;
  /** The newest text that was seen. */
  #seenText = $state(0);
  /** Warnings that came since. */
  unseenWarnings = $derived(
    countUnseen(
      this.texts.filter(({ severity }) => severity <= WARNING),
      this.#seenText,
    ),
  );

  age_s = $derived(this.#age_s(this.lastHeard_ms));
  freshness = $derived<Freshness>(freshness(this.age_s));
  /** Whether it was heard once and is not any more. */
  isLost = $derived(this.freshness === 'lost');
  mode = $derived(this.groups.heartbeat?.mode ?? null);
  isArmed = $derived(this.groups.heartbeat?.is_armed ?? null);
  /** Null when it is not reported. */
  isOnGround = $derived.by(() => {
    const landed = this.groups.extended?.landed;
    return landed === undefined || landed === 'undefined' ? null : landed === 'on ground';
  });
  /** Whether it lands now; `maybe` while it flies a mission that was not read. */
  landing = $derived.by<'no' | 'yes' | 'maybe'>(() => {
    // What is barred during a landing is dangerous for an ArduPlane alone (`guard_landing` of the server).
    const { autopilot } = this.groups.heartbeat ?? {};
    if (autopilot !== undefined && (autopilot !== ARDUPILOT || !['plane', 'vtol'].includes(this.kind))) return 'no';
    const { is_landing, follows_mission } = this.progress ?? {};
    if (is_landing == null) return follows_mission === true ? 'maybe' : 'no';
    return is_landing ? 'yes' : 'no';
  });
  kind = $derived(vehicleKind(this.groups.heartbeat?.mav_type ?? null));
  /** Its name in a fleet, when it is far away, or in a recording: the id is then only this server’s. */
  remoteName = $state<string | null>(null);
  /** Its name in a fleet alone. */
  fleetName = $derived.by(() => (this.isRecorded ? null : this.remoteName));
  /** What to call it, in the language in use. */
  name = $derived(vehicleName(this));

  constructor(systemId: number) {
    this.systemId = systemId;
    this.#flightClock = new FlightClock(String(systemId));
  }

  /** The present moment of its ages: that of a replay which stands still does not pass. */
  time_ms(now_ms: number): number {
    return this.#stopped_ms ?? now_ms;
  }

  /** How fast its time passes. */
  get rate(): number {
    return this.replay?.is.speed ?? 1;
  }

  /** Place of its replay now, seconds; null without one. Reactive. */
  position_s = $derived.by(() => {
    if (this.replay === null) return null;
    return positionAfter(this.replay.is, (clock.now_ms - this.replay.at_ms) / 1000);
  });

  #age_s(at_ms: number | null | undefined): number | null {
    return at_ms == null ? null : Math.max(0, ((this.time_ms(clock.now_ms) - at_ms) / 1000) * this.rate);
  }

  /** Takes over the state of its replay. Whether that went to another place: then nothing of it is known. */
  applyReplay(replay: Replay | null, now_ms: number): boolean {
    const before = this.replay?.is ?? null;
    const isStill = replay !== null && isStopped(replay);
    if (isStill) this.#stopped_ms ??= now_ms;
    else if (this.#stopped_ms !== null) {
      const stood_ms = now_ms - this.#stopped_ms;
      this.#stopped_ms = null;
      if (this.lastHeard_ms !== null) this.lastHeard_ms += stood_ms;
      this.heardAt_ms = Object.fromEntries(Object.entries(this.heardAt_ms).map(([name, at]) => [name, at + stood_ms]));
    }
    this.replay = replay === null ? null : { is: replay, at_ms: now_ms };
    const isElsewhere = before !== null && replay !== null && before.seeks !== replay.seeks;
    if (isElsewhere) this.#forget();
    return isElsewhere;
  }

  #forget(): void {
    this.groups = {};
    this.heardAt_ms = {};
    this.progress = null;
    this.planStates = null;
    this.texts = [];
    this.#hasPastTexts = false;
    this.lastHeard_ms = null;
    this.flightTime = null;
    this.#flightClock = new FlightClock(`${this.systemId}`);
    this.rest = null;
    this.sensors.clear();
  }

  /** Age in seconds of a group, null when it never came. Reactive. */
  groupAge_s(name: GroupName): number | null {
    return this.#age_s(this.heardAt_ms[name]);
  }

  groupFreshness(name: GroupName): Freshness {
    return freshness(this.groupAge_s(name));
  }

  /** The last known movement, for dead reckoning; null without a position. */
  lastKnown(): LastKnown | null {
    const { position, hud } = this.groups;
    const at = lonLat(position?.lon_deg, position?.lat_deg);
    if (!position || at === null) return null;
    const north_m_s = position.velocity_north_m_s ?? 0;
    const east_m_s = position.velocity_east_m_s ?? 0;
    const groundspeed_m_s = Math.hypot(north_m_s, east_m_s);
    const course_deg = wrap360_deg((Math.atan2(east_m_s, north_m_s) * 180) / Math.PI);
    return {
      at,
      course_deg,
      heading_deg: position.heading_deg ?? hud?.heading_deg ?? course_deg,
      groundspeed_m_s,
      turn_rate_deg_s: this.progress?.turn_rate_deg_s ?? 0,
    };
  }

  /** Monotonic time of the last that is known of where it is. */
  get placed_ms(): number | null {
    return this.heardAt_ms.position ?? this.lastHeard_ms;
  }

  /** Whether it is known to fly its mission. */
  get isInMission(): boolean {
    return this.progress?.follows_mission === true && this.isArmed === true && this.isOnGround === false;
  }

  /** Whether it is known to fly, and not its mission: home, to a place it was sent to, in a circle, or by hand. */
  get hasLeftMission(): boolean {
    const { progress } = this;
    if (progress?.follows_mission !== false || progress.is_complete) return false;
    const hasBegun = progress.reached.length > 0 || (progress.item ?? 1) > 1;
    return hasBegun && this.isArmed === true && this.isOnGround === false;
  }

  /**
   * Where it probably is at `now_ms` while it is lost; null while it is heard. In a mission it goes on as that was rehearsed from
   * about where it was last heard; else in a line or circle.
   */
  ghost(now_ms = performance.now()): Ghost | null {
    const { placed_ms, rest } = this;
    // of a recording nothing is estimated
    const last = this.isLost && !this.isRecorded ? this.lastKnown() : null;
    if (placed_ms === null || last === null) return null;
    const elapsed_s = (now_ms - placed_ms) / 1000;
    const early_s = rest === null ? Infinity : (placed_ms - rest.from_ms) / 1000;
    if (rest === null || !this.isInMission || early_s > REST_LASTS_S) return deadReckon(last, elapsed_s);
    return followTrack(last, rest.track, early_s, elapsed_s);
  }

  apply(change: TelemetryChange): void {
    this.groups = withChanges(this.groups, change.groups);
    const heardAt_ms = { ...this.heardAt_ms, ...change.heardAt_ms };
    for (const name of Object.keys(heardAt_ms) as GroupName[]) if (!(name in this.groups)) delete heardAt_ms[name];
    this.heardAt_ms = heardAt_ms;
    if (change.progress !== null) this.progress = change.progress;
    const newest_ms = Math.max(...Object.values(change.heardAt_ms));
    if (Number.isFinite(newest_ms)) {
      this.#hear(newest_ms);
      this.sensors.take(newest_ms / 1000, withChanges({}, change.groups));
    }
    const { system_time, extended, heartbeat } = this.groups;
    const boot_s = system_time === undefined ? null : system_time.boot_ms / 1000;
    if (boot_s !== null) {
      const landed = extended?.landed;
      const isFlying =
        landed !== undefined && landed !== 'undefined' ? landed !== 'on ground' : (heartbeat?.is_armed ?? null);
      // `boot_s` may be as old as the last SYSTEM_TIME of a plane that is lost.
      const age_ms = performance.now() - (heardAt_ms.system_time ?? performance.now());
      this.flightTime = this.#flightClock.update(boot_s, isFlying, (Date.now() - age_ms) / 1000);
    }
  }

  /** Whether it begins anew, as one of a replay that went to another place. */
  applySummary(summary: VehicleSummary, now_ms: number): boolean {
    this.isRecorded = summary.is_recorded;
    const isAnew = this.applyReplay(summary.replay, now_ms);
    if (summary.age_s !== null) this.#hear(this.time_ms(now_ms) - (summary.age_s * 1000) / this.rate);
    const { link, loss_pct, round_trip_ms } = summary;
    this.link = { id: link, loss_pct, round_trip_ms };
    this.isReached = summary.is_reached;
    this.rival = summary.rival;
    this.silence = summary.silence;
    this.lacksTerrain = summary.lacks_terrain;
    this.remoteName = summary.remote_name;
    this.#applyParameters(summary.flight_parameters);
    // Without news of the vehicle there is nothing new to plot of its link.
    if (summary.age_s !== null && summary.age_s < 2) this.sensors.takeLink(now_ms / 1000, this.link);
    return isAnew;
  }

  #applyParameters({ loiter_radius_m, airspeed_m_s, finds_landing }: FlightParameters): void {
    this.findsLanding = finds_landing;
    const { loiterRadius_m, cruise_m_s } = PLANE_ROUTE;
    const known = { loiterRadius_m: loiter_radius_m ?? loiterRadius_m, cruise_m_s: airspeed_m_s ?? cruise_m_s };
    // sent repeatedly: replaced only when it has changed, to avoid redrawing
    const isAsBefore = known.loiterRadius_m === this.route.loiterRadius_m && known.cruise_m_s === this.route.cruise_m_s;
    if (!isAsBefore) this.route = { ...this.route, ...known };
  }

  /** Takes over the whole state, except groups in messages `told` since the request, which are newer. */
  applyState(state: VehicleState, now_ms: number, told: readonly Told[] = []): void {
    const groups: TelemetryChanges = Object.fromEntries(
      Object.entries(state.telemetry).filter(([name]) => !told.some((message) => name in message.groups)),
    );
    const progress = told.some((message) => message.progress != null) ? null : state.progress;
    this.apply({ groups, progress, heardAt_ms: heardAt(groups, this.time_ms(now_ms), this.rate) });
    this.planStates = state.plan_states;
    this.modeNames = state.mode_names;
    if (state.flies_arcs !== this.route.fliesArcs) this.route = { ...this.route, fliesArcs: state.flies_arcs };
    this.setServerTime(state.time_s, now_ms);
  }

  applyPlanState(kind: PlanKind, state: PlanState): void {
    const unknown: PlanState = { state: 'unknown', count: null, hash: null, may_be_mixed: false, detail: '' };
    this.planStates = { ...(this.planStates ?? { mission: unknown, fence: unknown, rally: unknown }), [kind]: state };
  }

  /** Marks its texts as seen. */
  see(): void {
    this.#seenText = this.texts.at(-1)?.id ?? 0;
  }

  setServerTime(time_s: number, now_ms: number): void {
    this.#serverOffset_s = time_s - now_ms / 1000;
  }

  addText(text: StatusText, now_ms: number): void {
    this.texts = [...this.texts.slice(-(TEXTS_KEPT - 1)), this.#entry(text, now_ms, true)];
  }

  /** All texts that the server has kept. After a reconnection those that are here stay as they are, and newer ones are news. */
  setTexts(texts: readonly StatusText[], now_ms: number): void {
    const known = new Map(this.texts.map((text) => [keyOf(text), text]));
    const newest_s = this.texts.at(-1)?.time_s ?? -Infinity;
    // a restarted server counts from zero; a recording has its own time
    const isSameClock =
      this.replay !== null || this.#serverOffset_s === null || newest_s <= this.#serverOffset_s + now_ms / 1000;
    const isNews = (text: StatusText): boolean => this.#hasPastTexts && (!isSameClock || text.time_s > newest_s);
    this.texts = texts
      .slice(-TEXTS_KEPT)
      .map((text) => known.get(keyOf(text)) ?? this.#entry(text, now_ms, isNews(text)));
    this.#hasPastTexts = true;
  }

  #entry({ severity, text, time_s, unix_s }: StatusText, now_ms: number, isNews: boolean): Text {
    const at = unix_s === null ? this.#timeOfDay(time_s, now_ms) : new Date(unix_s * 1000);
    return { id: this.#nextText++, severity, text, time_s, unix_s, at, isNews };
  }

  /** Whether the time of day of a text is known: not in a recording without a date. */
  isDated({ unix_s }: Text): boolean {
    return unix_s !== null || this.replay === null;
  }

  #timeOfDay(time_s: number, now_ms: number): Date {
    const age_ms = this.#serverOffset_s === null ? 0 : Math.max(0, now_ms - (time_s - this.#serverOffset_s) * 1000);
    return new Date(Date.now() - age_ms);
  }

  #hear(at_ms: number): void {
    if (this.lastHeard_ms === null || at_ms > this.lastHeard_ms) this.lastHeard_ms = at_ms;
  }
}

const keyOf = ({ time_s, text }: StatusText): string => `${time_s} ${text}`;

/** The groups after a change; what the vehicle no longer has is gone. */
export function withChanges(groups: TelemetryGroups, changes: TelemetryChanges): TelemetryGroups {
  const next: TelemetryChanges = { ...groups, ...changes };
  for (const name of Object.keys(changes) as GroupName[]) if (next[name] == null) delete next[name];
  return next as TelemetryGroups;
}

/** When each group had arrived, from its age; of a vehicle whose time passes at a rate. */
export function heardAt(groups: TelemetryChanges, now_ms: number, rate = 1): Partial<Record<GroupName, number>> {
  const heard: Partial<Record<GroupName, number>> = {};
  type Aged = { age_s: number } | null;
  for (const [name, group] of Object.entries(groups) as [GroupName, Aged | Aged[]][]) {
    // of a list the first counts, which is the one that is shown
    const first = Array.isArray(group) ? group.find((one) => one !== null) : group;
    if (first != null) heard[name] = now_ms - (first.age_s * 1000) / rate;
  }
  return heard;
}

class Vehicles {
  readonly #byId = new SvelteMap<number, Vehicle>();
  #selectedId = $state<number | null>(null);
  /** Whether a person selected it. */
  #isChosen = false;
  /** The live one that was selected before a recording. */
  #lastLive: number | null = null;
  readonly #listeners = new Set<(vehicle: Vehicle) => void>();
  readonly #queue = new FrameQueue<number, TelemetryChange>({
    join: (waiting, next) => ({
      groups: { ...waiting.groups, ...next.groups },
      progress: next.progress ?? waiting.progress,
      heardAt_ms: { ...waiting.heardAt_ms, ...next.heardAt_ms },
    }),
    flush: (id, change) => {
      const vehicle = this.#byId.get(id);
      // it was dropped while this waited
      if (vehicle === undefined) return;
      vehicle.apply(change);
      for (const listener of this.#listeners) listener(vehicle);
    },
    after: () => clock.tick(),
  });

  all = $derived([...this.#byId.values()].sort((a, b) => a.systemId - b.systemId));
  /** The target of commands and plans: the first vehicle heard until the user selects another. It changes by itself only from a
   * recording: that nobody chose to a live vehicle, or that is closed to the live one selected before. */
  selected = $derived<Vehicle | null>(
    (this.#selectedId === null ? undefined : this.#byId.get(this.#selectedId)) ?? null,
  );

  /** What decides where a plan takes the selected vehicle; without one, an ArduPlane as it comes. */
  get route(): RouteOptions {
    return this.selected?.route ?? PLANE_ROUTE;
  }

  get(id: number): Vehicle | undefined {
    return this.#byId.get(id);
  }

  ensure(id: number): Vehicle {
    let vehicle = this.#byId.get(id);
    if (vehicle === undefined) {
      vehicle = new Vehicle(id);
      this.#byId.set(id, vehicle);
    }
    // the first one that is heard; of several a person chooses
    if (this.#byId.size === 1) this.#selectedId ??= id;
    return vehicle;
  }

  select(id: number): void {
    if (this.selected?.isRecorded === false) this.#lastLive = this.selected.systemId;
    this.#selectedId = id;
    this.#isChosen = true;
  }

  /** Selects a live vehicle in place of a recording that nobody chose. */
  preferLive(): void {
    if (this.#isChosen || this.selected?.isRecorded !== true) return;
    const live = this.all.find((vehicle) => !vehicle.isRecorded);
    if (live !== undefined) this.#selectedId = live.systemId;
  }

  /**
   * Forgets one that is not followed any more. In place of the selected one, the live one from before it is selected; without that the
   * only live one, and none of several.
   */
  drop(id: number): void {
    this.#byId.delete(id);
    if (this.#selectedId !== id) return;
    const live = this.all.filter(({ isRecorded }) => !isRecorded);
    const last = live.find(({ systemId }) => systemId === this.#lastLive);
    const next = last ?? (live.length > 1 ? undefined : (live[0] ?? this.all[0]));
    this.#selectedId = next?.systemId ?? null;
    this.#isChosen = last !== undefined;
  }

  /** The one after the selected, in the order of their ids; after the last the first. */
  get next(): Vehicle | undefined {
    const at = this.all.findIndex((vehicle) => vehicle === this.selected);
    return this.all[(at + 1) % this.all.length];
  }

  /** Calls `listener` after each frame in which a vehicle changed; for drawing outside of components. */
  onFrame(listener: (vehicle: Vehicle) => void): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  telemetry(id: number, time_s: number, groups: TelemetryChanges, progress: MissionProgress | null): void {
    const now_ms = performance.now();
    const vehicle = this.get(id);
    vehicle?.setServerTime(time_s, now_ms);
    const heardAt_ms = heardAt(groups, vehicle?.time_ms(now_ms) ?? now_ms, vehicle?.rate);
    this.#queue.push(id, { groups, progress, heardAt_ms });
  }
}

export const vehicles = new Vehicles();
