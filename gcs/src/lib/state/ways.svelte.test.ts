import { expect, it, vi } from 'vitest';
import type { Plan, Way } from '$lib/api/types';
import { makeItem } from '$lib/domain/plan';
import { PLANE_ROUTE } from '$lib/domain/way';
import { type Question, wayAsker } from './ways.svelte';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 690 };
const PROFILE = { points: [], loiters: [], length_m: 0, ground: null };
const WAY: Way = {
  stops: [],
  jumps: [],
  end: { item: 1, designed_item: null },
  profile: PROFILE,
  is_ground_pending: false,
};
const question = (count: number): Question => ({
  items: Array.from({ length: count }, (_, index) => ({ ...makeItem('waypoint', { at: HOME }), key: index + 1 })),
  ...{ home: HOME, vehicle: 7, route: PLANE_ROUTE, clearance_m: 30, knowsGround: true },
});

it('asks one question at a time, and of those that come meanwhile the last', async () => {
  const asked: { plan: Plan; vehicle?: number; answer: (way: Way) => void; fail: () => void }[] = [];
  const shown: (number | undefined)[] = [];
  const asker = wayAsker(
    (plan, vehicle) =>
      new Promise((answer, fail) => asked.push({ plan, ...(vehicle !== undefined && { vehicle }), answer, fail })),
    () => shown.push(asker.answer?.items.length),
  );
  const [one, two, three] = [question(1), question(2), question(3)];
  asker.ask(one);
  asker.ask(one);
  asker.ask(two);
  asker.ask(three);
  expect(asked.map(({ plan, vehicle }) => [plan.items.length, vehicle])).toEqual([[1, 7]]);
  expect(asked[0]?.plan.items[0]).not.toHaveProperty('key');
  asked[0]?.answer(WAY);
  await vi.waitFor(() => expect(asked).toHaveLength(2));
  expect(asker.answer?.items).toBe(one.items);
  expect(asked[1]?.plan.items).toHaveLength(3);
  asked[1]?.answer(WAY);
  await vi.waitFor(() => expect(asker.answer?.items).toBe(three.items));
  expect(shown).toEqual([1, 3]);

  // what failed may be asked again, and no plan needs no answer
  asker.ask(one);
  asked[2]?.fail();
  await vi.waitFor(() => {
    asker.ask(one);
    expect(asked).toHaveLength(4);
  });
  asker.ask(null);
  expect(asker.answer).toBeNull();
  asked[3]?.answer(WAY);
  await Promise.resolve();
  expect(asker.answer).toBeNull();
});

it('asks again while ground is on its way, and of what is asked by then', async () => {
  vi.useFakeTimers();
  const asked: Plan[] = [];
  const asker = wayAsker((plan) => {
    asked.push(plan);
    return Promise.resolve({ ...WAY, is_ground_pending: asked.length < 3 });
  });
  asker.ask(question(1));
  await vi.advanceTimersByTimeAsync(600);
  expect(asked).toHaveLength(1);
  asker.ask(question(2));
  await vi.advanceTimersByTimeAsync(600);
  expect(asked.map(({ items }) => items.length)).toEqual([1, 2]);
  await vi.advanceTimersByTimeAsync(5000);
  expect(asked.map(({ items }) => items.length)).toEqual([1, 2, 2]);
  vi.useRealTimers();
});
