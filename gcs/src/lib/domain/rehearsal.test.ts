import { describe, expect, it } from 'vitest';
import { destination } from './geo';
import { NO_PROFILE } from './profile';
import { alongProfile, endsInDanger, firstPassages, momentAt, nearestToGround, type Track } from './rehearsal';

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

it('is nearest to the ground where it flies, not where it climbs out or lands', () => {
  const along_m = [0, 100, 200, 300, 400, 500, 600, 700];
  const flown = {
    ...track(8),
    height_m: [0, 20, 50, 60, 60, 60, 40, 10],
    ground_m: [0, 0, 0, null, 35, 20, 0, 0],
    item: [1, 1, 1, 2, 2, 3, 4, 4],
  };
  const isLow = (number: number) => number === 1 || number === 4;
  expect(nearestToGround(flown, along_m, 30, isLow)).toEqual({ clearance_m: 25, distance_m: 400 });
  // what never climbs that high has left all the same at its third item
  expect(nearestToGround(flown, along_m, 80, isLow)).toEqual({ clearance_m: 40, distance_m: 500 });
  expect(nearestToGround({ ...flown, ground_m: flown.ground_m.map(() => null) }, along_m, 30, isLow)).toBeNull();
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

describe('a track along the profile', () => {
  const made = { alt_rel_home_m: 80, is_certain: true, is_beyond: false };
  const points = [null, 1, 2].map((item, at) => ({ ...made, item, distance_m: [0, 300, 800][at]!, is_item: at > 0 }));
  // a point that leads to the second item over the ground
  points.splice(2, 0, { ...made, item: 2, distance_m: 500, is_item: false });
  const profile = { ...NO_PROFILE, points, length_m: 800 };
  const passage = (item: number, begins_s: number, reached_s: number | null) => ({
    item,
    begins_s,
    reached_s,
    nearest_m: 0,
  });

  it('has each item where the profile has it, and goes on beyond the last', () => {
    const along_m = alongProfile(track(13), [passage(1, 0, 20), passage(2, 20, 50)], profile);
    expect(along_m[2]).toBeCloseTo(150, 0);
    expect(along_m[4]).toBeCloseTo(300, 0);
    expect(along_m[10]).toBeCloseTo(800, 0);
    expect(along_m[12]).toBeCloseTo(1000, 0);
  });

  it('goes back where a jump does, and no farther than it flew to what it never reaches', () => {
    const passages = [passage(1, 0, 20), passage(2, 20, 40), passage(1, 40, 50), passage(2, 50, null)];
    const along_m = alongProfile(track(13), passages, profile);
    expect(along_m[8]).toBeCloseTo(800, 0);
    expect(along_m[9]).toBeCloseTo(150, 0);
    expect(along_m[12]).toBeCloseTo(500, 0);
    expect(firstPassages(passages).get(2)?.reached_s).toBe(40);
  });
});
