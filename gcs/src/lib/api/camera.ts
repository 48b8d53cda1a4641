// Cameras: which there are, recording, still pictures, and the stream of one, over a WebSocket of its own.
import { readPicture, type Picture } from '$lib/domain/video';
import { Http } from './http';
import type { components } from './schema';
import { retryDelay_ms, SILENCE_LIMIT_MS } from './socket';

export type CameraInfo = components['schemas']['CameraInfo'];
export type CameraMessage = components['schemas']['CameraMessage'];

const http = new Http();
const path = (name: string, rest = '') => `/cameras/${encodeURIComponent(name)}${rest}`;

export const cameraApi = {
  list: () => http.json<CameraInfo[]>('GET', '/cameras'),
  startRecording: (name: string) => http.json<CameraInfo>('POST', path(name, '/recording')),
  stopRecording: (name: string) => http.json<CameraInfo>('DELETE', path(name, '/recording')),
  snapshot: async (name: string): Promise<Blob> => (await http.request('GET', path(name, '/snapshot'))).blob(),
};

export interface StreamHandlers {
  picture(picture: Picture): void;
  camera(info: CameraInfo): void;
  /** The server's time of day, in milliseconds since 1970. */
  time(unix_ms: number): void;
  /** Whether the connection is there. */
  connected(isConnected: boolean): void;
}

/** What the stream needs from outside, so that tests need neither network nor time. */
export interface StreamWorld {
  open(path: string): WebSocket;
  setTimeout(run: () => void, ms: number): number;
  clearTimeout(timer: number): void;
  random(): number;
}

const browser: StreamWorld = {
  open(address) {
    const { protocol, host } = window.location;
    return new WebSocket(`${protocol === 'https:' ? 'wss' : 'ws'}://${host}${address}`);
  },
  setTimeout: (run, ms) => window.setTimeout(run, ms),
  clearTimeout: (timer) => window.clearTimeout(timer),
  random: Math.random,
};

/** The stream of one camera, from its making until it is closed. Reconnects for ever, and notices silence. */
export class CameraStream {
  readonly #address: string;
  readonly #handlers: StreamHandlers;
  readonly #world: StreamWorld;
  #socket: WebSocket | null = null;
  #timer: number | null = null;
  #attempt = 0;
  #isClosed = false;

  constructor(name: string, showsH264: boolean, handlers: StreamHandlers, world: StreamWorld = browser) {
    this.#address = http.address(path(name, `/stream?accept=${showsH264 ? 'h264,jpeg' : 'jpeg'}`));
    this.#handlers = handlers;
    this.#world = world;
    this.#connect();
  }

  close(): void {
    this.#isClosed = true;
    this.#drop();
  }

  #connect(): void {
    const socket = this.#world.open(this.#address);
    this.#socket = socket;
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      this.#attempt = 0;
      this.#handlers.connected(true);
    };
    socket.onmessage = (event: MessageEvent) => {
      this.#watch();
      this.#hear(event.data);
    };
    socket.onclose = () => this.#retry();
    this.#watch();
  }

  #hear(data: unknown): void {
    if (data instanceof ArrayBuffer) {
      const picture = readPicture(data);
      if (picture !== null) this.#handlers.picture(picture);
      return;
    }
    if (typeof data !== 'string') return;
    let message: CameraMessage;
    try {
      message = JSON.parse(data) as CameraMessage;
    } catch {
      return;
    }
    if (message.type === 'camera') this.#handlers.camera(message);
    else if (message.type === 'clock') this.#handlers.time(message.unix_us / 1000);
  }

  /** The server speaks each second: silence means that the connection is dead. */
  #watch(): void {
    this.#stopTimer();
    this.#timer = this.#world.setTimeout(() => this.#retry(), SILENCE_LIMIT_MS);
  }

  #retry(): void {
    this.#drop();
    if (this.#isClosed) return;
    this.#handlers.connected(false);
    const wait_ms = retryDelay_ms(this.#attempt, this.#world.random());
    this.#attempt += 1;
    this.#timer = this.#world.setTimeout(() => this.#connect(), wait_ms);
  }

  #drop(): void {
    this.#stopTimer();
    const socket = this.#socket;
    this.#socket = null;
    if (socket === null) return;
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
  }

  #stopTimer(): void {
    if (this.#timer !== null) this.#world.clearTimeout(this.#timer);
    this.#timer = null;
  }
}
