// Long operations on the server: plan and parameter transfers, with progress and result.
import { SvelteMap } from 'svelte/reactivity';
import type { Api } from '$lib/api/client';
import { ownProblem, ProblemError } from '$lib/api/problem';
import type { Operation } from '$lib/api/types';

/** Finished ones kept to be looked at. */
const KEPT = 20;
/** Polling interval for operations without a message. */
const ASK_MS = 1000;
/** Timeout of one poll. */
const ANSWER_MS = 5000;

interface Waiter {
  resolve(operation: Operation): void;
  reject(error: unknown): void;
}

export class Operations {
  readonly #api: Api;
  readonly #byId = new SvelteMap<string, Operation>();
  readonly #waiters = new Map<string, Waiter[]>();
  /** Operations with a poll in flight. */
  readonly #asked = new Set<string>();

  constructor(api: Api) {
    this.#api = api;
  }

  get(id: Operation['id']): Operation | undefined {
    return this.#byId.get(String(id));
  }

  running = $derived.by(() => [...this.#byId.values()].filter((operation) => operation.state === 'running'));

  /** Takes an operation as reported by the server. */
  update(operation: Operation): void {
    const key = String(operation.id);
    const known = this.#byId.get(key);
    // Messages and answers may cross: an end is final.
    if (known && known.state !== 'running' && operation.state === 'running') return;
    this.#byId.set(key, { ...known, ...operation });
    if (operation.state !== 'running') this.#settle(key);
    while (this.#byId.size > KEPT) {
      const oldest = [...this.#byId].find(([, operation]) => operation.state !== 'running');
      if (oldest === undefined) break;
      this.#byId.delete(oldest[0]);
    }
  }

  /** Puts away those under way that nobody here waits for: a new connection is told of those that the server has. */
  greet(): void {
    for (const { id } of this.running) if (!this.#waiters.has(String(id))) this.#byId.delete(String(id));
  }

  /** Waits for the end of an operation and gives its result; throws its problem. */
  async finish<Result>(started: Operation): Promise<Result> {
    this.update(started);
    const key = String(started.id);
    const ended = new Promise<Operation>((resolve, reject) => {
      this.#waiters.set(key, [...(this.#waiters.get(key) ?? []), { resolve, reject }]);
    });
    if (this.#byId.get(key)?.state !== 'running') this.#settle(key);
    const timer = setInterval(() => void this.#ask(started.id), ASK_MS);
    try {
      let operation = await ended;
      if (operation.state === 'done' && operation.result == null) {
        operation = await this.#api.operation(operation.id);
      }
      if (operation.state === 'done') return operation.result as Result;
      throw new ProblemError(operation.error ?? ownProblem(operation.state, 499));
    } finally {
      clearInterval(timer);
    }
  }

  async cancel(id: Operation['id']): Promise<void> {
    await this.#api.cancelOperation(id);
  }

  async #ask(id: Operation['id']): Promise<void> {
    const key = String(id);
    // where answers do not come, questions would take the browser's few connections from what commands the vehicle
    if (this.#asked.has(key)) return;
    this.#asked.add(key);
    try {
      this.update(await this.#api.operation(id, { signal: AbortSignal.timeout(ANSWER_MS) }));
    } catch (error) {
      // No answer: polled again. Not found: a restarted server no longer knows it.
      if (error instanceof ProblemError && error.problem.status === 404) this.#fail(key, error);
    } finally {
      this.#asked.delete(key);
    }
  }

  #settle(key: string): void {
    const operation = this.#byId.get(key);
    if (operation === undefined) return;
    for (const waiter of this.#waiters.get(key) ?? []) waiter.resolve(operation);
    this.#waiters.delete(key);
  }

  #fail(key: string, error: ProblemError): void {
    const known = this.#byId.get(key);
    if (known) this.#byId.set(key, { ...known, state: 'failed', error: error.problem });
    for (const waiter of this.#waiters.get(key) ?? []) waiter.reject(error);
    this.#waiters.delete(key);
  }
}
