import { afterEach, expect, it, vi } from 'vitest';
import type { PlanState, Separation } from '$lib/api/types';
import { separations } from './separation.svelte';
import { api } from './station.svelte';
import { vehicles } from './vehicles.svelte';

const onBoard = (hash: string): PlanState => ({
  state: 'verified',
  count: 2,
  hash,
  may_be_mixed: false,
  detail: 'verified',
});

afterEach(() => vi.restoreAllMocks());

it('tells that missions stay apart only of those that are on board, and with the limits that are set', async () => {
  for (const id of [1, 2]) vehicles.ensure(id).applyPlanState('mission', onBoard(`of ${id}`));
  const apart = { flights: [], conflicts: [] } as unknown as Separation;
  const asked = vi.spyOn(api, 'separation').mockResolvedValue(apart);
  await separations.compare();
  expect(separations.found).toBe(apart);
  separations.set('vertical_m', 60);
  expect(separations.found).toBeNull();
  separations.set('vertical_m', 30);
  expect(separations.found).toBe(apart);
  vehicles.ensure(2).applyPlanState('mission', onBoard('another'));
  expect(separations.found).toBeNull();
  // nor an answer of what was on board when it was asked for
  asked.mockImplementationOnce(() => {
    vehicles.ensure(1).applyPlanState('mission', onBoard('yet another'));
    return Promise.resolve(apart);
  });
  await separations.compare();
  expect(separations.found).toBeNull();
});
