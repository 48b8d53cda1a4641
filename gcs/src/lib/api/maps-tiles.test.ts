import { describe, expect, it } from 'vitest';
import { MOST_AT_ONCE, tileLoader } from './maps-tiles';

const problem = (status: number, type: string, detail: string): Response =>
  new Response(JSON.stringify({ type, title: 'No', status, detail }), {
    status,
    headers: { 'content-type': 'application/problem+json' },
  });

describe('tiles', () => {
  it('come with what the server says of them', async () => {
    const loader = tileLoader(async (input) =>
      String(input).endsWith('old')
        ? new Response('old', { headers: { 'vencejo-tile': 'stale' } })
        : new Response('new', { headers: { 'vencejo-tile': 'hit' } }),
    );
    expect(await loader('/t/new')).toMatchObject({ kind: 'tile', isStale: false });
    expect(await loader('/t/old')).toMatchObject({ kind: 'tile', isStale: true });
  });

  it('are told apart from failures', async () => {
    const loader = tileLoader(async (input) => {
      if (String(input) === '/none') return problem(404, 'urn:vencejo:no-tile', 'outside');
      if (String(input) === '/gone') return problem(404, 'urn:vencejo:no-source', 'there is no source x');
      if (String(input) === '/bad') return problem(502, 'urn:vencejo:source-failed', 'LayerNotDefined: pnoa');
      throw new TypeError('offline');
    });
    expect(await loader('/none')).toEqual({ kind: 'none' });
    expect(await loader('/gone')).toMatchObject({ kind: 'failed', problem: { status: 404 } });
    expect(await loader('/bad')).toMatchObject({ kind: 'failed', problem: { detail: 'LayerNotDefined: pnoa' } });
    expect(await loader('/away')).toMatchObject({ kind: 'failed', problem: { status: 0 } });
  });

  it('leave connections free for commands', async () => {
    const open: (() => void)[] = [];
    let most = 0;
    let running = 0;
    const loader = tileLoader(async () => {
      running += 1;
      most = Math.max(most, running);
      await new Promise<void>((resolve) => open.push(resolve));
      running -= 1;
      return new Response('x');
    });
    const all = Array.from({ length: 20 }, (_, index) => loader(`/t/${index}`));
    let ended = 0;
    void Promise.all(all.map((one) => one.then(() => (ended += 1))));
    while (ended < 20) {
      open.shift()?.();
      await Promise.resolve();
    }
    expect(most).toBe(MOST_AT_ONCE);
  });
});
