// How the plan that is edited stands to what a vehicle has on board, as the core compares them.
import type { Plan, PlanChange, PlanComparison, PlanKind } from '$lib/api/types';
import { emptyPlan, plainItems, type Fence, type PlanItem, type RallyPoint } from '$lib/domain/plan';
import { Asker } from './asker.svelte';

/** What is to be compared; the parts of a plan keep their identity until they are edited. */
export interface Question {
  readonly vehicle: number;
  readonly mission: readonly PlanItem[];
  readonly fence: Fence;
  readonly rally: readonly RallyPoint[];
  /** Fingerprint of the known plan on board; `null` where it is unknown or empty. */
  readonly missionHash: string | null;
  readonly fenceHash: string | null;
  readonly rallyHash: string | null;
}

interface Answer {
  readonly question: Question;
  /** `null`: the server compared nothing. */
  readonly told: PlanComparison | null;
}

/** How a part differs from the one on board. */
interface Differing<Part extends PlanKind> {
  readonly changes: readonly PlanChange[];
  /** The part that was compared. */
  readonly of: Question[Part];
}

/** Minimum interval between requests: a list of differences is not read faster. */
const APART_MS = 100;
/** How long the last differences are shown without a newer answer while editing goes on. */
const LATE_MS = 200;
/** After that a server is asked again that did not answer. */
const AGAIN_MS = 2000;

/** Asks after edits, and knows what its answer is about. */
export class Comparison {
  readonly #asker: Asker<Question, Answer>;
  #asked: Question | null = null;
  #isLate = $state(false);
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(compare: (vehicle: number, plan: Plan) => Promise<PlanComparison>) {
    const tell = async (question: Question): Promise<Answer> => {
      const { vehicle, mission, fence, rally } = question;
      const plan = { ...emptyPlan(), items: plainItems(mission), fence, rally: [...rally] };
      // parts not compared are unknown
      return { question, told: await compare(vehicle, plan).catch(() => null) };
    };
    this.#asker = new Asker(tell, {
      apart_ms: APART_MS,
      onAnswer: ({ question }) => this.#onAnswer(question),
      again_ms: ({ told }) => (told === null ? AGAIN_MS : null),
    });
  }

  /** Asks; `null`: there is nothing to compare. */
  ask(question: Question | null): void {
    if (this.#asker.ask(question)) this.#timer ??= setTimeout(() => (this.#isLate = true), LATE_MS);
    this.#asked = question;
  }

  /** Lets the same be asked again, of a server that was away. */
  forget(): void {
    this.#asker.forget();
  }

  #onAnswer(question: Question): void {
    clearTimeout(this.#timer);
    this.#isLate = false;
    this.#timer = question === this.#asked ? undefined : setTimeout(() => (this.#isLate = true), LATE_MS);
  }

  /**
   * How a part as it is `now` differs from the one on board; `null` while that is unknown. "Same" holds only for the very version
   * that was compared; "differs" also for a moment after an edit. Reactive.
   */
  of<Part extends PlanKind>(part: Part, now: Question): Differing<Part> | null {
    const { question, told } = this.#asker.answer ?? { question: null, told: null };
    const compared = told?.[part] ?? null;
    if (question === null || compared === null) return null;
    const isSameBoard = question.vehicle === now.vehicle && compared.hash === now[`${part}Hash`];
    const isAsNow = question[part] === now[part];
    if (!isSameBoard || (!isAsNow && (this.#isLate || compared.changes.length === 0))) return null;
    return { changes: compared.changes, of: question[part] };
  }
}
