import { afterEach, expect, it, vi } from 'vitest';
import type { AreaEstimate, MapSource } from '$lib/api/maps-types';
import { mapsApi } from './maps.svelte';
import { offlineAreas } from './maps-offline.svelte';

afterEach(() => {
  vi.useRealTimers();
  vi.restoreAllMocks();
});

it('shows no estimate of what is no longer drawn', async () => {
  vi.useFakeTimers();
  let answer!: (estimate: AreaEstimate) => void;
  vi.spyOn(mapsApi, 'estimateArea').mockReturnValue(new Promise((resolve) => (answer = resolve)));
  const source = { id: 'x' } as MapSource;
  offlineAreas.begin('polygon', null);
  offlineAreas.points = [40.3, 40.31, 40.32].map((lat_deg, index) => ({ lat_deg, lon_deg: -3.7 + 0.01 * (index % 2) }));
  offlineAreas.ask(source, 1, 2);
  await vi.advanceTimersByTimeAsync(1000);
  offlineAreas.removeLast();
  offlineAreas.ask(source, 1, 2);
  answer({ tiles: 999 } as AreaEstimate);
  await vi.advanceTimersByTimeAsync(1000);
  expect([offlineAreas.drawn, offlineAreas.estimate, offlineAreas.isEstimating]).toEqual([null, null, false]);
  offlineAreas.end();
});
