import { beforeEach, describe, expect, it } from 'vitest';
import { CameraStream, type StreamHandlers } from './camera';
import { SILENCE_LIMIT_MS } from './socket';

class FakeSocket {
  binaryType = '';
  onopen: (() => void) | null = null;
  onclose: (() => void) | null = null;
  onmessage: ((event: { data: unknown }) => void) | null = null;
  isClosed = false;
  close() {
    this.isClosed = true;
  }
}

const sockets: FakeSocket[] = [];
const addresses: string[] = [];
let timers: { id: number; at_ms: number; run: () => void }[] = [];
let now_ms = 0;
let said: string[] = [];

function advance(ms: number): void {
  const end_ms = now_ms + ms;
  for (;;) {
    const due = timers.filter(({ at_ms }) => at_ms <= end_ms).sort((a, b) => a.at_ms - b.at_ms)[0];
    if (due === undefined) break;
    now_ms = due.at_ms;
    timers = timers.filter((other) => other !== due);
    due.run();
  }
  now_ms = end_ms;
}

const world = {
  open(address: string) {
    addresses.push(address);
    sockets.push(new FakeSocket());
    return sockets.at(-1) as unknown as WebSocket;
  },
  setTimeout(run: () => void, ms: number) {
    const id = timers.length + 1000 * sockets.length + now_ms;
    timers.push({ id, at_ms: now_ms + ms, run });
    return id;
  },
  clearTimeout(id: number) {
    timers = timers.filter((timer) => timer.id !== id);
  },
  random: () => 1,
};

const handlers: StreamHandlers = {
  picture: (picture) => said.push(`picture ${picture.data.length}`),
  camera: (info) => said.push(`camera ${info.state}`),
  time: (unix_ms) => said.push(`time ${unix_ms}`),
  connected: (isConnected) => said.push(isConnected ? 'open' : 'away'),
};

beforeEach(() => {
  sockets.length = addresses.length = 0;
  timers = [];
  said = [];
  now_ms = 0;
});

/** The address is asked for before the socket is opened. */
const opened = () => Promise.resolve();

describe('CameraStream', () => {
  it('hands on pictures, states and the time, and no nonsense', async () => {
    const stream = new CameraStream('no/se', true, handlers, world);
    await opened();
    expect(addresses).toEqual(['/api/v1/cameras/no%2Fse/stream?accept=h264,jpeg']);
    const [socket] = sockets;
    socket?.onopen?.();
    const picture = new Uint8Array(25);
    picture.set([1, 2, 1]);
    for (const data of [
      picture.buffer,
      new ArrayBuffer(3),
      '{',
      '{"type":"other"}',
      '{"type":"camera","state":"live"}',
    ])
      socket?.onmessage?.({ data });
    socket?.onmessage?.({ data: '{"type":"clock","unix_us":2000}' });
    expect(said).toEqual(['open', 'picture 5', 'camera live', 'time 2']);
    stream.close();
    expect(socket?.isClosed).toBe(true);
    expect(timers).toEqual([]);
  });

  it('connects again after an end and after silence, until it is closed', async () => {
    const stream = new CameraStream('nose', false, handlers, world);
    await opened();
    expect(addresses[0]).toContain('accept=jpeg');
    sockets[0]?.onopen?.();
    sockets[0]?.onclose?.();
    expect(said).toEqual(['open', 'away']);
    advance(250);
    await opened();
    expect(sockets.length).toBe(2);
    sockets[1]?.onopen?.();
    advance(SILENCE_LIMIT_MS);
    expect(sockets[1]?.isClosed).toBe(true);
    advance(250);
    await opened();
    expect(sockets.length).toBe(3);
    stream.close();
    advance(60_000);
    expect(sockets.length).toBe(3);
  });
});
