import { expect, it } from 'vitest';
import { armingReasons, filterMessages, foldMessages } from './messages';

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

const at = (s: number) => new Date(s * 1000);

it('folds what is said again within a minute, whatever lies in between', () => {
  const told = (s: number, text: string, severity = 2) => ({ severity, text, at: at(s) });
  const all = [told(0, 'Bad fix'), told(10, 'Mode'), told(30, 'Bad fix'), told(90, 'Bad fix'), told(91, 'Bad fix', 4)];
  const folded = foldMessages([...all, told(151, 'Bad fix')]).map(({ first, last, count }) => [
    last.text,
    last.severity,
    count,
    (last.at.getTime() - first.at.getTime()) / 1000,
  ]);
  expect(folded).toEqual([
    ['Mode', 2, 1, 0],
    ['Bad fix', 2, 3, 90],
    ['Bad fix', 4, 1, 0],
    ['Bad fix', 2, 1, 0],
  ]);
  expect(foldMessages([told(7200, 'Bad fix'), told(0, 'Bad fix')]), 'a clock was set back').toHaveLength(2);
});

it('finds what bars arming, the newest first, while it is repeated', () => {
  const texts = [
    'PreArm: Old',
    'PreArm: In landing sequence',
    'Landed',
    'PreArm: GPS 1: Bad fix',
    'PreArm: GPS 1: Bad fix',
  ];
  const told = texts.map((text, index) => ({ severity: 2, text, at: at(index * 30) }));
  expect(armingReasons(told, at(90))).toEqual(['GPS 1: Bad fix', 'In landing sequence']);
  expect(armingReasons(told, at(181))).toEqual([]);
});
