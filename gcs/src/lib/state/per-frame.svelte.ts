// Throttles values that change more often than frames are drawn.
import { untrack } from 'svelte';

/** A value for drawing: the newest, taken over at most once a frame. To be called while a component is made; it ends with that. */
export function perFrame<T>(read: () => T): { readonly current: T } {
  let newest = untrack(read);
  let current = $state.raw(newest);
  let frame = 0;
  $effect(() => {
    newest = read();
    if (frame === 0 && newest !== untrack(() => current)) {
      frame = requestAnimationFrame(() => {
        frame = 0;
        current = newest;
      });
    }
  });
  $effect(() => () => cancelAnimationFrame(frame));
  return {
    get current() {
      return current;
    },
  };
}
