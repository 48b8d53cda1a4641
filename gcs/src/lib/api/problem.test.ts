import { expect, it } from 'vitest';
import { doubtOf, reasonsOf } from './problem';
import type { CommandName, Problem, RefusalCode } from './types';

const refused = (reasons: string[], refusals?: (RefusalCode | null)[]): Problem => ({
  type: 'urn:vencejo:command-refused',
  title: 'Refused',
  status: 409,
  detail: '',
  reasons,
  ...(refusals && { refusals }),
});

it('tells each reason once, without what every refusal begins with', () => {
  const texts = ['PreArm: GPS 1: Bad fix', 'Arm: GPS 1: Bad fix', 'Arm: RTL mode not armable', 'plain'];
  expect(reasonsOf(refused(texts, ['gps-no-fix', 'gps-no-fix', 'mode-not-armable', null]))).toEqual([
    { text: 'GPS 1: Bad fix', refusal: 'gps-no-fix' },
    { text: 'RTL mode not armable', refusal: 'mode-not-armable' },
    { text: 'plain', refusal: null },
  ]);
  expect(reasonsOf(refused(['item 2: height 80, kept 79']))).toEqual([
    { text: 'item 2: height 80, kept 79', refusal: null },
  ]);
});

it('knows which refusals are about the mission on board, and may be overridden', () => {
  const doubt = (code: string, command: CommandName) =>
    doubtOf({ ...refused([]), cause: { code } as NonNullable<Problem['cause']> }, command);
  expect([doubt('plan-unknown', 'arm'), doubt('out-of-reach', 'mission/resume')]).toEqual(['mixed', 'reach']);
  expect([doubt('home-unknown', 'mode'), doubt('home-unknown', 'goto')]).toEqual(['home', null]);
  expect(doubt('landing', 'mode')).toBeNull();
});
