import { beforeEach, describe, expect, it, vi } from 'vitest';
import { ProblemError } from '$lib/api/problem';
import type { Operation, Parameter, ServerMessage } from '$lib/api/types';
import { paramFiles } from './param-files.svelte';
import { params, type VehicleParams } from './params.svelte';
import { api, station } from './station.svelte';
import { vehicles } from './vehicles.svelte';

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
  const reading = table.read();
  await vi.waitFor(() => expect(readParams).toHaveBeenCalled());
  const [started] = await Promise.all(readParams.mock.results.map(({ value }) => value as Promise<Operation>));
  say({ type: 'operation', ...started!, state: 'done', done: 3 });
  expect(await reading).toBe(true);
});

const say = (message: unknown) => station.receive(message as ServerMessage);

describe('parameters', () => {
  it('are read once, and again only when changes may have been missed', () => {
    expect([table.isWhole, table.isOld, table.byName.size, table.hasDefaults]).toEqual([true, false, 3, true]);
    say({ type: 'event', vehicle: table.systemId, kind: 'rebooted', detail: {}, time_s: 1 });
    expect(table.isOld).toBe(true);
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
    expect(paramFiles.written).toEqual({ set: 1, refused: 0 });
    expect(paramFiles.comparison?.differing.map(({ name }) => name)).toEqual(['WP_RADIUS']);
  });

  it('is written on after a refusal of one value, and not after one that concerns all', async () => {
    await paramFiles.open(file('WP_RADIUS,60\nFENCE_ENABLE,1\nRTL_AUTOLAND,1'));
    setParam.mockRejectedValueOnce(refusal('param-refused'));
    await paramFiles.write();
    expect(paramFiles.written).toEqual({ set: 2, refused: 1 });
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
    expect(paramFiles.writing).toEqual({ done: 0, total: 3 });
    paramFiles.stop();
    await writing;
    expect([setParam.mock.calls.length, paramFiles.writing]).toEqual([1, null]);
  });

  it('belongs to the vehicle that it was opened for', async () => {
    await paramFiles.open(file('WP_RADIUS,60'));
    vehicles.select(vehicles.ensure(19).systemId);
    expect([paramFiles.opened, paramFiles.comparison]).toEqual([null, null]);
  });
});
