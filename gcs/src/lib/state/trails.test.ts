import { afterEach, expect, it, vi } from 'vitest';
import { telemetryAt } from '../../../dev/mock/flight';
import { trails } from './trails';
import { vehicles } from './vehicles.svelte';

const { position } = telemetryAt(100).groups;

/** A vehicle that is followed, and tells where it is. */
function record(id: number, lat_deg: number): void {
  vehicles.ensure(id);
  vehicles.telemetry(id, 0, { position: { ...position!, lat_deg } }, null);
}

afterEach(() => {
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

it('keeps the trails of the vehicles that are followed, and puts the others away', async () => {
  vi.useFakeTimers();
  const stored = new Map<string, string>();
  vi.stubGlobal('sessionStorage', {
    getItem: (key: string) => stored.get(key) ?? null,
    setItem: (key: string, value: string) => stored.set(key, value),
  });
  vi.stubGlobal('window', { addEventListener: () => undefined, removeEventListener: () => undefined });
  vi.stubGlobal('document', { hidden: true });
  const stop = trails.start();
  for (let id = 1; id <= 20; id += 1) {
    for (let point = 0; point < 3; point += 1) {
      record(id, 40 + point / 1000);
      await vi.advanceTimersByTimeAsync(500);
    }
    if (id > 8) vehicles.drop(id - 8);
  }
  await vi.advanceTimersByTimeAsync(10_000);
  expect(trails.all).toHaveLength(8);
  record(2, 40.01);
  await vi.advanceTimersByTimeAsync(500);
  expect(trails.of(2)?.length, 'as it was, when it is followed again').toBe(4);
  stop();
});
