import { afterEach, expect, it, vi } from 'vitest';
import { ownProblem, ProblemError } from '$lib/api/problem';
import type { ServerMessage } from '$lib/api/types';
import { fleet } from './fleet.svelte';
import { stationLease, vehicleLease } from './leases.svelte';
import { api, station } from './station.svelte';

const refused = () => new ProblemError(ownProblem('The aircraft does not answer', 409));
const ofPlane7 = () => vehicleLease(fleet.row(300)!);

function tell(row: object): void {
  const message = { type: 'roster', time_s: 1, rows: [{ id: 300, ...row }], gone: [], followed: [] };
  station.receive(message as unknown as ServerMessage);
}

afterEach(() => {
  vi.restoreAllMocks();
});

it('shows a refusal until control of the vehicle changes hands or is asked for', async () => {
  tell({ remote_name: 'plane7', holder: 'Luis', is_held_here: false, requested_by: null });
  let refuse!: (error: Error) => void;
  vi.spyOn(api, 'requestVehicle').mockReturnValue(new Promise((_, reject) => (refuse = reject)));
  const asked = ofPlane7().ask();
  expect([ofPlane7().isBusy, ofPlane7().problem]).toEqual([true, null]);
  refuse(refused());
  await asked;
  expect([ofPlane7().isBusy, ofPlane7().problem?.title]).toEqual([false, 'The aircraft does not answer']);
  tell({ mode: 'RTL' });
  expect(ofPlane7().problem, 'control stands as it did').not.toBeNull();
  tell({ holder: 'Ana', is_held_here: true });
  tell({ holder: 'Luis', is_held_here: false });
  expect(ofPlane7().problem).toBeNull();
});

it('shows a refusal of the station’s control until that changes', async () => {
  vi.spyOn(api, 'requestControl').mockRejectedValue(refused());
  const asked = stationLease().ask();
  expect(stationLease().isBusy).toBe(true);
  await asked;
  expect([stationLease().isBusy, stationLease().problem?.title]).toEqual([false, 'The aircraft does not answer']);
  station.receive({ type: 'control', has_control: true, holder: 'Ana', requested_by: null });
  expect(stationLease().problem).toBeNull();
});

it('does not wait beyond a new connection for what was asked over the last one', () => {
  tell({ holder: 'Luis', is_held_here: false });
  const never = new Promise<never>(() => undefined);
  vi.spyOn(api, 'requestControl').mockReturnValue(never);
  vi.spyOn(api, 'requestVehicle').mockReturnValue(never);
  void stationLease().ask();
  void ofPlane7().ask();
  expect([stationLease().isBusy, ofPlane7().isBusy]).toEqual([true, true]);
  const hello = { type: 'hello', version: '1', time_s: 0, session: 's', name: 'Ana', role: 'operator' };
  station.receive({ ...hello, has_control: false, holder: null, requested_by: null } as ServerMessage);
  expect([stationLease().isBusy, ofPlane7().isBusy]).toEqual([false, false]);
});
