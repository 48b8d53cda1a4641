// What went wrong with a request, in the server's words or, when there was no answer, in ours.
import type { Cause, CommandName, Problem, RefusalCode } from './types';

/** The type of a problem without a kind (RFC 9457). */
const NO_KIND = 'about:blank';
/** No answer came: the server is away. */
const NO_ANSWER = 0;
const NO_ANSWER_TITLE = 'No answer';

export class ProblemError extends Error {
  readonly problem: Problem;

  constructor(problem: Problem) {
    super(problem.detail || problem.title);
    this.name = 'ProblemError';
    this.problem = problem;
  }
}

/** The problem in the body of an error response; built from the status when the body is something else. */
export async function problemOf(response: Response): Promise<Problem> {
  const fallback: Problem = { type: NO_KIND, title: response.statusText, status: response.status, detail: '' };
  if (!/[/+]json\b/.test(response.headers.get('content-type') ?? '')) return fallback;
  const body: unknown = await response.json().catch(() => null);
  if (typeof body !== 'object' || body === null) return fallback;
  const { title, detail, type, reasons, refusals, remedy, cause } = body as Record<string, unknown>;
  return {
    type: typeof type === 'string' ? type : NO_KIND,
    title: typeof title === 'string' ? title : fallback.title,
    status: response.status,
    detail: typeof detail === 'string' ? detail : '',
    ...(Array.isArray(reasons)
      ? { reasons: reasons.filter((reason): reason is string => typeof reason === 'string') }
      : {}),
    ...(Array.isArray(refusals) ? { refusals: refusals.map((code: unknown) => (isRefusal(code) ? code : null)) } : {}),
    ...(typeof remedy === 'string' ? { remedy } : {}),
    ...(isCause(cause) ? { cause } : {}),
  };
}

/** Whether it is a word; which ones there are is the server's. */
const isRefusal = (value: unknown): value is RefusalCode => typeof value === 'string';

/** Whether it has a code; which fields belong to that is the server's word. */
function isCause(value: unknown): value is Cause {
  return typeof value === 'object' && value !== null && 'code' in value && typeof value.code === 'string';
}

export interface Reason {
  /** What the vehicle wrote, without the words that every refusal begins with. */
  readonly text: string;
  /** What that is about, where the server knows. */
  readonly refusal: RefusalCode | null;
}

/** Why the vehicle refused, each reason once. */
export function reasonsOf({ reasons = [], refusals = [] }: Problem): Reason[] {
  const bare = (text: string): string => text.replace(/^\s*(PreArm|Arm|Arming denied)\s*:\s*/i, '').trim();
  const told = reasons.map((text, index) => ({ text: bare(text), refusal: refusals[index] ?? null }));
  return told.filter(({ text }, index) => told.findIndex((other) => other.text === text) === index);
}

/** Whether changing the mode solves it. */
export const isCuredByMode = (refusal: RefusalCode): boolean =>
  refusal === 'mode-not-armable' || refusal === 'landing-sequence';

type Challenge = Extract<Cause, { code: 'needs-confirmation' }>;

/** What the server wants confirmed; null for any other problem. */
export const challengeOf = ({ cause }: Problem): Challenge | null =>
  cause?.code === 'needs-confirmation' ? cause : null;

/** Why a mission on board is not flown; each is overridden in the same way. */
export type Doubt = 'mixed' | 'reach' | 'home';

/** Commands that may have the mission followed. */
const FOLLOW_MISSION: ReadonlySet<CommandName> = new Set([
  'arm',
  'mode',
  'prepare-flight',
  'mission/start',
  'mission/resume',
  'land',
]);

/** Why a command was held back because of the mission on board; null when that was not the reason. */
export function doubtOf({ cause }: Problem, command: CommandName): Doubt | null {
  if (cause?.code === 'plan-unknown') return 'mixed';
  if (cause?.code === 'out-of-reach') return 'reach';
  // to others home is a height's reference, which no override replaces
  return cause?.code === 'home-unknown' && FOLLOW_MISSION.has(command) ? 'home' : null;
}

/** The problem for an unreachable server. */
export const noAnswer = (error: unknown): Problem => ownProblem(NO_ANSWER_TITLE, NO_ANSWER, String(error));

export const isNoAnswer = ({ title, status }: Problem): boolean => status === NO_ANSWER && title === NO_ANSWER_TITLE;

/** A problem of our own making. */
export function ownProblem(title: string, status: number, detail = ''): Problem {
  return { type: NO_KIND, title, status, detail };
}

/** The problem for anything that was thrown. */
export function problemFrom(error: unknown): Problem {
  if (error instanceof ProblemError) return error.problem;
  return ownProblem('Error', NO_ANSWER, error instanceof Error ? error.message : String(error));
}
