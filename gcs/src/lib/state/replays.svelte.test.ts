import { afterEach, expect, it, vi } from 'vitest';
import { replaysApi, type Replay } from '$lib/api/replays';
import { replays } from './replays.svelte';

afterEach(() => vi.restoreAllMocks());

it('is taken to one place at a time, and of those asked for meanwhile to the last', async () => {
  const answers: (() => void)[] = [];
  const change = vi
    .spyOn(replaysApi, 'change')
    .mockImplementation(
      () => new Promise((resolve) => answers.push(() => resolve({ vehicles: [] } as unknown as Replay))),
    );
  const first = replays.seek(1, 10);
  for (const position_s of [20, 30, 40]) void replays.seek(1, position_s);
  expect([replays.soughtIn(1), change.mock.calls.length]).toEqual([40, 1]);
  answers.shift()!();
  await vi.waitFor(() => expect(change).toHaveBeenCalledTimes(2));
  expect(replays.soughtIn(1), 'the first answer takes nothing back').toBe(40);
  answers.shift()!();
  await first;
  expect(replays.soughtIn(1)).toBeNull();
  expect(change.mock.calls.map(([id, body]) => [id, body.position_s])).toEqual([
    [1, 10],
    [1, 40],
  ]);
});
