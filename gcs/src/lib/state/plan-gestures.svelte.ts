// What a click with the tool in hand makes, and what a drag moves.
import { isPlacedKind, type EditableKind } from '$lib/domain/plan';
import type { LonLat } from '$lib/domain/lonlat';
import { addAt, landingPart, shiftKeys } from '$lib/domain/plan-edit';
import { plan } from './plan.svelte';
import { planLanding } from './plan-landing.svelte';

class PlanGestures {
  /** Adds what the tool in hand makes. Take-off and landing are for one click each (SPEC G5). */
  addWithTool(at: LonLat): void {
    if (plan.tool === 'select') {
      plan.selectKeys([]);
      return;
    }
    if (plan.tool === 'runway') {
      planLanding.markRunway(at);
      return;
    }
    this.add(plan.tool, isPlacedKind(plan.tool) ? at : null);
    if (plan.tool === 'takeoff' || plan.tool === 'land' || !isPlacedKind(plan.tool)) plan.tool = 'waypoint';
  }

  add(kind: EditableKind, at: LonLat | null): void {
    if (kind !== 'land') plan.addWith((draft) => addAt(draft, kind, at, plan.defaults));
    else if (at !== null) plan.waitFor(planLanding.land(at));
  }

  /** Moves an item, or the selection that it is part of, as a pointer drags it. */
  drag(number: number, from: LonLat, to: LonLat, isEnd: boolean): void {
    const key = plan.items[number - 1]?.key;
    if (key === undefined) return;
    if (!plan.selectedKeys.has(key)) plan.pick(key, false);
    const part = plan.selectedKeys.size === 1 ? landingPart(plan.draft, key, plan.end) : null;
    if (part !== null) {
      planLanding.drag(part, key, from, to, isEnd);
      return;
    }
    // an item inserted by this very drag is one step with it
    const about = plan.about?.startsWith('insert-') ? plan.about : `drag-${key}`;
    plan.edit((draft) => shiftKeys(draft, plan.selectedKeys, from, to), about);
    if (isEnd) plan.seal();
  }
}

export const planGestures = new PlanGestures();
