import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import type { Plan, PlanComparison } from '$lib/api/types';
import { emptyPlan, makeItem } from '$lib/domain/plan';
import { Comparison, type Question } from './comparison.svelte';

const AT = { lat_deg: 40.336, lon_deg: -3.7978 };
const { fence, rally } = emptyPlan();
const edited = (count: number): Question => ({
  vehicle: 7,
  mission: Array.from({ length: count }, (_, index) => ({ ...makeItem('waypoint', { at: AT }), key: index + 1 })),
  ...{ fence, rally, missionHash: 'a', fenceHash: null, rallyHash: null },
});
const added = (item: number) => [{ kind: 'added' as const, item }];

/** A server that answers on demand. */
function asked() {
  const questions: { plan: Plan; answer: (told: PlanComparison) => void; fail: () => void }[] = [];
  const comparison = new Comparison(
    (_, plan) => new Promise((answer, fail) => questions.push({ plan, answer, fail: () => fail(new Error('away')) })),
  );
  const tell = async (mission: PlanComparison['mission']) => {
    questions.at(-1)?.answer({ mission, fence: null, rally: null });
    await vi.advanceTimersByTimeAsync(0);
  };
  return { questions, comparison, tell };
}

beforeEach(() => vi.useFakeTimers());
afterEach(() => vi.useRealTimers());

it('says that a plan is the same of no other than was compared', async () => {
  const { questions, comparison, tell } = asked();
  const [one, two] = [edited(1), edited(2)];
  comparison.ask(one);
  expect(comparison.of('mission', one)).toBeNull();
  await tell({ hash: 'a', changes: [] });
  expect(questions[0]?.plan.items[0]).not.toHaveProperty('key');
  expect(comparison.of('mission', one)).toEqual({ changes: [], of: one.mission });
  expect(comparison.of('mission', two)).toBeNull();
  // another vehicle, and another plan on board
  expect(comparison.of('mission', { ...one, vehicle: 8 })).toBeNull();
  expect(comparison.of('mission', { ...one, missionHash: 'b' })).toBeNull();
  // the server did not know what is there
  expect(comparison.of('fence', one)).toBeNull();
});

it('keeps for a moment what differs, while the plan is edited on', async () => {
  const { questions, comparison, tell } = asked();
  const [one, two, three] = [edited(1), edited(2), edited(3)];
  comparison.ask(one);
  await tell({ hash: 'a', changes: added(1) });
  comparison.ask(two);
  expect(comparison.of('mission', two)).toEqual({ changes: added(1), of: one.mission });
  await vi.advanceTimersByTimeAsync(150);
  expect(questions).toHaveLength(2);
  comparison.ask(three);
  // of the plan before that
  await tell({ hash: 'a', changes: added(2) });
  expect(comparison.of('mission', three)?.changes).toEqual(added(2));
  await vi.advanceTimersByTimeAsync(250);
  expect(questions).toHaveLength(3);
  expect(comparison.of('mission', three)).toBeNull();
  await tell({ hash: 'a', changes: added(3) });
  expect(comparison.of('mission', three)?.changes).toEqual(added(3));
});

it('asks a server again that did not answer, and knows nothing until it does', async () => {
  const { questions, comparison, tell } = asked();
  const one = edited(1);
  comparison.ask(one);
  questions[0]?.fail();
  await vi.advanceTimersByTimeAsync(1900);
  expect(comparison.of('mission', one)).toBeNull();
  expect(questions).toHaveLength(1);
  await vi.advanceTimersByTimeAsync(200);
  expect(questions).toHaveLength(2);
  await tell({ hash: 'a', changes: [] });
  expect(comparison.of('mission', one)?.changes).toEqual([]);
  comparison.ask(null);
  expect(comparison.of('mission', one)).toBeNull();
});
