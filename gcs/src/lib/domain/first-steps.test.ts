import { expect, it } from 'vitest';
import { firstSteps, type Standing } from './first-steps';

const unknown: Standing = {
  hasPlan: false,
  isSent: false,
  isArmed: null,
  needsPreparation: null,
  isReady: null,
  mode: null,
};
const done = (known: Partial<Standing>) =>
  firstSteps({ ...unknown, ...known }).flatMap(({ name, isDone }) => (isDone ? [name] : []));

it('counts nothing as done that is not known', () => {
  expect(done({})).toEqual([]);
  expect(done({ isArmed: false })).toEqual([]);
  expect(done({ needsPreparation: false })).toEqual([]);
});

it('goes on as the vehicle does', () => {
  const sent = { hasPlan: true, isSent: true, isArmed: false, mode: 'AUTO' };
  expect(done({ ...sent, needsPreparation: true })).toEqual(['plan', 'send']);
  expect(done({ ...sent, needsPreparation: false })).toEqual(['plan', 'send', 'prepare']);
  expect(done({ ...sent, needsPreparation: false, isReady: true })).toEqual(['plan', 'send', 'prepare', 'ready']);
  expect(done({ ...sent, isArmed: true, mode: 'MANUAL' })).toEqual(['plan', 'send', 'prepare', 'ready', 'arm']);
  expect(done({ ...sent, isArmed: true })).toHaveLength(6);
});
