import { expect, it } from 'vitest';
import {
  chosenByHand,
  firstFree,
  NOTHING_CHOSEN,
  pathOf,
  pluggedIn,
  type Port,
  portOf,
  type SerialChoice,
  shortName,
  withPorts,
} from './serial-ports';

const port = (device: string, more: Partial<Port> = {}): Port => ({
  device,
  lasting_path: null,
  link: null,
  is_in_use: false,
  is_allowed: true,
  ...more,
});
const [acm, usb] = [port('/dev/ttyACM0'), port('/dev/ttyUSB0')];

it('offers what can be opened first', () => {
  expect(firstFree([])).toBeNull();
  expect(firstFree([acm, usb])).toBe(acm);
  expect(
    firstFree([port('a', { link: 1 }), port('b', { is_in_use: true }), port('c', { is_allowed: false }), usb]),
  ).toBe(usb);
  const locked = port('c', { is_allowed: false });
  expect(firstFree([port('a', { link: 1 }), locked])).toBe(locked);
  const linked = port('a', { link: 1, is_in_use: true });
  expect(firstFree([linked])).toBe(linked);
});

it('knows what was plugged in', () => {
  expect(pluggedIn([acm, usb], null)).toBeNull();
  expect(pluggedIn([acm, usb], [port('/dev/ttyUSB0')])).toBe(acm);
  expect(pluggedIn([acm], [acm, usb])).toBeNull();
});

it('opens a port under the name that stays', () => {
  expect(pathOf(acm)).toBe('/dev/ttyACM0');
  expect(pathOf(port('/dev/ttyACM0', { lasting_path: '/dev/serial/by-id/usb-x' }))).toBe('/dev/serial/by-id/usb-x');
  expect([shortName(usb), shortName(port('COM3'))]).toEqual(['ttyUSB0', 'COM3']);
});

it('offers what is plugged in, and says so of no other port', () => {
  let choice: SerialChoice = NOTHING_CHOSEN;
  const told = [[acm], [acm, usb], [acm, usb], [acm], [acm, usb], []].map((ports) => {
    choice = withPorts(choice, ports);
    return [choice.path && shortName({ device: choice.path }), choice.isNew];
  });
  expect(told).toEqual([
    ['ttyACM0', false],
    ['ttyUSB0', true],
    ['ttyUSB0', true],
    ['ttyACM0', false],
    ['ttyUSB0', true],
    [null, false],
  ]);
});

it('keeps what a person chose or typed, also while it is gone and when the form begins anew', () => {
  const chosen = withPorts(chosenByHand(withPorts(NOTHING_CHOSEN, [acm, usb]), usb.device), [acm]);
  expect([chosen.path, portOf(chosen), chosen.isNew]).toEqual([usb.device, null, false]);
  expect(portOf(withPorts(chosen, [acm, usb]))).toBe(usb);
  const typed = withPorts(chosenByHand(NOTHING_CHOSEN, null), [acm]);
  expect([typed.path, withPorts(typed, [acm, usb]).path]).toEqual([null, null]);
});

it('tells two radios apart that have had the same device in turn', () => {
  const [a, b] = ['A', 'B'].map((name) => port(usb.device, { lasting_path: `/dev/serial/by-id/${name}` }));
  const chosen = chosenByHand(withPorts(NOTHING_CHOSEN, [a!]), pathOf(a!));
  expect([portOf(withPorts(withPorts(chosen, []), [b!])), portOf(withPorts(chosen, [b!, a!]))]).toEqual([null, a]);
  expect(withPorts(withPorts(NOTHING_CHOSEN, [a!]), [b!])).toMatchObject({ path: pathOf(b!), isNew: true });
});
