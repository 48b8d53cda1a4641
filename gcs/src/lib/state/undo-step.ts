// Undo: takes back the last corner of what is being drawn, or else the last change of the plan.
import { areas } from './areas.svelte';
import { plan } from './plan.svelte';
import { surveys } from './surveys.svelte';

const shapes = () => (surveys.isEditing ? surveys : areas);

export const canUndoStep = (): boolean => shapes().isSketching || plan.canUndo;

export function undoStep(): void {
  if (shapes().isSketching) shapes().unsketch();
  else plan.undo();
}
