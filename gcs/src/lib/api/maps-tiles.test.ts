import { describe, expect, it } from 'vitest';
import { MOST_AT_ONCE, MOST_OF_ONE, tileLoader } from './maps-tiles';

const { signal } = new AbortController();

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
    expect(await loader('a', '/t/new', signal)).toMatchObject({ kind: 'tile', isStale: false });
    expect(await loader('a', '/t/old', signal)).toMatchObject({ kind: 'tile', isStale: true });
  });

  it('are told apart from failures', async () => {
    const loader = tileLoader(async (input) => {
      if (String(input) === '/none') return problem(404, 'urn:vencejo:no-tile', 'outside');
      if (String(input) === '/gone') return problem(404, 'urn:vencejo:no-source', 'there is no source x');
      if (String(input) === '/bad') return problem(502, 'urn:vencejo:source-failed', 'LayerNotDefined: pnoa');
      throw new TypeError('offline');
    });
    expect(await loader('a', '/none', signal)).toEqual({ kind: 'none' });
    expect(await loader('a', '/gone', signal)).toMatchObject({ kind: 'failed', problem: { status: 404 } });
    expect(await loader('a', '/bad', signal)).toMatchObject({
      kind: 'failed',
      problem: { detail: 'LayerNotDefined: pnoa' },
    });
    expect(await loader('a', '/away', signal)).toMatchObject({ kind: 'failed', problem: { status: 0 } });
  });

  /** A server that answers on demand, tile by tile; `asked` has their addresses in turn. */
  function slowServer() {
    const asked: string[] = [];
    const answers = new Map<string, () => void>();
    const loader = tileLoader(async (input, init) => {
      asked.push(String(input));
      await new Promise<void>((resolve, reject) => {
        answers.set(String(input), resolve);
        init?.signal?.addEventListener('abort', () => reject(new DOMException('ended', 'AbortError')));
      });
      return new Response('x');
    });
    const settle = () => new Promise((resolve) => setTimeout(resolve));
    const answer = async (address: string) => {
      answers.get(address)?.();
      await settle();
    };
    return { asked, answer, loader, settle, signal: new AbortController().signal };
  }

  it('leave connections free for commands, and places for other sources', async () => {
    const { asked, answer, loader, settle, signal } = slowServer();
    for (const name of ['a', 'b'])
      for (let index = 0; index < 5; index += 1) void loader(name, `/${name}/${index}`, signal);
    await settle();
    expect(asked).toEqual(['/a/0', '/a/1', '/a/2', '/b/0']);
    expect(asked).toHaveLength(MOST_AT_ONCE);
    expect(asked.filter((address) => address.startsWith('/a'))).toHaveLength(MOST_OF_ONE);
    // a hanging source does not block the others
    for (let index = 0; index < 5; index += 1) await answer(`/b/${index}`);
    expect(asked.filter((address) => address.startsWith('/b'))).toHaveLength(5);
  });

  it('come first that were asked for last', async () => {
    const { asked, answer, loader, settle, signal } = slowServer();
    for (let index = 0; index < 5; index += 1) void loader('a', `/old/${index}`, signal);
    await settle();
    for (let index = 0; index < 2; index += 1) void loader('a', `/new/${index}`, signal);
    for (let index = 0; index < 3; index += 1) await answer(`/old/${index}`);
    expect(asked.slice(MOST_OF_ONE)).toEqual(['/new/0', '/new/1', '/old/3']);
  });

  it('are given up when nobody waits for them', async () => {
    const { asked, loader, settle } = slowServer();
    const abort = new AbortController();
    const all = Array.from({ length: 5 }, (_, index) => loader('a', `/${index}`, abort.signal));
    await settle();
    abort.abort();
    expect(await Promise.all(all)).toEqual(all.map(() => ({ kind: 'ended' })));
    expect(asked).toHaveLength(MOST_OF_ONE);
  });
});
