/** What is different between the plan being edited and the one that the vehicle has. */

import { sameLonLat } from './lonlat';
import { altOf_m, COMMAND, isPlaced, kindOf, type PlanItem, placeOf } from './plan';

export type DiffEntry =
  /** Numbers count from 1: `draft` in the plan being edited, `vehicle` on board. */
  | { readonly kind: 'added'; readonly draft: number; readonly item: PlanItem }
  | { readonly kind: 'removed'; readonly vehicle: number; readonly item: PlanItem }
  | {
      readonly kind: 'changed';
      readonly draft: number;
      readonly vehicle: number;
      readonly item: PlanItem;
      readonly was: PlanItem;
      readonly fields: readonly DiffField[];
    };

/** Of a plan, what is flown. */
export interface Mission {
  readonly items: readonly PlanItem[];
}

export type DiffField = 'command' | 'place' | 'height' | 'parameters';

/** Heights nearer than this are one: a vehicle keeps centimetres. */
const SAME_HEIGHT_M = 0.011;
/** Parameters nearer than this are one: they travel as 32-bit floats. */
const SAME_PARAM = 1e-4;

/** What of an item differs from another. Values that the item's command has no use for do not count. */
function fieldsThatDiffer(a: PlanItem, b: PlanItem): DiffField[] {
  if (a.command !== b.command) return ['command'];
  const fields: DiffField[] = [];
  if (isPlaced(a) || isPlaced(b)) {
    const [at, other] = [placeOf(a), placeOf(b)];
    if (at === null || other === null ? at !== other : !sameLonLat(at, other)) fields.push('place');
    if (a.frame !== b.frame || !near(altOf_m(a), altOf_m(b), SAME_HEIGHT_M)) fields.push('height');
  }
  const count = isPlaced(a) || kindOf(a) !== 'other' ? 4 : 7;
  for (let index = 0; index < count; index += 1) {
    const [left, right] = [kept(a, index), kept(b, index)];
    if (!near(left, right, SAME_PARAM * Math.max(1, Math.abs(left)))) {
      fields.push('parameters');
      break;
    }
  }
  return fields;
}

/** A parameter as it comes back: an ArduPlane keeps of a landing's parameter 4 the sign alone, and that of 0 or nothing is 1. */
function kept({ command, params }: PlanItem, index: number): number {
  const value = params[index] ?? 0;
  return command === COMMAND.land && index === 3 && value === 0 ? 1 : value;
}

function near(a: number | null, b: number | null, tolerance: number): boolean {
  return a === null || b === null ? a === b : Math.abs(a - b) <= tolerance;
}

const isSameItem = (a: PlanItem, b: PlanItem): boolean => fieldsThatDiffer(a, b).length === 0;

export function isSameMission(a: Mission, b: Mission): boolean {
  return (
    a.items.length === b.items.length && a.items.every((item, index) => isSameItem(item, b.items[index] as PlanItem))
  );
}

/**
 * The shortest story of how the vehicle's items became the draft's: items that stayed are left out, and one that was
 * taken out where another was put in is told as changed.
 */
export function diffMissions(draft: readonly PlanItem[], vehicle: readonly PlanItem[]): DiffEntry[] {
  let begin = 0;
  while (begin < draft.length && begin < vehicle.length && same(draft, begin, vehicle, begin)) begin += 1;
  let [draftEnd, vehicleEnd] = [draft.length, vehicle.length];
  while (draftEnd > begin && vehicleEnd > begin && same(draft, draftEnd - 1, vehicle, vehicleEnd - 1)) {
    draftEnd -= 1;
    vehicleEnd -= 1;
  }
  const [rows, columns] = [draftEnd - begin, vehicleEnd - begin];
  // longest common subsequence; a mission has at most some hundred items, and both ends are cut off already
  const width = columns + 1;
  const longest = new Uint16Array((rows + 1) * width);
  for (let row = rows - 1; row >= 0; row -= 1) {
    for (let column = columns - 1; column >= 0; column -= 1) {
      longest[row * width + column] = same(draft, begin + row, vehicle, begin + column)
        ? (longest[(row + 1) * width + column + 1] as number) + 1
        : Math.max(longest[(row + 1) * width + column] as number, longest[row * width + column + 1] as number);
    }
  }
  const entries: DiffEntry[] = [];
  let added: number[] = [];
  let removed: number[] = [];
  const flush = (): void => {
    for (let index = 0; index < Math.max(added.length, removed.length); index += 1) {
      const [to, from] = [added[index], removed[index]];
      if (to !== undefined && from !== undefined) {
        const [item, was] = [draft[to] as PlanItem, vehicle[from] as PlanItem];
        const fields = fieldsThatDiffer(item, was);
        entries.push({ kind: 'changed', draft: to + 1, vehicle: from + 1, item, was, fields });
      } else if (to !== undefined) {
        entries.push({ kind: 'added', draft: to + 1, item: draft[to] as PlanItem });
      } else if (from !== undefined) {
        entries.push({ kind: 'removed', vehicle: from + 1, item: vehicle[from] as PlanItem });
      }
    }
    [added, removed] = [[], []];
  };
  let [row, column] = [0, 0];
  while (row < rows || column < columns) {
    if (row < rows && column < columns && same(draft, begin + row, vehicle, begin + column)) {
      flush();
      row += 1;
      column += 1;
    } else if (
      column >= columns ||
      (row < rows && (longest[(row + 1) * width + column] as number) >= (longest[row * width + column + 1] as number))
    ) {
      added.push(begin + row);
      row += 1;
    } else {
      removed.push(begin + column);
      column += 1;
    }
  }
  flush();
  return entries;
}

function same(a: readonly PlanItem[], at: number, b: readonly PlanItem[], other: number): boolean {
  return isSameItem(a[at] as PlanItem, b[other] as PlanItem);
}
