import { describe, expect, it } from 'vitest';
import {
  attentionTo,
  changedRow,
  found,
  inOrder,
  isOld,
  keptOrder,
  keyOf,
  levelOf,
  type Listed,
  placesByName,
  type RosterChange,
} from './roster';

const row = (change: RosterChange) => changedRow(undefined, change);

function listed(change: RosterChange, name: string, age_s = 1): Listed {
  const one = row(change);
  const words = () => `${name} ${one.id} ${one.mode ?? ''}`;
  return { row: one, name, place: 0, age_s, attention: attentionTo(one, age_s), words };
}

describe('rows', () => {
  it('keep what was not told again, and take null for not known', () => {
    const first = row({ id: 300, remote_name: 'plane7', mode: 'AUTO', lat_deg: 40.1 });
    const next = changedRow(first, { id: 300, mode: 'RTL', lat_deg: null });
    expect([next.remote_name, next.mode, next.lat_deg, next.battery_pct]).toEqual(['plane7', 'RTL', null, null]);
    expect([keyOf(next), keyOf(row({ id: 3 }))]).toEqual(['plane7', '#3']);
  });
});

describe('attention', () => {
  const cases: [string, RosterChange, number | null, string[], string][] = [
    ['nothing', { id: 1, battery_pct: 80, holder: 'Ana', is_held_here: true }, 1, [], 'none'],
    ['never heard', { id: 1 }, null, [], 'none'],
    ['lost', { id: 1, is_reached: false }, 9, ['lost'], 'danger'],
    ['autopilot silent', { id: 1, silence: 'ttyS0 (open)' }, 9, ['silent'], 'danger'],
    ['late', { id: 1 }, 4, ['stale'], 'warn'],
    ['battery', { id: 1, battery_pct: 12 }, 1, ['battery-critical'], 'danger'],
    ['battery getting low', { id: 1, battery_pct: 20 }, 1, ['battery-low'], 'warn'],
    ['off its plan, and more', { id: 1, target_off_m: 300, may_be_mixed: true }, 1, ['target', 'mixed'], 'danger'],
    ['revoked', { id: 1, is_revoked: true }, 60, ['revoked'], 'warn'],
    ['asked for', { id: 1, holder: 'Ana', is_held_here: true, requested_by: 'Luis' }, 1, ['wanted'], 'warn'],
    ['asked of another', { id: 1, holder: 'Eva', is_held_here: false, requested_by: 'Luis' }, 1, ['held'], 'warn'],
    ['held elsewhere', { id: 1, holder: 'Luis', is_held_here: false }, 1, ['held'], 'warn'],
    ['alarm', { id: 1, alarm: { severity: 2, text: 'x', time_s: 1 } }, 1, ['alarm'], 'danger'],
    ['warning', { id: 1, alarm: { severity: 4, text: 'x', time_s: 1 } }, 1, ['warning'], 'warn'],
    ['one way', { id: 1, is_reached: false, loss_pct: 40 }, 1, ['unreached', 'loss'], 'danger'],
    ['two of one id', { id: 1, is_contested: true }, 1, ['contested'], 'danger'],
  ];
  it.each(cases)('%s', (_, change, age_s, reasons, level) => {
    const attention = attentionTo(row(change), age_s);
    expect([attention, levelOf(attention)]).toEqual([reasons, level]);
  });
});

it('is shown as old by its age, whatever else is to be said of it', () => {
  const isOldAt = (change: RosterChange, age_s: number) => isOld(listed(change, 'plane7', age_s));
  expect([isOldAt({ id: 1, is_revoked: true }, 60), isOldAt({ id: 1, is_revoked: true }, 1)]).toEqual([true, false]);
  expect([isOldAt({ id: 1 }, 4), isOldAt({ id: 1, is_recorded: true }, 60)]).toEqual([true, false]);
  expect(isOldAt({ id: 1, silence: 'ttyS0 (open)' }, 1)).toBe(true);
});

describe('the list', () => {
  const some = [
    listed({ id: 300, mode: 'AUTO' }, 'plane10'),
    listed({ id: 301, mode: 'RTL', battery_pct: 10 }, 'plane2'),
    listed({ id: 302, mode: 'AUTO' }, 'plane1', 20),
    listed({ id: 303, mode: 'LOITER' }, 'Peñón'),
  ];
  const places = placesByName(some.map(({ row, name }) => ({ id: row.id, name })));
  const all = some.map((one) => ({ ...one, place: places.get(one.row.id) ?? 0 }));
  const ids = (some: readonly Listed[]): number[] => some.map(({ row: { id } }) => id);

  it('has what needs attention first, the rest by name', () => {
    expect(ids(inOrder(all, 'attention'))).toEqual([302, 301, 303, 300]);
    expect(ids(inOrder(all, 'name'))).toEqual([303, 302, 301, 300]);
  });

  it('keeps its order while it is pointed at', () => {
    expect(ids(keptOrder([303, 999, 300], all))).toEqual([303, 300, 301, 302]);
  });

  it('is searched by words in any order', () => {
    expect(ids(found(all, ' auto PLANE '))).toEqual([300, 302]);
    expect(ids(found(all, 'penon'))).toEqual([303]);
    expect(ids(found(all, '301'))).toEqual([301]);
    expect(found(all, '').length).toBe(4);
  });
});
