import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import type { PlanDrafts } from '$lib/api/types';
import { emptyPlan, makeItem, type Plan } from '$lib/domain/plan';
import { plan } from './plan.svelte';
import { planTransfers } from './plan-transfers.svelte';
import { sharedDraft } from './shared-draft.svelte';
import { api, station } from './station.svelte';
import { vehicles } from './vehicles.svelte';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 690 };
const items = [makeItem('takeoff', { at: HOME, alt_m: 50 }), makeItem('waypoint', { at: HOME, alt_m: 80 })];
const verified = { state: 'verified', count: 2, hash: 'aa', may_be_mixed: false, detail: '' } as const;

beforeEach(() => {
  vi.useFakeTimers();
  station.socketState = 'open';
  station.session = { role: 'operator' } as never;
});
afterEach(() => {
  vi.useRealTimers();
  vi.restoreAllMocks();
});

it('takes what a vehicle has on board for no work of this browser', async () => {
  const theirs: Plan = { ...emptyPlan(), items, home: HOME };
  const drafts = { current: { revision: 5, by: 'laptop', author: 'other', saved_unix_s: 1, plan: theirs } };
  vi.spyOn(api, 'draft').mockResolvedValue({ ...drafts, other: null } as unknown as PlanDrafts);
  const saved = vi.spyOn(api, 'saveDraft').mockResolvedValue({ revision: 6 } as never);
  await sharedDraft.look();
  expect(sharedDraft.theirs?.kind).toBe('offer');
  // the same as it was sent: the vehicle says nothing of home
  const board = { state: verified, plan: { ...emptyPlan(), items } };
  vi.spyOn(api, 'planOnBoard').mockResolvedValue(board as never);
  vehicles.ensure(1).applyPlanState('mission', verified as never);
  vehicles.select(1);
  await planTransfers.follow();
  expect(plan.items).toHaveLength(2);
  sharedDraft.changed();
  await vi.advanceTimersByTimeAsync(1500);
  await sharedDraft.look();
  expect([sharedDraft.theirs?.kind, saved.mock.calls.length]).toEqual(['offer', 0]);
  // a change of it is
  plan.setAlt(new Set(plan.items.map(({ key }) => key)), 120);
  sharedDraft.changed();
  await vi.advanceTimersByTimeAsync(1500);
  expect(sharedDraft.theirs?.kind).toBe('conflict');
});
