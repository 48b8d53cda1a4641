// Stands in for the server in the browser, for `npm run dev:mock` and for screenshots: answers requests, speaks on a
// WebSocket. `?scene=` chooses what is to be seen: lost, away, refused, mixed, elsewhere, oneway, watching, two, none,
// token, fleet (`&count=`).
import type {
  ClientMessage,
  LinkInfo,
  Operation,
  Plan,
  PlanKind,
  PlanComparison,
  ServerMessage,
  Session,
  VehicleState,
  VehicleSummary,
  Way,
} from '../../src/lib/api/types';
import { PAGE_VERSION } from '../../src/lib/api/version';
import { fleetRow } from './fleet';
import { home, mission, telemetryAt } from './flight';
import { mapsAnswer } from './maps';

const scene = new URLSearchParams(window.location.search).get('scene') ?? 'fly';
const start_ms = performance.now();
/** The flight has been going on for a while when the page opens. */
const HEAD_START_S = 212;
const time_s = () => (performance.now() - start_ms) / 1000 + HEAD_START_S;

let isArmed = scene !== 'refused' && scene !== 'mixed';
const session: Session = {
  session: 'mock',
  name: 'Mock',
  role: 'operator',
  has_control: scene !== 'watching',
  holder: scene === 'watching' ? 'Ana' : 'Mock',
  requested_by: null,
};
/** When the vehicle falls silent: after a few seconds in the scene "lost". */
const lastHeard_s = scene === 'lost' ? HEAD_START_S + 4 : Number.POSITIVE_INFINITY;
const count = scene === 'fleet' ? Number(new URLSearchParams(window.location.search).get('count') ?? 12) : 0;
const fleetIds = Array.from({ length: count }, (_, index) => 300 + index);
const ids = scene === 'none' ? [] : scene === 'fleet' ? fleetIds : scene === 'two' ? [1, 2] : [1];
const age_s = () => Math.max(0.04, time_s() - lastHeard_s);

const summary = (system_id: number): VehicleSummary => ({
  system_id,
  mav_type: 1,
  autopilot: 3,
  mode: 'AUTO',
  is_armed: isArmed,
  age_s: age_s(),
  link: 1,
  loss_pct: scene === 'lost' ? 31 : 0.4,
  round_trip_ms: 38 + 9 * Math.sin(time_s()),
  is_reached: scene !== 'oneway',
  rival: null,
  silence: null,
  remote_name: system_id >= 300 ? `plane${system_id - 300}` : null,
  control: null,
  is_revoked: false,
  is_recorded: false,
  replay: null,
  lacks_terrain: false,
  flight_parameters: { loiter_radius_m: 80, airspeed_m_s: 22, finds_landing: false },
});

const link = (): LinkInfo => ({
  id: 1,
  name: 'telemetry radio',
  address: '/dev/ttyUSB0,57600',
  local_address: null,
  state: 'up',
  fault: null,
  detail: null,
  forward: false,
  frames_received: 41_233,
  frames_sent: 812,
  bytes_received: 1_912_000,
  bytes_sent: 22_000,
  bad_crc: 2,
  garbage_bytes: 0,
  frames_lost: 166,
  loss_pct: 0.4,
  round_trip_ms: 38,
  age_s: age_s(),
  frames_per_s: 92,
  namesake: null,
  frames_refused: 0,
  accepts_unsigned: true,
  recent_loss_pct: 0.4,
});

const texts = [
  { time_s: HEAD_START_S - 205, unix_s: null, severity: 6, text: 'ArduPlane V4.6.3 (3fc7011a)' },
  { time_s: HEAD_START_S - 190, unix_s: null, severity: 4, text: 'PreArm: GPS 1: Bad fix' },
  { time_s: HEAD_START_S - 160, unix_s: null, severity: 6, text: 'EKF3 IMU0 origin set' },
  { time_s: HEAD_START_S - 95, unix_s: null, severity: 6, text: 'Throttle armed' },
  { time_s: HEAD_START_S - 90, unix_s: null, severity: 6, text: 'Mission: 1 Takeoff' },
  { time_s: HEAD_START_S - 61, unix_s: null, severity: 5, text: 'Takeoff complete at 60.12m' },
  { time_s: HEAD_START_S - 20, unix_s: null, severity: 2, text: 'Battery 1 is low 10.50V used 1840 mAh' },
  { time_s: HEAD_START_S - 8, unix_s: null, severity: 6, text: 'Mission: 2 WP' },
];

const plan: Plan = { items: mission, home, fence: { zones: [], return_point: null }, rally: [] };
const verified = {
  state: 'verified' as const,
  count: mission.length,
  hash: 'c0ffee',
  may_be_mixed: false,
  detail: 'read back and compared',
};
const empty = { state: 'empty' as const, count: 0, hash: null, may_be_mixed: false, detail: 'none' };
const mixed = { ...verified, state: 'unknown' as const, reason: 'mixed' as const, may_be_mixed: true };

/** In the scene "elsewhere" the plane flies to somewhere else than its plan says. */
function toldAt(...[t, options]: Parameters<typeof telemetryAt>): ReturnType<typeof telemetryAt> {
  const { groups, progress } = telemetryAt(t, options);
  return { groups, progress: { ...progress, target_off_m: scene === 'elsewhere' ? 412 : null } };
}

const KINDS: Record<string, Operation['kind']> = { PUT: 'upload_mission', POST: 'download_mission' };

let nextOperation = 1;
/** Here none fails. */
type Going = Omit<Operation, 'error'>;
const operations = new Map<number, Going>();

function begin(kind: Operation['kind'], result?: Plan): Going {
  const operation: Going = {
    id: nextOperation++,
    vehicle: 1,
    kind,
    state: 'running',
    done: 0,
    total: mission.length,
  };
  operations.set(operation.id, operation);
  const timer = setInterval(() => {
    const now = operations.get(operation.id)!;
    const done = Math.min(now.done + 1, now.total);
    const isDone = done === now.total;
    const next: Going = { ...now, done, state: isDone ? 'done' : 'running' };
    operations.set(operation.id, isDone && result ? { ...next, result } : next);
    say({ type: 'operation', ...next });
    if (isDone) clearInterval(timer);
  }, 150);
  return operation;
}

const json = (body: unknown, status = 200) =>
  new Response(JSON.stringify(body), {
    status,
    headers: { 'content-type': status < 400 ? 'application/json' : 'application/problem+json' },
  });

const refusal = () =>
  json(
    {
      type: 'urn:vencejo:command-refused',
      title: 'The vehicle refused',
      status: 409,
      detail: 'The vehicle refused COMPONENT_ARM_DISARM.',
      reasons: [
        'PreArm: DO_LAND_START set and RTL_AUTOLAND disabled',
        'PreArm: GPS 1: Bad fix',
        'PreArm: Servo 3 does something nobody explained',
      ],
    },
    409,
  );

const heldBack = () =>
  json(
    {
      type: 'urn:vencejo:plan-unknown',
      title: 'The plan on board is not known',
      status: 409,
      detail: 'The mission on board is perhaps mixed.',
      cause: { code: 'plan-unknown', plan: 'mission', reason: 'mixed' },
    },
    409,
  );

const planStates = () => ({ mission: scene === 'mixed' ? mixed : verified, fence: empty, rally: empty });

/** Straight lines stay what they are: guesses. */
const way = (items: number): Way => ({
  stops: [],
  jumps: [],
  end: { item: items + 1, designed_item: null },
  profile: { points: [], loiters: [], length_m: 0, ground: null },
  is_ground_pending: false,
});

/** What is not answered here fails as it would on an older server, and not in what the page makes of it. */
const notHere = () =>
  json({ type: 'urn:vencejo:not-found', title: 'Not found', status: 404, detail: 'the mock has no answer' }, 404);

async function answer(method: string, path: string, query: string, body: string): Promise<Response> {
  const ofMaps = await mapsAnswer(method, path, body, json);
  if (ofMaps !== null) return ofMaps;
  await new Promise((resolve) => setTimeout(resolve, 120));
  if (path.endsWith('/plan/compare')) {
    const same: PlanComparison = { mission: { hash: verified.hash, changes: [] }, fence: null, rally: null };
    return json(same);
  }
  const plans = /^\/vehicles\/\d+\/plan\/(\w+)(\/read)?$/.exec(path);
  if (plans && method === 'GET') return json({ state: planStates()[plans[1] as PlanKind], plan });
  if (plans) return json(begin(KINDS[method] ?? 'clear_mission', method === 'POST' ? plan : undefined), 202);
  const operation = /^\/operations\/(\d+)$/.exec(path);
  if (operation) return json(operations.get(Number(operation[1])) ?? {});
  if (path === '/session' && scene === 'token') return json({ title: 'Token needed', status: 401, detail: '' }, 401);
  if (path === '/session') return json(session);
  if (path === '/links') return json([link()]);
  if (path === '/serial-ports') return json([]);
  if (path === '/plan/check') return json([]);
  if (path === '/plan/way') return json(way((JSON.parse(body) as { plan: Plan }).plan.items.length));
  if (path.startsWith('/control/')) return json(session);
  if (/^\/vehicles\/\d+\/texts$/.test(path)) return json(texts);
  if (/^\/vehicles\/\d+$/.test(path)) {
    const { groups, progress } = toldAt(time_s(), { isArmed });
    const state: Partial<VehicleState> = {
      time_s: time_s(),
      telemetry: groups,
      progress,
      plan_states: planStates(),
      mode_names: ['MANUAL', 'FBWA', 'FBWB', 'CRUISE', 'AUTO', 'RTL', 'LOITER', 'GUIDED', 'TAKEOFF', 'CIRCLE'],
    };
    return json({ ...summary(Number(path.split('/')[2])), ...state });
  }
  if (path.endsWith('/arm')) {
    if (scene === 'refused') return refusal();
    if (scene === 'mixed' && query !== '?despite_mixed_plan=true') return heldBack();
    isArmed = true;
  }
  if (path.endsWith('/disarm')) isArmed = false;
  // commands
  if (method !== 'POST' || !/^\/vehicles\/\d+\/[\w/-]+$/.test(path)) return notHere();
  await new Promise((resolve) => setTimeout(resolve, 400));
  return json({});
}

const sockets = new Set<MockSocket>();
const say = (message: ServerMessage) => sockets.forEach((socket) => socket.say(message));

class MockSocket {
  readyState = 0;
  onopen: (() => void) | null = null;
  onmessage: ((event: { data: string }) => void) | null = null;
  onclose: (() => void) | null = null;
  #timers: ReturnType<typeof setInterval>[] = [];
  #rates = new Map<number, ReturnType<typeof setInterval>>();

  constructor() {
    if (scene === 'away') {
      setTimeout(() => this.#greet(), 50);
      setTimeout(() => (this.close(), this.onclose?.()), 4000);
      if (performance.now() - start_ms > 3000) this.#timers.push(setTimeout(() => this.onclose?.(), 100));
      return;
    }
    setTimeout(() => this.#greet(), 50);
  }

  #greet() {
    if (scene === 'away' && performance.now() - start_ms > 3000) return;
    this.readyState = 1;
    sockets.add(this);
    this.onopen?.();
    this.say({ type: 'hello', version: PAGE_VERSION, time_s: time_s(), ...session });
    const lists = () => {
      if (ids.length <= 8) this.say({ type: 'vehicles', vehicles: ids.map(summary) });
      this.say({ type: 'links', links: [link()] });
    };
    lists();
    this.#timers.push(setInterval(lists, 1000));
  }

  say(message: ServerMessage) {
    this.onmessage?.({ data: JSON.stringify(message) });
  }

  send(text: string) {
    const message = JSON.parse(text) as ClientMessage;
    if (message.type === 'assess_plan') {
      const trip = { distance_m: 6200, time_s: 280, end: 'end', is_estimate: true } as const;
      this.say({ type: 'assessment', seq: message.seq, findings: [], trip, rehearsal: null });
      return;
    }
    if (message.type === 'plan_way') {
      this.say({ type: 'way', seq: message.seq, ...way(message.plan.items.length) });
      return;
    }
    if (message.type === 'subscribe_roster') {
      const roster = () => {
        const rows = fleetIds.map((_, index) => fleetRow(index, count, time_s()));
        const followed = ids.filter((id) => this.#rates.has(id)).map(summary);
        if (count > 0) this.say({ type: 'roster', time_s: time_s(), rows, gone: [], followed });
      };
      roster();
      this.#timers.push(setInterval(roster, 1000));
    }
    if (!('vehicle' in message)) return;
    clearInterval(this.#rates.get(message.vehicle));
    if (message.type !== 'subscribe') return;
    const { vehicle, rate_hz } = message;
    const tell = () => {
      if (time_s() > lastHeard_s) return;
      this.say({
        type: 'telemetry',
        vehicle,
        time_s: time_s(),
        ...toldAt(time_s() + 40 * ((vehicle - 1) % 100), { isArmed, offset_m: 300 * ((vehicle - 1) % 100) }),
      });
    };
    this.#rates.set(vehicle, setInterval(tell, 1000 / rate_hz));
  }

  close() {
    this.readyState = 3;
    sockets.delete(this);
    for (const timer of [...this.#timers, ...this.#rates.values()]) clearInterval(timer);
  }
}

/** Replaces the network by this file. */
export function install(): void {
  const real = window.fetch.bind(window);
  window.fetch = (input, init) => {
    const { pathname, search } = new URL(input instanceof Request ? input.url : input, window.location.href);
    if (!pathname.startsWith('/api/v1')) return real(input, init);
    const body = typeof init?.body === 'string' ? init.body : '';
    return answer(init?.method ?? 'GET', pathname.slice('/api/v1'.length), search, body);
  };
  window.WebSocket = MockSocket as unknown as typeof WebSocket;
}
