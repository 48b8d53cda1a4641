import { beforeEach, describe, expect, it, vi } from 'vitest';
import type { Picture } from '$lib/domain/video';
import { Player } from './player';

type Init = { output(frame: unknown): void; error(error: { name: string }): void };

class FakeDecoder {
  state = 'unconfigured';
  decodeQueueSize = 0;
  decoded: string[] = [];
  isThrowing = false;

  constructor(readonly init: Init) {
    decoders.push(this);
  }
  configure({ codec }: { codec: string }) {
    if (codec.endsWith('FF')) throw new TypeError('no codec');
    this.state = 'configured';
  }
  decode({ type, timestamp }: { type: string; timestamp: number }) {
    if (this.isThrowing) throw new TypeError('a key frame is required');
    this.decoded.push(`${type} ${timestamp}`);
  }
  show(timestamp: number) {
    this.init.output({ displayWidth: 64, displayHeight: 48, timestamp, close: () => undefined });
  }
  close() {
    this.state = 'closed';
  }
}

let decoders: FakeDecoder[] = [];
let said: string[] = [];

const canvas = { width: 0, height: 0, getContext: () => ({ drawImage: () => undefined }) };
const events = {
  shown: (at: number) => said.push(`shown ${at}`),
  cannotDecode: () => said.push('cannot decode'),
};

const picture = (captured_unix_us: number, isKey: boolean, level = 0x1f): Picture => ({
  codec: 'h264',
  isKey,
  width: 64,
  height: 48,
  captured_unix_us,
  data: new Uint8Array(isKey ? [0, 0, 1, 0x67, 0x64, 0, level, 0, 0] : [0, 0, 1, 0x41, 0]),
});

beforeEach(() => {
  decoders = [];
  said = [];
  vi.stubGlobal('VideoDecoder', FakeDecoder);
  vi.stubGlobal(
    'EncodedVideoChunk',
    class {
      constructor(init: object) {
        Object.assign(this, init);
      }
    },
  );
});

const make = () => new Player(canvas as unknown as HTMLCanvasElement, events);

describe('Player', () => {
  it('goes on at the next key frame after a broken picture', () => {
    const player = make();
    player.push(picture(1, false));
    expect(decoders).toEqual([]);
    player.push(picture(2, true));
    decoders[0]?.show(2);
    decoders[0]?.init.error({ name: 'EncodingError' });
    player.push(picture(3, false));
    expect(decoders.length).toBe(1);
    player.push(picture(4, true));
    player.push(picture(5, false));
    expect(decoders[1]?.decoded).toEqual(['key 4', 'delta 5']);
    decoders[1]?.show(4);
    expect(said).toEqual(['shown 2', 'shown 4']);
    // What an older decoder says late is about nothing any more.
    decoders[0]?.init.error({ name: 'EncodingError' });
    decoders[0]?.show(9);
    expect(said).toEqual(['shown 2', 'shown 4']);
  });

  it('begins anew at a key frame when the decoder refuses by throwing', () => {
    const player = make();
    player.push(picture(1, true));
    if (decoders[0]) decoders[0].isThrowing = true;
    player.push(picture(2, false));
    player.push(picture(3, true));
    expect(decoders.map(({ decoded }) => decoded)).toEqual([['key 1'], ['key 3']]);
    expect(said).toEqual([]);
  });

  it('gives H.264 up when no decoder shows anything, and at once when it is not supported', () => {
    let player = make();
    for (let at = 1; at <= 3; at += 1) {
      expect(said).toEqual([]);
      player.push(picture(at, true));
      decoders.at(-1)?.init.error({ name: 'EncodingError' });
    }
    expect(said).toEqual(['cannot decode']);
    said = [];
    player = make();
    player.push(picture(1, true));
    decoders.at(-1)?.init.error({ name: 'NotSupportedError' });
    expect(said).toEqual(['cannot decode']);
    said = [];
    make().push(picture(1, true, 0xff));
    expect(said).toEqual(['cannot decode']);
  });

  it('waits for a key frame when the decoder is far behind', () => {
    const player = make();
    player.push(picture(1, true));
    if (decoders[0]) decoders[0].decodeQueueSize = 61;
    player.push(picture(2, false));
    player.push(picture(3, false));
    player.push(picture(4, true));
    player.push(picture(5, false));
    expect(decoders.map(({ decoded }) => decoded)).toEqual([['key 1'], ['key 4', 'delta 5']]);
    player.close();
    expect(decoders[1]?.state).toBe('closed');
    player.push(picture(6, true));
    expect(decoders.length).toBe(2);
  });
});
