import { beforeEach, describe, expect, it, vi } from 'vitest';
import { ProblemError } from '$lib/api/problem';
import type { Operation, Parameter, ServerMessage } from '$lib/api/types';
import { paramFiles } from './param-files.svelte';
import { params, type VehicleParams } from './params.svelte';
import { showParam } from './show-param';
import { api, operations, station } from './station.svelte';
import { vehicles } from './vehicles.svelte';
import { telemetryAt } from '../../../dev/mock/flight';

const param = (name: string, value: number, kind = 'real32', usual: number | null = null): Parameter => ({
  name,
  value,
  kind,
  default: usual,
});
const LIST = [
  param('WP_RADIUS', 90, 'real32', 90),
  param('FENCE_ENABLE', 0, 'int8', 0),
  param('RTL_AUTOLAND', 2, 'int8', 0),
];
const read: Operation = { id: 7, vehicle: 1, kind: 'read_params', state: 'running', done: 0, total: 3 };
const refusal = (code: string, status = 409, more = {}) =>
  new ProblemError({ type: '', title: '', status, detail: code, cause: { code, ...more } } as never);

let vehicleHas: Map<string, Parameter>;
let nextId = 1;
let table: VehicleParams;

const setParam = vi.fn((_id: number, name: string, value: number, _acts: readonly string[] = []) => {
  const had = vehicleHas.get(name);
  if (had === undefined) return Promise.reject(refusal('unknown-param', 404, { name, told: true }));
  const set = { ...had, value, default: null };
  vehicleHas.set(name, set);
  return Promise.resolve(set);
});
const readParams = vi.fn((vehicle: number) => Promise.resolve({ ...read, id: 100 + nextId++, vehicle }));

beforeEach(async () => {
  vehicleHas = new Map(LIST.map((one) => [one.name, one]));
  setParam.mockClear();
  readParams.mockClear();
  Object.assign(api, {
    readParams,
    setParam,
    operation: (id: number) => Promise.resolve({ ...read, id, state: 'done', result: [...vehicleHas.values()] }),
    parseParams: async (file: Blob) =>
      (await file.text()).split('\n').map((line) => ({ name: line.split(',')[0], value: Number(line.split(',')[1]) })),
  });
  // a vehicle of its own for each test
  const id = 20 + nextId++;
  vehicles.ensure(id);
  vehicles.select(id);
  table = params.of(id);
  await reads();
});

const say = (message: unknown) => station.receive(message as ServerMessage);

/** Reads all; `meanwhile` happens before the vehicle's list is there. */
async function reads(meanwhile: () => Promise<unknown> | void = () => undefined): Promise<void> {
  const before = readParams.mock.results.length;
  const reading = table.read();
  await vi.waitFor(() => expect(readParams.mock.results.length).toBe(before + 1));
  const started = (await readParams.mock.results.at(-1)?.value) as Operation;
  await meanwhile();
  say({ type: 'operation', ...started, state: 'done', done: 3 });
  expect(await reading).toBe(true);
}

function arm(isArmed: boolean, systemId = table.systemId): void {
  const heartbeat = { ...telemetryAt(100).groups.heartbeat!, is_armed: isArmed };
  vehicles.ensure(systemId).apply({ groups: { heartbeat }, progress: null, heardAt_ms: {} });
}

describe('parameters', () => {
  it('are read once, and again only when changes may have been missed', () => {
    expect([table.isWhole, table.isOld, table.byName.size, table.hasDefaults]).toEqual([true, false, 3, true]);
    say({ type: 'event', vehicle: table.systemId, kind: 'rebooted', detail: {}, time_s: 1 });
    expect(table.isOld).toBe(true);
  });

  it('are not read without being asked while armed, and after a gap in the connection of the page', () => {
    const hello = { type: 'hello', version: '1', time_s: 0, session: 's', name: 'Ana', role: 'operator' };
    const gap = () => say({ ...hello, has_control: true, holder: 'Ana', requested_by: null });
    station.socketState = 'open';
    const other = params.of(vehicles.ensure(70 + table.systemId).systemId);
    arm(false, other.systemId);
    gap();
    expect([table.isOld, table.isDue, other.isDue]).toEqual([true, false, true]);
    arm(false);
    expect(table.isDue, 'what the vehicle changed was told to the station').toBe(false);
    say({ type: 'event', vehicle: table.systemId, kind: 'rebooted', detail: {}, time_s: 1 });
    expect(table.isDue).toBe(true);
    arm(true);
    arm(true, other.systemId);
    expect([table.isDue, other.isDue]).toEqual([false, false]);
    vehicles.drop(other.systemId);
  });

  it('that nobody asked for make room for a plan; those that a person reads do not', async () => {
    const cancelled: unknown[] = [];
    Object.assign(api, {
      cancelOperation: (id: number) => {
        cancelled.push(id);
        say({ type: 'operation', ...read, id, vehicle: table.systemId, state: 'cancelled' });
        return Promise.resolve();
      },
    });
    await reads(() => table.makeRoom(() => Promise.resolve()));
    expect(cancelled).toEqual([]);
    table.readUnasked();
    await vi.waitFor(() => expect(operations.running.some(({ vehicle }) => vehicle === table.systemId)).toBe(true));
    station.socketState = 'open';
    arm(false);
    say({ type: 'event', vehicle: table.systemId, kind: 'rebooted', detail: {}, time_s: 1 });
    await table.makeRoom(() => {
      expect([cancelled.length, table.isReading, table.isDue]).toEqual([1, false, false]);
      return Promise.resolve();
    });
    expect([table.isStopped, table.problem, table.isDue], 'it is read again').toEqual([false, null, true]);
    say({ type: 'operation', ...read, id: 999, vehicle: table.systemId, state: 'running' });
    expect(table.isDue, 'a transfer is under way').toBe(false);
    say({ type: 'operation', ...read, id: 999, vehicle: table.systemId, state: 'done' });
    table.readUnasked();
    await vi.waitFor(() => expect(operations.running.some(({ vehicle }) => vehicle === table.systemId)).toBe(true));
    arm(true);
    params.receive({ type: 'telemetry', vehicle: table.systemId, time_s: 2, groups: {} } as ServerMessage);
    await vi.waitFor(() => expect(table.isReading).toBe(false));
    expect([cancelled.length, table.isReading, table.isStopped]).toEqual([2, false, false]);
  });

  it('that were set or told while the list was read are newer than it', async () => {
    const old = [...vehicleHas.values()];
    await reads(async () => {
      await table.set('FENCE_ENABLE', 1);
      say({ type: 'param', vehicle: table.systemId, param: param('WP_RADIUS', 60) });
      vehicleHas = new Map(old.map((one) => [one.name, one]));
    });
    expect([table.get('FENCE_ENABLE'), table.get('WP_RADIUS')]).toEqual([
      param('FENCE_ENABLE', 1, 'int8', 0),
      param('WP_RADIUS', 60, 'real32', 90),
    ]);
    expect(table.answers.get('FENCE_ENABLE')).toMatchObject({ state: 'set', value: 1 });
    // another page's list as well
    const theirs = { type: 'operation', ...read, vehicle: table.systemId, id: 902 };
    say({ ...theirs, state: 'running' });
    say({ type: 'param', vehicle: table.systemId, param: param('WP_RADIUS', 55) });
    say({ ...theirs, state: 'running', done: 2 });
    say({ ...theirs, state: 'done' });
    await vi.waitFor(() => expect(table.get('FENCE_ENABLE')?.value).toBe(0));
    expect(table.get('WP_RADIUS')?.value).toBe(55);
    expect(table.answers.has('FENCE_ENABLE'), 'it is not set to 1 any more').toBe(false);
  });

  it('are taken over when another page has read them, unless that was before this page came', async () => {
    vehicleHas.set('WP_RADIUS', param('WP_RADIUS', 60));
    const other = { type: 'operation', ...read, vehicle: table.systemId };
    say({ ...other, id: 900, state: 'done' });
    say({ ...other, id: 901, state: 'running' });
    expect(table.get('WP_RADIUS')?.value).toBe(90);
    say({ ...other, id: 901, state: 'done' });
    await vi.waitFor(() => expect(table.get('WP_RADIUS')?.value).toBe(60));
  });

  it('are set as they were typed, and the edit ends when the vehicle has the value', async () => {
    table.begin('RTL_AUTOLAND');
    expect(table.edit?.text).toBe('2');
    table.edit!.text = '1.5';
    await table.send();
    expect(setParam).not.toHaveBeenCalled();
    table.edit!.text = '1';
    await table.send();
    expect(setParam).toHaveBeenCalledWith(table.systemId, 'RTL_AUTOLAND', 1, []);
    expect([table.edit, table.answers.get('RTL_AUTOLAND')]).toEqual([null, { state: 'set', value: 1, was: 2 }]);
    expect(table.get('RTL_AUTOLAND'), 'its default is kept').toEqual(param('RTL_AUTOLAND', 1, 'int8', 0));
  });

  it('that were refused stay open with the reason; the value that the vehicle keeps is shown', async () => {
    setParam.mockRejectedValueOnce(refusal('param-not-kept', 409, { name: 'WP_RADIUS', asked: 2, kept: 30 }));
    table.begin('WP_RADIUS');
    table.edit!.text = '2';
    await table.send();
    expect(table.edit?.name).toBe('WP_RADIUS');
    expect(table.answers.get('WP_RADIUS')).toMatchObject({ state: 'refused', value: 2 });
    expect(table.get('WP_RADIUS')).toEqual(param('WP_RADIUS', 30, 'real32', 90));
  });

  it('that are named elsewhere are opened, once they are known, and take nothing that is being typed', async () => {
    await paramFiles.open(new File(['WP_RADIUS,60'], 'plane.param'));
    showParam('WP_RADIUS');
    expect([paramFiles.opened, table.edit?.name]).toEqual([null, 'WP_RADIUS']);
    showParam('FENCE_ENABLE');
    expect(table.edit?.name).toBe('FENCE_ENABLE');
    table.edit!.text = '1';
    showParam('WP_RADIUS');
    expect([table.edit, params.search]).toMatchObject([{ name: 'FENCE_ENABLE', text: '1' }, 'WP_RADIUS']);
    const unread = params.of(vehicles.ensure(500 + table.systemId).systemId);
    vehicles.select(unread.systemId);
    showParam('WP_RADIUS');
    expect(unread.edit).toBeNull();
    table = unread;
    await reads();
    expect(unread.edit?.name).toBe('WP_RADIUS');
  });

  it('that somebody else sets are told, and what is being typed stays', async () => {
    table.begin('WP_RADIUS');
    table.edit!.text = '7';
    const told = (value: number) => say({ type: 'param', vehicle: table.systemId, param: param('WP_RADIUS', value) });
    told(55);
    expect([table.edit?.text, table.edit?.told, table.get('WP_RADIUS')?.value]).toEqual(['7', 55, 55]);
    table.leave();
    table.begin('WP_RADIUS');
    table.edit!.text = '8';
    const sent = table.send();
    told(8);
    await sent;
    expect(table.answers.get('WP_RADIUS'), 'our own is no news').toEqual({ state: 'set', value: 8, was: 55 });
    told(9);
    expect(table.answers.get('WP_RADIUS'), 'the answer is out of date').toBeUndefined();
  });
});

describe('a file', () => {
  const file = (text: string) => new File([text], 'plane.param');

  it('is compared, and what is chosen is written in order; what is set leaves the list', async () => {
    await paramFiles.open(file('WP_RADIUS,60\nFENCE_ENABLE,0\nRTL_AUTOLAND,1\nOTHER_NAME,5'));
    expect(paramFiles.comparison).toMatchObject({ equal: 1, unknown: ['OTHER_NAME'] });
    expect(paramFiles.chosen.map(({ name }) => name)).toEqual(['RTL_AUTOLAND', 'WP_RADIUS']);
    paramFiles.choose('WP_RADIUS', false);
    await paramFiles.write();
    expect(setParam.mock.calls.map(([, name]) => name)).toEqual(['RTL_AUTOLAND']);
    expect(paramFiles.written).toMatchObject({ set: 1, refused: 0, unheld: 0 });
    expect(paramFiles.comparison?.differing.map(({ name }) => name)).toEqual(['WP_RADIUS']);
  });

  it('is written on after a refusal of one value, and not after one that concerns all', async () => {
    await paramFiles.open(file('WP_RADIUS,60\nFENCE_ENABLE,1\nRTL_AUTOLAND,1'));
    setParam.mockRejectedValueOnce(refusal('param-refused'));
    await paramFiles.write();
    expect(paramFiles.written).toMatchObject({ set: 2, refused: 1 });
    expect(paramFiles.comparison?.differing.map(({ name }) => name)).toEqual(['FENCE_ENABLE']);
    expect(table.answers.get('FENCE_ENABLE')).toMatchObject({ state: 'refused' });

    await paramFiles.open(file('WP_RADIUS,61\nFENCE_ENABLE,1'));
    setParam.mockClear();
    setParam.mockRejectedValueOnce(refusal('no-control', 423));
    await paramFiles.write();
    expect(setParam).toHaveBeenCalledTimes(1);
    expect(paramFiles.problem).toMatchObject({ status: 423 });
  });

  it('is stopped between two parameters', async () => {
    await paramFiles.open(file('WP_RADIUS,60\nFENCE_ENABLE,1\nRTL_AUTOLAND,1'));
    const writing = paramFiles.write();
    expect(paramFiles.writing).toMatchObject({ done: 0, total: 3 });
    paramFiles.stop();
    await writing;
    expect([setParam.mock.calls.length, paramFiles.writing]).toEqual([1, null]);
  });

  it('is written no further once the vehicle is armed, unless it was armed when that was confirmed', async () => {
    arm(false);
    await paramFiles.open(file('WP_RADIUS,60\nFENCE_ENABLE,1\nRTL_AUTOLAND,1'));
    const writing = paramFiles.write();
    arm(true);
    await writing;
    expect(setParam).toHaveBeenCalledTimes(1);
    expect(paramFiles.written).toMatchObject({ set: 1, refused: 0, unheld: 2 });
    await paramFiles.write();
    expect(paramFiles.written).toMatchObject({ set: 2, refused: 0, unheld: 0 });
  });

  it('is told of while another vehicle is selected, and keeps what became of it to its own', async () => {
    await paramFiles.open(file('WP_RADIUS,60\nFENCE_ENABLE,1'));
    setParam.mockRejectedValueOnce(refusal('no-control', 423));
    const writing = paramFiles.write();
    const other = vehicles.ensure(19);
    vehicles.select(other.systemId);
    expect(paramFiles.elsewhere).toMatchObject({ of: table, file: 'plane.param', done: 0, total: 2 });
    await paramFiles.open(file('WP_RADIUS,61'));
    expect(paramFiles.opened, 'one file at a time').toBeNull();
    await writing;
    expect(paramFiles.elsewhere).toMatchObject({ of: table, problem: { status: 423 } });
    expect([paramFiles.problem, paramFiles.written]).toEqual([null, null]);
    showParam('WP_RADIUS');
    expect(paramFiles.elsewhere, 'what is done with this one does not put it away').toMatchObject({ of: table });
    vehicles.select(table.systemId);
    expect([paramFiles.elsewhere, paramFiles.problem]).toMatchObject([null, { status: 423 }]);
  });

  it('belongs to the vehicle that it was opened for', async () => {
    await paramFiles.open(file('WP_RADIUS,60'));
    vehicles.select(vehicles.ensure(19).systemId);
    expect([paramFiles.opened, paramFiles.comparison]).toEqual([null, null]);
  });
});
