import { beforeEach, expect, it } from 'vitest';
import { emptyPlan, makeItem } from '$lib/domain/plan';
import { areas } from './areas.svelte';
import { plan } from './plan.svelte';
import { canUndoStep, undoStep } from './undo-step';

const at = (n: number) => ({ lat_deg: 40 + (n % 2) / 100, lon_deg: -3 + Math.trunc(n / 2) / 100 });

beforeEach(() => {
  plan.clear();
  plan.isEditing = true;
  plan.part = 'fence';
  areas.cancelSketch();
  areas.tool = 'in-polygon';
});

it('keeps a half-drawn polygon while another tool or part is in hand', () => {
  for (const n of [0, 1, 2]) areas.click(at(n));
  plan.part = 'rally';
  areas.click(at(9));
  expect([areas.sketch.length, areas.interrupted, plan.draft.rally.length]).toEqual([0, 3, 1]);
  plan.part = 'fence';
  expect([areas.isSketching, areas.interrupted]).toEqual([true, 0]);
  areas.tool = 'out-circle';
  areas.click(at(8));
  expect([areas.tool, areas.isSketching, areas.interrupted]).toEqual(['select', false, 3]);
  areas.resumeSketch();
  areas.click(at(3));
  areas.finish();
  expect(plan.draft.fence.zones.map(({ points, inclusion }) => [points.length, inclusion])).toEqual([
    [1, false],
    [4, true],
  ]);
  expect([areas.isSketching, areas.interrupted]).toEqual([false, 0]);
});

it('makes a half-drawn polygon one of the other kind with the other tool', () => {
  for (const n of [0, 1, 2]) areas.click(at(n));
  areas.tool = 'out-circle';
  areas.tool = 'out-polygon';
  areas.click(at(3));
  expect([areas.sketch.length, areas.interrupted]).toEqual([4, 0]);
  areas.finish();
  expect(plan.draft.fence.zones.map(({ points, inclusion }) => [points.length, inclusion])).toEqual([[4, false]]);
});

it('undoes the corners of what is drawn before changes of the plan', () => {
  areas.tool = 'in-circle';
  areas.click(at(5));
  areas.tool = 'in-polygon';
  for (const n of [0, 1]) areas.click(at(n));
  undoStep();
  expect([areas.sketch.length, plan.draft.fence.zones.length]).toEqual([1, 1]);
  undoStep();
  undoStep();
  expect([areas.sketch.length, plan.draft.fence.zones.length, canUndoStep()]).toEqual([0, 0, true]);
});

it('drops what is half drawn with the fence that it was drawn for', () => {
  const draw = () => [0, 1, 2].forEach((n) => areas.click(at(n)));
  draw();
  plan.clear('mission');
  expect(areas.sketch.length).toBe(3);
  plan.clear('fence');
  expect(areas.sketch.length).toBe(0);
  draw();
  plan.replace({ ...emptyPlan(), items: [makeItem('waypoint', { at: at(0), alt_m: 80 })] });
  expect(areas.sketch.length).toBe(0);
});
