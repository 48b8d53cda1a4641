import { expect, it, vi } from 'vitest';
import { type MapActs, theMap } from './the-map';

const at = { lat_deg: 40.3332, lon_deg: -3.7978 };
const box = { west_deg: -4, south_deg: 40, east_deg: -3, north_deg: 41 };
const acts = (): MapActs => ({
  centre: vi.fn(() => at),
  visibleBox: vi.fn(() => box),
  show: vi.fn(),
  goTo: vi.fn(),
  fit: vi.fn(),
  retryTiles: vi.fn(),
});

function useAll(): (LonLatOrBox | void)[] {
  return [
    theMap.centre(),
    theMap.visibleBox(),
    theMap.show(at),
    theMap.goTo(at),
    theMap.fit([at]),
    theMap.retryTiles('osm'),
  ];
}
type LonLatOrBox = ReturnType<typeof theMap.centre> | ReturnType<typeof theMap.visibleBox>;

it('acts by the map that there is, and by none after it is gone', () => {
  expect(useAll().slice(0, 2)).toEqual([null, null]);
  const map = acts();
  const detach = theMap.attach(map);
  expect(useAll().slice(0, 2)).toEqual([at, box]);
  for (const act of Object.values(map)) expect(act).toHaveBeenCalledOnce();
  detach();
  expect(useAll().slice(0, 2)).toEqual([null, null]);
  for (const act of Object.values(map)) expect(act).toHaveBeenCalledOnce();
});

it('keeps the newer map when the older one goes last', () => {
  const [older, newer] = [acts(), acts()];
  const [detachOlder, detachNewer] = [theMap.attach(older), theMap.attach(newer)];
  detachOlder();
  expect(theMap.centre()).toEqual(at);
  expect(newer.centre).toHaveBeenCalledOnce();
  detachNewer();
  expect(theMap.centre()).toBeNull();
});
