/** Which serial port the form of a link offers. */

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
export const shortName = ({ device }: Port): string => device.slice(device.lastIndexOf('/') + 1);

/** A port that was plugged in since the list `before`; `null` without one, and without such a list. */
export function pluggedIn<T extends Port>(ports: readonly T[], before: readonly Port[] | null): T | null {
  if (before === null) return null;
  return ports.find(({ device }) => !before.some((known) => known.device === device)) ?? null;
}

/** The first port that can be opened, else the first. */
export function firstFree<T extends Port>(ports: readonly T[]): T | null {
  const isFree = (port: Port): boolean => port.link === null && !port.is_in_use;
  return ports.find((port) => isFree(port) && port.is_allowed) ?? ports.find(isFree) ?? ports[0] ?? null;
}
