import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import type { WhatIfs } from '$lib/api/types';
import type { Wind } from '$lib/domain/wind';
import { telemetryAt } from '../../../dev/mock/flight';
import { ahead } from './ahead.svelte';
import { clock } from './clock.svelte';
import { planWind } from './plan-wind.svelte';
import { api } from './station.svelte';
import { heardAt, type Vehicle, vehicles } from './vehicles.svelte';

const { groups, progress } = telemetryAt(100);
const SET: Wind = { from_deg: 0, speed_m_s: 12 };

function inMission(id: number, wind: Wind | null): Vehicle {
  const vehicle = vehicles.ensure(id);
  const changes = { ...groups, wind: wind && { ...groups.wind!, ...wind } };
  const flying = { ...progress!, follows_mission: true };
  vehicle.apply({ groups: changes, progress: flying, heardAt_ms: heardAt(groups, 10_000) });
  return vehicle;
}

/** What the rest of a mission is rehearsed in. */
async function asked(begin: () => unknown): Promise<unknown[]> {
  const told = { ahead: null, now: null, outlook: null, what_ifs: [] } as unknown as WhatIfs;
  const whatIf = vi.spyOn(api, 'whatIf').mockResolvedValue(told);
  const end = begin();
  await vi.advanceTimersByTimeAsync(10);
  if (typeof end === 'function') end();
  return whatIf.mock.calls.map(([{ vehicle, wind }]) => ({ vehicle, wind }));
}

beforeEach(() => {
  vi.useFakeTimers();
  clock.tick(10_000);
  planWind.set(SET);
});
afterEach(() => {
  planWind.unset();
  for (const { systemId } of vehicles.all) vehicles.drop(systemId);
  vi.useRealTimers();
  vi.restoreAllMocks();
});

it('rehearses the rest of a flight in the wind that the plane estimates, not in that of the plan', async () => {
  const vehicle = inMission(1, { from_deg: 180, speed_m_s: 2 });
  expect(await asked(() => ahead.follow(vehicle))).toEqual([{ vehicle: 1, wind: { from_deg: 180, speed_m_s: 2 } }]);
});

it('takes the wind that was set where the plane estimates none', async () => {
  const vehicle = inMission(1, null);
  expect(await asked(() => ahead.follow(vehicle))).toEqual([{ vehicle: 1, wind: SET }]);
});

it('expects each lost plane in a wind of its own', async () => {
  inMission(1, { from_deg: 180, speed_m_s: 2 });
  const lost = [inMission(2, { from_deg: 90, speed_m_s: 4 }), inMission(3, null)];
  expect(await asked(() => ahead.expect(lost))).toEqual([
    { vehicle: 2, wind: { from_deg: 90, speed_m_s: 4 } },
    { vehicle: 3, wind: { from_deg: 0, speed_m_s: 0 } },
  ]);
});
