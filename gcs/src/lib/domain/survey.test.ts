import { describe, expect, it } from 'vitest';
import { destination, distance_m } from './geo';
import { moveSurvey, surveyHandles, turner, withoutCorner } from './survey';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978 };
const at = (bearing: number, distance: number) => destination(HOME, bearing, distance);
const AREA = { places: [at(315, 500), at(45, 500), at(135, 500), at(225, 500)], width_m: null };
const ROAD = { places: [at(270, 800), HOME, at(45, 800)], width_m: 80 };

describe('handles of a survey', () => {
  it('has corners and the middles between them, of a line without one between its ends', () => {
    const kinds = (handles: ReturnType<typeof surveyHandles>) => handles.map(({ handle }) => handle.kind).sort();
    const four = (kind: string) => Array.from({ length: 4 }, () => kind);
    expect(kinds(surveyHandles(AREA, 90))).toEqual(['centre', ...four('corner'), 'course', ...four('edge')]);
    expect(kinds(surveyHandles(ROAD, 90))).toEqual(['corner', 'corner', 'corner', 'edge', 'edge']);
  });

  it('moves corners, inserts on edges, moves and turns the whole, and keeps what it took', () => {
    const to = at(0, 900);
    const [corner, edge] = [
      { kind: 'corner', zone: 0, corner: 2 },
      { kind: 'edge', zone: 0, corner: 3 },
    ] as const;
    expect(moveSurvey(AREA, corner, AREA.places[2]!, to)?.change.places?.[2]).toEqual(
      expect.objectContaining({ lat_deg: expect.closeTo(to.lat_deg, 6) as number }),
    );
    const inserted = moveSurvey(AREA, edge, AREA.places[3]!, to);
    expect(inserted?.handle).toEqual({ kind: 'corner', zone: 0, corner: 4 });
    expect(inserted?.change.places).toHaveLength(5);
    const whole = moveSurvey(AREA, { kind: 'centre', zone: 0 }, HOME, to)?.change.places ?? [];
    whole.forEach((place, index) => expect(distance_m(place, AREA.places[index]!)).toBeCloseTo(900, 0));
    expect(moveSurvey(AREA, { kind: 'course', zone: 0 }, HOME, at(123.4, 700))?.change.course_deg).toBe(123);
    expect(distance_m(turner(AREA, 123), HOME)).toBeCloseTo(625, 0);
    expect(AREA.places).toHaveLength(4);
  });

  it('leaves as many corners as lines can be laid out from', () => {
    expect(withoutCorner(AREA, { kind: 'corner', zone: 0, corner: 0 })).toEqual(AREA.places.slice(1));
    const triangle = { ...AREA, places: AREA.places.slice(1) };
    expect(withoutCorner(triangle, { kind: 'corner', zone: 0, corner: 0 })).toBeNull();
    expect(withoutCorner(ROAD, { kind: 'corner', zone: 0, corner: 1 })).toHaveLength(2);
    expect(withoutCorner(AREA, { kind: 'centre', zone: 0 })).toBeNull();
  });
});
