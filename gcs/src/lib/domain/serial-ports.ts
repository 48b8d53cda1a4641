// Which serial port the form of a link offers, as ports are plugged in and out and a person chooses.

export interface Port {
  /** `/dev/ttyUSB0`, `COM3`. */
  readonly device: string;
  /** A name that stays when the number of the device changes. */
  readonly lasting_path: string | null;
  /** Of the link that is on it. */
  readonly link: number | null;
  readonly is_in_use: boolean;
  readonly is_allowed: boolean;
}

/** What a link is opened on. */
export const pathOf = ({ device, lasting_path }: Port): string => lasting_path ?? device;

/** The last part of its device: `ttyUSB0`. */
export const shortName = ({ device }: Pick<Port, 'device'>): string => device.slice(device.lastIndexOf('/') + 1);

/** A port that was plugged in since the list `before`; `null` without one, and without such a list. */
export function pluggedIn<T extends Port>(ports: readonly T[], before: readonly Port[] | null): T | null {
  if (before === null) return null;
  return ports.find((port) => !before.some((known) => pathOf(known) === pathOf(port))) ?? null;
}

/** The first port that can be opened, else the first. */
export function firstFree<T extends Port>(ports: readonly T[]): T | null {
  const isFree = (port: Port): boolean => port.link === null && !port.is_in_use;
  return ports.find((port) => isFree(port) && port.is_allowed) ?? ports.find(isFree) ?? ports[0] ?? null;
}

/** What stands in the form. */
export interface SerialChoice<T extends Port = Port> {
  /** Those that were there last; null before the server told. */
  readonly ports: readonly T[] | null;
  /** Of the port that is chosen from them; null for one that is typed. A device may be another's when it is plugged in again. */
  readonly path: string | null;
  /** Whether it is offered because it was just plugged in. */
  readonly isNew: boolean;
  /** Whether a person chose or typed it: then it stays, whatever is plugged in or out. */
  readonly isByHand: boolean;
}

export const NOTHING_CHOSEN: SerialChoice<never> = { ports: null, path: null, isNew: false, isByHand: false };

/** What a person chose: a port of the list, or null to type one. */
export const chosenByHand = <T extends Port>(choice: SerialChoice<T>, path: string | null): SerialChoice<T> => ({
  ...choice,
  path,
  isNew: false,
  isByHand: true,
});

/** The choice once these ports are there. */
export function withPorts<T extends Port>(choice: SerialChoice<T>, ports: readonly T[]): SerialChoice<T> {
  if (choice.isByHand) return { ...choice, ports };
  const plugged = pluggedIn(ports, choice.ports);
  if (plugged !== null) return { ...choice, ports, path: pathOf(plugged), isNew: true };
  const isThere = ports.some((port) => pathOf(port) === choice.path);
  if (isThere) return { ...choice, ports };
  const free = firstFree(ports);
  return { ...choice, ports, path: free && pathOf(free), isNew: false };
}

/** The chosen port; null for one that is typed, or gone. */
export const portOf = <T extends Port>({ ports, path }: SerialChoice<T>): T | null =>
  ports?.find((port) => pathOf(port) === path) ?? null;
