import { describe, expect, it } from 'vitest';
import { destination } from './geo';
import type { LonLat } from './lonlat';
import {
  altOf_m,
  COMMAND,
  emptyPlan,
  FRAME,
  isDestination,
  isPlaced,
  kindOf,
  KINDS,
  makeItem,
  type PlanItem,
  placeOf,
  withAlt,
  withCommand,
} from './plan';
import {
  addAt,
  addLanding,
  changeCommand,
  changeLanding,
  type Draft,
  draftOf,
  exchange,
  endIndex,
  insertItems,
  insertOnLeg,
  landingPart,
  moveTo,
  nudge,
  numberOfKey,
  planOf,
  removeKeys,
  reorder,
  setAlt,
  setParam,
  shiftKeys,
} from './plan-edit';
import { commit, historyOf, redo, seal, undo } from './history';
import { ticks } from './profile';
import { type End, NO_END } from './way';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 690 };
const DEFAULTS = { alt_m: 80, frame: 'home' } as const;
const at = (bearing: number, distance: number): LonLat => destination(HOME, bearing, distance);

const start = (): Draft => draftOf({ ...emptyPlan(), home: HOME });
const kinds = (draft: Draft): string[] => draft.items.map(kindOf);

/** Take-off, three waypoints, landing. */
function circuit(): Draft {
  let draft = addAt(start(), 'takeoff', at(270, 250), DEFAULTS).draft;
  for (const bearing of [300, 0, 60]) draft = addAt(draft, 'waypoint', at(bearing, 600), DEFAULTS).draft;
  return addLanding(draft, landingAt(HOME), NO_END).draft;
}

/** What the core says of a landing that begins at an item. */
const endFrom = ({ items }: Draft, index: number): End => {
  const designed = items.slice(index).map((item) => item.key);
  return { keys: new Set(designed), designed };
};

/** A landing as the core designs it: a circle down beside the beginning of the final leg, and the landing. */
function landingAt(place: LonLat, hasLandStart = false): PlanItem[] {
  const begin = destination(place, 60, 500);
  const circle = makeItem('loiter_to_height', { at: destination(begin, 330, 80), alt_m: 40 });
  const start = { ...makeItem('waypoint', { at: begin, alt_m: 40 }), command: 189, name: 'MAV_CMD_DO_LAND_START' };
  return [...(hasLandStart ? [start] : []), circle, makeItem('land', { at: place, alt_m: 0 })];
}

describe('items', () => {
  it.each(KINDS)('makes a %s that is one', (kind) => {
    const item = makeItem(kind, { at: HOME, alt_m: 50 });
    expect(kindOf(item)).toBe(kind);
    expect(item.command).toBe(COMMAND[kind]);
    expect(item.name).toMatch(/^MAV_CMD_/);
    expect(item.params).toHaveLength(7);
    expect(item.frame).toBe(isPlaced(item) ? FRAME.home : FRAME.mission);
    expect(placeOf(item) === null).toBe(!isPlaced(item));
  });

  it('takes 0/0 for no place', () => {
    expect(placeOf(makeItem('takeoff', { alt_m: 50 }))).toBeNull();
  });

  it('keeps place and height when the kind changes, and lands on the ground', () => {
    const waypoint = makeItem('waypoint', { at: HOME, alt_m: 70, frame: 'amsl' });
    const loiter = withCommand(waypoint, COMMAND.loiter_turns, {});
    expect(placeOf(loiter)).toEqual(placeOf(waypoint));
    expect([altOf_m(loiter), loiter.frame]).toEqual([70, FRAME.amsl]);
    // nought above the sea is below the ground almost everywhere
    const land = withCommand(waypoint, COMMAND.land, {});
    expect([altOf_m(land), land.frame]).toEqual([0, FRAME.home]);
    expect(withCommand({ ...waypoint, frame: FRAME.terrain }, COMMAND.land, {}).frame).toBe(FRAME.terrain);
    const back = withCommand(withCommand(waypoint, COMMAND.return_to_launch, {}), COMMAND.waypoint, {
      at: HOME,
      alt_m: 33,
    });
    expect(altOf_m(back)).toBe(33);
  });

  it('leaves commands that it does not know as they are', () => {
    const item: PlanItem = {
      command: 206,
      name: 'MAV_CMD_DO_SET_CAM_TRIGG_DIST',
      frame: 2,
      params: [25, 0, 1, null, 0, 0, 0],
      autocontinue: true,
    };
    expect(kindOf(item)).toBe('other');
    expect(isPlaced(item)).toBe(false);
    expect(planOf(draftOf({ ...emptyPlan(), items: [item] })).items).toEqual([item]);
  });
});

describe('landing', () => {
  it('replaces the landing that is there, approach and all', () => {
    const once = circuit();
    const twice = addLanding(once, landingAt(at(10, 100), true), endFrom(once, 4)).draft;
    expect(twice.items.map((item) => item.command)).toEqual([22, 16, 16, 16, 189, 31, 21]);
    expect(placeOf(twice.items.at(-1)!)).toEqual(placeOf(landingAt(at(10, 100))[1]!));
    expect(addLanding(twice, landingAt(HOME), endFrom(twice, 4)).draft.items.map((item) => item.command)).toEqual([
      22, 16, 16, 16, 31, 21,
    ]);
  });

  it('has parts that are moved while it ends the mission as it was told', () => {
    const draft = circuit();
    const end = endFrom(draft, 4);
    const parts = (one: Draft) => one.items.map(({ key }) => landingPart(one, key, end));
    expect(parts(draft)).toEqual([null, null, null, null, 'circle', 'point']);
    expect(parts(removeKeys(draft, new Set([end.designed[0]!]))).filter(Boolean)).toEqual([]);
    const moved = changeLanding(draft, landingAt(at(10, 100)), end);
    expect(moved.items.map(({ key }) => key)).toEqual(draft.items.map(({ key }) => key));
  });
});

describe('adding', () => {
  it('puts things where they belong', () => {
    const draft = circuit();
    expect(kinds(draft)).toEqual(['takeoff', 'waypoint', 'waypoint', 'waypoint', 'loiter_to_height', 'land']);
    const end = endFrom(draft, 4);
    expect(endIndex(draft, end)).toBe(4);
    const more = addAt(draft, 'loiter_turns', at(90, 500), { ...DEFAULTS, end }).draft;
    expect(kindOf(more.items[4]!)).toBe('loiter_turns');
  });

  it('has one take-off, at the front', () => {
    const again = addAt(circuit(), 'takeoff', at(90, 100), DEFAULTS);
    expect(kinds(again.draft).filter((kind) => kind === 'takeoff')).toHaveLength(1);
    expect(numberOfKey(again.draft, again.keys[0]!)).toBe(1);
  });

  it('keeps a return at the end', () => {
    const draft = addAt(start(), 'return_to_launch', null, DEFAULTS).draft;
    expect(kinds(addAt(draft, 'waypoint', at(0, 100), DEFAULTS).draft)).toEqual(['waypoint', 'return_to_launch']);
  });

  it('inserts on a leg at the middle height', () => {
    let draft = circuit();
    draft = setAlt(draft, new Set([draft.items[2]!.key]), 120);
    const added = insertOnLeg(draft, 2, at(330, 550), DEFAULTS);
    expect(added.draft.items[2]?.key).toBe(added.keys[0]);
    expect(altOf_m(added.draft.items[2]!)).toBe(100);
  });
});

describe('changing', () => {
  it('never touches the draft that it took', () => {
    const draft = circuit();
    const before = structuredClone(draft);
    const key = draft.items[1]!.key;
    moveTo(draft, key, HOME);
    shiftKeys(draft, new Set([key]), HOME, at(0, 10));
    removeKeys(draft, new Set([key]));
    nudge(draft, new Set([key]), 1);
    changeCommand(draft, key, COMMAND.jump, DEFAULTS);
    addLanding(draft, landingAt(HOME), endFrom(draft, 4));
    expect(draft).toEqual(before);
  });

  it('shifts a selection as one', () => {
    const draft = circuit();
    const keys = new Set(draft.items.slice(1, 3).map((item) => item.key));
    const shifted = shiftKeys(draft, keys, HOME, { lat_deg: HOME.lat_deg + 0.001, lon_deg: HOME.lon_deg });
    for (const [index, item] of shifted.items.entries()) {
      const moved = placeOf(item)!.lat_deg - placeOf(draft.items[index]!)!.lat_deg;
      expect(moved).toBeCloseTo(keys.has(item.key) ? 0.001 : 0, 6);
    }
  });

  it('moves blocks up and down and stops at the ends', () => {
    const draft = circuit();
    const keys = new Set([draft.items[1]!.key, draft.items[2]!.key]);
    const order = (one: Draft): number[] => one.items.map((item) => item.key);
    const down = nudge(draft, keys, 1);
    expect(down.items.slice(2, 4).map((item) => item.key)).toEqual([...keys]);
    expect(order(nudge(down, keys, -1))).toEqual(order(draft));
    expect(nudge(draft, new Set([draft.items[0]!.key]), -1)).toBe(draft);
    expect(nudge(draft, new Set([draft.items.at(-1)!.key]), 1)).toBe(draft);
    expect(reorder(draft, new Set([draft.items[2]!.key]), 2)).toBe(draft);
  });

  it('takes other items for those that nobody changed meanwhile', () => {
    const draft = circuit();
    const [, first, second] = draft.items;
    const edited = setAlt(draft, new Set([second!.key]), 90);
    const { items } = exchange(edited, [first!, second!], [withAlt(first!, 770), withAlt(second!, 770)]);
    expect(items.map(altOf_m).slice(1, 3)).toEqual([770, 90]);
    expect(items[1]!.key).toBe(first!.key);
  });

  it('lets jumps follow the items that they jump to', () => {
    const base = insertItems(circuit(), 4, [makeItem('jump')]).draft;
    const jump = base.items[4]!.key;
    const target = base.items[1]!.key;
    const set = setParam(base, jump, 0, 2);
    const jumpsTo = (draft: Draft): number | null => draft.items.find((item) => item.key === jump)!.params[0];
    expect(jumpsTo(addAt(set, 'waypoint', at(1, 50), DEFAULTS).draft)).toBe(2);
    expect(jumpsTo(insertOnLeg(set, 1, at(280, 400), DEFAULTS).draft)).toBe(3);
    expect(jumpsTo(nudge(set, new Set([target]), 1))).toBe(3);
    // gone: to what followed it
    expect(jumpsTo(removeKeys(set, new Set([target])))).toBe(2);
    expect(jumpsTo(removeKeys(set, new Set([set.items[0]!.key])))).toBe(1);
    // nonsense is left for the checks to name
    expect(jumpsTo(removeKeys(setParam(base, jump, 0, 99), new Set([target])))).toBe(99);
  });
});

describe('history', () => {
  it('goes back and forth', () => {
    let history = historyOf(0);
    for (const value of [1, 2, 3]) history = commit(history, value);
    history = undo(undo(history));
    expect(history.present).toBe(1);
    expect(redo(history).present).toBe(2);
    expect(undo(undo(undo(history))).present).toBe(0);
    history = commit(history, 9);
    expect(redo(history).present).toBe(9);
  });

  it('takes one drag as one step', () => {
    let history = historyOf(0);
    for (const value of [1, 2, 3]) history = commit(history, value, 'drag');
    history = commit(seal(history), 4, 'drag');
    expect(undo(history).present).toBe(3);
    expect(undo(undo(history)).present).toBe(0);
  });

  it('forgets the oldest and ignores what changes nothing', () => {
    let history = historyOf(0);
    for (let value = 1; value <= 500; value += 1) history = commit(history, value);
    expect(history.past).toHaveLength(200);
    expect(commit(history, history.present)).toBe(history);
  });
});

describe('route and profile', () => {
  it('does not fly to a take-off or an action', () => {
    expect(isDestination(makeItem('takeoff', { at: HOME }), false)).toBe(false);
    expect(isDestination(makeItem('change_speed'), false)).toBe(false);
  });

  it('puts round values on axes', () => {
    expect(ticks(0, 100, 5)).toEqual([0, 20, 40, 60, 80, 100]);
    expect(ticks(-3, 84, 4)).toEqual([0, 50]);
    expect(ticks(5, 5, 4)).toEqual([5]);
  });
});
