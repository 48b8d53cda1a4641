// The interface of editors for areas and lines drawn on the map: fence and rally points, or a survey.
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
  /** Called during a drag; returns the handle held from now on. */
  drag(handle: AreaHandle, from: LonLat, to: LonLat, isEnd: boolean): AreaHandle;
  /** Ends the drawing, where there are corners enough. */
  finish(): void;
  /** Takes the last corner of the drawing back. */
  unsketch(): void;
  cancelSketch(): void;
  /** Removes the selection. */
  remove(): void;
}
