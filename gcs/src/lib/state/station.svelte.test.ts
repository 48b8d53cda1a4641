import { afterEach, expect, it, vi } from 'vitest';
import type { Replay } from '$lib/api/replays';
import { PAGE_VERSION } from '$lib/api/version';
import type { VehicleState } from '$lib/api/types';
import { telemetryAt } from '../../../dev/mock/flight';
import { ownProblem, ProblemError } from '$lib/api/problem';
import { fleet } from './fleet.svelte';
import { Station, api } from './station.svelte';
import { vehicles } from './vehicles.svelte';

const { groups, progress } = telemetryAt(100);
const unknown = { state: 'unknown', count: null, hash: null, may_be_mixed: false, detail: '' } as const;
const mixed = { ...unknown, may_be_mixed: true };

afterEach(() => {
  vi.restoreAllMocks();
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

it('does not lose what is told while it asks for the whole state', async () => {
  vi.useFakeTimers();
  vi.stubGlobal('document', { hidden: true });
  const NOT_READ = { loiter_radius_m: null, airspeed_m_s: null, finds_landing: null };
  const summary = {
    system_id: 9,
    age_s: 0,
    link: 1,
    loss_pct: 0,
    round_trip_ms: 1,
    is_reached: true,
    rival: null,
    silence: null,
    remote_name: null,
    is_recorded: false,
    replay: null,
    lacks_terrain: false,
    flight_parameters: NOT_READ,
  };
  const state = {
    telemetry: { heartbeat: groups.heartbeat, wind: groups.wind },
    progress,
    plan_states: { mission: unknown, fence: unknown, rally: unknown },
    mode_names: [],
    flies_arcs: false,
    time_s: 10,
  } as unknown as VehicleState;
  let answer!: (state: VehicleState) => void;
  vi.spyOn(api, 'vehicle').mockReturnValue(new Promise((resolve) => (answer = resolve)));
  vi.spyOn(api, 'texts').mockResolvedValue([
    { time_s: 8, unix_s: null, severity: 6, text: 'before' },
    { time_s: 9, unix_s: null, severity: 6, text: 'in both' },
  ]);
  const station = new Station();
  station.receive({ type: 'vehicles', vehicles: [summary] } as unknown as Parameters<Station['receive']>[0]);
  const vehicle = vehicles.ensure(9);
  const heartbeat = { ...groups.heartbeat!, mode: 'RTL' };
  for (const [time_s, text] of [
    [9, 'in both'],
    [11, 'afterwards'],
  ] as const)
    station.receive({ type: 'text', vehicle: 9, time_s, unix_s: null, severity: 4, text });
  station.receive({ type: 'plan_state', vehicle: 9, kind: 'mission', state: mixed });
  station.receive({ type: 'telemetry', vehicle: 9, time_s: 11, groups: { heartbeat } });
  answer(state);
  await vi.advanceTimersByTimeAsync(1000);
  expect(vehicle.texts.map(({ text }) => text)).toEqual(['before', 'in both', 'afterwards']);
  expect(vehicle.planStates).toMatchObject({ mission: mixed, fence: unknown });
  expect(vehicle.mode).toBe('RTL');
});

it('gives the answer to the last question about a plan, and none that never comes', async () => {
  vi.stubGlobal('document', { hidden: true });
  const station = new Station();
  const draft = { items: [], home: null, fence: { zones: [], return_point: null }, rally: [] };
  const wind = { from_deg: 90, speed_m_s: 5 };
  await expect(station.assess(draft, 9, wind, 30)).rejects.toThrow('no connection');
  station.socketState = 'open';
  const first = station.assess(draft, 9, wind, 30);
  const second = station.assess(draft, undefined, wind, 30);
  await expect(first).rejects.toThrow('another question');
  const trip = { distance_m: 1, time_s: 2, end: 'end', is_estimate: false } as const;
  station.receive({ type: 'assessment', seq: 2, findings: [], trip, rehearsal: null });
  station.receive({ type: 'assessment', seq: 3, findings: [], trip: { ...trip, distance_m: 3 }, rehearsal: null });
  await expect(second).resolves.toMatchObject({ trip: { distance_m: 3 } });
  const third = station.assess(draft, 9, wind, 30);
  vi.spyOn(console, 'error').mockReturnValue();
  station.receive({ type: 'error', detail: 'no plan', cause: { code: 'invalid' }, seq: 4 } as never);
  await expect(third).rejects.toThrow('no plan');
  // a way waits for no assessment, and ends none
  const [assessed, way] = [station.assess(draft, 9, wind, 30), station.way(draft, 9, 30)];
  const profile = { points: [], loiters: [], length_m: 0, ground: null };
  const end = { item: 1, designed_item: null };
  station.receive({ type: 'way', seq: 6, stops: [], jumps: [], end, profile, is_ground_pending: false });
  await expect(way).resolves.toMatchObject({ stops: [] });
  station.receive({ type: 'assessment', seq: 5, findings: [], trip, rehearsal: null });
  await expect(assessed).resolves.toMatchObject({ trip });
});

it('follows all of a few, and of many those that were chosen', () => {
  vi.stubGlobal('document', { hidden: true });
  vi.spyOn(api, 'vehicle').mockReturnValue(new Promise(() => undefined));
  vi.spyOn(api, 'texts').mockReturnValue(new Promise(() => undefined));
  for (const { systemId } of vehicles.all) vehicles.drop(systemId);
  const station = new Station();
  const rows = (from: number, to: number) => Array.from({ length: to - from }, (_, n) => ({ id: from + n }));
  const roster = (some: readonly { id: number }[], gone: number[] = []) =>
    station.receive({ type: 'roster', time_s: 1, rows: some, gone, followed: [] } as never);
  const followed = () => vehicles.all.map(({ systemId }) => systemId);
  roster(rows(300, 303));
  expect(followed()).toEqual([300, 301, 302]);
  roster(rows(303, 340));
  expect(followed()).toEqual([300]);
  station.choose(320);
  expect([followed(), vehicles.selected?.systemId]).toEqual([[300, 320], 320]);
  for (let id = 321; id < 335; id += 1) station.choose(id);
  expect(followed()).toEqual([327, 328, 329, 330, 331, 332, 333, 334]);
});

it('counts recordings apart from live vehicles, and forgets those closed while the connection was away', async () => {
  vi.stubGlobal('document', { hidden: true });
  vi.spyOn(api, 'vehicle').mockReturnValue(new Promise(() => undefined));
  vi.spyOn(api, 'texts').mockReturnValue(new Promise(() => undefined));
  for (const { systemId } of vehicles.all) vehicles.drop(systemId);
  fleet.begin();
  const station = new Station();
  const live = Array.from({ length: 8 }, (_, n) => ({ id: 1 + n }));
  const roster = (rows: readonly { id: number; is_recorded?: boolean }[]) =>
    station.receive({ type: 'roster', time_s: 1, rows, gone: [], followed: [] } as never);
  const followed = () => vehicles.all.map(({ systemId }) => systemId);
  roster(live);
  station.choose(7);
  roster([{ id: 43_172, is_recorded: true }]);
  station.choose(43_172);
  expect([vehicles.selected?.isRecorded, followed()]).toEqual([true, [1, 2, 3, 4, 5, 6, 7, 8, 43_172]]);
  roster([{ id: 9 }]);
  expect(followed(), 'the one flown before stays').toEqual([1, 7, 43_172]);
  // the socket comes back, and the recording is not in the whole roster
  const sockets: { onopen?: () => void; send: () => void; close: () => void }[] = [];
  vi.stubGlobal('document', { hidden: true, addEventListener: vi.fn() });
  const location = { hash: '', search: '', protocol: 'http:', host: 'station' };
  vi.stubGlobal('window', { addEventListener: vi.fn(), setTimeout: vi.fn(), clearTimeout: vi.fn(), location });
  vi.stubGlobal('WebSocket', function () {
    sockets.push({ send: vi.fn(), close: vi.fn() });
    return sockets.at(-1);
  });
  vi.spyOn(api, 'openSession').mockResolvedValue({} as never);
  station.start();
  await vi.waitFor(() => expect(sockets[0]?.onopen).toBeDefined());
  sockets[0]?.onopen?.();
  expect(vehicles.selected?.systemId).toBe(43_172);
  roster([...live, { id: 9 }]);
  expect([followed(), vehicles.selected?.systemId]).toEqual([[1, 7], 7]);
});

it('takes a replay that was opened for one before the roster tells of it', () => {
  vi.stubGlobal('document', { hidden: true });
  vi.spyOn(api, 'vehicle').mockReturnValue(new Promise(() => undefined));
  vi.spyOn(api, 'texts').mockReturnValue(new Promise(() => undefined));
  const station = new Station();
  station.beginReplay({ id: 1, vehicles: [43_172], position_s: 12, seeks: 1 } as Replay);
  station.choose(43_172);
  const vehicle = vehicles.selected;
  expect([vehicle?.systemId, vehicle?.replay?.is.position_s, station.barOf(vehicle)]).toEqual([
    43_172,
    12,
    'recording',
  ]);
  vehicles.drop(43_172);
});

it('sends a refused token once, and one that has to wait again until it is taken', async () => {
  vi.useFakeTimers();
  const on = { addEventListener: vi.fn() };
  vi.stubGlobal('document', { hidden: true, ...on });
  const [setTimeout, clearTimeout] = [globalThis.setTimeout, globalThis.clearTimeout];
  vi.stubGlobal('window', {
    ...on,
    setTimeout,
    clearTimeout,
    location: { hash: '#token=wrong', search: '' },
    history: { replaceState: vi.fn() },
  });
  const asked: unknown[] = [];
  const refuse = (status: number, cause: object) =>
    new ProblemError({ ...ownProblem('', status), cause: cause as never });
  const answers = [
    refuse(401, { code: 'bad-token' }),
    refuse(429, { code: 'tokens-slowed', wait_s: 9 }),
    refuse(429, { code: 'tokens-slowed', wait_s: 8 }),
    new ProblemError(ownProblem('', 503)),
  ];
  vi.spyOn(api, 'openSession').mockImplementation(({ token }) => {
    asked.push(token);
    return Promise.reject(answers.shift() ?? new Promise(() => undefined));
  });
  const station = new Station();
  station.start();
  await vi.advanceTimersByTimeAsync(60_000);
  expect([asked, station.sessionProblem?.cause?.code]).toEqual([['wrong'], 'bad-token']);
  station.useToken(' right ');
  await vi.advanceTimersByTimeAsync(0);
  expect(station.sessionProblem?.cause).toMatchObject({ wait_s: 9 });
  await vi.advanceTimersByTimeAsync(300);
  expect([asked, station.sessionProblem?.cause]).toMatchObject([['wrong', 'right', 'right'], { wait_s: 8 }]);
  await vi.advanceTimersByTimeAsync(1000);
  expect(station.sessionProblem).toBeNull();
});

it('tells that the server is of another version than the page', () => {
  const station = new Station();
  const told = [PAGE_VERSION, '0.0.9', '0.0.9', PAGE_VERSION].map((version) => {
    const session = { session: 's2', name: 'Luis', role: 'operator', has_control: false, holder: null };
    station.receive({ type: 'hello', version, time_s: 0, ...session, requested_by: null } as never);
    return station.isUpdated;
  });
  expect(told).toEqual([false, true, true, false]);
});

it('follows what becomes of its request for control', () => {
  const station = new Station();
  const told: string[] = [];
  const tell = (
    type: 'hello' | 'control',
    requested_by: string | null,
    holder: string | null = 'Ana',
    has_control = false,
  ) => {
    const session = { session: 's2', name: 'Luis', role: 'operator' };
    station.receive({ type, version: '1', time_s: 0, ...session, has_control, holder, requested_by } as never);
    told.push(station.controlRequest);
  };
  tell('hello', null);
  tell('control', 'Eva');
  tell('control', 'Luis');
  tell('control', null);
  tell('control', null);
  tell('control', 'Luis');
  tell('control', null, 'Luis', true);
  tell('control', null);
  tell('hello', 'Luis');
  tell('hello', null);
  expect(told.join(' ')).toBe('none none waiting declined declined waiting none none waiting none');
});
