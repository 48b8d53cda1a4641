import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { LandingMove, LandingRequest, Plan, PlanComparison, PlanState, PlanWind, Rehearsal } from '$lib/api/types';
import type { LonLat } from '$lib/domain/lonlat';
import { makeItem } from '$lib/domain/plan';
import { api, station } from './station.svelte';
import { plan } from './plan.svelte';
import { planAssessed } from './plan-assessed.svelte';
import { planCompared } from './plan-compared.svelte';
import { planGestures } from './plan-gestures.svelte';
import { planLanding } from './plan-landing.svelte';
import { planTransfers } from './plan-transfers.svelte';
import { planWind } from './plan-wind.svelte';
import { vehicles } from './vehicles.svelte';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 690 };
const AT = { lat_deg: 40.336, lon_deg: -3.7978 };
const NEVER_READ: PlanState = {
  state: 'unknown',
  count: null,
  hash: null,
  may_be_mixed: false,
  detail: 'unknown: never read',
};

const landingAt = (at: LonLat | null) => ({
  items: [makeItem('loiter_to_height', { at, alt_m: 40 }), makeItem('land', { at, alt_m: 0 })],
});

/** A server whose vehicle keeps what it is sent, and is read by it. */
function serve() {
  let onBoard: Plan = { items: [], home: HOME, fence: { zones: [], return_point: null }, rally: [] };
  let hash = 0;
  /** What is reported of its mission instead, until it is read again. */
  let uncertain: PlanState | null = null;
  const answer = <T>(value: T) => Promise.resolve(value);
  const done = (result: Plan) => answer({ id: 1, kind: 'plan', state: 'done' as const, done: 1, total: 1, result });
  const state = (): PlanState =>
    uncertain ??
    (onBoard.items.length === 0
      ? { state: 'empty', count: 0, hash: null, may_be_mixed: false, detail: 'empty' }
      : {
          state: 'verified',
          count: onBoard.items.length,
          hash: String(hash),
          may_be_mixed: false,
          detail: 'verified',
        });
  const spies = {
    send: vi.fn((_id: number, _kind: string, sent: Plan) => {
      onBoard = structuredClone(sent);
      hash += 1;
      return done(onBoard);
    }),
    read: vi.fn((_id: number, _kind: string) => {
      uncertain = null;
      return done(onBoard);
    }),
    known: vi.fn((_id: number, _kind: string) =>
      answer({ state: state(), plan: uncertain === null ? structuredClone(onBoard) : null }),
    ),
    /** By what is the same to the letter. */
    compare: vi.fn((_id: number, draft: Plan): Promise<PlanComparison> => {
      const isSame = JSON.stringify(draft.items) === JSON.stringify(onBoard.items);
      const changes = isSame ? [] : [{ kind: 'changed' as const, item: 1, on_board: 1, fields: ['height' as const] }];
      return answer({ mission: { hash: state().hash, changes }, fence: null, rally: null });
    }),
    /** A circle down, and the landing. */
    design: vi.fn(({ at = null }: LandingRequest) => answer(landingAt(at))),
    /** The whole landing at the place that a part of it was moved to. */
    move: vi.fn(({ to }: LandingMove) => answer(landingAt(to))),
    clear: vi.fn(() => {
      onBoard = { ...onBoard, items: [] };
      return done(onBoard);
    }),
  };
  station.assess = () => answer({ findings: [], trip: null, rehearsal: null });
  Object.assign(api, {
    sendPlan: spies.send,
    readPlan: spies.read,
    planOnBoard: spies.known,
    comparePlan: spies.compare,
    clearPlan: spies.clear,
    designLanding: spies.design,
    moveLanding: spies.move,
  });
  const byOthers = (items: Plan['items'], told: PlanState | null = null) => {
    onBoard = { ...onBoard, items };
    hash += 1;
    uncertain = told;
    vehicles.ensure(1).applyPlanState('mission', state());
  };
  return { ...spies, byOthers };
}

describe('the plan store', () => {
  let server: ReturnType<typeof serve>;

  beforeEach(() => {
    vi.useFakeTimers();
    server = serve();
    vehicles.ensure(1).applyPlanState('mission', NEVER_READ);
    vehicles.select(1);
    plan.clear();
    plan.problem = null;
    station.socketState = 'open';
  });
  /** As the page does when anything has changed. */
  const compared = async () => {
    planCompared.compare();
    await vi.advanceTimersByTimeAsync(100);
  };
  afterEach(() => vi.useRealTimers());

  it('says verified only after the vehicle has it, and differs after the next edit', async () => {
    planGestures.add('waypoint', AT);
    expect(planCompared.state).toBe('unknown');
    await planTransfers.send();
    expect(planTransfers.problem).toBeNull();
    expect(server.send).toHaveBeenCalledOnce();
    expect(planCompared.state).toBe('uncompared');
    await compared();
    expect(planCompared.state).toBe('verified');
    plan.setAlt(new Set(plan.items.map((item) => item.key)), 123);
    expect(planCompared.state).toBe('uncompared');
    await compared();
    expect(planCompared.state).toBe('differs');
    expect(planCompared.difference).toMatchObject([
      { change: { kind: 'changed', item: 1 }, was: { params: { 6: 80 } } },
    ]);
    expect(planCompared.difference[0]?.item?.params[6]).toBe(123);
    plan.undo();
    await compared();
    expect(planCompared.state).toBe('verified');
    expect(server.compare.mock.lastCall?.[1].items[0]).not.toHaveProperty('key');
  });

  it('takes nothing for known that another station may have changed', async () => {
    planGestures.add('waypoint', AT);
    await planTransfers.send();
    vehicles.ensure(1).applyPlanState('mission', {
      state: 'verified',
      count: 3,
      hash: 'another',
      may_be_mixed: false,
      detail: 'verified: another',
    });
    expect(planCompared.state).toBe('unknown');
    expect(planCompared.vehiclePlan).toBeNull();
  });

  it('takes over what another station loaded, asks the vehicle nothing, and leaves the draft alone', async () => {
    planGestures.add('waypoint', AT);
    server.byOthers([], { ...NEVER_READ, reason: 'changed_elsewhere' });
    await planTransfers.follow();
    expect(server.known).not.toHaveBeenCalled();
    expect(planCompared.vehiclePlan).toBeNull();
    server.byOthers([makeItem('takeoff', { at: AT, alt_m: 50 }), makeItem('return_to_launch')]);
    await planTransfers.follow();
    await planTransfers.follow();
    expect(server.known.mock.calls).toEqual([[1, 'mission']]);
    expect(server.read).not.toHaveBeenCalled();
    expect(planCompared.vehiclePlan?.items).toHaveLength(2);
    expect(plan.items).toHaveLength(1);
    await compared();
    expect(planCompared.state).toBe('differs');
  });

  it('follows what others load, until somebody touches it', async () => {
    const whole = [
      makeItem('takeoff', { at: AT, alt_m: 50 }),
      makeItem('waypoint', { at: AT }),
      makeItem('return_to_launch'),
    ];
    while (plan.canUndo) plan.undo();
    server.byOthers(whole.slice(0, 1));
    await planTransfers.follow();
    expect(plan.items).toHaveLength(1);
    server.byOthers(whole.slice(0, 2));
    await planTransfers.follow();
    expect(plan.items).toHaveLength(2);
    planGestures.add('waypoint', AT);
    server.byOthers(whole);
    await planTransfers.follow();
    expect(planCompared.vehiclePlan?.items).toHaveLength(3);
    plan.undo();
    expect(plan.items).toHaveLength(2);
  });

  it('does not follow others while a change of the draft is on its way', async () => {
    while (plan.canUndo) plan.undo();
    let design: (landing: ReturnType<typeof landingAt>) => void = () => undefined;
    server.design.mockImplementationOnce(() => new Promise((resolve) => (design = resolve)));
    plan.waitFor(planLanding.land(AT));
    server.byOthers([makeItem('takeoff', { at: AT, alt_m: 50 })]);
    const followed = planTransfers.follow();
    await vi.advanceTimersByTimeAsync(10);
    design(landingAt(AT));
    await followed;
    expect(plan.items.at(-1)?.command).toBe(makeItem('land', { at: AT }).command);
    expect(plan.canUndo).toBe(true);
  });

  it('asks one question about the draft at a time, and of the edits meanwhile about the last', async () => {
    const asked: number[] = [];
    const answers: ((answer: Awaited<ReturnType<typeof station.assess>>) => void)[] = [];
    station.assess = (draft) => {
      asked.push(draft.items.length);
      return new Promise((resolve) => answers.push(resolve));
    };
    for (let edit = 0; edit < 4; edit += 1) planGestures.add('waypoint', AT);
    expect(asked).toEqual([1]);
    const trip = { distance_m: 100, time_s: 5, end: 'end' as const, is_estimate: false };
    answers[0]!({ findings: [], trip, rehearsal: null });
    await vi.waitFor(() => expect(asked).toEqual([1, 4]));
    expect([planAssessed.trip, planAssessed.checkState]).toEqual([trip, 'checking']);
    answers[1]!({ findings: [], trip: { ...trip, distance_m: 400 }, rehearsal: null });
    await vi.waitFor(() => expect(planAssessed.checkState).toBe('done'));
    expect(planAssessed.trip?.distance_m).toBe(400);
    station.assess = () => Promise.reject(new Error('away'));
    planGestures.add('waypoint', AT);
    await vi.waitFor(() => expect(planAssessed.checkState).toBe('unavailable'));
    expect(planAssessed.trip).toBeNull();
  });

  it('keeps the last rehearsal until the next, marked as old when that takes long', async () => {
    const rehearsal = { duration_s: 60 } as Rehearsal;
    station.assess = () => Promise.resolve({ findings: [], trip: null, rehearsal });
    planGestures.add('waypoint', AT);
    await vi.waitFor(() => expect(planAssessed.rehearsal).toBe(rehearsal));
    let answer: ((told: Awaited<ReturnType<typeof station.assess>>) => void) | undefined;
    station.assess = () => new Promise((resolve) => (answer = resolve));
    planGestures.add('waypoint', AT);
    expect([planAssessed.rehearsal, planAssessed.isRehearsalOld]).toEqual([rehearsal, false]);
    vi.advanceTimersByTime(250);
    expect([planAssessed.rehearsal, planAssessed.isRehearsalOld]).toEqual([rehearsal, true]);
    const next = { duration_s: 80 } as Rehearsal;
    answer?.({ findings: [], trip: null, rehearsal: next });
    await vi.waitFor(() => expect(planAssessed.rehearsal).toBe(next));
    expect(planAssessed.isRehearsalOld).toBe(false);
    // rally points alone are not a flight, whatever the core makes of them
    station.assess = () => Promise.resolve({ findings: [], trip: null, rehearsal });
    plan.editAreas((areas) => ({ ...areas, rally: [{ ...AT, alt_m: 80, frame: 3 }] }));
    plan.clear('mission');
    await vi.waitFor(() => expect(planAssessed.checkState).toBe('done'));
    expect(planAssessed.rehearsal).toBeNull();
    plan.clear();
    expect(planAssessed.rehearsal).toBeNull();
  });

  it('is rehearsed in the wind that the vehicle estimates, until somebody sets one', async () => {
    const winds: PlanWind[] = [];
    station.assess = (_draft, _vehicle, wind) => {
      winds.push(wind);
      return Promise.resolve({ findings: [], trip: null, rehearsal: null });
    };
    const ask = async () => {
      winds.length = 0;
      planAssessed.assess();
      await vi.waitFor(() => expect(planAssessed.checkState).toBe('done'));
      return winds[0];
    };
    planGestures.add('waypoint', AT);
    await vi.waitFor(() => expect(planAssessed.checkState).toBe('done'));
    expect(winds).toEqual([{ from_deg: 0, speed_m_s: 0 }]);
    const wind = { age_s: 0, from_deg: 358.4, speed_m_s: 4.13, speed_z_m_s: 0 };
    vehicles.ensure(1).apply({ groups: { wind } as never, heardAt_ms: {}, progress: null });
    expect(await ask()).toEqual({ from_deg: 0, speed_m_s: 4 });
    planWind.set({ from_deg: -90, speed_m_s: 30 });
    expect(await ask()).toEqual({ from_deg: 270, speed_m_s: 20 });
    planWind.unset();
    expect(await ask()).toEqual({ from_deg: 0, speed_m_s: 4 });
    vehicles.ensure(1).apply({ groups: { wind: null } as never, heardAt_ms: {}, progress: null });
  });

  it('says which heights could not be counted from another level, until they are changed', async () => {
    planGestures.add('waypoint', AT);
    planGestures.add('waypoint', AT);
    api.countFrom = ({ plan: { items }, frame }) =>
      Promise.resolve({
        items: items.map((item) => ({ ...item, frame: frame === 'amsl' ? 0 : 10 })),
        unconverted: items.map((_, index) => ({ item: index + 1, level: 'home' as const })),
      });
    plan.setFrame(new Set(plan.items.map(({ key }) => key)), 'amsl');
    await vi.waitFor(() => expect(plan.unconverted).toEqual({ level: 'home', numbers: [1, 2] }));
    plan.setAlt(new Set([plan.items[0]!.key]), 770);
    expect(plan.unconverted?.numbers).toEqual([2]);
    plan.undo();
    plan.undo();
    expect(plan.unconverted).toBeNull();
  });

  it('reads into the draft, and undo brings the old one back', async () => {
    planGestures.add('waypoint', AT);
    server.byOthers([makeItem('takeoff', { at: AT, alt_m: 50 }), makeItem('return_to_launch')]);
    await planTransfers.read();
    expect(plan.items).toHaveLength(2);
    await compared();
    expect(planCompared.state).toBe('verified');
    plan.undo();
    expect(plan.items).toHaveLength(1);
  });

  it('sends all parts to the vehicle that was selected, whichever is selected meanwhile', async () => {
    planGestures.add('waypoint', AT);
    vehicles.ensure(2).applyPlanState('mission', NEVER_READ);
    const sending = planTransfers.send('mission', 'rally');
    vehicles.select(2);
    expect(planCompared.states.mission).not.toBe('sending');
    await sending;
    expect(server.send.mock.calls.map(([id, part]) => [id, part])).toEqual([
      [1, 'mission'],
      [1, 'rally'],
    ]);
    vehicles.select(1);
    vehicles.drop(2);
  });

  it('clears the vehicle and keeps the draft', async () => {
    planGestures.add('waypoint', AT);
    await planTransfers.send();
    await planTransfers.clear();
    expect(plan.items).toHaveLength(1);
    expect(planCompared.state).toBe('not-sent');
  });

  it('shows why a transfer failed, and knows no more than before', async () => {
    planGestures.add('waypoint', AT);
    server.send.mockRejectedValueOnce(new Error('no link'));
    await planTransfers.send();
    expect(planTransfers.problem?.detail).toBe('no link');
    vehicles.ensure(2);
    vehicles.select(2);
    expect(planTransfers.problem, 'of another vehicle').toBeNull();
    vehicles.select(1);
    planTransfers.forgetProblem();
    expect(planTransfers.problem).toBeNull();
    expect(planTransfers.transfer).toBeNull();
    expect(planCompared.state).toBe('unknown');
  });

  it('takes one drag as one step, with the selection that it is part of', () => {
    for (const metres of [0, 1, 2]) planGestures.add('waypoint', { ...AT, lat_deg: AT.lat_deg + metres / 1000 });
    plan.select([1, 2]);
    const before = plan.items.map((item) => item.params[4]);
    let from = AT;
    for (let step = 1; step <= 5; step += 1) {
      const to = { ...AT, lat_deg: AT.lat_deg + step * 1e-4 };
      planGestures.drag(1, from, to, step === 5);
      from = to;
    }
    const moved = plan.items.map((item, index) => (item.params[4] ?? 0) - (before[index] ?? 0));
    expect(moved[0]).toBeCloseTo(5e-4, 7);
    expect(moved[1]).toBeCloseTo(5e-4, 7);
    expect(moved[2]).toBe(0);
    plan.undo();
    expect(plan.items.map((item) => item.params[4])).toEqual(before);
    expect([...plan.selection]).toEqual([1, 2]);
  });

  it('takes a run of keys on the profile as one step for each selection', () => {
    for (const _ of [1, 2]) planGestures.add('waypoint', AT);
    const [one, other] = plan.items.map(({ key }) => new Set([key]));
    const heights = () => plan.items.map((item) => item.params[6]);
    const before = heights();
    for (const _ of [1, 2]) plan.shiftAlt(one!, 10, 'profile-keys');
    plan.shiftAlt(other!, -20, 'profile-keys');
    plan.undo();
    expect(heights()).toEqual([before[0]! + 20, before[1]]);
    plan.undo();
    expect(heights()).toEqual(before);
  });

  it('says why a landing cannot be, and takes the last of two', async () => {
    server.design.mockRejectedValueOnce(new Error('no direction'));
    planGestures.add('land', AT);
    await vi.waitFor(() => expect(plan.problem).not.toBeNull());
    expect(plan.items).toHaveLength(0);
    planGestures.add('land', HOME);
    planGestures.add('land', AT);
    await vi.waitFor(() => expect(plan.items).toHaveLength(2));
    expect(plan.problem).toBeNull();
    expect(plan.items[1]?.params[4]).toBe(AT.lat_deg);
  });

  it('lands on a runway whose two ends are clicked, until the landing is dragged off it', async () => {
    plan.tool = 'runway';
    planGestures.addWithTool(HOME);
    expect(plan.items).toHaveLength(0);
    server.design.mockImplementationOnce(({ runway }) => Promise.resolve(landingAt(runway!.end)));
    planGestures.addWithTool(AT);
    expect(plan.tool).toBe('waypoint');
    await vi.waitFor(() => expect(plan.items).toHaveLength(2));
    const { lat_deg, lon_deg } = HOME;
    const runway = { begin: { lat_deg, lon_deg }, end: AT };
    expect(server.design).toHaveBeenLastCalledWith(expect.objectContaining({ at: null, runway }));
    expect(planLanding.landingHere()).toMatchObject({ at: null, runway });
    planGestures.drag(2, AT, { ...AT, lon_deg: AT.lon_deg + 1e-3 }, true);
    await vi.waitFor(() => expect(server.move).toHaveBeenCalledOnce());
    expect(planLanding.landingHere()).toMatchObject({ at: { lon_deg: AT.lon_deg + 1e-3 }, runway: null });
  });

  it('lets the rest of a landing follow the part that is dragged, as one step', async () => {
    planGestures.add('land', AT);
    await vi.waitFor(() => expect(plan.items).toHaveLength(2));
    const before = plan.items.map((item) => item.params[4]);
    const keys = plan.items.map((item) => item.key);
    let from = AT;
    for (let step = 1; step <= 5; step += 1) {
      const to = { ...AT, lat_deg: AT.lat_deg + step * 1e-4 };
      planGestures.drag(1, from, to, step === 5);
      expect(plan.items[0]?.params[4]).toBeCloseTo(to.lat_deg, 9);
      from = to;
    }
    await vi.waitFor(() => expect(plan.items[1]?.params[4]).toBeCloseTo(from.lat_deg, 9));
    // the first place and the last one: those between were outrun
    expect(server.move).toHaveBeenCalledTimes(2);
    const { items, part } = server.move.mock.lastCall?.[0] as LandingMove;
    expect([part, items.map((item) => item.params[4])]).toEqual(['circle', before]);
    expect(plan.items.map((item) => item.key)).toEqual(keys);
    plan.undo();
    expect(plan.items.map((item) => item.params[4])).toEqual(before);
  });

  it('stays undone when the answer about a dragged landing comes after the undo', async () => {
    await planLanding.land(AT);
    const before = plan.items;
    const to = { ...AT, lon_deg: AT.lon_deg + 0.001 };
    let answer!: () => void;
    server.move.mockImplementationOnce(
      (asked) => new Promise((done) => (answer = () => done(landingAt(asked.to)))) as never,
    );
    planGestures.drag(2, AT, to, true);
    await vi.waitFor(() => expect(answer).toBeDefined());
    plan.undo();
    expect(plan.items).toEqual(before);
    answer();
    await plan.settled;
    expect([plan.items, plan.canRedo]).toEqual([before, true]);
  });

  it('puts a landing back that cannot be so, and says why', async () => {
    planGestures.add('land', AT);
    await vi.waitFor(() => expect(plan.items).toHaveLength(2));
    server.move.mockRejectedValueOnce(new Error('too much wind'));
    planGestures.drag(2, AT, HOME, true);
    await vi.waitFor(() => expect(plan.problem).not.toBeNull());
    expect(plan.items[1]?.params[4]).toBe(AT.lat_deg);
  });

  it('gives the tool back after a landing, and keeps the selection on what is there', async () => {
    planGestures.add('waypoint', AT);
    plan.tool = 'land';
    const there = { ...AT, lat_deg: AT.lat_deg + 0.01 };
    planGestures.addWithTool(there);
    expect(plan.tool).toBe('waypoint');
    await vi.waitFor(() => expect(plan.items).toHaveLength(3));
    const asked = server.design.mock.lastCall?.[0];
    expect(asked).toMatchObject({ at: there, vehicle: 1, has_land_start: null });
    expect(asked?.plan?.items).toHaveLength(1);
    plan.remove(new Set(plan.items.map((item) => item.key)));
    expect(plan.items).toHaveLength(0);
    expect(plan.selectedKeys.size).toBe(0);
  });
});
