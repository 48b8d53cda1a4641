import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { connection } from '$lib/api/connection';
import { isNoAnswer } from '$lib/api/problem';
import type { Operation } from '$lib/api/types';
import { makeItem } from '$lib/domain/plan';
import { operations } from './station.svelte';
import { plan } from './plan.svelte';
import { planTransfers } from './plan-transfers.svelte';
import { vehicles } from './vehicles.svelte';

const AT = { lat_deg: 40.336, lon_deg: -3.7978 };
const RUNNING: Operation = { id: 'a-1', kind: 'plan', vehicle: 1, state: 'running', done: 0, total: 0 } as never;

/** A server that is asked, and answers only when `answer` is called. */
function silentServer() {
  const asked: string[] = [];
  let answer!: (body: unknown) => void;
  vi.stubGlobal('fetch', (address: string, { method, signal }: RequestInit) => {
    asked.push(`${method} ${address.replace('/api/v1', '')}`);
    return new Promise<Response>((resolve, reject) => {
      answer = (body) => resolve(new Response(JSON.stringify(body)));
      signal?.addEventListener('abort', () => reject(new DOMException('aborted', 'AbortError')));
    });
  });
  return { asked, answer: (body: unknown) => answer(body) };
}
const asks = (asked: readonly string[], what: string) => vi.waitFor(() => expect(asked.at(-1)).toBe(what));

beforeEach(() => {
  vehicles.ensure(1);
  vehicles.select(1);
  plan.clear();
  plan.replace({ ...plan.asApi(), items: [makeItem('waypoint', { at: AT, alt_m: 80 })] });
});
afterEach(() => vi.unstubAllGlobals());

describe('a transfer over a network that swallows its request', () => {
  it('ends with the connection', async () => {
    const { asked } = silentServer();
    const sent = planTransfers.send('mission');
    await asks(asked, 'PUT /vehicles/1/plan/mission');
    connection.lose();
    await sent;
    expect(planTransfers.transfer).toBeNull();
    expect(planTransfers.problem).toSatisfy(isNoAnswer);
  });

  it('is cancelled as soon as the server has begun it', async () => {
    const { asked, answer } = silentServer();
    const sent = planTransfers.send('mission');
    await asks(asked, 'PUT /vehicles/1/plan/mission');
    await planTransfers.cancel();
    expect(planTransfers.transfer, 'the server may have it').not.toBeNull();
    answer(RUNNING);
    await asks(asked, 'DELETE /operations/a-1');
    answer({});
    operations.update({ ...RUNNING, state: 'cancelled' });
    await sent;
    expect([planTransfers.transfer, planTransfers.problem?.title]).toEqual([null, 'cancelled']);
  });

  it('is cancelled at once while the core is still at work on the draft', async () => {
    const { asked } = silentServer();
    plan.waitFor(new Promise(() => undefined));
    const sent = planTransfers.send('mission');
    await planTransfers.cancel();
    await sent;
    expect([planTransfers.transfer, asked]).toEqual([null, []]);
  });
});
