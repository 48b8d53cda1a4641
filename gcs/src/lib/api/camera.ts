// Cameras: list, recording, still pictures, footage, and the stream of one over its own WebSocket.
import { readPicture, type Picture } from '$lib/domain/video';
import { Http } from './http';
import type { components } from './schema';
import { browserWorld, Socket, type SocketWorld } from './socket';

export type CameraInfo = components['schemas']['CameraInfo'];
export type Footage = components['schemas']['Footage'];
export type CameraMessage = components['schemas']['CameraMessage'];

const http = new Http();
const path = (name: string, rest = '') => `/cameras/${encodeURIComponent(name)}${rest}`;

export const cameraApi = {
  list: () => http.json<CameraInfo[]>('GET', '/cameras'),
  startRecording: (name: string) => http.json<CameraInfo>('POST', path(name, '/recording')),
  stopRecording: (name: string) => http.json<CameraInfo>('DELETE', path(name, '/recording')),
  snapshot: (name: string) => http.blob('GET', path(name, '/snapshot')),
  /** The same, kept on the server's disk as well. */
  keepSnapshot: (name: string) => http.blob('POST', path(name, '/snapshot')),
  footage: () => http.json<Footage[]>('GET', '/footage'),
  footageAddress: (name: string) => http.address(`/footage/${encodeURIComponent(name)}`),
  deleteFootage: (name: string) => http.json<object>('DELETE', `/footage/${encodeURIComponent(name)}`),
};

export interface StreamHandlers {
  picture(picture: Picture): void;
  camera(info: CameraInfo): void;
  /** The server's time of day, in milliseconds since 1970. */
  time(unix_ms: number): void;
  /** Whether the connection is there. */
  connected(isConnected: boolean): void;
}

const browser: SocketWorld = {
  ...browserWorld,
  open(address) {
    const { protocol, host } = window.location;
    return browserWorld.open(`${protocol === 'https:' ? 'wss' : 'ws'}://${host}${address}`);
  },
};

/** The stream of one camera, from its making until it is closed. */
export class CameraStream {
  readonly #handlers: StreamHandlers;
  readonly #socket: Socket;

  constructor(name: string, showsH264: boolean, handlers: StreamHandlers, world: SocketWorld = browser) {
    this.#handlers = handlers;
    const address = http.address(path(name, `/stream?accept=${showsH264 ? 'h264,jpeg' : 'jpeg'}`));
    this.#socket = new Socket(
      {
        address: () => address,
        message: (data) => this.#hear(data),
        state: (state) => {
          if (state === 'open') handlers.connected(true);
          if (state === 'waiting') handlers.connected(false);
        },
      },
      world,
    );
    this.#socket.start();
  }

  close(): void {
    this.#socket.close();
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
}
