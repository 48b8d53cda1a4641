// Requests to the server's HTTP API. Every failure is a ProblemError.
import { noAnswer, ProblemError, problemOf } from './problem';

export type Method = 'GET' | 'POST' | 'PUT' | 'DELETE';

export class Http {
  readonly #base: string;
  readonly #fetch: typeof fetch;

  constructor(base = '/api/v1', fetchWith: typeof fetch = (...args) => fetch(...args)) {
    this.#base = base;
    this.#fetch = fetchWith;
  }

  /** The address of a path of the API, for links. */
  address(path: string): string {
    return this.#base + path;
  }

  async json<T>(method: Method, path: string, body?: unknown, signal?: AbortSignal): Promise<T> {
    const response = await this.request(method, path, body, signal);
    const text = await response.text();
    // An empty answer stands for "done, nothing to tell".
    return (text === '' ? {} : JSON.parse(text)) as T;
  }

  /** `signal` ends a request that nobody waits for any more. */
  async request(method: Method, path: string, body?: unknown, signal?: AbortSignal): Promise<Response> {
    const init: RequestInit = {
      method,
      credentials: 'same-origin',
      headers: { accept: 'application/json' },
      ...(signal === undefined ? {} : { signal }),
    };
    if (body instanceof Blob) {
      init.body = body;
      init.headers = { ...init.headers, 'content-type': 'application/octet-stream' };
    } else if (body !== undefined) {
      init.body = JSON.stringify(body);
      init.headers = { ...init.headers, 'content-type': 'application/json' };
    }
    let response: Response;
    try {
      response = await this.#fetch(this.#base + path, init);
    } catch (error) {
      throw new ProblemError(noAnswer(error));
    }
    if (!response.ok) throw new ProblemError(await problemOf(response));
    return response;
  }
}
