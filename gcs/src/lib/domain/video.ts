// Video as bytes: the header before each picture on the wire, and what a decoder must know of an H.264 stream.

export interface Picture {
  codec: 'h264' | 'jpeg';
  /** Whether it can be shown without those before it. */
  isKey: boolean;
  width: number;
  height: number;
  /** When it was taken, by the server's clock. */
  captured_unix_us: number;
  data: Uint8Array<ArrayBuffer>;
}

const HEADER_BYTES = 20;
const VERSION = 1;
const CODECS: Readonly<Record<number, Picture['codec']>> = { 1: 'h264', 2: 'jpeg' };

/** The picture in a binary message of a camera's stream; null for anything else. */
export function readPicture(message: ArrayBuffer): Picture | null {
  if (message.byteLength <= HEADER_BYTES) return null;
  const header = new DataView(message, 0, HEADER_BYTES);
  const codec = CODECS[header.getUint8(1)];
  if (header.getUint8(0) !== VERSION || codec === undefined) return null;
  return {
    codec,
    isKey: (header.getUint8(2) & 1) !== 0,
    width: header.getUint16(4, true),
    height: header.getUint16(6, true),
    captured_unix_us: Number(header.getBigUint64(8, true)),
    data: new Uint8Array(message, HEADER_BYTES),
  };
}

const SPS = 7;

/**
 * The codec string of an H.264 byte stream, `avc1.PPCCLL` (RFC 6381): profile, constraints and level of the
 * first sequence parameter set; null when there is none.
 */
export function h264Codec(data: Uint8Array): string | null {
  for (let at = 0; at + 6 < data.length; at += 1) {
    if (data[at] !== 0 || data[at + 1] !== 0 || data[at + 2] !== 1) continue;
    if (((data[at + 3] ?? 0) & 0x1f) !== SPS) continue;
    const hex = [...data.subarray(at + 4, at + 7)].map((byte) => byte.toString(16).padStart(2, '0'));
    return `avc1.${hex.join('').toUpperCase()}`;
  }
  return null;
}
