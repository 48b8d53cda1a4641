// The station: session and control, links, vehicles and operations, kept up to date over the WebSocket.
import { Api, type Acting, type CommandName, type VehicleCommands } from '$lib/api/client';
import type { Options } from '$lib/api/http';
import { connection } from '$lib/api/connection';
import { Pending } from '$lib/api/pending';
import { problemFrom } from '$lib/api/problem';
import { parse, Socket, type SocketState } from '$lib/api/socket';
import { PAGE_VERSION } from '$lib/api/version';
import type { Replay } from '$lib/api/replays';
import { commandBar, type CommandBar } from '$lib/domain/command-bar';
import { type ControlRequest, followed, NO_REQUEST } from '$lib/domain/control-request';
import type {
  Assessment,
  ClientMessage,
  FleetNetwork,
  LinkInfo,
  Plan,
  PlaneProfile,
  PlanWind,
  Problem,
  ServerMessage,
  Session,
  StatusText,
  StorageProblem,
  Trip,
  Way,
} from '$lib/api/types';
import { SvelteMap } from 'svelte/reactivity';
import { clock } from './clock.svelte';
import { fleet } from './fleet.svelte';
import { Operations } from './operations.svelte';
import { settings } from './settings.svelte';
import { trails } from './trails';
import { vehicles, type Vehicle } from './vehicles.svelte';

export { problemFrom };

export const api = new Api();
export const operations = new Operations(api);

const SHOWN_MS: Readonly<Record<Answer['state'], number>> = { waiting: Infinity, accepted: 10_000, refused: 60_000 };
/** Vehicles that are followed in all detail at once: of more, those chosen last. */
const DETAILED = 8;
/** Longer questions are not asked over the WebSocket, which takes half a megabyte. */
const MAX_ASKED = 500_000;

/** What became of the last command of a kind: a button pressed is not a command accepted. */
export interface Answer {
  command: CommandName;
  state: 'waiting' | 'accepted' | 'refused';
  problem: Problem | null;
  at_ms: number;
  /** The same once more: with the confirmation that the server gave, or in spite of the mission on board. */
  repeat: (more: Acting) => void;
}

export class Station {
  socketState = $state<SocketState>('connecting');
  session = $state.raw<Session | null>(null);
  version = $state<string | null>(null);
  /** Whether the server is of another version than this page. */
  isUpdated = $derived(this.version !== null && this.version !== PAGE_VERSION);
  links = $state.raw<readonly LinkInfo[]>([]);
  /** The fleets that the server is in, and why one's vehicles are not heard. */
  networks = $state.raw<readonly FleetNetwork[]>([]);
  /** Storage faults of the server, the flight recorder's first. */
  storage = $state.raw<readonly StorageProblem[]>([]);
  /** The newest draft announced by the server. */
  draft = $state.raw<{ revision: number; author: string } | null>(null);
  /** Offset from the station's clock to this page's. */
  #clockOffset_ms: number | null = null;
  /** Why no session could be opened: a token is asked for, mostly. */
  sessionProblem = $state.raw<Problem | null>(null);
  /** Why the last change of control was refused, until control changes hands or is asked for. */
  controlProblem = $state.raw<Problem | null>(null);
  /** Whether a change of control is under way. */
  isControlBusy = $state(false);
  /** This page's request for control. */
  #request = $state.raw<ControlRequest>(NO_REQUEST);
  /** What became of it. */
  controlRequest = $derived(this.#request.state);
  /** Monotonic time since when the server is not heard; null while it is. */
  #away_ms = $state<number | null>(performance.now());
  readonly #answers = new SvelteMap<string, Answer>();
  #token: string | null = null;
  readonly #subscribed = new Map<number, number>();
  /** Those chosen, the newest last. */
  #chosen: number[] = [];
  /** Whether the next roster is the first of its connection: a whole one. */
  #isRosterWhole = false;
  /** Messages about a vehicle received while its whole state is being fetched; they are newer than that. */
  readonly #meanwhile = new Map<number, ServerMessage[]>();

  readonly #listeners = new Set<(message: ServerMessage) => void>();
  readonly #assessments = new Pending<Assessment>();
  readonly #ways = new Pending<Way>();
  #nextSeq = 1;

  readonly #socket = new Socket({
    address: (signal) => this.#openSession(signal),
    message: (data) => {
      const message = parse(data);
      if (message !== null) this.receive(message);
    },
    state: (state) => this.#setSocketState(state),
  });

  /** Counts announced changes of map sources and offline areas. */
  mapsRevision = $state(0);
  isOnline = $derived(this.socketState === 'open');
  /** How long the server has been away; null while it is there. */
  away_s = $derived(clock.age_s(this.#away_ms));
  hasControl = $derived(this.isOnline && this.session?.has_control === true && this.session.role === 'operator');
  holder = $derived(this.session?.holder ?? null);
  isOperator = $derived(this.session?.role === 'operator');
  /** Who asks for control. */
  requestedBy = $derived(this.session?.requested_by ?? null);

  /** Why a vehicle takes no command from this page; null when it does. */
  barOf(vehicle: Vehicle | null): CommandBar | null {
    const { isOnline, isOperator, hasControl } = this;
    const isHeldElsewhere = vehicle !== null && fleet.isHeldElsewhere(vehicle.systemId);
    return commandBar({ isRecorded: vehicle?.isRecorded ?? false, isOnline, isOperator, hasControl, isHeldElsewhere });
  }

  /** Whether a vehicle may be commanded. */
  canCommand(vehicle: Vehicle | null): boolean {
    return vehicle !== null && this.barOf(vehicle) === null;
  }

  /** Takes over the state of a replay, for its vehicles. */
  applyReplay(replay: Replay): void {
    const now_ms = performance.now();
    for (const id of replay.vehicles) {
      const vehicle = vehicles.get(id);
      if (vehicle?.applyReplay(replay, now_ms)) this.#beginAnew(vehicle);
    }
  }

  /** Takes over a replay that was opened just now: its vehicles are recorded before the roster says so. */
  beginReplay(replay: Replay): void {
    for (const id of replay.vehicles) vehicles.ensure(id).isRecorded = true;
    this.applyReplay(replay);
  }

  #beginAnew(vehicle: Vehicle): void {
    trails.cut(vehicle.systemId);
    void this.#meet(vehicle);
  }

  start(): void {
    this.#token = takeToken();
    clock.start();
    this.#socket.start();
    const hurry = () => {
      if (!document.hidden) this.#socket.hurry();
    };
    window.addEventListener('online', hurry);
    document.addEventListener('visibilitychange', hurry);
  }

  /** Reopens the session with a typed token. */
  useToken(token: string): void {
    this.#token = token.trim();
    this.sessionProblem = null;
    this.#socket.close();
    this.#socket.start();
  }

  /** Sends the selected rate to the server after a change. */
  resubscribe(): void {
    for (const vehicle of vehicles.all) this.#subscribe(vehicle.systemId);
  }

  /**
   * Asks the core to assess a plan, rehearsed in a wind with a ground clearance. One question at a time: a second one ends the first.
   *
   * Rejects when the connection ends before the answer, and for an invalid plan. A plan too long for the WebSocket goes by HTTP,
   * which returns its findings alone.
   */
  async assess(
    plan: Plan,
    vehicle: number | undefined,
    wind: PlanWind,
    clearance_m: number,
    profile: PlaneProfile = {},
  ): Promise<Omit<Assessment, 'trip'> & { trip: Trip | null }> {
    const asked = { vehicle: vehicle ?? null, plan, rehearse_in: wind, clearance_m, profile };
    const told = this.#ask(this.#assessments, (seq) => ({ type: 'assess_plan', seq, ...asked }));
    return told ?? { findings: await api.checkPlan(plan, vehicle), trip: null, rehearsal: null };
  }

  /** Asks for the way of a plan that is edited; otherwise as {@link assess}. A long plan's comes another way. */
  async way(plan: Plan, vehicle: number | undefined, clearance_m: number): Promise<Way> {
    const asked = { type: 'plan_way', vehicle: vehicle ?? null, clearance_m, plan } as const;
    return this.#ask(this.#ways, (seq) => ({ ...asked, seq })) ?? api.way(plan, vehicle, clearance_m);
  }

  /** `null`: it is too long for the WebSocket. */
  #ask<Answer>(kind: Pending<Answer>, question: (seq: number) => ClientMessage): Promise<Answer> | null {
    const seq = this.#nextSeq++;
    const text = JSON.stringify(question(seq));
    if (text.length > MAX_ASKED) return null;
    const answer = kind.ask(seq);
    if (this.isOnline) this.#socket.sendText(text);
    else kind.end('no connection');
    return answer;
  }

  #endQuestions(why: string, seq?: number): void {
    this.#assessments.end(why, seq);
    this.#ways.end(why, seq);
  }

  /** Sends a command and remembers the vehicle's answer. Gives whether it was accepted. */
  async command<Name extends CommandName>(
    vehicle: Vehicle,
    command: Name,
    body: VehicleCommands[Name],
    options: Acting = {},
  ): Promise<boolean> {
    const key = `${vehicle.systemId}/${command}`;
    const at_ms = performance.now();
    const repeat = (more: Acting) => void this.command(vehicle, command, body, { ...options, ...more });
    const asked = { command, problem: null, repeat };
    this.#answers.set(key, { ...asked, state: 'waiting', at_ms });
    let answer: Answer;
    try {
      const acts =
        'force' in body && body.force === true ? [`force-${command}`] : command === 'home' ? ['move-home'] : [];
      const send = (confirmed: Options) => api.command(vehicle.systemId, command, body, { ...options, ...confirmed });
      // Holding the button for a second confirms a forced command, and that home moves.
      await api.confirmed(acts, send);
      answer = { ...asked, state: 'accepted', at_ms: performance.now() };
    } catch (error) {
      answer = { ...asked, state: 'refused', problem: problemFrom(error), at_ms: performance.now() };
    }
    // A later press of the same button supersedes this answer.
    if (this.#answers.get(key)?.at_ms === at_ms) this.#answers.set(key, answer);
    return answer.state === 'accepted';
  }

  answer(vehicle: Vehicle, command: CommandName): Answer | undefined {
    return this.#answers.get(`${vehicle.systemId}/${command}`);
  }

  /** The newest answers of a vehicle, newest first, for as long as they concern its present state. */
  answers(vehicle: Vehicle): Answer[] {
    return [...this.#answers]
      .filter(([key, answer]) => {
        const isOld = clock.now_ms - answer.at_ms > SHOWN_MS[answer.state];
        return key.startsWith(`${vehicle.systemId}/`) && !isOld;
      })
      .map(([, answer]) => answer)
      .sort((a, b) => b.at_ms - a.at_ms);
  }

  /** The newest of them. */
  lastAnswer(vehicle: Vehicle): Answer | undefined {
    return this.answers(vehicle)[0];
  }

  forgetAnswer(vehicle: Vehicle, command: CommandName): void {
    this.#answers.delete(`${vehicle.systemId}/${command}`);
  }

  takeControl = () => this.#control(() => api.takeControl());
  releaseControl = () => this.#control(() => api.releaseControl());
  /** Declines the request of the operator with this name. */
  keepControl = (requestedBy: string) => this.#control(() => api.keepControl(requestedBy));
  requestControl = () => this.#control(() => api.requestControl());

  async #control(call: () => Promise<Partial<Session>>): Promise<void> {
    this.controlProblem = null;
    this.isControlBusy = true;
    try {
      const { has_control, holder } = await call();
      if (this.session && typeof has_control === 'boolean') {
        this.session = { ...this.session, has_control, holder: holder ?? null };
      }
    } catch (error) {
      this.controlProblem = problemFrom(error);
    } finally {
      this.isControlBusy = false;
    }
  }

  #followRequest(before: ControlRequest): void {
    const { session } = this;
    if (session === null) return;
    const { has_control: has, holder, name, requested_by: requestedBy } = session;
    this.#request = followed(before, { has, holder, requestedBy, isRequestOurs: requestedBy === name });
  }

  /** A moment on the station's clock, on this page's. */
  stationTime_ms(time_s: number): number | null {
    return this.#clockOffset_ms === null ? null : time_s * 1000 + this.#clockOffset_ms;
  }

  /** Calls `listener` with each message of the server, after the station has taken it. */
  whenTold(listener: (message: ServerMessage) => void): void {
    this.#listeners.add(listener);
  }

  receive(message: ServerMessage): void {
    const now_ms = performance.now();
    if ('vehicle' in message && message.vehicle !== null) this.#meanwhile.get(message.vehicle)?.push(message);
    switch (message.type) {
      case 'hello': {
        this.version = message.version;
        this.#clockOffset_ms = now_ms - message.time_s * 1000;
        const { session, name, role, has_control, holder, requested_by } = message;
        this.session = { session, name, role, has_control, holder, requested_by };
        // what was asked before may never be answered
        [this.controlProblem, this.isControlBusy] = [null, false];
        this.#followRequest(NO_REQUEST);
        operations.greet();
        break;
      }
      case 'vehicles':
        // With many vehicles the roster decides which are followed.
        if (message.vehicles.length > DETAILED) break;
        for (const summary of message.vehicles) {
          const vehicle = vehicles.ensure(summary.system_id);
          if (vehicle.applySummary(summary, now_ms)) this.#beginAnew(vehicle);
          else if (!this.#subscribed.has(summary.system_id)) void this.#meet(vehicle);
        }
        vehicles.preferLive();
        break;
      case 'roster':
        fleet.apply(message.time_s, message.rows, message.gone, now_ms);
        for (const id of this.#isRosterWhole ? vehicles.all.map(({ systemId }) => systemId) : message.gone) {
          if (fleet.get(id) === undefined && vehicles.get(id)?.isRecorded) this.#forget(id);
        }
        this.#isRosterWhole = false;
        this.#followFleet();
        for (const summary of message.followed) {
          const vehicle = vehicles.get(summary.system_id);
          if (vehicle?.applySummary(summary, now_ms)) this.#beginAnew(vehicle);
        }
        vehicles.preferLive();
        break;
      case 'telemetry':
        vehicles.telemetry(message.vehicle, message.time_s, message.groups, message.progress ?? null);
        break;
      case 'text':
        vehicles.get(message.vehicle)?.addText(message, now_ms);
        break;
      case 'plan_state':
        vehicles.get(message.vehicle)?.applyPlanState(message.kind, message.state);
        break;
      case 'operation':
        operations.update(message);
        break;
      case 'links':
        this.links = message.links;
        break;
      case 'maps':
        this.mapsRevision += 1;
        break;
      case 'networks':
        this.networks = message.networks;
        break;
      case 'storage':
        this.storage = message.problems;
        break;
      case 'draft':
        this.draft = { revision: message.revision, author: message.author };
        break;
      case 'control':
        this.controlProblem = null;
        if (this.session) {
          const { has_control, holder, requested_by } = message;
          this.session = { ...this.session, has_control, holder, requested_by };
          this.#followRequest(this.#request);
        }
        break;
      case 'event':
      case 'param':
        // Events repeat what is in the telemetry; parameters have a state of their own.
        break;
      case 'assessment':
        this.#assessments.answer(message.seq, message);
        break;
      case 'way':
        this.#ways.answer(message.seq, message);
        break;
      case 'error':
        console.error('The server did not understand:', message.detail);
        if (message.seq !== undefined) this.#endQuestions(message.detail, message.seq);
        break;
    }
    for (const listener of this.#listeners) listener(message);
  }

  async #openSession(signal: AbortSignal): Promise<string> {
    try {
      this.session = await api.openSession(this.#token === null ? {} : { token: this.#token }, signal);
      this.sessionProblem = null;
    } catch (error) {
      const problem = problemFrom(error);
      // Only a refusal is worth telling; an absent server shows as such already.
      const isRefused = problem.status === 401 || problem.status === 403;
      // The form covers the map: that of a page that was let in before waits without it.
      const isSlowed = problem.cause?.code === 'tokens-slowed' && this.session === null;
      this.sessionProblem = isRefused || isSlowed ? problem : null;
      // Not again until a token is typed: each wrong one counts, and slows all who come from this address.
      if (problem.cause?.code === 'bad-token') this.#socket.close();
      throw error;
    }
    const { protocol, host } = window.location;
    return `${protocol === 'https:' ? 'wss' : 'ws'}://${host}/api/v1/ws`;
  }

  #setSocketState(state: SocketState): void {
    this.socketState = state;
    if (state === 'open') {
      this.#away_ms = null;
      this.#subscribed.clear();
      fleet.begin();
      this.#isRosterWhole = true;
      this.#socket.send({ type: 'subscribe_roster' });
      for (const vehicle of vehicles.all) void this.#meet(vehicle);
    } else {
      this.#away_ms ??= performance.now();
      connection.lose();
      this.#endQuestions('the connection was lost');
    }
  }

  /** Shows this vehicle from now on, in all detail. */
  choose(id: number): void {
    const vehicle = this.#introduce(id);
    // the one selected until now counts as chosen: from a recording it is gone back to
    const before = vehicles.selected?.systemId ?? id;
    const others = this.#chosen.filter((other) => other !== id && other !== before);
    this.#chosen = [...new Set([...others, before, id])].slice(-DETAILED);
    vehicles.select(id);
    if (!this.#subscribed.has(id)) void this.#meet(vehicle);
    this.#followFleet();
  }

  /** Follows all of a few; of many the chosen ones, and the first where none is. Recordings and live vehicles are counted apart. */
  #followFleet(): void {
    const ids = fleet.ids;
    const recorded = ids.filter((id) => fleet.get(id)?.is_recorded === true);
    const live = ids.filter((id) => fleet.get(id)?.is_recorded !== true);
    const few = [live, recorded].filter(({ length }) => length <= DETAILED).flat();
    if (few.length < ids.length) {
      if (this.#chosen.length === 0) this.choose(vehicles.selected?.systemId ?? Math.min(...ids));
      for (const { systemId } of vehicles.all) {
        if (few.includes(systemId) || this.#chosen.includes(systemId)) continue;
        this.#subscribed.delete(systemId);
        this.#socket.send({ type: 'unsubscribe', vehicle: systemId });
        vehicles.drop(systemId);
      }
    }
    for (const id of few) if (!this.#subscribed.has(id)) void this.#meet(this.#introduce(id));
  }

  /** A vehicle with what its row of the roster says: whether it takes commands at all is known before its summary comes. */
  #introduce(id: number): Vehicle {
    const vehicle = vehicles.ensure(id);
    const row = fleet.get(id);
    vehicle.isRecorded = row?.is_recorded ?? vehicle.isRecorded;
    vehicle.remoteName = row?.remote_name ?? vehicle.remoteName;
    return vehicle;
  }

  /** A recording that was closed leaves nothing behind. */
  #forget(id: number): void {
    this.#subscribed.delete(id);
    this.#chosen = this.#chosen.filter((other) => other !== id);
    this.#socket.send({ type: 'unsubscribe', vehicle: id });
    vehicles.drop(id);
    vehicles.preferLive();
  }

  /** Subscribes to a vehicle and fetches what is not pushed. */
  async #meet(vehicle: Vehicle): Promise<void> {
    const id = vehicle.systemId;
    this.#subscribe(id);
    const meanwhile: ServerMessage[] = [];
    this.#meanwhile.set(id, meanwhile);
    try {
      const [state, texts] = await Promise.all([api.vehicle(id), api.texts(id)]);
      this.#isMet(id, meanwhile);
      const now_ms = performance.now();
      const isListed = ({ time_s, text }: StatusText) =>
        texts.some((one) => one.time_s === time_s && one.text === text);
      const told = meanwhile.filter((message) => message.type === 'telemetry');
      vehicle.applyState(state, now_ms, told);
      vehicle.setTexts(texts, now_ms);
      for (const message of meanwhile) {
        if (message.type === 'plan_state' || (message.type === 'text' && !isListed(message))) this.receive(message);
      }
    } catch {
      // The server is away again; the next connection retries.
      this.#subscribed.delete(id);
      this.#isMet(id, meanwhile);
    }
  }

  /** Stops collecting messages, unless a newer request has started. */
  #isMet(id: number, meanwhile: ServerMessage[]): void {
    if (this.#meanwhile.get(id) === meanwhile) this.#meanwhile.delete(id);
  }

  #subscribe(id: number): void {
    this.#subscribed.set(id, settings.rate_hz);
    this.#socket.send({ type: 'subscribe', vehicle: id, rate_hz: settings.rate_hz });
  }
}

/** The token of a ready-made address (`#token=…`); removed from the address bar so that it is not copied along. */
function takeToken(): string | null {
  const { hash, search, pathname } = window.location;
  const token = new URLSearchParams(hash.replace(/^#/, '')).get('token') ?? new URLSearchParams(search).get('token');
  if (token !== null) window.history.replaceState(null, '', pathname);
  return token;
}

export const station = new Station();
