// Brings a plan into view on the map.
import { fenceHandles, rallyHandles } from '$lib/domain/area-edit';
import type { LonLat } from '$lib/domain/lonlat';
import { placeOf } from '$lib/domain/plan';
import { mapLook } from './map.svelte';
import { plan } from './plan.svelte';
import { planCompared } from './plan-compared.svelte';
import { theMap } from './the-map';

/** Shows the plan that is edited, with its fence and rally points; where it has no mission, that of the vehicle. */
export function showPlan(): void {
  const { fence, rally } = plan.draft;
  const items = plan.items.length > 0 ? plan.items : (planCompared.vehiclePlan?.items ?? []);
  const areas = [...fenceHandles(fence), ...rallyHandles(rally)].map(({ at }) => at);
  const places = [...items.map(placeOf), ...areas, plan.home].filter((at): at is LonLat => at !== null);
  if (mapLook.follow === 'follow') mapLook.follow = 'sight';
  theMap.fit(places);
}
