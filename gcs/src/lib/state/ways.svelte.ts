// The ways and heights of the plan that is edited and of the one on board, as the core lays them out.
import { emptyPlan, type Home, type Plan, type PlanItem } from '$lib/domain/plan';
import { NO_PROFILE, type ProfileGround } from '$lib/domain/profile';
import { endOf, type RouteOptions, type ToldWay, type Way, type WayAnswer, wayOf } from '$lib/domain/way';
import { elevation } from './maps-elevation.svelte';
import { plan } from './plan.svelte';
import { api, station } from './station.svelte';
import { vehicles } from './vehicles.svelte';

export interface Question {
  readonly items: readonly (PlanItem & { readonly key?: number })[];
  readonly home: Home | null;
  readonly vehicle: number | undefined;
  /** What of the vehicle the answer depends on. */
  readonly route: RouteOptions;
  /** Height above the ground that should be kept, metres. */
  readonly clearance_m: number;
  /** Whether anything tells the height of the ground. */
  readonly knowsGround: boolean;
}

type Tell = (
  plan: Plan,
  vehicle: number | undefined,
  clearance_m: number,
) => Promise<ToldWay & { readonly is_ground_pending: boolean }>;

/** Questions follow each other by so much at least: no display shows more, and the server takes 200 messages a second. */
const APART_MS = 10;
/** After that the core is asked again about ground that it did not know yet. */
const GROUND_AGAIN_MS = 700;

/** Asks about one plan: one question at a time, and of those that come meanwhile the last. */
export class Asker {
  readonly #tell: Tell;
  readonly #onAnswer: (answer: WayAnswer) => void;
  answer = $state.raw<WayAnswer | null>(null);
  #asked: Question | null = null;
  #next: Question | null = null;
  #isAsking = false;
  #again: ReturnType<typeof setTimeout> | undefined;

  /** `onAnswer` is called with each answer, before anything that is drawn from it. */
  constructor(tell: Tell, onAnswer: (answer: WayAnswer) => void = () => undefined) {
    this.#tell = tell;
    this.#onAnswer = onAnswer;
  }

  ask(question: Question | null): void {
    if (question === null || question.items.length === 0) {
      [this.answer, this.#asked, this.#next] = [null, null, null];
      return;
    }
    if (this.#asked !== null && isSame(this.#asked, question)) return;
    this.#asked = question;
    this.#askNow();
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
        const { items, home, vehicle, clearance_m } = this.#next;
        this.#next = null;
        const asked_ms = performance.now();
        const asked = items.map(({ command, name, frame, params, autocontinue }) => {
          return { command, name, frame, params, autocontinue };
        });
        const way = await this.#tell({ ...emptyPlan(), items: asked, home }, vehicle, clearance_m);
        if (this.#asked !== null) this.#onAnswer((this.answer = { items, home, way }));
        clearTimeout(this.#again);
        if (way.is_ground_pending) this.#again = setTimeout(() => this.#askNow(), GROUND_AGAIN_MS);
        const early_ms = asked_ms + APART_MS - performance.now();
        if (early_ms > 0) await new Promise((done) => setTimeout(done, early_ms));
      }
    } catch {
      // straight lines, until the plan is another one or the station is back
      this.forget();
    } finally {
      this.#isAsking = false;
    }
  }
}

const isSame = (a: Question, b: Question): boolean =>
  (Object.keys(a) as (keyof Question)[]).every((key) => a[key] === b[key]);

class Ways {
  readonly #ofDraft = new Asker(
    (...asked) => station.way(...asked),
    (answer) => {
      // of what was edited meanwhile it is told in a moment
      if (answer.items === plan.items) plan.end = endOf(answer);
      this.#listeners.forEach((listen) => listen());
    },
  );
  readonly #listeners = new Set<() => void>();
  /** Which changes seldom, and takes no draft's turn. */
  readonly #ofBoard = new Asker((...asked) => api.way(...asked));
  #boardItems = $derived(plan.vehiclePlan?.items ?? []);

  /** The way of the plan that is edited. */
  draft = $derived<Way>(wayOf(plan.items, plan.home, vehicles.route.fliesArcs, this.#ofDraft.answer));
  /** The way of the mission on board, as far as that is known. */
  onBoard = $derived<Way>(wayOf(this.#boardItems, plan.home, vehicles.route.fliesArcs, this.#ofBoard.answer));

  /** While nothing is edited the plan that the vehicle has is shown, where that is known. */
  isOnBoardShown = $derived(!plan.isEditing && this.#boardItems.length > 0);
  #shownAnswer = $derived(this.isOnBoardShown ? this.#ofBoard.answer : this.#ofDraft.answer);
  /** The heights of the plan that is shown; while it is edited, of what it was at the core's last answer. */
  profile = $derived(this.#shownAnswer?.way.profile ?? NO_PROFILE);
  /** The items of that, with the keys that they keep. */
  profileItems = $derived<Question['items']>(this.#shownAnswer?.items ?? []);
  /** Whether these are the heights of another plan than is shown, which the core cannot be asked about. */
  isProfileOld = $derived(
    !station.isOnline &&
      this.#shownAnswer !== null &&
      this.#shownAnswer.items !== (this.isOnBoardShown ? this.#boardItems : plan.items),
  );
  /** The ground below; `null` where nothing could tell it. */
  ground = $derived<ProfileGround | null>(elevation.isKnowable ? this.profile.ground : null);

  /** Calls at each answer about the draft, before all that the page writes of it: the map is not to wait for that. */
  onDraft(listen: () => void): () => void {
    this.#listeners.add(listen);
    return () => this.#listeners.delete(listen);
  }

  /** Asks for what is not known yet; to be called when anything of it, or the station, is another. */
  ask(): void {
    const { route } = vehicles;
    const { clearance_m, isKnowable: knowsGround } = elevation;
    const common = { home: plan.home, vehicle: vehicles.selected?.systemId, route, clearance_m, knowsGround };
    const [draft, board] = [plan.items, this.#boardItems];
    if (!station.isOnline) {
      this.#ofDraft.forget();
      this.#ofBoard.forget();
      return;
    }
    this.#ofDraft.ask({ ...common, items: draft });
    this.#ofBoard.ask({ ...common, items: board });
  }
}

export const ways = new Ways();
