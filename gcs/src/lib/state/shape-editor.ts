// Who takes the gestures on the map that draw and change areas and lines: fence and rally points, or a survey.
import type { AreaHandle, PlacedHandle } from '$lib/domain/area-edit';
import type { LonLat } from '$lib/domain/lonlat';

export interface ShapeEditor {
  /** Whether clicks on the map are for it. */
  readonly isEditing: boolean;
  readonly handles: readonly PlacedHandle[];
  selected: AreaHandle | null;
  /** Corners so far of what is being drawn. */
  readonly sketch: readonly LonLat[];
  readonly isSketching: boolean;
  readonly isSketchLine: boolean;
  /** A click on the map, beside everything. */
  click(at: LonLat): void;
  /** As a pointer drags; gives what is held from now on. */
  drag(handle: AreaHandle, from: LonLat, to: LonLat, isEnd: boolean): AreaHandle;
  /** Ends the drawing, where there are corners enough. */
  finish(): void;
  /** Takes the last corner of the drawing back. */
  unsketch(): void;
  cancelSketch(): void;
  /** Takes away what is selected. */
  remove(): void;
}
