// Tiles of a map's source, with the reason where there is none: an <img> would hide it.
import { NO_ANSWER, ownProblem, problemOf } from './problem';
import type { Problem } from './types';

export type TileAnswer =
  /** `isStale`: the source failed, this is an older copy. */
  | { readonly kind: 'tile'; readonly picture: Blob; readonly isStale: boolean }
  /** The source has nothing there. */
  | { readonly kind: 'none' }
  | { readonly kind: 'failed'; readonly problem: Problem };

export type TileLoader = (address: string) => Promise<TileAnswer>;

/**
 * So many at once. A browser opens six connections to a server (HTTP/1.1); a slow map source must not keep a command to the
 * plane waiting for one of them.
 */
export const MOST_AT_ONCE = 4;

export function tileLoader(fetchWith: typeof fetch = (...args) => fetch(...args)): TileLoader {
  let running = 0;
  const waiting: (() => void)[] = [];
  return async (address) => {
    // who ends hands its place on
    if (running >= MOST_AT_ONCE) await new Promise<void>((resolve) => waiting.push(resolve));
    else running += 1;
    try {
      return await load(address, fetchWith);
    } finally {
      const next = waiting.shift();
      if (next === undefined) running -= 1;
      else next();
    }
  };
}

async function load(address: string, fetchWith: typeof fetch): Promise<TileAnswer> {
  try {
    const response = await fetchWith(address, { credentials: 'same-origin' });
    if (response.ok) {
      const isStale = response.headers.get('vencejo-tile') === 'stale';
      return { kind: 'tile', picture: await response.blob(), isStale };
    }
    const problem = await problemOf(response);
    const isNone = problem.status === 404 && problem.type.endsWith(':no-tile');
    return isNone ? { kind: 'none' } : { kind: 'failed', problem };
  } catch (error) {
    return { kind: 'failed', problem: ownProblem('No answer', NO_ANSWER, String(error)) };
  }
}
