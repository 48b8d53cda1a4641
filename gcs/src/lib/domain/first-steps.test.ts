import { expect, it } from 'vitest';
import { firstSteps, type Standing, stepToTake } from './first-steps';

const unknown: Standing = {
  hasPlan: false,
  isSent: false,
  isArmed: null,
  needsPreparation: null,
  isReady: null,
  followsMission: null,
};
const done = (known: Partial<Standing>) =>
  firstSteps({ ...unknown, ...known }).flatMap(({ name, isDone }) => (isDone ? [name] : []));

it('counts nothing as done that is not known', () => {
  expect(done({})).toEqual([]);
  expect(done({ isArmed: false })).toEqual([]);
  expect(done({ needsPreparation: false })).toEqual([]);
});

it('goes on as the vehicle does', () => {
  const sent = { hasPlan: true, isSent: true, isArmed: false, followsMission: true };
  expect(done({ ...sent, needsPreparation: true })).toEqual(['plan', 'send']);
  expect(done({ ...sent, needsPreparation: false })).toEqual(['plan', 'send', 'prepare']);
  expect(done({ ...sent, needsPreparation: false, isReady: true })).toEqual(['plan', 'send', 'prepare', 'ready']);
  expect(done({ ...sent, isArmed: true, followsMission: false })).toEqual(['plan', 'send', 'prepare', 'ready', 'arm']);
  expect(done({ ...sent, isArmed: true })).toHaveLength(6);
});

it('leads to what comes next, and never to arm before there is a plan on board', () => {
  const on = (known: Partial<Standing>) => stepToTake({ ...unknown, isArmed: false, isReady: true, ...known });
  expect(on({})).toBe('plan');
  expect(on({ hasPlan: true })).toBe('send');
  const sent = { hasPlan: true, isSent: true };
  expect(on({ ...sent, needsPreparation: true })).toBe('prepare');
  expect(on({ ...sent, needsPreparation: false })).toBe('arm');
  expect(on({ ...sent, needsPreparation: false, isReady: false })).toBeNull();
  // readiness unknown: the vehicle itself refuses if it is not ready
  expect(on({ ...sent, needsPreparation: false, isReady: null })).toBe('arm');
  expect(on({ ...sent, isArmed: true, followsMission: false })).toBe('start');
  expect(on({ ...sent, isArmed: true, followsMission: true })).toBeNull();
});
