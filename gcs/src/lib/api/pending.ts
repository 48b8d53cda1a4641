// Pending questions over the WebSocket: one of each kind, since a newer one supersedes it.

interface Question<Answer> {
  readonly seq: number;
  readonly resolve: (answer: Answer) => void;
  readonly reject: (error: Error) => void;
}

export class Pending<Answer> {
  #open: Question<Answer> | null = null;

  /** The answer to the question that is asked now; rejects when a newer one comes, or when it is ended. */
  ask(seq: number): Promise<Answer> {
    this.end('another question came');
    return new Promise((resolve, reject) => (this.#open = { seq, resolve, reject }));
  }

  /** An answer arrived; answers to older questions are dropped. */
  answer(seq: number, answer: Answer): void {
    if (this.#open?.seq !== seq) return;
    this.#open.resolve(answer);
    this.#open = null;
  }

  /** Rejects the question of this number, or all of them. */
  end(why: string, seq: number | undefined = this.#open?.seq): void {
    if (this.#open === null || this.#open.seq !== seq) return;
    this.#open.reject(new Error(why));
    this.#open = null;
  }
}
