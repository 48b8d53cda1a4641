// Editing of fence and rally points: the tool, the polygon being drawn, and the selection.
import {
  addCircle,
  addPolygon,
  addRally,
  type AreaHandle,
  fenceHandles,
  isPolygon,
  moveHandle,
  rallyHandles,
  removeHandle,
  withRally,
  withReturnPoint,
  withZone,
} from '$lib/domain/area-edit';
import type { LonLat } from '$lib/domain/lonlat';
import type { FenceZone, RallyPoint, ReturnPoint } from '$lib/domain/plan';
import { roundLength_m } from '$lib/domain/units';
import { plan } from './plan.svelte';
import { settings } from './settings.svelte';
import type { ShapeEditor } from './shape-editor';

/** What a click on the map makes while the fence is edited; "in" is stayed in, "out" is stayed out of. */
export const FENCE_TOOLS = ['select', 'in-polygon', 'in-circle', 'out-polygon', 'out-circle', 'return'] as const;
export type FenceTool = (typeof FENCE_TOOLS)[number];

const isPolygonTool = (tool: FenceTool): boolean => tool.endsWith('polygon');

/** Radius of a new circle, metres. */
const NEW_RADIUS_M = 200;

class AreaStore implements ShapeEditor {
  #tool = $state<FenceTool>('in-polygon');
  /** The tool that draws, or drew last, a polygon. */
  #polygonTool: FenceTool = 'in-polygon';
  /**
   * Corners so far of the polygon that is being drawn; kept while another tool or part of the plan is in hand. The other tool for
   * polygons makes it one of the other kind.
   */
  #corners = $state.raw<readonly LonLat[]>([]);
  sketch = $derived(plan.part === 'fence' && isPolygonTool(this.#tool) ? this.#corners : []);
  selected = $state.raw<AreaHandle | null>(null);

  /** Whether clicks on the map are for fence or rally points. */
  isEditing = $derived(plan.isEditing && plan.part !== 'mission');
  /** What the map lets one move. */
  handles = $derived.by(() => {
    if (!this.isEditing) return [];
    return plan.part === 'fence' ? fenceHandles(plan.draft.fence) : rallyHandles(plan.draft.rally);
  });
  readonly isSketchLine = false;
  isSketching = $derived(this.sketch.length > 0);
  /** How many corners were drawn of the polygon that another tool has interrupted. */
  interrupted = $derived(this.#corners.length - this.sketch.length);
  canFinish = $derived(isPolygon(this.sketch));

  get tool(): FenceTool {
    return this.#tool;
  }
  set tool(tool: FenceTool) {
    this.#tool = tool;
    if (isPolygonTool(tool)) this.#polygonTool = tool;
  }
  get isInclusion(): boolean {
    return this.#tool.startsWith('in-');
  }

  /** A click on the map, beside everything. */
  click(at: LonLat): void {
    if (plan.part === 'rally') this.addRallyPoint(at);
    else if (this.#tool === 'select') this.selected = null;
    else if (isPolygonTool(this.#tool)) this.#corners = [...this.#corners, at];
    else if (this.#tool.endsWith('circle')) {
      const radius_m = roundLength_m(NEW_RADIUS_M, settings.units.length);
      plan.editAreas((areas) => ({ ...areas, fence: addCircle(areas.fence, this.isInclusion, at, radius_m) }));
      this.selected = { kind: 'centre', zone: plan.draft.fence.zones.length - 1 };
      this.tool = 'select';
    } else {
      const alt_m = plan.draft.fence.return_point?.alt_rel_home_m ?? plan.defaults.alt_m;
      plan.editAreas((areas) => ({ ...areas, fence: withReturnPoint(areas.fence, at, alt_m) }));
      this.selected = { kind: 'return' };
      this.tool = 'select';
    }
  }

  /** Closes the polygon being drawn, if it has three corners. */
  finish(): void {
    if (!this.canFinish) return;
    const corners = this.#corners;
    this.#corners = [];
    plan.editAreas((areas) => ({ ...areas, fence: addPolygon(areas.fence, this.isInclusion, corners) }));
    this.selected = { kind: 'centre', zone: plan.draft.fence.zones.length - 1 };
    this.tool = 'select';
  }

  /** Takes the last corner of the drawing back. */
  unsketch(): void {
    this.#corners = this.#corners.slice(0, -1);
  }

  cancelSketch(): void {
    this.#corners = [];
  }

  /** Goes on with the polygon that another tool has interrupted. */
  resumeSketch(): void {
    this.tool = this.#polygonTool;
  }

  /** Called during a drag; returns the handle held from now on. */
  drag(handle: AreaHandle, from: LonLat, to: LonLat, isEnd: boolean): AreaHandle {
    let held = handle;
    plan.editAreas((areas) => {
      const moved = moveHandle(areas, handle, from, to);
      held = moved.handle;
      return moved.areas;
    }, `area-${plan.part}`);
    if (isEnd) plan.seal();
    this.selected = held;
    return held;
  }

  remove(handle: AreaHandle | null = this.selected): void {
    if (handle === null) return;
    plan.editAreas((areas) => removeHandle(areas, handle));
    this.selected = null;
  }

  addRallyPoint(at: LonLat): void {
    const { alt_m, frame } = plan.defaults;
    plan.editAreas((areas) => ({ ...areas, rally: addRally(areas.rally, at, alt_m, frame) }));
    this.selected = { kind: 'rally', index: plan.draft.rally.length - 1 };
  }

  changeZone(index: number, change: Partial<FenceZone>): void {
    plan.editAreas((areas) => ({ ...areas, fence: withZone(areas.fence, index, (zone) => ({ ...zone, ...change })) }));
  }

  changeReturn(change: Partial<ReturnPoint>): void {
    plan.editAreas((areas) => {
      const { fence } = areas;
      if (fence.return_point === null) return areas;
      return { ...areas, fence: { ...fence, return_point: { ...fence.return_point, ...change } } };
    });
  }

  changeRally(index: number, change: Partial<RallyPoint>): void {
    plan.editAreas((areas) => ({ ...areas, rally: withRally(areas.rally, index, change) }));
  }
}

export const areas = new AreaStore();
plan.whenReplaced((before) => {
  if (plan.draft.fence !== before.fence) areas.cancelSketch();
});
