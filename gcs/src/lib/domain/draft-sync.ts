/** Reconciles the draft in this browser with the one on the server: no changes are overwritten silently. */

/** The draft in this browser. */
export interface LocalDraft {
  /** The revision on the server that it comes from; 0 for none. */
  readonly base: number;
  /** Tells it from other drafts. */
  readonly mark: string;
  /** Whether it was changed since it was last on the server. */
  readonly isChanged: boolean;
  /** Whether nothing would be lost with it: it is empty, or what a vehicle has on board. */
  readonly isEmpty: boolean;
}

/** The draft on the server. */
export interface ServerDraft {
  readonly revision: number;
  readonly mark: string;
  readonly isEmpty: boolean;
}

/**
 * `push`: save ours on their revision. `adopt`: they are the same. `offer`: theirs differs, and nothing of ours would be lost.
 * `conflict`: both were changed, and a person decides.
 */
export type Meeting = 'none' | 'push' | 'adopt' | 'offer' | 'conflict';

export function meet(local: LocalDraft, server: ServerDraft | null): Meeting {
  if (server === null) return local.isEmpty ? 'none' : 'push';
  if (server.mark === local.mark) return 'adopt';
  if (server.revision === local.base) return local.isChanged ? 'push' : 'none';
  if (server.isEmpty) return local.isEmpty ? 'adopt' : 'push';
  return local.isEmpty || !local.isChanged ? 'offer' : 'conflict';
}

/** A short text that is the same for the same content (FNV-1a, twice 32 bits). */
export function markOf(text: string): string {
  let [a, b] = [0x811c9dc5, 0x9dc5811c];
  for (let index = 0; index < text.length; index += 1) {
    const code = text.charCodeAt(index);
    a = Math.imul(a ^ code, 0x01000193);
    b = Math.imul(b ^ (code + index), 0x01000193);
  }
  return [a, b].map((part) => (part >>> 0).toString(16).padStart(8, '0')).join('');
}
