import { expect, it } from 'vitest';
import { vehicles } from '$lib/state/vehicles.svelte';
import { withoutVehicle } from './bars';

it('says whether there is no vehicle to show, or several to choose from', () => {
  expect(withoutVehicle('fly.needVehicle')).toBe('Commands appear when a vehicle is heard.');
  vehicles.ensure(300).isRecorded = true;
  for (const id of [1, 2]) vehicles.ensure(id);
  vehicles.drop(300);
  expect(vehicles.selected).toBeNull();
  expect(withoutVehicle('fly.needVehicle')).toBe('No vehicle is selected. Select one in the bar at the top.');
});
