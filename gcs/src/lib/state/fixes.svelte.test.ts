import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { FindingFix, PlanFinding, RehearsalRequest } from '$lib/api/types';
import { makeItem } from '$lib/domain/plan';
import { fixes } from './fixes.svelte';
import { plan } from './plan.svelte';
import { planAssessed } from './plan-assessed.svelte';
import { planGestures } from './plan-gestures.svelte';
import { planeProfile } from './plane-profile.svelte';
import { api, station } from './station.svelte';
import { vehicles } from './vehicles.svelte';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 690 };
const AT = { lat_deg: 40.336, lon_deg: -3.7978 };
const FINDING: PlanFinding = {
  severity: 'warning',
  item: 2,
  message: 'too low',
  remedy: 'climb',
  code: 'height-not-reached',
  figures: { difference_m: 30, is_low: true },
};
const CIRCLE: FindingFix = {
  finding: FINDING,
  message: 'circle',
  does: 'add-circle',
  with: { alt_m: 80 },
  first_item: 2,
  count: 0,
  items: [makeItem('loiter_to_height', { at: AT, alt_m: 80 })],
};

describe('remedies by one click', () => {
  const ask = vi.fn((_: RehearsalRequest) => Promise.resolve<FindingFix[]>([CIRCLE]));

  beforeEach(() => {
    vi.useFakeTimers();
    station.assess = () => Promise.resolve({ findings: [FINDING], trip: null, rehearsal: null });
    Object.assign(api, { planFixes: ask });
    ask.mockClear();
    plan.clear();
    plan.replace({ ...plan.asApi(), home: HOME, items: [makeItem('takeoff', { at: HOME, alt_m: 50 })] } as never);
    planGestures.add('waypoint', AT);
    planGestures.add('jump', null);
    plan.setParam(plan.items[2]!.key, 0, 2);
  });
  afterEach(() => vi.useRealTimers());

  it('is looked for once the plan is let alone, and taken back as one step', async () => {
    await vi.waitFor(() => expect(planAssessed.findings).toEqual([FINDING]));
    fixes.look();
    fixes.look();
    await vi.advanceTimersByTimeAsync(700);
    expect(ask).toHaveBeenCalledTimes(1);
    expect(fixes.of(FINDING)).toEqual(CIRCLE);
    expect(fixes.of({ ...FINDING, item: 1 })).toBeNull();
    const before = plan.items;
    await fixes.apply(CIRCLE);
    expect(plan.items.map((item) => item.command)).toEqual([22, 31, 16, 177]);
    expect(plan.items[3]?.params[0], 'the jump leads to where it led').toBe(3);
    expect(fixes.of(FINDING), 'what was found for another plan is not offered').toBeNull();
    plan.undo();
    expect(plan.items).toEqual(before);
    expect(fixes.of(FINDING)).toEqual(CIRCLE);
  });

  it('is of the vehicle and the plane that the findings are of', async () => {
    const set = vi.fn(() => Promise.resolve({}));
    Object.assign(api, { setParam: set });
    const parameter = { ...CIRCLE, does: 'set-parameter', with: { name: 'RTL_AUTOLAND', value: 2 } } as FindingFix;
    ask.mockResolvedValueOnce([parameter]);
    planeProfile.sayOfBattery({ capacity_mah: 5000 });
    for (const id of [1, 2]) vehicles.ensure(id);
    vehicles.select(1);
    await vi.waitFor(() => expect(planAssessed.findings).toEqual([FINDING]));
    fixes.look();
    await vi.advanceTimersByTimeAsync(700);
    expect(ask.mock.lastCall?.[0]).toMatchObject({ vehicle: 1, profile: planeProfile.asked });
    expect(fixes.of(FINDING)).toEqual(parameter);
    vehicles.select(2);
    expect(fixes.of(FINDING), 'it was not tried for this one').toBeNull();
    await fixes.apply(parameter);
    expect(set).not.toHaveBeenCalled();
    vehicles.select(1);
    await fixes.apply(parameter);
    expect(set).toHaveBeenCalledWith(1, 'RTL_AUTOLAND', 2, []);
    for (const id of [1, 2]) vehicles.drop(id);
  });

  it('asks again for a plan that was edited meanwhile', async () => {
    await vi.waitFor(() => expect(planAssessed.findings).toEqual([FINDING]));
    let answer = (_: FindingFix[]): void => undefined;
    ask.mockImplementationOnce(() => new Promise((resolve) => (answer = resolve)));
    fixes.look();
    await vi.advanceTimersByTimeAsync(700);
    plan.setAlt(new Set([plan.items[1]!.key]), 70);
    await vi.waitFor(() => expect(planAssessed.checkState).toBe('done'));
    fixes.look();
    await vi.advanceTimersByTimeAsync(700);
    expect(ask).toHaveBeenCalledTimes(1);
    answer([CIRCLE]);
    await vi.waitFor(() => expect(ask).toHaveBeenCalledTimes(2));
    await vi.waitFor(() => expect(fixes.of(FINDING)).toEqual(CIRCLE));
  });
});
