// Requests to the server's HTTP API. Every failure is a ProblemError.
import { type Connection, connection as ownConnection } from './connection';
import { challengeOf, noAnswer, ProblemError, problemOf } from './problem';

type Method = 'GET' | 'POST' | 'PUT' | 'PATCH' | 'DELETE';

export interface Options {
  /** Aborts the request. Default: the loss of the connection; `null`: nothing does, as for a long upload. */
  readonly signal?: AbortSignal | null;
  /** Of a dangerous act, as the server gave it. */
  readonly confirmation?: string;
}

export class Http {
  readonly #base: string;
  readonly #fetch: typeof fetch;
  readonly #connection: Connection;

  constructor(
    base = '/api/v1',
    fetchWith: typeof fetch = (...args) => fetch(...args),
    connection: Connection = ownConnection,
  ) {
    this.#base = base;
    this.#fetch = fetchWith;
    this.#connection = connection;
  }

  /** The address of a path of the API, for links. */
  address(path: string): string {
    return this.#base + path;
  }

  async json<T>(method: Method, path: string, body?: unknown, options: Options = {}): Promise<T> {
    const response = await this.request(method, path, body, options);
    const text = await bodyOf(response.text());
    // An empty body means "done".
    return (text === '' ? {} : JSON.parse(text)) as T;
  }

  /**
   * What a person has confirmed: the server is asked for the confirmation of these acts, and asked again with it. Anything else
   * that it wants confirmed stays a problem.
   */
  async confirmed<T>(acts: readonly string[], send: (options: Options) => Promise<T>): Promise<T> {
    try {
      return await send({});
    } catch (error) {
      const challenge = error instanceof ProblemError ? challengeOf(error.problem) : null;
      if (challenge === null || !acts.includes(challenge.act)) throw error;
      return send({ confirmation: challenge.confirmation });
    }
  }

  async request(method: Method, path: string, body?: unknown, options: Options = {}): Promise<Response> {
    const { signal = this.#connection.signal, confirmation } = options;
    const init: RequestInit = {
      method,
      credentials: 'same-origin',
      headers: {
        accept: 'application/json',
        ...(confirmation === undefined ? {} : { 'vencejo-confirmation': confirmation }),
      },
      signal,
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

  async blob(method: Method, path: string, body?: unknown, options: Options = {}): Promise<Blob> {
    const response = await this.request(method, path, body, options);
    return bodyOf(response.blob());
  }
}

/** The connection may be lost between the head of an answer and its body. */
export async function bodyOf<T>(body: Promise<T>): Promise<T> {
  try {
    return await body;
  } catch (error) {
    throw new ProblemError(noAnswer(error));
  }
}
