import { describe, expect, it } from 'vitest';
import { Api } from './client';
import { ProblemError } from './problem';

function make(answer: () => Promise<Response>) {
  const calls: { url: string; init: RequestInit }[] = [];
  const api = new Api('/api/v1', (input, init) => {
    calls.push({ url: String(input), init: init ?? {} });
    return answer();
  });
  return { api, calls };
}

const problem = (body: unknown, status: number) =>
  Promise.resolve(
    new Response(JSON.stringify(body), { status, headers: { 'content-type': 'application/problem+json' } }),
  );

describe('Api', () => {
  it('sends a command as JSON', async () => {
    const { api, calls } = make(() => Promise.resolve(new Response('{}')));
    await api.command(3, 'mission/current', { item: 5 });
    expect(calls[0]?.url).toBe('/api/v1/vehicles/3/mission/current');
    expect(calls[0]?.init).toMatchObject({ method: 'POST', body: '{"item":5}' });
  });

  it('says by name that a mission that may be mixed is to be flown', async () => {
    const { api, calls } = make(() => Promise.resolve(new Response('{}')));
    await api.command(3, 'arm', { force: false }, { despiteMixedPlan: true });
    await api.command(3, 'arm', {}, { despiteMixedPlan: false });
    const asked = calls.map(({ url, init }) => [url, init.body]);
    expect(asked).toEqual([
      ['/api/v1/vehicles/3/arm?despite_mixed_plan=true', '{"force":false}'],
      ['/api/v1/vehicles/3/arm', '{}'],
    ]);
  });

  it("hands on the vehicle's reasons", async () => {
    const body = {
      type: 'urn:x',
      title: 'Refused',
      status: 409,
      detail: 'no',
      reasons: ['PreArm: a', 3],
      refusals: ['gyros', 3],
      remedy: 'b',
    };
    const { api } = make(() => problem(body, 409));
    const error = await api.command(1, 'arm', {}).catch((error: unknown) => error);
    expect(error).toBeInstanceOf(ProblemError);
    expect((error as ProblemError).problem).toEqual({ ...body, reasons: ['PreArm: a'], refusals: ['gyros', null] });
  });

  it('makes a problem of everything else that fails', async () => {
    const status = async (answer: () => Promise<Response>) =>
      make(answer)
        .api.info()
        .then(() => null)
        .catch((error: unknown) => (error as ProblemError).problem.status);
    expect(await status(() => Promise.reject(new TypeError('refused')))).toBe(0);
    expect(await status(() => Promise.resolve(new Response('<html>', { status: 502 })))).toBe(502);
    expect(await status(() => problem('not an object', 500))).toBe(500);
  });

  it('takes an empty answer for "done"', async () => {
    const { api } = make(() => Promise.resolve(new Response('')));
    expect(await api.removeLink(1)).toEqual({});
  });

  it('confirms what a person has confirmed, once, and nothing else', async () => {
    const cause = { code: 'needs-confirmation', act: 'clear-fence', vehicle: 1, confirmation: 'c0ffee', valid_s: 15 };
    const body = {
      type: 'urn:vencejo:needs-confirmation',
      title: 'Has to be confirmed',
      status: 428,
      detail: '',
      cause,
    };
    const answers = [problem(body, 428), Promise.resolve(new Response('{"id":4}'))];
    const asked = make(() => answers.shift() ?? Promise.reject(new Error('asked too often')));
    expect(await asked.api.clearPlan(1, 'fence')).toEqual({ id: 4 });
    expect(asked.calls.map(({ init }) => new Headers(init.headers).get('vencejo-confirmation'))).toEqual([
      null,
      'c0ffee',
    ]);
    const other = make(() => problem(body, 428));
    await expect(other.api.clearPlan(1, 'mission')).rejects.toThrow(ProblemError);
    expect(other.calls).toHaveLength(1);
  });
});
