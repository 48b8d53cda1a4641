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

export function tileLoader(fetchWith: typeof fetch = (...args) => fetch(...args)): TileLoader {
  return async (address) => {
    let response: Response;
    try {
      response = await fetchWith(address, { credentials: 'same-origin' });
    } catch (error) {
      return { kind: 'failed', problem: ownProblem('No answer', NO_ANSWER, String(error)) };
    }
    if (!response.ok) {
      const problem = await problemOf(response);
      return problem.status === 404 && problem.type.endsWith(':no-tile')
        ? { kind: 'none' }
        : { kind: 'failed', problem };
    }
    try {
      return {
        kind: 'tile',
        picture: await response.blob(),
        isStale: response.headers.get('vencejo-tile') === 'stale',
      };
    } catch (error) {
      return { kind: 'failed', problem: ownProblem('No answer', NO_ANSWER, String(error)) };
    }
  };
}
