// Keyboard shortcuts. None of them commands the vehicle: that takes a button, held.
import { t } from '$lib/i18n/index.svelte';
import { cameras } from '$lib/state/camera.svelte';
import { help } from '$lib/state/help.svelte';
import { layout, type Panel } from '$lib/state/layout.svelte';
import { mapLook } from '$lib/state/map.svelte';
import { settings } from '$lib/state/settings.svelte';
import { station } from '$lib/state/station.svelte';
import { vehicles } from '$lib/state/vehicles.svelte';

interface Shortcut {
  key: string;
  shown: string;
  text: () => string;
  run: () => void;
}

const panel = (key: string, name: Panel): Shortcut => ({
  key,
  shown: key.toUpperCase(),
  text: () => t('key.panel', { panel: t(`panel.${name}`) }),
  run: () => layout.toggle(name),
});

export const SHORTCUTS: readonly Shortcut[] = [
  panel('f', 'fly'),
  panel('i', 'instruments'),
  panel('p', 'plan'),
  panel('n', 'numbers'),
  panel('s', 'sensors'),
  panel('m', 'messages'),
  panel('a', 'params'),
  panel('l', 'maps'),
  panel(',', 'settings'),
  { key: 'g', shown: 'G', text: () => t('goTo.title'), run: () => (mapLook.isGoingTo = true) },
  { key: 'c', shown: 'C', text: () => t('key.camera'), run: () => cameras.toggle() },
  {
    key: 'v',
    shown: 'V',
    text: () => t('key.vehicle'),
    run: () => vehicles.next && station.choose(vehicles.next.systemId),
  },
  {
    key: 't',
    shown: 'T',
    text: () => t('key.theme'),
    run: () => (settings.theme = settings.shownTheme === 'dark' ? 'light' : 'dark'),
  },
  { key: '?', shown: '?', text: () => t('key.help'), run: () => (help.isOpen = !help.isOpen) },
  {
    key: 'Escape',
    shown: 'Esc',
    text: () => t('key.escape'),
    run: () => {
      const open = layout.sheet ?? layout.right;
      if (open !== null) layout.close(open);
    },
  },
];

/** Whether the focused element takes letters itself. */
function isTyping(target: EventTarget | null): boolean {
  return (
    target instanceof HTMLElement &&
    (target.isContentEditable ||
      /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName) ||
      target.closest('[role=menu]') !== null)
  );
}

export function onShortcut(event: KeyboardEvent): void {
  if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
  if (isTyping(event.target)) return;
  // the dialog closes itself by Esc, and what lies below it is not seen
  if (help.isOpen && event.key !== '?') return;
  const shortcut = SHORTCUTS.find(({ key }) => key === event.key || key === event.key.toLowerCase());
  if (shortcut === undefined) return;
  event.preventDefault();
  shortcut.run();
}
