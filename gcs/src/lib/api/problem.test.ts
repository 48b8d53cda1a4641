import { expect, it } from 'vitest';
import { reasonsOf } from './problem';
import type { Problem, RefusalCode } from './types';

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
