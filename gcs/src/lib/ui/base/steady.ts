// A scrolling box that keeps the element under the pointer in place when content above it grows or shrinks, so that no press hits something that has just moved there.
import type { Attachment } from 'svelte/attachments';

/** Keeps the element under the pointer where it is while the box's content changes its size. */
export const steady: Attachment<HTMLElement> = (box) => {
  let held: { element: Element; top: number; x: number; y: number } | null = null;

  function hold(element: Element | null, x: number, y: number): void {
    const isIn = element !== null && element !== box && box.contains(element);
    held = isIn ? { element, top: element.getBoundingClientRect().top, x, y } : null;
    // The browser's own scroll anchoring would interfere.
    box.style.overflowAnchor = held === null ? '' : 'none';
  }

  const onPointer = ({ target, clientX, clientY }: PointerEvent) => hold(target as Element, clientX, clientY);
  const onScroll = () => {
    if (held !== null) hold(document.elementFromPoint(held.x, held.y), held.x, held.y);
  };
  const release = () => hold(null, 0, 0);

  const sizes = new ResizeObserver(() => {
    if (!held?.element.isConnected) return;
    const top = held.element.getBoundingClientRect().top;
    if (Math.abs(top - held.top) >= 1) box.scrollTop += top - held.top;
    held.top = held.element.getBoundingClientRect().top;
  });
  const observe = () => {
    sizes.disconnect();
    for (const child of box.children) sizes.observe(child);
  };
  const children = new MutationObserver(observe);
  children.observe(box, { childList: true });
  observe();

  box.addEventListener('pointermove', onPointer, { passive: true });
  box.addEventListener('pointerdown', onPointer, { passive: true });
  box.addEventListener('pointerleave', release, { passive: true });
  box.addEventListener('scroll', onScroll, { passive: true });
  return () => {
    sizes.disconnect();
    children.disconnect();
    box.removeEventListener('pointermove', onPointer);
    box.removeEventListener('pointerdown', onPointer);
    box.removeEventListener('pointerleave', release);
    box.removeEventListener('scroll', onScroll);
  };
};
