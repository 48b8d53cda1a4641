/** Reordering rows of a list by dragging. */

/** Upper and lower edge of a row, in the pointer's coordinates. */
export interface Row {
  readonly top: number;
  readonly bottom: number;
}

/** Index of the row before which something that is let go at `y` belongs; the number of rows when it is below all. */
export function insertionIndex(rows: readonly Row[], y: number): number {
  const index = rows.findIndex(({ top, bottom }) => y < (top + bottom) / 2);
  return index < 0 ? rows.length : index;
}
