import { describe, expect, it, vi } from 'vitest';
import { Api } from '$lib/api/client';
import { ProblemError } from '$lib/api/problem';
import type { Operation } from '$lib/api/types';
import { Operations } from './operations.svelte';

const running: Operation = { id: 4, vehicle: 1, kind: 'read_params', state: 'running', done: 0, total: 2 };
const result = [{ name: 'A', value: 1, kind: 'real32', default: null }];

function make(answer: Operation) {
  const asked: string[] = [];
  const api = new Api('', (input) => {
    asked.push(String(input));
    return Promise.resolve(new Response(JSON.stringify(answer)));
  });
  return { operations: new Operations(api), asked };
}

describe('Operations', () => {
  it('fetches the result when a message tells of the end', async () => {
    const { operations, asked } = make({ ...running, state: 'done', done: 2, result });
    const finished = operations.finish(running);
    operations.update({ ...running, done: 1 });
    expect(operations.running).toHaveLength(1);
    operations.update({ ...running, state: 'done', done: 2 });
    expect(await finished).toEqual(result);
    expect(asked).toEqual(['/operations/4']);
    expect(operations.running).toHaveLength(0);
  });

  it('throws the problem of one that failed', async () => {
    const { operations } = make(running);
    const cause = { code: 'home-unknown' } as const;
    const error = { type: 'urn:vencejo:home-unknown', title: 'No', status: 409, detail: 'because', cause };
    const finished = operations.finish(running);
    operations.update({ ...running, state: 'failed', error });
    await expect(finished).rejects.toThrowError(new ProblemError(error));
  });

  it('knows of a new connection only what is told there, and what is waited for', () => {
    const { operations } = make(running);
    void operations.finish(running);
    operations.update({ ...running, id: 5 });
    operations.update({ ...running, id: 6, state: 'done' });
    operations.greet();
    expect([operations.running.map(({ id }) => id), operations.get(6)?.state]).toEqual([[4], 'done']);
  });

  it('does not begin again after its end, whatever comes late', async () => {
    const { operations } = make(running);
    operations.update({ ...running, state: 'cancelled' });
    operations.update({ ...running, done: 1 });
    expect(operations.get(4)?.state).toBe('cancelled');
    await expect(operations.finish(running)).rejects.toBeInstanceOf(ProblemError);
  });

  it('asks one question at a time where no answer comes', async () => {
    vi.useFakeTimers();
    let asked = 0;
    const api = new Api('', (_, init) => {
      asked += 1;
      return new Promise((_resolve, reject) =>
        init?.signal?.addEventListener('abort', () => reject(new Error('late'))),
      );
    });
    const operations = new Operations(api);
    const finished = operations.finish(running);
    await vi.advanceTimersByTimeAsync(4000);
    expect(asked).toBe(1);
    operations.update({ ...running, state: 'done', done: 2, result });
    expect(await finished).toEqual(result);
    vi.useRealTimers();
  });

  it('keeps a bounded number of ended ones', () => {
    const { operations } = make(running);
    for (let id = 0; id < 100; id += 1) operations.update({ ...running, id, state: 'done' });
    expect(operations.get(0)).toBeUndefined();
    expect(operations.get(99)).toBeDefined();
  });
});
