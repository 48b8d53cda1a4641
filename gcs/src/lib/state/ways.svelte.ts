// The ways and heights of the plan that is edited and of the one on board, as the core lays them out.
import { emptyPlan, plainItems, type Home, type Plan, type PlanItem } from '$lib/domain/plan';
import { NO_PROFILE, type ProfileGround } from '$lib/domain/profile';
import { endOf, type RouteOptions, type ToldWay, type Way, type WayAnswer, wayOf } from '$lib/domain/way';
import { Asker } from './asker.svelte';
import { elevation } from './maps-elevation.svelte';
import { plan } from './plan.svelte';
import { planCompared } from './plan-compared.svelte';
import { api, station } from './station.svelte';
import { vehicles } from './vehicles.svelte';

export interface Question {
  readonly items: readonly (PlanItem & { readonly key?: number })[];
  readonly home: Home | null;
  readonly vehicle: number | undefined;
  /** The vehicle's properties that the answer depends on. */
  readonly route: RouteOptions;
  /** Height above the ground that should be kept, metres. */
  readonly clearance_m: number;
  /** Whether there is a source of elevation. */
  readonly knowsGround: boolean;
}

type Tell = (
  plan: Plan,
  vehicle: number | undefined,
  clearance_m: number,
) => Promise<ToldWay & { readonly is_ground_pending: boolean }>;

/** Minimum interval between requests: no display shows more, and the server takes 200 messages a second. */
const APART_MS = 10;
/** After that the core is asked again about ground that it did not know yet. */
const GROUND_AGAIN_MS = 700;

/** Asks for the way of one plan. */
export const wayAsker = (tell: Tell, onAnswer: (answer: WayAnswer) => void = () => undefined) =>
  new Asker(
    async ({ items, home, vehicle, clearance_m }: Question): Promise<WayAnswer> => {
      const plan = { ...emptyPlan(), items: plainItems(items), home };
      return { items, home, way: await tell(plan, vehicle, clearance_m) };
    },
    {
      apart_ms: APART_MS,
      onAnswer,
      again_ms: ({ way }) => ('is_ground_pending' in way && way.is_ground_pending ? GROUND_AGAIN_MS : null),
    },
  );

class Ways {
  readonly #ofDraft = wayAsker(
    (...asked) => station.way(...asked),
    (answer) => {
      // what was edited meanwhile is asked about next
      if (answer.items === plan.items) plan.end = endOf(answer);
      this.#listeners.forEach((listen) => listen());
    },
  );
  readonly #listeners = new Set<() => void>();
  /** Which changes seldom, and takes no draft's turn. */
  readonly #ofBoard = wayAsker((...asked) => api.way(...asked));
  #boardItems = $derived(planCompared.vehiclePlan?.items ?? []);

  /** The way of the plan that is edited. */
  draft = $derived<Way>(wayOf(plan.items, plan.home, vehicles.route.fliesArcs, this.#ofDraft.answer));
  /** The way of the mission on board, as far as that is known. */
  onBoard = $derived<Way>(wayOf(this.#boardItems, plan.home, vehicles.route.fliesArcs, this.#ofBoard.answer));

  /** While nothing is edited the plan that the vehicle has is shown, where that is known. */
  isOnBoardShown = $derived(!plan.isEditing && this.#boardItems.length > 0);
  #shownAnswer = $derived(this.isOnBoardShown ? this.#ofBoard.answer : this.#ofDraft.answer);
  /** The heights of the shown plan; during an edit, those of the core's last answer. */
  profile = $derived(this.#shownAnswer?.way.profile ?? NO_PROFILE);
  /** The items of that, with the keys that they keep. */
  profileItems = $derived<Question['items']>(this.#shownAnswer?.items ?? []);
  /** Whether these heights are of an older plan than the one shown, because the core cannot be asked. */
  isProfileOld = $derived(
    !station.isOnline &&
      this.#shownAnswer !== null &&
      this.#shownAnswer.items !== (this.isOnBoardShown ? this.#boardItems : plan.items),
  );
  /** The ground below; `null` where it is unknown. */
  ground = $derived<ProfileGround | null>(elevation.isKnowable ? this.profile.ground : null);

  /** Calls at each answer about the draft, before all that the page writes of it: the map is not to wait for that. */
  onDraft(listen: () => void): () => void {
    this.#listeners.add(listen);
    return () => this.#listeners.delete(listen);
  }

  /** Asks for what is not known yet; to be called when any input, or the connection, changes. */
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
    this.#ofDraft.ask(draft.length === 0 ? null : { ...common, items: draft });
    this.#ofBoard.ask(board.length === 0 ? null : { ...common, items: board });
  }
}

export const ways = new Ways();
