// The WebSocket: opens it, keeps it open, and notices when it is silently dead. Reconnects for ever.
import type { ClientMessage, ServerMessage } from './types';

/** The server speaks at least once a second; silence this long means that the connection is dead. */
export const SILENCE_LIMIT_MS = 5000;
/** The end of that, in which a page that was held up hears what has come meanwhile. */
const LAST_LOOK_MS = 500;
const FIRST_RETRY_MS = 250;
const LAST_RETRY_MS = 4000;

export type SocketState = 'connecting' | 'open' | 'waiting' | 'closed';

interface SocketHandlers {
  /**
   * Asked before each attempt: opens the session, gives the address. A rejection counts as a failed attempt; so does
   * silence, and then `signal` ends what was begun.
   */
  address(signal: AbortSignal): Promise<string> | string;
  /** What came: text, or an `ArrayBuffer`. */
  message(data: unknown): void;
  state(state: SocketState): void;
}

/** What the socket needs from outside, so that tests need neither network nor time. */
export interface SocketWorld {
  open(address: string): WebSocket;
  setTimeout(run: () => void, ms: number): number;
  clearTimeout(timer: number): void;
  random(): number;
}

export const browserWorld: SocketWorld = {
  open: (address) => new WebSocket(address),
  setTimeout: (run, ms) => window.setTimeout(run, ms),
  clearTimeout: (timer) => window.clearTimeout(timer),
  random: Math.random,
};

/** The wait before attempt `attempt` (from 0): doubles up to 4 s, with up to half of it by chance. */
export function retryDelay_ms(attempt: number, random: number): number {
  const full = Math.min(FIRST_RETRY_MS * 2 ** attempt, LAST_RETRY_MS);
  return full * (0.5 + 0.5 * random);
}

export class Socket {
  readonly #handlers: SocketHandlers;
  readonly #world: SocketWorld;
  #socket: WebSocket | null = null;
  #timer: number | null = null;
  #attempt = 0;
  #abort = new AbortController();
  #isClosed = true;
  /** Counts the attempts, so that what belongs to an older one is ignored. */
  #generation = 0;

  constructor(handlers: SocketHandlers, world: SocketWorld = browserWorld) {
    this.#handlers = handlers;
    this.#world = world;
  }

  start(): void {
    if (!this.#isClosed) return;
    this.#isClosed = false;
    this.#attempt = 0;
    void this.#connect();
  }

  close(): void {
    this.#isClosed = true;
    this.#drop();
    this.#handlers.state('closed');
  }

  /** Tries at once instead of waiting: the network came back, or the page is looked at again. */
  hurry(): void {
    if (this.#isClosed || this.#socket !== null) return;
    this.#attempt = 0;
    void this.#connect();
  }

  /** Sends when open; otherwise the message is dropped, as state is sent again after each opening. */
  send(message: ClientMessage): void {
    this.sendText(JSON.stringify(message));
  }

  /** The same of a message that is a text already. */
  sendText(text: string): void {
    if (this.#socket?.readyState === 1) this.#socket.send(text);
  }

  async #connect(): Promise<void> {
    this.#drop();
    const generation = this.#generation;
    this.#abort = new AbortController();
    this.#handlers.state('connecting');
    // a network that swallows everything answers nothing, not even no
    this.#watch();
    let socket: WebSocket;
    try {
      const address = await this.#handlers.address(this.#abort.signal);
      if (generation !== this.#generation) return;
      socket = this.#world.open(address);
    } catch {
      if (generation === this.#generation) this.#retry();
      return;
    }
    socket.binaryType = 'arraybuffer';
    this.#socket = socket;
    this.#watch();
    socket.onopen = () => {
      if (generation !== this.#generation) return;
      this.#attempt = 0;
      this.#watch();
      this.#handlers.state('open');
    };
    socket.onmessage = (event: MessageEvent) => {
      if (generation !== this.#generation) return;
      this.#watch();
      this.#handlers.message(event.data);
    };
    socket.onclose = () => {
      if (generation === this.#generation) this.#retry();
    };
  }

  /**
   * Restarts the silence timer. In two steps: when the page was held up, its timers are due at once, before the messages
   * that wait.
   */
  #watch(): void {
    this.#stopTimer();
    this.#timer = this.#world.setTimeout(() => {
      this.#timer = this.#world.setTimeout(() => this.#retry(), LAST_LOOK_MS);
    }, SILENCE_LIMIT_MS - LAST_LOOK_MS);
  }

  #retry(): void {
    this.#drop();
    if (this.#isClosed) return;
    this.#handlers.state('waiting');
    const wait = retryDelay_ms(this.#attempt, this.#world.random());
    this.#attempt += 1;
    this.#timer = this.#world.setTimeout(() => void this.#connect(), wait);
  }

  #drop(): void {
    this.#generation += 1;
    this.#abort.abort();
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

/** A message of the server, or null for anything that is not one. */
export function parse(data: unknown): ServerMessage | null {
  if (typeof data !== 'string') return null;
  try {
    const message: unknown = JSON.parse(data);
    const isMessage =
      typeof message === 'object' && message !== null && 'type' in message && typeof message.type === 'string';
    return isMessage ? (message as ServerMessage) : null;
  } catch {
    return null;
  }
}
