// Brings a plan into view on the map.
import { fenceHandles, rallyHandles } from '$lib/domain/area-edit';
import { destination } from '$lib/domain/geo';
import type { LonLat } from '$lib/domain/lonlat';
import { isLoiter, type PlanItem, placeOf } from '$lib/domain/plan';
import { placesOf } from '$lib/domain/rehearsal';
import { mapLook } from './map.svelte';
import { plan } from './plan.svelte';
import { planAssessed } from './plan-assessed.svelte';
import { planCompared } from './plan-compared.svelte';
import { rehearsal } from './rehearsal.svelte';
import { theMap } from './the-map';
import { vehicles } from './vehicles.svelte';
import { ways } from './ways.svelte';

/** The circle round a place, by its outermost points. */
const outmost = (at: LonLat, radius_m: number): LonLat[] =>
  [0, 90, 180, 270].map((bearing_deg) => destination(at, bearing_deg, radius_m));

/** Circles flown round items: of the path, and until it is known as the items say. */
function circles(items: readonly PlanItem[]): LonLat[] {
  const told = new Map(ways.draft.stops.map(({ index, loiter }) => [index, loiter?.radius_m]));
  return items.flatMap((item, index) => {
    const at = placeOf(item);
    const own_m = isLoiter(item) ? vehicles.route.loiterRadius_m : 0;
    const radius_m = items === plan.items ? (told.get(index) ?? own_m) : own_m;
    return at === null || radius_m === 0 ? [] : outmost(at, radius_m);
  });
}

/**
 * Shows the plan that is edited as it is drawn: with its circles, its rehearsed track, fence and rally points; where it has no mission,
 * that of the vehicle. The track at hand is not that of a plan that `isNew`.
 */
export function showPlan({ isNew = false } = {}): void {
  const { fence, rally } = plan.draft;
  const items = plan.items.length > 0 ? plan.items : (planCompared.vehiclePlan?.items ?? []);
  const areas = [...fenceHandles(fence), ...rallyHandles(rally)].map(({ at }) => at);
  const zones = fence.zones.flatMap(({ points: [at], radius_m }) =>
    radius_m === null || at === undefined ? [] : outmost(at, radius_m),
  );
  const track = isNew || rehearsal.shown === null || planAssessed.isRehearsalOld ? [] : placesOf(rehearsal.shown.track);
  const drawn = [...items.map(placeOf), ...circles(items), ...areas, ...zones, ...track, plan.home];
  if (mapLook.follow === 'follow') mapLook.follow = 'sight';
  theMap.fit(drawn.filter((at): at is LonLat => at !== null));
}
