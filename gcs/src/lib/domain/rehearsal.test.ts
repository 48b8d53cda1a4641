import { describe, expect, it } from 'vitest';
import { destination } from './geo';
import { endsInDanger, firstPassages, momentAt, type Track } from './rehearsal';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 690 };
/** North from home at 20 m/s, a moment every 100 m. */
const track = (count: number): Track => {
  const indices = Array.from({ length: count }, (_, index) => index);
  const places = indices.map((index) => destination(HOME, 0, index * 100));
  return {
    time_s: indices.map((index) => index * 5),
    lat_deg: places.map((at) => at.lat_deg),
    lon_deg: places.map((at) => at.lon_deg),
    height_m: indices.map((index) => index * 10),
    ground_m: indices.map(() => null),
    airspeed_m_s: indices.map(() => 20),
    groundspeed_m_s: indices.map(() => 20),
    bank_deg: indices.map(() => 0),
    heading_deg: indices.map((index) => (index % 2 === 0 ? 350 : 10)),
    item: indices.map((index) => (index < 3 ? 1 : null)),
  };
};

it('is no danger to land, to come back or to circle', () => {
  const dangers = ['landed', 'returned', 'unlimited', 'ground', 'held', 'grounded', 'endless'].filter((ending) =>
    endsInDanger({ ending }),
  );
  expect(dangers).toEqual(['ground', 'held', 'grounded', 'endless']);
  expect(endsInDanger(null)).toBe(false);
});

describe('a moment of a rehearsal', () => {
  it('lies between those of the track, angles the shorter way round', () => {
    const moment = momentAt(track(4), 7.5);
    expect(moment).toMatchObject({ time_s: 7.5, height_m: 15, item: 1, heading_deg: 0 });
    expect(moment?.at.lat_deg).toBeCloseTo(destination(HOME, 0, 150).lat_deg, 6);
  });

  it('is kept within the track', () => {
    expect(momentAt(track(4), -1)?.time_s).toBe(0);
    expect(momentAt(track(4), 99)).toMatchObject({ time_s: 15, height_m: 30, item: null });
    expect(momentAt(track(0), 0)).toBeNull();
  });

  it('crosses the date line', () => {
    const crossing = { ...track(2), lat_deg: [0, 0], lon_deg: [179.9, -179.9] };
    expect(Math.abs(momentAt(crossing, 2.5)?.at.lon_deg ?? 0)).toBeCloseTo(180, 6);
    expect(momentAt(crossing, 4)?.at.lon_deg).toBeCloseTo(-179.94, 6);
  });
});

it('knows the first passage of each item', () => {
  const passage = (item: number, reached_s: number | null) => ({ item, begins_s: 0, reached_s, nearest_m: 0 });
  const first = firstPassages([passage(1, 20), passage(2, 40), passage(1, 50), passage(2, null)]);
  expect([...first.values()].map(({ reached_s }) => reached_s)).toEqual([20, 40]);
});
