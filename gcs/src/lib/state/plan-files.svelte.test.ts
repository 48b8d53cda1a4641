import { beforeEach, expect, it, vi } from 'vitest';
import type { Plan } from '$lib/api/types';
import { emptyPlan, makeItem } from '$lib/domain/plan';
import { plan } from './plan.svelte';
import { planFiles } from './plan-files.svelte';
import { api } from './station.svelte';
import { vehicles } from './vehicles.svelte';

const AT = { lat_deg: 40.336, lon_deg: -3.7978 };
const circle = (radius_m: number) =>
  ({ zones: [{ inclusion: true, shape: 'circle', points: [AT], radius_m }], return_point: null }) as Plan['fence'];
const rally = [{ ...AT, alt_m: 60, frame: 3 }] as unknown as Plan['rally'];
const items = [makeItem('waypoint', { at: AT, alt_m: 80 })];

function open(name: string, read: Partial<Plan>): Promise<boolean> {
  const file = { plan: { ...emptyPlan(), ...read }, notes: [] };
  vi.spyOn(api, 'parsePlan').mockResolvedValue(file as never);
  return planFiles.loadFile({ name } as File);
}

beforeEach(() => {
  plan.clear();
  plan.replace({ ...emptyPlan(), items, fence: circle(100), rally } as never);
});

it.each(['field.fen', 'field.plan'])('takes the fence alone from a %s with nothing else', async (name) => {
  const before = plan.draft;
  await open(name, { fence: circle(200) });
  expect(plan.draft.fence).toEqual(circle(200));
  expect([plan.draft.items, plan.draft.rally]).toEqual([before.items, before.rally]);
  expect(planFiles.removed).toEqual([]);
});

it('takes the mission alone from a file that cannot hold more', async () => {
  await open('field.waypoints', { items: [...items, ...items] });
  expect([plan.items.length, plan.draft.fence.zones.length, plan.draft.rally.length]).toEqual([2, 1, 1]);
});

it('takes a whole plan, and says what it had none of', async () => {
  await open('other.plan', { items });
  expect([plan.items.length, plan.isEmpty('fence'), plan.isEmpty('rally')]).toEqual([1, true, true]);
  expect(planFiles.removed).toEqual(['fence', 'rally']);
  plan.undo();
  expect(plan.isEmpty('fence')).toBe(false);
});

it('writes a plan for the vehicle that its file is for; one of no file for the selected', async () => {
  const format = vi.spyOn(api, 'formatPlan').mockResolvedValue({ file: new Blob(), notes: [] });
  const written = async () => {
    await planFiles.fileOf('plan');
    return format.mock.lastCall?.[0].planned_for;
  };
  const of = (vehicle_type: number, firmware_type: number) => ({
    cruise_speed_m_s: null,
    hover_speed_m_s: null,
    vehicle_type,
    firmware_type,
  });
  expect(await written(), 'no vehicle').toBeUndefined();
  const heartbeat = { mav_type: 20, autopilot: 12 } as never;
  vehicles.ensure(1).apply({ groups: { heartbeat }, progress: null, heardAt_ms: {} });
  expect(await written()).toEqual(of(20, 12));
  const planned_for = { ...of(2, 3), cruise_speed_m_s: 18 };
  await open('copter.plan', { items, planned_for });
  plan.move(plan.items[0]!.key, { lat_deg: 40.34, lon_deg: -3.8 });
  expect(await written()).toEqual(planned_for);
  await open('field.waypoints', { items });
  expect(await written()).toEqual(of(20, 12));
});

it('says beside the buttons what went wrong, until the next file', async () => {
  vi.spyOn(api, 'parsePlan').mockRejectedValueOnce(new Error('no plan'));
  expect(await planFiles.loadFile({ name: 'broken.plan' } as File)).toBe(false);
  expect([planFiles.problem?.detail, plan.problem]).toEqual(['no plan', null]);
  await open('field.plan', { items });
  expect(planFiles.problem).toBeNull();
});
