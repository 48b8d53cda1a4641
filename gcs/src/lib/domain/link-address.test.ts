import { expect, it } from 'vitest';
import { linkAddress, USUAL } from './link-address';

it('writes link strings as the field does', () => {
  expect(linkAddress(USUAL)).toBe('/dev/ttyUSB0,57600');
  expect(linkAddress({ ...USUAL, device: ' COM3 ', baud: 115_200 })).toBe('COM3,115200');
  expect(linkAddress({ ...USUAL, kind: 'udp', port: '14550' })).toBe('udpin:0.0.0.0:14550');
  expect(linkAddress({ ...USUAL, kind: 'tcp' })).toBe('tcp:127.0.0.1:5760');
  expect(linkAddress({ ...USUAL, kind: 'other', text: ' tlog:a.tlog ' })).toBe('tlog:a.tlog');
});

it('gives none while something is missing or no port', () => {
  expect(linkAddress({ ...USUAL, device: ' ' })).toBeNull();
  for (const port of ['', '0', '70000', '57x']) expect(linkAddress({ ...USUAL, kind: 'udp', port })).toBeNull();
  expect(linkAddress({ ...USUAL, kind: 'tcp', host: '' })).toBeNull();
  expect(linkAddress({ ...USUAL, kind: 'other' })).toBeNull();
});
