// The connection to the server; its loss aborts all requests in flight.

export class Connection {
  #controller = new AbortController();

  /** Aborted when the connection is lost. Read it for each request: it is replaced after a loss. */
  get signal(): AbortSignal {
    return this.#controller.signal;
  }

  /** Aborted with `signal`, or when the connection is lost. Browsers from before 2024 have no `AbortSignal.any`: there by `signal` alone. */
  or(signal: AbortSignal): AbortSignal {
    const any = AbortSignal.any as typeof AbortSignal.any | undefined;
    return any?.call(AbortSignal, [signal, this.signal]) ?? signal;
  }

  /**
   * Ends the requests in flight. A network that swallows packets fails no request by itself: without this the button that waits
   * for an answer stays disabled after the connection is back, and the requests hold the browser's six connections to the server.
   */
  lose(): void {
    this.#controller.abort('the connection was lost');
    this.#controller = new AbortController();
  }
}

export const connection = new Connection();
