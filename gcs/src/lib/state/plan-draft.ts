// What the rest of the app may ask of the plan draft. `plan.svelte.ts` holds the draft and exports
// `plan: PlanDraft`; drawing and editing belong to map/ and ui/plan/.
import type { PlanItem } from '$lib/api/types';

/** How the draft stands to what the selected vehicle is known to have on board; `uncompared` until the core has said. */
export type DraftState = 'empty' | 'not-sent' | 'sending' | 'verified' | 'differs' | 'uncompared' | 'unknown';

export interface PlanDraft {
  /** The mission's items, in order; item numbers shown to people are index + 1, as in `MissionProgress`. */
  readonly items: readonly PlanItem[];
  /** Numbers (from 1) of the items selected in table, map and profile alike. */
  readonly selection: ReadonlySet<number>;
  readonly state: DraftState;
  /** Whether the map takes clicks as new items. */
  isEditing: boolean;
  select(numbers: Iterable<number>): void;
}
