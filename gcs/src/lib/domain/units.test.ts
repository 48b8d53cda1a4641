import { describe, expect, it } from 'vitest';
import {
  formatDistance,
  formatDuration,
  formatHeight,
  formatScale,
  formatSpeed,
  lengthFrom_m,
  lengthTo_m,
  parseMeasure,
  parseNumber,
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
    expect(formatScale(1000, SI, 'en')).toBe('1 km');
    expect(formatScale(1500, SI, 'es')).toBe('1,5 km');
    expect(formatScale(500, SI, 'en')).toBe('500 m');
    expect(formatScale(3704, FEET, 'en')).toBe('2 nmi');
    expect(formatDuration(65)).toBe('1:05');
    expect(formatDuration(3729)).toBe('1:02:09');
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
