import { describe, expect, it } from 'vitest';
import { h264Codec, readPicture } from './video';

/** As crates/server/src/video/tests.rs has it. */
const MESSAGE = new Uint8Array([
  1, 1, 1, 0, 0x80, 0x02, 0xe0, 0x01, 0x00, 0x40, 0x1e, 0x18, 0x24, 0x0a, 0x06, 0x00, 7, 0, 0, 0, 99, 111, 100, 101,
]);

describe('readPicture', () => {
  it('reads header and code', () => {
    const picture = readPicture(MESSAGE.buffer);
    expect(picture).toMatchObject({ codec: 'h264', isKey: true, width: 640, height: 480 });
    expect(picture?.captured_unix_us).toBe(1_700_000_000_000_000);
    expect(new TextDecoder().decode(picture?.data)).toBe('code');
  });

  it('takes nothing else', () => {
    expect(readPicture(MESSAGE.slice(0, 20).buffer)).toBeNull();
    expect(readPicture(new ArrayBuffer(0))).toBeNull();
    expect(readPicture(MESSAGE.with(0, 2).buffer)).toBeNull();
    expect(readPicture(MESSAGE.with(1, 9).buffer)).toBeNull();
  });
});

describe('h264Codec', () => {
  it('is in the sequence parameter set, wherever that stands', () => {
    const units = [0, 0, 0, 1, 6, 5, 1, 0, 0, 0, 1, 0x67, 0x64, 0x00, 0x1e, 0xac, 0, 0, 1, 0x68, 1];
    expect(h264Codec(new Uint8Array(units))).toBe('avc1.64001E');
    expect(h264Codec(new Uint8Array([0, 0, 1, 0x67, 0x42, 0xc0, 0x1e]))).toBe('avc1.42C01E');
  });

  it('is not known without one', () => {
    expect(h264Codec(new Uint8Array([0, 0, 1, 0x41, 0x9a, 0x3b, 1, 1]))).toBeNull();
    expect(h264Codec(new Uint8Array([0, 0, 1, 0x67]))).toBeNull();
  });
});
