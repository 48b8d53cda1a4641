// Which messages are shown: by severity and by words; repetitions folded.

/** MAV_SEVERITY; smaller is worse. */
export const WARNING = 4;

interface Searchable {
  severity: number;
  text: string;
}

const plain = (text: string): string =>
  text
    .normalize('NFD')
    .replace(/\p{Diacritic}/gu, '')
    .toLowerCase();

/** Those at least as severe as `severity` that hold every word of `search`, in any order, without regard to case. */
export function filterMessages<Message extends Searchable>(
  messages: readonly Message[],
  severity: number,
  search: string,
): Message[] {
  const words = plain(search)
    .split(/\s+/)
    .filter((word) => word !== '');
  return messages.filter((message) => {
    if (message.severity > severity) return false;
    const text = plain(message.text);
    return words.every((word) => text.includes(word));
  });
}

/** ArduPilot repeats what bars arming every 30 s; a message that comes again after longer than this is news, ms. */
const REPEATED_WITHIN_MS = 60_000;

interface Received extends Searchable {
  /** Time of day at which it arrived. */
  at: Date;
}

/** A message with its repetitions. */
export interface Run<Message> {
  readonly first: Message;
  readonly last: Message;
  readonly count: number;
}

/** Messages with their repetitions folded, in the order of the last of each; others may lie in between. */
export function foldMessages<Message extends Received>(messages: readonly Message[]): Run<Message>[] {
  const runs = new Map<string, Run<Message>>();
  const ended: Run<Message>[] = [];
  for (const message of messages) {
    const key = `${message.severity} ${message.text}`;
    const run = runs.get(key);
    // the clock of a recording may have been set back
    const goesOn = run !== undefined && Math.abs(message.at.getTime() - run.last.at.getTime()) <= REPEATED_WITHIN_MS;
    if (run !== undefined && !goesOn) ended.push(run);
    runs.set(
      key,
      goesOn ? { ...run, last: message, count: run.count + 1 } : { first: message, last: message, count: 1 },
    );
  }
  const place = new Map(messages.map((message, index) => [message, index]));
  const placeOf = ({ last }: Run<Message>): number => place.get(last) ?? 0;
  return [...ended, ...runs.values()].sort((a, b) => placeOf(a) - placeOf(b));
}

/** ArduPilot's prefix, and PX4's. */
const BARS_ARMING = /^(?:PreArm|Preflight Fail): */;

interface Counted extends Received {
  readonly id: number;
  /** Whether it came while the page was open. */
  readonly isNews: boolean;
}

/**
 * How many messages have come since number `seen`, each with its repetitions once. What bars arming counts once for as long as it
 * is repeated, also after it was seen; anything else that comes again counts again.
 */
export function countUnseen<Message extends Counted>(messages: readonly Message[], seen: number): number {
  const isUnseen = ({ id, isNews }: Message): boolean => isNews && id > seen;
  const bars = ({ text }: Message): boolean => BARS_ARMING.test(text);
  const barring = foldMessages(messages.filter(bars)).filter(({ first }) => isUnseen(first));
  const others = foldMessages(messages.filter((message) => !bars(message) && isUnseen(message)));
  return barring.length + others.length;
}

/** What the vehicle has told within the last minute that bars arming, the newest first. */
export function armingReasons(messages: readonly Received[], now: Date): string[] {
  const reasons = messages
    .filter(({ at, text }) => BARS_ARMING.test(text) && now.getTime() - at.getTime() <= REPEATED_WITHIN_MS)
    .map(({ text }) => text.replace(BARS_ARMING, ''));
  return [...new Set(reasons.reverse())];
}
