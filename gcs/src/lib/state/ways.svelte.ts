// The ways of the plan that is edited and of the one on board, as the core lays them out.
import { emptyPlan, type Home, type Plan, type PlanItem } from '$lib/domain/plan';
import { type RouteOptions, type ToldWay, type Way, type WayAnswer, wayOf } from '$lib/domain/way';
import { plan } from './plan.svelte';
import { api, station } from './station.svelte';
import { vehicles } from './vehicles.svelte';

export interface Question {
  readonly items: readonly (PlanItem & { readonly key?: number })[];
  readonly home: Home | null;
  readonly vehicle: number | undefined;
  /** What of the vehicle the answer depends on. */
  readonly route: RouteOptions;
}

/** Questions follow each other by so much at least: no display shows more, and the server takes 200 messages a second. */
const APART_MS = 10;

/** Asks about one plan: one question at a time, and of those that come meanwhile the last. */
export class Asker {
  readonly #tell: (plan: Plan, vehicle: number | undefined) => Promise<ToldWay>;
  answer = $state.raw<WayAnswer | null>(null);
  #asked: Question | null = null;
  #next: Question | null = null;
  #isAsking = false;

  constructor(tell: (plan: Plan, vehicle: number | undefined) => Promise<ToldWay>) {
    this.#tell = tell;
  }

  ask(question: Question | null): void {
    if (question === null || question.items.length === 0) {
      [this.answer, this.#asked, this.#next] = [null, null, null];
      return;
    }
    if (this.#asked !== null && isSame(this.#asked, question)) return;
    this.#asked = this.#next = question;
    if (!this.#isAsking) void this.#work();
  }

  /** Lets the same question be asked again. */
  forget(): void {
    this.#asked = null;
  }

  async #work(): Promise<void> {
    this.#isAsking = true;
    try {
      while (this.#next !== null) {
        const { items, home, vehicle } = this.#next;
        this.#next = null;
        const asked_ms = performance.now();
        const asked = items.map(({ command, name, frame, params, autocontinue }) => {
          return { command, name, frame, params, autocontinue };
        });
        const way = await this.#tell({ ...emptyPlan(), items: asked, home }, vehicle);
        if (this.#asked !== null) this.answer = { items, home, way };
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
  a.items === b.items && a.home === b.home && a.vehicle === b.vehicle && a.route === b.route;

class Ways {
  readonly #ofDraft = new Asker((draft, vehicle) => station.way(draft, vehicle));
  /** Which changes seldom, and takes no draft's turn. */
  readonly #ofBoard = new Asker((mission, vehicle) => api.way(mission, vehicle));
  #boardItems = $derived(plan.vehiclePlan?.items ?? []);

  /** The way of the plan that is edited. */
  draft = $derived<Way>(wayOf(plan.items, plan.home, vehicles.route.fliesArcs, this.#ofDraft.answer));
  /** The way of the mission on board, as far as that is known. */
  onBoard = $derived<Way>(wayOf(this.#boardItems, plan.home, vehicles.route.fliesArcs, this.#ofBoard.answer));

  /** Asks for what is not known yet; to be called when anything of it, or the station, is another. */
  ask(): void {
    const { route } = vehicles;
    const common = { home: plan.home, vehicle: vehicles.selected?.systemId, route };
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
