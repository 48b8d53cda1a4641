import { expect, it } from 'vitest';
import { handleOf, MOST_WIND_M_S, windOf } from './wind';

const CALM = { from_deg: 90, speed_m_s: 0 };

it('comes from where the handle is, as strong as that is far out', () => {
  expect(windOf(0, -0.5, CALM)).toEqual({ from_deg: 0, speed_m_s: 10 });
  expect(windOf(-0.253, 0, CALM)).toEqual({ from_deg: 270, speed_m_s: 5 });
  expect(windOf(-0.001, -1, CALM)).toEqual({ from_deg: 0, speed_m_s: MOST_WIND_M_S });
  expect(windOf(3, 3, CALM)).toEqual({ from_deg: 135, speed_m_s: MOST_WIND_M_S });
});

it('is calm in the middle, and keeps its direction there', () => {
  expect(windOf(-0.05, 0.04, { from_deg: 90, speed_m_s: 7 })).toEqual(CALM);
});

it('has its handle where it was set', () => {
  for (const wind of [
    { from_deg: 35, speed_m_s: 8.5 },
    { from_deg: 300, speed_m_s: 20 },
  ]) {
    const { east, south } = handleOf(wind);
    expect(windOf(east, south, CALM)).toEqual(wind);
  }
});
