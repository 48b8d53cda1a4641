// Words for why a vehicle takes no command, or there is none to show.
import type { CommandBar } from '$lib/domain/command-bar';
import { type MessageKey, t } from '$lib/i18n/index.svelte';
import { vehicles } from '$lib/state/vehicles.svelte';

const WORDS = {
  recording: 'replay.bars',
  away: 'bar.serverAway',
  watching: 'fly.onlyWatching',
  control: 'fly.needControl',
  held: 'fly.heldElsewhere',
} as const;

export const barWords = (bar: CommandBar): string => t(WORDS[bar]);

/** Why there is no vehicle: of several none is selected, or none is heard, in the words for that. */
export const withoutVehicle = (unheard: MessageKey): string => t(vehicles.all.length > 0 ? 'bar.selectOne' : unheard);
