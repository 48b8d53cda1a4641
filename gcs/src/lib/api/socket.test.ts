import { describe, expect, it } from 'vitest';
import { SILENCE_LIMIT_MS, Socket, parse, retryDelay_ms, type SocketState } from './socket';

/** A world with its own time, in which sockets open when the test says so. */
class World {
  now_ms = 0;
  sockets: FakeSocket[] = [];
  #timers = new Map<number, { at_ms: number; run: () => void }>();
  #next = 1;

  open = () => {
    const socket = new FakeSocket();
    this.sockets.push(socket);
    return socket as unknown as WebSocket;
  };
  setTimeout = (run: () => void, ms: number) => {
    this.#timers.set(this.#next, { at_ms: this.now_ms + ms, run });
    return this.#next++;
  };
  clearTimeout = (timer: number) => void this.#timers.delete(timer);
  random = () => 1;

  async pass(ms: number) {
    const end = this.now_ms + ms;
    for (;;) {
      await Promise.resolve().then(() => Promise.resolve());
      const due = [...this.#timers]
        .filter(([, timer]) => timer.at_ms <= end)
        .sort((a, b) => a[1].at_ms - b[1].at_ms)[0];
      if (!due) break;
      this.now_ms = due[1].at_ms;
      this.#timers.delete(due[0]);
      due[1].run();
    }
    this.now_ms = end;
  }

  /** The page is held up, and then runs the timers that were due. */
  hold(ms: number) {
    this.now_ms += ms;
    for (const [timer, { at_ms, run }] of [...this.#timers]) {
      if (at_ms <= this.now_ms && this.#timers.delete(timer)) run();
    }
  }
}

class FakeSocket {
  readyState = 0;
  sent: string[] = [];
  isClosed = false;
  onopen: (() => void) | null = null;
  onmessage: ((event: { data: unknown }) => void) | null = null;
  onclose: (() => void) | null = null;
  accept() {
    this.readyState = 1;
    this.onopen?.();
  }
  say(message: unknown) {
    this.onmessage?.({ data: JSON.stringify(message) });
  }
  send(text: string) {
    this.sent.push(text);
  }
  close() {
    this.isClosed = true;
  }
}

function start(address: (signal: AbortSignal) => Promise<string> = () => Promise.resolve('ws://here')) {
  const world = new World();
  const states: SocketState[] = [];
  const messages: unknown[] = [];
  const socket = new Socket(
    { address, message: (data) => messages.push(parse(data)), state: (state) => states.push(state) },
    world,
  );
  socket.start();
  return { world, states, messages, socket };
}

describe('Socket', () => {
  it('opens, hands on messages and sends', async () => {
    const { world, states, messages, socket } = start();
    await world.pass(0);
    socket.send({ type: 'unsubscribe', vehicle: 1 });
    world.sockets[0]!.accept();
    world.sockets[0]!.say({ type: 'links', links: [] });
    socket.send({ type: 'unsubscribe', vehicle: 2 });
    expect(states).toEqual(['connecting', 'open']);
    expect(messages).toEqual([{ type: 'links', links: [] }]);
    expect(world.sockets[0]!.sent).toEqual(['{"type":"unsubscribe","vehicle":2}']);
  });

  it('comes back after a close, again and again', async () => {
    const { world, states } = start();
    for (let round = 0; round < 3; round += 1) {
      await world.pass(5);
      world.sockets[round]!.accept();
      world.sockets[round]!.onclose?.();
      await world.pass(300);
    }
    expect(world.sockets).toHaveLength(4);
    expect(states.filter((state) => state === 'open')).toHaveLength(3);
  });

  it('takes silence for a dead connection', async () => {
    const { world, states } = start();
    await world.pass(0);
    world.sockets[0]!.accept();
    await world.pass(SILENCE_LIMIT_MS - 1);
    expect(states.at(-1)).toBe('open');
    world.sockets[0]!.say({ type: 'links', links: [] });
    await world.pass(SILENCE_LIMIT_MS - 1);
    expect(states.at(-1)).toBe('open');
    await world.pass(1);
    expect(states.at(-1)).toBe('waiting');
    expect(world.sockets[0]!.isClosed).toBe(true);
  });

  it('hears what came while the page was held up before it takes the connection for dead', async () => {
    const { world, states } = start();
    await world.pass(0);
    world.sockets[0]!.accept();
    world.hold(3 * SILENCE_LIMIT_MS);
    world.sockets[0]!.say({ type: 'links', links: [] });
    await world.pass(SILENCE_LIMIT_MS - 1);
    expect(states.at(-1)).toBe('open');
    await world.pass(1);
    expect(states.at(-1)).toBe('waiting');
  });

  it('keeps trying while no session can be opened', async () => {
    let attempts = 0;
    const { world } = start(() => {
      attempts += 1;
      return Promise.reject(new Error('away'));
    });
    await world.pass(20_000);
    expect(attempts).toBeGreaterThan(5);
    expect(attempts).toBeLessThan(15);
  });

  it('tries again when an attempt gets no answer at all, and leaves nothing behind', async () => {
    const signals: AbortSignal[] = [];
    const { world, states } = start((signal) => {
      signals.push(signal);
      return signals.length < 3 ? new Promise(() => undefined) : Promise.resolve('ws://here');
    });
    await world.pass(3 * SILENCE_LIMIT_MS);
    expect(signals.map((signal) => signal.aborted)).toEqual([true, true, false]);
    world.sockets[0]!.accept();
    expect(states.at(-1)).toBe('open');
  });

  it('is quiet after close', async () => {
    const { world, states, socket } = start();
    await world.pass(0);
    socket.close();
    await world.pass(60_000);
    expect(states.at(-1)).toBe('closed');
    expect(world.sockets).toHaveLength(1);
  });
});

it('waits longer after each failure, at most 4 s', () => {
  expect([0, 1, 2, 3, 4, 5, 20].map((attempt) => retryDelay_ms(attempt, 1))).toEqual([
    250, 500, 1000, 2000, 4000, 4000, 4000,
  ]);
  expect(retryDelay_ms(0, 0)).toBe(125);
});

it('ignores what is not a message', () => {
  for (const data of ['', '{', 'null', '3', '[]', '{"type":3}', '{}', new ArrayBuffer(1)])
    expect(parse(data)).toBeNull();
});
