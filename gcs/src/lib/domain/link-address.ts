/** Link strings, put together from what a person fills in. The server has the last word on them. */

export type LinkKind = 'serial' | 'udp' | 'tcp' | 'other';

export interface LinkParts {
  readonly kind: LinkKind;
  /** Of a serial port: `/dev/ttyUSB0`, `COM3`. */
  readonly device: string;
  /** Of a serial port, bits per second. */
  readonly baud: number;
  readonly host: string;
  readonly port: string;
  /** A whole link string, for `other`. */
  readonly text: string;
}

/** Speeds that autopilots and radios use. */
export const BAUDS = [57_600, 115_200, 921_600, 460_800, 230_400, 38_400, 9600] as const;

/** Defaults as usual in the field. */
export const USUAL: LinkParts = {
  kind: 'serial',
  device: '/dev/ttyUSB0',
  baud: 57_600,
  host: '127.0.0.1',
  port: '5760',
  text: '',
};
export const UDP_PORT = '14550';

/** The link string; `null` while something is missing or no number. */
export function linkAddress({ kind, device, baud, host, port, text }: LinkParts): string | null {
  const isPort = /^\d{1,5}$/.test(port.trim()) && Number(port) >= 1 && Number(port) <= 65_535;
  switch (kind) {
    case 'serial':
      return device.trim() === '' ? null : `${device.trim()},${baud}`;
    case 'udp':
      return isPort ? `udpin:0.0.0.0:${Number(port)}` : null;
    case 'tcp':
      return isPort && host.trim() !== '' ? `tcp:${host.trim()}:${Number(port)}` : null;
    case 'other':
      return text.trim() === '' ? null : text.trim();
  }
}
