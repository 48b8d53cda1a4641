// Tiles of a map source, with the reason for a missing one, which an <img> would hide.
import { connection } from './connection';
import { noAnswer, problemOf } from './problem';
import type { Problem } from './types';

type TileAnswer =
  /** `isStale`: the source failed, this is an older copy. */
  | { readonly kind: 'tile'; readonly picture: Blob; readonly isStale: boolean }
  /** The source has nothing there. */
  | { readonly kind: 'none' }
  /** No caller waits for it any more. */
  | { readonly kind: 'ended' }
  | { readonly kind: 'failed'; readonly problem: Problem };

/** Fetches a tile of a source until `signal` is aborted. */
export type TileLoader = (source: string, address: string, signal: AbortSignal) => Promise<TileAnswer>;

/**
 * Requests in flight. A browser opens six connections to a server (HTTP/1.1); a slow map source must not keep a command to the
 * plane waiting for one of them.
 */
export const MOST_AT_ONCE = 4;
/** Requests in flight per source: a hanging one must not keep the others from the map. */
export const MOST_OF_ONE = 3;

interface Waiting {
  readonly source: string;
  /** Tiles that were asked for together. */
  readonly batch: number;
  readonly begin: () => void;
}

export function tileLoader(fetchWith: typeof fetch = (...args) => fetch(...args)): TileLoader {
  const running = new Map<string, number>();
  const waiting: Waiting[] = [];
  let [all, batch, isBatchOpen] = [0, 0, false];

  const ofOne = (source: string): number => running.get(source) ?? 0;

  /** The batch of the current task: tiles requested together. */
  function batchNow(): number {
    if (!isBatchOpen) {
      isBatchOpen = true;
      batch += 1;
      queueMicrotask(() => (isBatchOpen = false));
    }
    return batch;
  }

  /** The next tile: of the source with the fewest in flight, from the newest batch, which is in view now. */
  function turn(): number {
    let best = -1;
    waiting.forEach(({ source, batch: ofBatch }, index) => {
      if (ofOne(source) >= MOST_OF_ONE) return;
      const other = waiting[best];
      const fewer = other === undefined ? -1 : ofOne(source) - ofOne(other.source);
      if (fewer < 0 || (fewer === 0 && other !== undefined && ofBatch > other.batch)) best = index;
    });
    return best;
  }

  function goOn(): void {
    while (all < MOST_AT_ONCE) {
      const index = turn();
      const [next] = index < 0 ? [] : waiting.splice(index, 1);
      if (next === undefined) return;
      all += 1;
      running.set(next.source, ofOne(next.source) + 1);
      next.begin();
    }
  }

  return async (source, address, signal) => {
    const ofBatch = batchNow();
    await new Promise<void>((begin) => {
      waiting.push({ source, batch: ofBatch, begin });
      goOn();
    });
    try {
      return signal.aborted ? { kind: 'ended' } : await load(address, signal, fetchWith);
    } finally {
      all -= 1;
      running.set(source, ofOne(source) - 1);
      goOn();
    }
  };
}

async function load(address: string, signal: AbortSignal, fetchWith: typeof fetch): Promise<TileAnswer> {
  try {
    const response = await fetchWith(address, { credentials: 'same-origin', signal: connection.or(signal) });
    if (response.ok) {
      const isStale = response.headers.get('vencejo-tile') === 'stale';
      return { kind: 'tile', picture: await response.blob(), isStale };
    }
    const problem = await problemOf(response);
    const isNone = problem.status === 404 && problem.type.endsWith(':no-tile');
    return isNone ? { kind: 'none' } : { kind: 'failed', problem };
  } catch (error) {
    if (signal.aborted) return { kind: 'ended' };
    return { kind: 'failed', problem: noAnswer(error) };
  }
}
