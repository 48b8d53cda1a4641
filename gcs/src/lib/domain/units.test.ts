import { describe, expect, it } from 'vitest';
import {
  climbFigure,
  climbSymbol,
  editedNumber,
  formatDistance,
  formatDuration,
  formatHeight,
  formatScale,
  formatSpan,
  formatSpeed,
  lengthFrom_m,
  lengthTo_m,
  parseMeasure,
  parseNumber,
  roundLength_m,
  scaleStep_m,
  speedFrom_m_s,
  speedTo_m_s,
  type Units,
} from './units';

const SI: Units = { length: 'm', speed: 'm_s' };
const FEET: Units = { length: 'ft', speed: 'kt' };

describe('units', () => {
  it('converts by the exact definitions', () => {
    expect(lengthTo_m(1, 'ft')).toBe(0.3048);
    expect(speedTo_m_s(1, 'kt')).toBeCloseTo(1852 / 3600, 12);
    expect(speedFrom_m_s(10, 'km_h')).toBeCloseTo(36, 12);
  });

  it('comes back to where it was', () => {
    for (const unit of ['m', 'ft'] as const) expect(lengthTo_m(lengthFrom_m(123.4, unit), unit)).toBeCloseTo(123.4, 10);
    for (const unit of ['m_s', 'kt', 'km_h'] as const) {
      expect(speedTo_m_s(speedFrom_m_s(12.3, unit), unit)).toBeCloseTo(12.3, 10);
    }
  });

  it('writes for people', () => {
    expect(formatHeight(80, SI, 'en')).toBe('80 m');
    expect(formatHeight(80, FEET, 'en')).toBe('262 ft');
    expect(formatHeight(-0.2, SI, 'en')).toBe('0 m');
    expect(formatDistance(840, SI, 'en')).toBe('840 m');
    expect(formatDistance(3254, SI, 'es')).toBe('3,25 km');
    expect(formatDistance(3254, FEET, 'en')).toBe('1.76 nmi');
    expect(formatSpeed(12.34, SI, 'en')).toBe('12.3 m/s');
    expect(formatSpeed(12.34, FEET, 'en')).toBe('24 kt');
    expect(formatDuration(65)).toBe('1:05');
    expect(formatDuration(3729)).toBe('1:02:09');
    expect([formatSpan(245), formatSpan(76_975)]).toEqual(['4:05', '21 h 23 min']);
  });

  it('has scales and choices that are round in the unit that is read', () => {
    expect([70, 300, 1400].map((least_m) => scaleStep_m(least_m, SI))).toEqual([100, 500, 2000]);
    const steps = [70, 300, 600, 900, 1400].map((least_m) => scaleStep_m(least_m, FEET));
    expect(steps.map((step_m) => formatScale(step_m, step_m, FEET, 'en'))).toEqual([
      '500 ft',
      '1,000 ft',
      '2,000 ft',
      '0.5 nmi',
      '1 nmi',
    ]);
    expect(formatScale(6 * 609.6, 609.6, FEET, 'es')).toBe('12.000 ft');
    expect(formatScale(1500, 500, SI, 'es')).toBe('1,5 km');
    expect(formatScale(500, 500, SI, 'en')).toBe('500 m');
    expect([80, 200, 12].map((value_m) => Math.round(lengthFrom_m(roundLength_m(value_m, 'ft'), 'ft')))).toEqual([
      250, 650, 40,
    ]);
    expect(roundLength_m(80, 'm')).toBe(80);
  });

  it('climbs in the unit of heights', () => {
    expect([climbFigure(1.24, SI, 'es'), climbSymbol(SI)]).toEqual(['1,2', 'm/s']);
    expect([climbFigure(1.24, FEET, 'es'), climbSymbol(FEET)]).toEqual(['240', 'ft/min']);
    expect([climbFigure(-0.01, FEET, 'en'), climbFigure(10, FEET, 'en')]).toEqual(['0', '1970']);
  });

  it('writes numbers to edit with the separator of the language', () => {
    expect([editedNumber(262.5, 2, 'es'), editedNumber(1476, 2, 'en'), editedNumber(-0.001, 1, 'en')]).toEqual([
      '262,5',
      '1476',
      '0',
    ]);
    expect(parseNumber(editedNumber(-2.25, 2, 'es'))).toBe(-2.25);
  });

  it('reads what people type', () => {
    expect(parseNumber(' 12,5 ')).toBe(12.5);
    expect(parseNumber('−3')).toBe(-3);
    expect(parseNumber('.5')).toBe(0.5);
    for (const text of ['', '1.2.3', 'a', '1e9', 'Infinity']) expect(parseNumber(text)).toBeNull();
  });

  it('takes no height for a thousandth of itself because of how its digits are grouped', () => {
    for (const text of ['1,500', '1.500', ' −1,476 ', '12.345', '1,234,567']) expect(parseMeasure(text)).toBeNull();
    expect(['1500', '1,5', '0,125', '1234.567', '1.50'].map(parseMeasure)).toEqual([1500, 1.5, 0.125, 1234.567, 1.5]);
  });
});
