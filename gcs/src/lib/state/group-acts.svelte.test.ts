import { afterEach, describe, expect, it, vi } from 'vitest';
import { ProblemError } from '$lib/api/problem';
import type { Cause } from '$lib/api/types';
import { attentionTo, changedRow, type Listed } from '$lib/domain/roster';
import { groupActs } from './group-acts.svelte';
import { api } from './station.svelte';

function plane(id: number, isArmed: boolean | null): Listed {
  const row = changedRow(undefined, { id, is_armed: isArmed });
  return { row, name: `plane${id}`, age_s: 1, place: id, attention: attentionTo(row, 1), words: () => '' };
}

const failing = (cause: Partial<Cause>): ProblemError =>
  new ProblemError({ type: 'urn:vencejo:x', title: 'x', status: 409, detail: '', cause: cause as Cause });

afterEach(() => vi.restoreAllMocks());

describe('a group act', () => {
  it('is one request to each, and shows what became of each', async () => {
    const command = vi.spyOn(api, 'command').mockImplementation(async (id) => {
      if (id === 2) throw failing({ code: 'command-refused' });
      if (id === 3) throw failing({ code: 'vehicle-lost' });
      if (id === 4) throw new Error('the server went away');
      return {};
    });
    const whom = [plane(1, true), plane(2, true), plane(3, null), plane(4, true), plane(5, false)];
    const done = groupActs.do('return-to-launch', whom);
    expect([groupActs.isUnderWay, groupActs.counts.waiting]).toEqual([true, 4]);
    await groupActs.do('return-to-launch', whom);
    await done;
    expect(command.mock.calls.map(([id, act]) => [id, act])).toEqual(
      [1, 2, 3, 4].map((id) => [id, 'return-to-launch']),
    );
    const states = groupActs.answers.map(({ state, isDisarmed }) => `${state}${isDisarmed ? ' disarmed' : ''}`);
    expect(states).toEqual(['done', 'refused', 'unreached', 'unknown', 'refused disarmed']);
    expect(groupActs.isUnderWay).toBe(false);
    groupActs.forget();
    expect([groupActs.act, groupActs.answers]).toEqual([null, []]);
  });

  it('gives way to another one, which those that wait in line are told alone', async () => {
    const command = vi
      .spyOn(api, 'command')
      .mockImplementation(
        (_, act, __, options) =>
          new Promise((resolve, reject) =>
            act === 'mission/pause' ? options?.signal?.addEventListener('abort', reject) : resolve({}),
          ),
      );
    const whom = [1, 2, 3, 4, 5, 6].map((id) => plane(id, true));
    const paused = groupActs.do('mission/pause', whom);
    await groupActs.do('return-to-launch', whom);
    await paused;
    const told = command.mock.calls.map(([id, act]) => `${id} ${act}`);
    expect(told).toEqual([
      ...[1, 2, 3, 4].map((id) => `${id} mission/pause`),
      ...[1, 2, 3, 4, 5, 6].map((id) => `${id} return-to-launch`),
    ]);
    expect([groupActs.act, groupActs.counts.done]).toEqual(['return-to-launch', 6]);
    groupActs.forget();
  });
});
