// Questions about the plan that follow its edits: one is asked at a time, and of those that come meanwhile the last.

interface Terms<Answer> {
  /** Minimum interval between requests. */
  readonly apart_ms: number;
  /** Called with each answer, before anything that is drawn from it. */
  readonly onAnswer?: (answer: Answer) => void;
  /** After how long the same is asked again, of an answer that is not the last word; `null` of one that is. */
  readonly again_ms?: (answer: Answer) => number | null;
}

/** Asks about one thing. Questions are the same when all their values are, each by identity. */
export class Asker<Question extends object, Answer> {
  readonly #tell: (question: Question) => Promise<Answer>;
  readonly #terms: Terms<Answer>;
  /** The newest answer; `null` before the first one, and when there is nothing to ask. */
  answer = $state.raw<Answer | null>(null);
  #asked: Question | null = null;
  #next: Question | null = null;
  #isAsking = false;
  #again: ReturnType<typeof setTimeout> | undefined;

  constructor(tell: (question: Question) => Promise<Answer>, terms: Terms<Answer>) {
    this.#tell = tell;
    this.#terms = terms;
  }

  /** Asks; `null` means nothing to ask. Returns whether the question differs from the last. */
  ask(question: Question | null): boolean {
    if (question === null) {
      [this.answer, this.#asked, this.#next] = [null, null, null];
      return false;
    }
    if (this.#asked !== null && isSame(this.#asked, question)) return false;
    this.#asked = question;
    this.#askNow();
    return true;
  }

  #askNow(): void {
    clearTimeout(this.#again);
    this.#next = this.#asked;
    if (this.#next !== null && !this.#isAsking) void this.#work();
  }

  /** Lets the same question be asked again. */
  forget(): void {
    this.#asked = null;
  }

  async #work(): Promise<void> {
    this.#isAsking = true;
    try {
      while (this.#next !== null) {
        const question = this.#next;
        this.#next = null;
        const asked_ms = performance.now();
        const answer = await this.#tell(question);
        if (this.#asked !== null) {
          this.answer = answer;
          this.#terms.onAnswer?.(answer);
        }
        clearTimeout(this.#again);
        const again_ms = this.#terms.again_ms?.(answer) ?? null;
        if (again_ms !== null) this.#again = setTimeout(() => this.#askNow(), again_ms);
        const early_ms = asked_ms + this.#terms.apart_ms - performance.now();
        if (early_ms > 0) await new Promise((done) => setTimeout(done, early_ms));
      }
    } catch {
      // no answer: asked again when the question changes, which may have happened already, or the station is back
      if (this.#next === null) this.forget();
    } finally {
      this.#isAsking = false;
    }
    if (this.#next !== null) await this.#work();
  }
}

const isSame = <Question extends object>(a: Question, b: Question): boolean =>
  (Object.keys(a) as (keyof Question)[]).every((key) => a[key] === b[key]);
