import { describe, expect, it } from 'vitest';
import type { Parameter } from '$lib/api/types';
import ofArduPlane from '../../../../tests/fixtures/captures/arduplane-params.parm?raw';
import {
  byName,
  compareParams,
  countPrefixes,
  docsOf,
  groupsOf,
  isChanged,
  isSameInFile,
  isSameValue,
  matches,
  partsOf,
  rangeOf,
  readParam,
  writeParam,
} from './params';

const param = (name: string, value: number, kind = 'real32', usual: number | null = null): Parameter => ({
  name,
  value,
  kind,
  default: usual,
});

describe('values', () => {
  it('have the digits of their type', () => {
    const written = [Math.fround(0.1), Math.fround(1 / 3), 80, Math.fround(1e-7), Math.fround(16777217)];
    expect(written.map((value) => writeParam(value, 'real32'))).toEqual([
      '0.1',
      '0.33333334',
      '80',
      '1e-7',
      '16777216',
    ]);
    expect(writeParam(2_147_483_647, 'int32')).toBe('2147483647');
    expect(writeParam(Math.fround(0.1), 'real32', ',')).toBe('0,1');
  });

  it('of a real ArduPlane come back as they are written', () => {
    const values = ofArduPlane
      .trim()
      .split('\n')
      .map((line) => Number(line.split(/\s+/)[1]));
    expect(values).toHaveLength(1399);
    for (const value of values) {
      expect(Math.fround(readParam(writeParam(value, 'real32'), 'real32').value ?? NaN)).toBe(Math.fround(value));
    }
  });

  it('are refused before they are sent when their type cannot hold them', () => {
    const read = (text: string, kind: string) => readParam(text, kind).value ?? readParam(text, kind).fault;
    expect(['12', '-12', '1.5', '1,0', '1.500', '128', '', 'x'].map((text) => read(text, 'int8'))).toEqual([
      12,
      -12,
      'whole',
      'whole',
      'whole',
      'range',
      'number',
      'number',
    ]);
    expect(['1,5', '−2.25', '1e-3', '1.002', '1e39', 'Infinity'].map((text) => read(text, 'real32'))).toEqual([
      1.5,
      -2.25,
      0.001,
      1.002,
      'range',
      'number',
    ]);
    expect([read('0', 'uint8'), read('-1', 'uint8'), rangeOf('uint32')[1]]).toEqual([0, 'range', 4_294_967_295]);
  });

  it('are the same where a file has fewer digits than the vehicle', () => {
    expect(isSameInFile(0.333333, Math.fround(1 / 3), 'real32')).toBe(false);
    expect(isSameInFile(0.3333333, Math.fround(1 / 3), 'real32')).toBe(true);
    expect(isSameInFile(16_777_217, 16_777_216, 'int32')).toBe(false);
    expect([isChanged(param('A', 0.1, 'real32', Math.fround(0.1))), isChanged(param('A', 1, 'int8', 2))]).toEqual([
      false,
      true,
    ]);
    expect(isChanged(param('A', 1))).toBeNull();
  });

  it('that 32 bits tell apart are two, also in a file that has the digits', () => {
    const [home, beside] = [-35.363262, -35.363242];
    expect([isSameValue(home, beside, 'real32'), isSameValue(home, Math.fround(home), 'real32')]).toEqual([
      false,
      true,
    ]);
    expect([
      isSameInFile(beside, Math.fround(home), 'real32'),
      isSameInFile(home, Math.fround(home), 'real32'),
    ]).toEqual([false, true]);
  });
});

describe('the list', () => {
  const all = ['WP_RADIUS', 'SERVO10_MIN', 'SERVO2_MIN', 'WP_LOITER_RAD', 'STICK_MIXING'].map((name) => param(name, 1));

  it('is grouped by prefixes without numbers, single ones last, and a search moves none', () => {
    const groups = (found: readonly Parameter[]) =>
      groupsOf([...found].sort(byName), countPrefixes(all)).map(({ prefix, params }) => [
        prefix,
        ...params.map(({ name }) => name),
      ]);
    expect(groups(all)).toEqual([
      ['SERVO', 'SERVO2_MIN', 'SERVO10_MIN'],
      ['WP', 'WP_LOITER_RAD', 'WP_RADIUS'],
      ['', 'STICK_MIXING'],
    ]);
    expect(groups(all.slice(0, 1))).toEqual([['WP', 'WP_RADIUS']]);
  });

  it('is searched by each word, in names and meanings', () => {
    const found = (search: string) =>
      all.filter(({ name }) => matches(search, name, name === 'WP_LOITER_RAD' ? 'Radius of circles' : '')).length;
    expect(['', 'wp rad', 'circles', 'wp circles', 'nothing', ' servo '].map(found)).toEqual([5, 2, 1, 1, 0, 2]);
  });
});

it('a file is compared by name: equal values are counted, unknown names told, and of a name twice the last counts', () => {
  const vehicle = new Map([param('A_B', 1, 'int8'), param('C_D', 0.5), param('E_F', 7)].map((one) => [one.name, one]));
  const file = [
    { name: 'C_D', value: 2 },
    { name: 'a_b', value: 1 },
    { name: 'X_Y', value: 3 },
    { name: 'C_D', value: 0.25 },
  ];
  expect(compareParams(file, vehicle)).toEqual({
    differing: [{ name: 'C_D', inFile: 0.25, onVehicle: param('C_D', 0.5) }],
    equal: 1,
    unknown: ['X_Y'],
    repeated: ['C_D'],
  });
});

it('names of parameters are found in a text, other words in capitals are not', () => {
  const known = new Set(['RTL_AUTOLAND', 'WP_RADIUS']);
  const text = 'DO_LAND_START: set the parameter RTL_AUTOLAND to 1 or widen WP_RADIUS.';
  const parts = partsOf(text, (name) => known.has(name));
  expect(parts.filter((part) => part.isParam).map((part) => part.text)).toEqual(['RTL_AUTOLAND', 'WP_RADIUS']);
  expect(parts.map((part) => part.text).join('')).toBe(text);
});

it('descriptions are at the makers of the autopilot', () => {
  expect(docsOf('SERVO1_MIN', 3, 'vtol')).toBe('https://ardupilot.org/plane/docs/parameters.html#servo1-min');
  expect(docsOf('COM_FLTMODE1', 12, 'plane')).toMatch(/docs\.px4\.io.*#COM_FLTMODE1$/);
  expect([docsOf('A', 3, 'other'), docsOf('A', undefined, 'plane')]).toEqual([null, null]);
});
