import { expect, it } from 'vitest';
import { filterMessages } from './messages';

const messages = [
  { severity: 6, text: 'Throttle armed' },
  { severity: 4, text: 'PreArm: GPS 1: Bad fix' },
  { severity: 2, text: 'Battery 1 is low 10.50V' },
];
const texts = (severity: number, search: string) => filterMessages(messages, severity, search).map(({ text }) => text);

it('filters by severity and by words', () => {
  expect(texts(7, '')).toHaveLength(3);
  expect(texts(4, '')).toEqual(['PreArm: GPS 1: Bad fix', 'Battery 1 is low 10.50V']);
  expect(texts(7, 'fix gps')).toEqual(['PreArm: GPS 1: Bad fix']);
  expect(texts(7, '  ARMED ')).toEqual(['Throttle armed']);
  expect(texts(7, 'nothing')).toEqual([]);
});
