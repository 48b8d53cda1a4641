// Words for why a vehicle takes no command.
import type { CommandBar } from '$lib/domain/command-bar';
import { t } from '$lib/i18n/index.svelte';

const WORDS = {
  recording: 'replay.bars',
  away: 'bar.serverAway',
  watching: 'fly.onlyWatching',
  control: 'fly.needControl',
  held: 'fly.heldElsewhere',
} as const;

export const barWords = (bar: CommandBar): string => t(WORDS[bar]);
