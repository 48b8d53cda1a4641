import { expect, it } from 'vitest';
import { isLanding } from './landing';
import { makeItem } from './plan';

const at = { lat_deg: 40, lon_deg: -3 };
const items = [makeItem('waypoint', { at }), makeItem('land', { at })];
const flying = { mode: 'AUTO', landed: 'in air', isFlying: true, items, current: 2 };

it('knows a landing by the item in execution, by the mode, or because the vehicle says so', () => {
  expect(isLanding(flying)).toBe(true);
  expect(isLanding({ ...flying, current: 1 })).toBe(false);
  expect(isLanding({ ...flying, mode: 'AUTO_MISSION' })).toBe(true);
  expect(isLanding({ ...flying, mode: 'AUTOLAND', current: 1 })).toBe(true);
  expect(isLanding({ ...flying, mode: 'FBWA', landed: 'landing' })).toBe(true);
});

it('is none on the ground or in another mode, and not known with an unknown mission', () => {
  expect(isLanding({ ...flying, isFlying: false })).toBe(false);
  expect(isLanding({ ...flying, mode: 'RTL' })).toBe(false);
  expect(isLanding({ ...flying, mode: null })).toBe(false);
  expect(isLanding({ ...flying, items: null })).toBeNull();
  expect(isLanding({ ...flying, current: null })).toBeNull();
});
