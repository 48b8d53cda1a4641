/**
 * The figures in a finding's English message. The API gives a finding a stable code but its figures only in words; a
 * message that is worded otherwise has none, and is told without them.
 */

const NUMBER = '-?\\d+(?:\\.\\d+)?';
const pattern = (text: string): RegExp => new RegExp(text.replaceAll('#', NUMBER));

const PATTERNS: Readonly<Record<string, RegExp>> = {
  'too-many-items': pattern('has (?<count>#) items, the vehicle holds (?<max>#)'),
  'too-many-jumps': pattern('has (?<count>#) jumps; small boards track (?<max>#)'),
  'param-out-of-range': pattern('\\): (?<label>.+) is (?<value>#)'),
  'param-changed': pattern('\\): (?<label>.+) of (?<value>#) \\S* ?is kept as (?<kept>#)'),
  'takeoff-too-low': pattern('climbs to (?<height>#) m'),
  'below-home': pattern('lies at (?<height>#) m'),
  'far-from-home': pattern('lies (?<distance>#) km'),
  'far-first': pattern('lies (?<distance>#) km'),
  'short-leg': pattern('is (?<length>#) m long, the plane turns within (?<turn>#) m'),
  'steep-approach': pattern('drops (?<drop>#) m in (?<length>#) m'),
  'outside-fence': pattern('zone (?<zone>#) of the fence'),
  'leg-crosses-fence': pattern('crosses fence zone (?<zone>#)'),
};
/** The range stands in the remedy. */
const RANGE = /from (?<min>\S+) to (?<max>\S+)/;

export interface Worded {
  readonly code: string;
  readonly message: string;
  readonly remedy: string;
}

/** Figures and names by their place in the sentence; `null` when there are none. */
export function findingFigures({ code, message, remedy }: Worded): Readonly<Record<string, string>> | null {
  const found = PATTERNS[code]?.exec(message)?.groups;
  if (found === undefined) return null;
  const range = code === 'param-out-of-range' ? RANGE.exec(remedy)?.groups : undefined;
  return { ...found, ...range };
}
