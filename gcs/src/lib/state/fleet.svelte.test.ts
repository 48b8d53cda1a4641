import { beforeEach, describe, expect, it } from 'vitest';
import { clock } from './clock.svelte';
import { fleet } from './fleet.svelte';

beforeEach(() => {
  clock.tick(performance.now());
  fleet.begin();
  fleet.marked.clear();
  [fleet.search, fleet.order, fleet.group] = ['', 'attention', null];
  const rows = [
    { id: 300, remote_name: 'plane7', mode: 'AUTO', mav_type: 1, heard_s: 99.9 },
    { id: 301, remote_name: 'plane8', mode: 'RTL', mav_type: 1, heard_s: 90 },
    { id: 3, mode: 'LOITER', mav_type: 2, heard_s: 99.5, holder: 'Ana', is_held_here: false },
  ];
  fleet.apply(100, rows, [], performance.now());
});

const names = (): string[] => fleet.shown.map(({ name }) => name);

describe('the fleet', () => {
  it('has what needs attention first, and is searched by what is told of it', () => {
    expect(names()).toEqual(['plane8', 'Copter 3', 'plane7']);
    expect([fleet.count, fleet.needing]).toEqual([3, 2]);
    fleet.search = 'lost';
    expect(names()).toEqual(['plane8']);
    fleet.search = 'ana loiter';
    expect(names()).toEqual(['Copter 3']);
  });

  it('takes over what changed, and forgets who went', () => {
    fleet.apply(101, [{ id: 301, heard_s: 100.9 }], [3], performance.now());
    expect(names()).toEqual(['plane7', 'plane8']);
    expect([fleet.get(301)?.mode, fleet.needing]).toEqual(['RTL', 0]);
  });

  it('marks nobody who went while the page was away', () => {
    for (const id of [3, 300]) fleet.mark(id, true);
    fleet.begin();
    expect(fleet.marked.size, 'until the list is there').toBe(2);
    fleet.apply(102, [{ id: 300, remote_name: 'plane7', mav_type: 1, heard_s: 101 }], [], performance.now());
    expect([fleet.marked.size, fleet.markedRows().length]).toEqual([1, 1]);
  });

  it('tells the lost last, and keeps those marked as a group by name', () => {
    for (const id of [3, 300, 301]) fleet.mark(id, true);
    expect(fleet.markedRows().map(({ name }) => name)).toEqual(['Copter 3', 'plane7', 'plane8']);
    fleet.mark(300, false);
    expect(fleet.keepGroup(' north ')).toBe(true);
    expect([fleet.group, fleet.groupNames, names()]).toEqual(['north', ['north'], ['plane8', 'Copter 3']]);
    fleet.forgetGroup('north');
    expect([fleet.group, fleet.groupNames.length, fleet.keepGroup('  ')]).toEqual([null, 0, false]);
    for (const id of [3, 300, 301]) fleet.mark(id, true);
    fleet.apply(100, [{ id: 3, is_revoked: true }], [], performance.now());
    expect(
      fleet.markedRows().map(({ name }) => name),
      'nor does a revoked one answer',
    ).toEqual(['plane7', 'Copter 3', 'plane8']);
    fleet.apply(100, [{ id: 3, is_revoked: false }], [], performance.now());
  });

  it('forgets the marked ones that are lost until they are heard', () => {
    for (const id of [3, 300, 301]) fleet.mark(id, true);
    fleet.forgetLost();
    expect([names(), fleet.count, fleet.needing, fleet.marked.size]).toEqual([['Copter 3', 'plane7'], 2, 1, 2]);
    fleet.apply(101, [{ id: 301, mode: 'AUTO' }], [], performance.now());
    expect(fleet.count, 'of old news').toBe(2);
    fleet.apply(102, [{ id: 301, heard_s: 102 }], [], performance.now());
    expect(names()).toContain('plane8');
  });
});
