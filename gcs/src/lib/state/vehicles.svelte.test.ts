import { beforeEach, describe, expect, it, vi } from 'vitest';
import type { TelemetryChanges } from '$lib/api/types';
import { telemetryAt } from '../../../dev/mock/flight';
import { destination, distance_m } from '$lib/domain/geo';
import { clock } from './clock.svelte';
import { Vehicle, heardAt, vehicles, withChanges } from './vehicles.svelte';

const { groups, progress } = telemetryAt(100);

function heard(changes: TelemetryChanges, now_ms: number): Vehicle {
  const vehicle = new Vehicle(1);
  vehicle.apply({ groups: changes, progress, heardAt_ms: heardAt(changes, now_ms) });
  return vehicle;
}

beforeEach(() => clock.tick(10_000));

describe('Vehicles', () => {
  it('keeps the one that is selected until a person selects another', () => {
    vehicles.ensure(5);
    expect(vehicles.selected?.systemId).toBe(5);
    vehicles.ensure(1);
    expect(vehicles.selected?.systemId).toBe(5);
    expect(vehicles.next?.systemId).toBe(1);
    vehicles.drop(1);
    expect(vehicles.selected?.systemId).toBe(5);
    vehicles.drop(5);
    expect(vehicles.selected).toBeNull();
    vehicles.ensure(7);
    expect(vehicles.selected?.systemId).toBe(7);
    vehicles.drop(7);
  });

  it('does not bring back one that was dropped while its telemetry waited for a frame, or that is told afterwards', () => {
    vi.useFakeTimers();
    vi.stubGlobal('document', { hidden: true });
    const seen: number[] = [];
    const end = vehicles.onFrame(({ systemId }) => seen.push(systemId));
    for (const id of [7, 300]) vehicles.ensure(id);
    for (const id of [7, 300]) vehicles.telemetry(id, 1, groups, progress);
    vehicles.drop(300);
    vehicles.telemetry(300, 2, groups, progress);
    vi.runAllTimers();
    expect([vehicles.all.map(({ systemId }) => systemId), seen]).toEqual([[7], [7]]);
    vehicles.drop(7);
    end();
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });
});

describe('a recorded vehicle', () => {
  const replay = {
    id: 1,
    name: 'flight',
    file: 'flight.tlog',
    vehicles: [300],
    start_unix_s: 1_700_000_000,
    unix_s: 1_700_000_100,
    position_s: 100,
    duration_s: 300,
    speed: 4,
    is_paused: false,
    is_over: false,
    seeks: 1,
    fault: null,
    skipped_bytes: 0,
  };

  it('ages in the time of its recording: at its speed, and not while it is paused', () => {
    const vehicle = new Vehicle(300);
    vehicle.applyReplay(replay, 10_000);
    vehicle.apply({ groups, progress, heardAt_ms: heardAt(groups, vehicle.time_ms(10_000), vehicle.rate) });
    const before_s = vehicle.groupAge_s('wind') ?? NaN;
    clock.tick(11_000);
    expect([vehicle.groupAge_s('wind'), vehicle.position_s]).toEqual([expect.closeTo(before_s + 4, 6), 104]);
    vehicle.applyReplay({ ...replay, position_s: 104, is_paused: true }, 11_000);
    clock.tick(99_000);
    expect([vehicle.groupAge_s('wind'), vehicle.position_s]).toEqual([expect.closeTo(before_s + 4, 6), 104]);
    vehicle.applyReplay({ ...replay, position_s: 104 }, 99_000);
    clock.tick(100_000);
    expect([vehicle.groupAge_s('wind'), vehicle.position_s]).toEqual([expect.closeTo(before_s + 8, 6), 108]);
  });

  it('knows nothing of another place, and is never estimated', () => {
    const vehicle = new Vehicle(300);
    vehicle.isRecorded = true;
    expect(vehicle.applyReplay(replay, 10_000)).toBe(false);
    vehicle.apply({ groups, progress, heardAt_ms: heardAt(groups, 10_000) });
    vehicle.addText({ severity: 4, text: 'Bad', time_s: 60, unix_s: 1_700_000_060 }, 10_000);
    const plotted = vehicle.sensors.series('wind');
    expect(plotted.length).toBe(1);
    clock.tick(60_000);
    expect([vehicle.isLost, vehicle.ghost(60_000)]).toEqual([true, null]);
    expect(vehicle.applyReplay({ ...replay, position_s: 5, seeks: 2 }, 60_000)).toBe(true);
    expect(vehicle).toMatchObject({ groups: {}, progress: null, texts: [], age_s: null, flightTime: null });
    expect(plotted.length).toBe(0);
    vehicle.apply({ groups, progress, heardAt_ms: heardAt(groups, vehicle.time_ms(60_000)) });
    expect(plotted.length, 'a plot goes on with the new values').toBe(1);
  });

  it('has texts at the time of its recorder, however that was set meanwhile, or without a date', () => {
    const vehicle = new Vehicle(300);
    vehicle.addText({ severity: 4, text: 'Before', time_s: 19, unix_s: 1_700_000_019 }, 10_000);
    vehicle.addText({ severity: 4, text: 'After', time_s: 21, unix_s: 1_700_007_221 }, 12_000);
    vehicle.addText({ severity: 4, text: 'Undated', time_s: 23, unix_s: null }, 14_000);
    expect(vehicle.texts.map(({ at }) => at.getTime()).slice(0, 2)).toEqual([1_700_000_019_000, 1_700_007_221_000]);
    // the replay comes with the next summary
    vehicle.applyReplay(replay, 15_000);
    expect(vehicle.texts.map((text) => vehicle.isDated(text))).toEqual([true, true, false]);
  });

  it('gives way, when it is closed, to the live one that was selected before', () => {
    for (const id of [1, 7, 300]) vehicles.ensure(id);
    vehicles.get(300)!.isRecorded = true;
    vehicles.select(7);
    vehicles.select(300);
    vehicles.drop(300);
    expect(vehicles.selected?.systemId).toBe(7);
    // that one is gone as well: of several others a person chooses
    vehicles.ensure(9);
    vehicles.ensure(300).isRecorded = true;
    vehicles.select(300);
    vehicles.drop(7);
    vehicles.drop(300);
    vehicles.ensure(1);
    expect(vehicles.selected).toBeNull();
    for (const id of [1, 9]) vehicles.drop(id);
  });

  it('has the name that the server gives it, which tells it from the others of its recording', () => {
    const names = ['two 1 (replay)', 'two 2 (replay)', 'two 1 (replay 2)'].map((remoteName) => {
      const vehicle = new Vehicle(300);
      Object.assign(vehicle, { isRecorded: true, remoteName, replay: { is: replay, at_ms: 0 } });
      return vehicle.name;
    });
    expect(names).toEqual(['two 1 (recording)', 'two 2 (recording)', 'two 1 2 (recording)']);
  });

  it('is selected for as long as there is nothing live, or because a person chose it', () => {
    vehicles.ensure(300).isRecorded = true;
    vehicles.preferLive();
    expect(vehicles.selected?.systemId).toBe(300);
    vehicles.ensure(1);
    vehicles.preferLive();
    expect(vehicles.selected?.systemId).toBe(1);
    vehicles.select(300);
    vehicles.preferLive();
    expect(vehicles.selected?.systemId).toBe(300);
    vehicles.drop(300);
    vehicles.drop(1);
  });
});

describe('Vehicle', () => {
  it('knows nothing before it is heard', () => {
    const vehicle = new Vehicle(7);
    expect(vehicle).toMatchObject({ age_s: null, freshness: 'never', isLost: false, mode: null, isArmed: null });
    expect(vehicle.ghost(10_000)).toBeNull();
    expect(vehicle.groupAge_s('wind')).toBeNull();
  });

  it('ages by the monotonic clock: fresh, stale after 3.5 s, lost after 5 s', () => {
    const vehicle = heard(groups, 10_000);
    const freshness = [3500, 3501, 5000, 5001].map((ms) => {
      clock.tick(10_000 + ms);
      return vehicle.freshness;
    });
    expect(freshness).toEqual(['fresh', 'stale', 'stale', 'lost']);
    expect(vehicle.mode).toBe('AUTO');
  });

  it('counts the warnings that nobody has looked at, for each vehicle by itself', () => {
    const [one, other] = [new Vehicle(1), new Vehicle(2)];
    const warn = (vehicle: Vehicle, text: string) =>
      vehicle.addText({ severity: 4, text, time_s: 0, unix_s: null }, 10_000);
    for (const text of ['Bad', 'Worse', 'Bad', 'Worst', 'Bad']) warn(one, text);
    warn(other, 'Bad');
    one.addText({ severity: 6, text: 'Well', time_s: 0, unix_s: null }, 10_000);
    expect([one.unseenWarnings, other.unseenWarnings]).toEqual([3, 1]);
    one.see();
    expect([one.unseenWarnings, other.unseenWarnings]).toEqual([0, 1]);
    warn(one, 'Bad');
    expect(one.unseenWarnings, 'it is bad again').toBe(1);
    warn(other, 'PreArm: GPS 1: not healthy');
    other.see();
    warn(other, 'PreArm: GPS 1: not healthy');
    expect(other.unseenWarnings, 'still not ready').toBe(0);
  });

  it('counts what came while the connection was lost, and what nobody had looked at before', () => {
    const text = (time_s: number, severity = 2) => ({ time_s, unix_s: null, severity, text: `text of ${time_s}` });
    const vehicle = new Vehicle(1);
    vehicle.setServerTime(100, 10_000);
    vehicle.setTexts([text(50), text(60)], 10_000);
    expect(vehicle.unseenWarnings, 'from before').toBe(0);
    vehicle.addText(text(100), 10_000);
    const before = vehicle.texts;
    vehicle.setTexts([text(60), text(100), text(120, 0), text(121, 6)], 40_000);
    expect(vehicle.unseenWarnings).toBe(2);
    expect(vehicle.texts.slice(0, 2), 'those here stay the same').toEqual(before.slice(1));
    vehicle.see();
    expect(vehicle.unseenWarnings).toBe(0);
    vehicle.setServerTime(5, 60_000);
    vehicle.setTexts([text(3)], 60_000);
    expect(vehicle.unseenWarnings, 'of a server that was started anew').toBe(1);
  });

  it('may be landing while it flies a mission that was not read', () => {
    const vehicle = new Vehicle(1);
    const landing = (is_landing: boolean | null, follows_mission: boolean | null) => {
      vehicle.apply({ groups: {}, progress: { ...progress!, is_landing, follows_mission }, heardAt_ms: {} });
      return vehicle.landing;
    };
    expect(vehicle.landing).toBe('no');
    expect(landing(null, true)).toBe('maybe');
    expect([landing(true, true), landing(true, false), landing(false, true)]).toEqual(['yes', 'yes', 'no']);
    expect([landing(null, false), landing(null, null)]).toEqual(['no', 'no']);
    const heartbeat = { ...groups.heartbeat!, autopilot: 12 };
    vehicle.apply({ groups: { heartbeat }, progress: { ...progress!, is_landing: true }, heardAt_ms: {} });
    expect(vehicle.landing, 'of a PX4 nothing is barred').toBe('no');
  });

  it('takes over the age that a group had when it was sent', () => {
    const { wind } = groups;
    const vehicle = heard({ ...groups, wind: { ...wind!, age_s: 4 } }, 10_000);
    expect(vehicle.groupAge_s('wind')).toBeCloseTo(4);
    expect(vehicle.groupFreshness('wind')).toBe('stale');
    expect(vehicle.freshness).toBe('fresh');
  });

  it('becomes a ghost when it is lost, and none when it is back', () => {
    const vehicle = heard(groups, 10_000);
    expect(vehicle.ghost(10_000)).toBeNull();
    clock.tick(20_000);
    const ghost = vehicle.ghost(20_000);
    expect(ghost?.elapsed_s).toBeCloseTo(10);
    expect(ghost?.reach_m).toBeGreaterThan(100);
    vehicle.apply({ groups: { hud: groups.hud! }, progress: null, heardAt_ms: heardAt({ hud: groups.hud! }, 20_000) });
    expect(vehicle.ghost(20_000)).toBeNull();
    expect(vehicle.progress).toEqual(progress);
  });

  it('goes on as its mission was rehearsed, straight on otherwise', () => {
    const vehicle = heard(groups, 10_000);
    const last = vehicle.lastKnown()!;
    const beside = destination(last.at, last.course_deg + 90, 500);
    const [first, end] = [last.at, beside];
    const track = {
      time_s: [0, 20],
      lat_deg: [first.lat_deg, end.lat_deg],
      lon_deg: [first.lon_deg, end.lon_deg],
      height_m: [50, 50],
      ground_m: [null, null],
      airspeed_m_s: [25, 25],
      groundspeed_m_s: [25, 25],
      bank_deg: [0, 0],
      heading_deg: [90, 90],
      item: [1, 1],
    };
    clock.tick(20_000);
    expect(vehicle.ghost(20_000)).toMatchObject({ isOnRoute: false });
    vehicle.rest = { track, from_ms: 5_000 };
    const ghost = vehicle.ghost(20_000)!;
    expect(ghost.isOnRoute).toBe(true);
    // 15 of 20 s after the rehearsal's beginning
    expect(distance_m(ghost.at, beside)).toBeCloseTo(125, 0);
    expect(ghost.path[0]).toEqual(last.at);
    vehicle.rest = { track, from_ms: -5_000 };
    expect(vehicle.ghost(20_000)).toMatchObject({ isOnRoute: false });
    vehicle.rest = { track, from_ms: 5_000 };
    vehicle.apply({ groups: {}, progress: { ...progress, follows_mission: false }, heardAt_ms: {} });
    expect(vehicle.ghost(20_000)).toMatchObject({ isOnRoute: false });
  });

  it('takes over what its parameters say, an ArduPlane as it comes where they say nothing, and its name in a fleet', () => {
    const vehicle = new Vehicle(1);
    const told = {
      system_id: 1,
      age_s: 0,
      link: 1,
      loss_pct: 0,
      round_trip_ms: 1,
      is_reached: true,
      rival: null,
      silence: null,
      remote_name: null,
      is_recorded: false,
      replay: null,
      control: null,
      is_revoked: false,
      lacks_terrain: false,
    };
    const known = { loiter_radius_m: 95, airspeed_m_s: null, finds_landing: true };
    const summary = { ...told, mav_type: 1, autopilot: 3, mode: 'MANUAL', is_armed: false, flight_parameters: known };
    vehicle.applySummary(summary, 10_000);
    const { route } = vehicle;
    expect(route).toMatchObject({ loiterRadius_m: 95, cruise_m_s: 22 });
    expect(vehicle.findsLanding).toBe(true);
    const far = new Vehicle(254);
    far.applySummary({ ...summary, system_id: 254, remote_name: 'plane7' }, 10_000);
    expect([far.name, vehicle.name.endsWith(' 1')]).toEqual(['plane7', true]);
    vehicle.applySummary({ ...summary, flight_parameters: { ...known } }, 11_000);
    expect(vehicle.route, 'what is drawn from it is drawn anew only where it is another').toBe(route);
  });

  it('forgets what the vehicle no longer has', () => {
    const vehicle = heard(groups, 10_000);
    vehicle.apply({ groups: { wind: null }, progress: null, heardAt_ms: {} });
    expect('wind' in vehicle.groups).toBe(false);
    expect(vehicle.groups.hud).toEqual(groups.hud);
    expect(vehicle.groupAge_s('wind')).toBeNull();
  });

  it('tells the time of day of texts of the past', () => {
    vi.useFakeTimers({ now: new Date('2026-05-01T10:00:00Z'), toFake: ['Date'] });
    try {
      const vehicle = new Vehicle(1);
      vehicle.setServerTime(500, 10_000);
      vehicle.setTexts([{ time_s: 440, unix_s: null, severity: 6, text: 'a minute ago' }], 10_000);
      vehicle.addText({ time_s: 500, unix_s: null, severity: 4, text: 'now' }, 10_000);
      expect(vehicle.texts.map(({ at, text }) => [at.toISOString(), text])).toEqual([
        ['2026-05-01T09:59:00.000Z', 'a minute ago'],
        ['2026-05-01T10:00:00.000Z', 'now'],
      ]);
    } finally {
      vi.useRealTimers();
    }
  });

  it('keeps a bounded number of texts', () => {
    const vehicle = new Vehicle(1);
    for (let n = 0; n < 1100; n += 1)
      vehicle.addText({ time_s: n, unix_s: null, severity: 6, text: String(n) }, 10_000);
    expect(vehicle.texts).toHaveLength(1000);
    expect(vehicle.texts[0]?.text).toBe('100');
  });
});

it('joins changes without touching what was there', () => {
  const before = { hud: groups.hud!, wind: groups.wind! };
  const after = withChanges(before, { wind: null, gps: groups.gps! });
  expect(Object.keys(after).sort()).toEqual(['gps', 'hud']);
  expect(Object.keys(before)).toEqual(['hud', 'wind']);
});

it('takes the age of the first of a list, which is the one that is shown', () => {
  const battery = groups.batteries![0]!;
  const batteries = [
    { ...battery, age_s: 5 },
    { ...battery, age_s: 1 },
  ];
  expect(heardAt({ batteries, wind: null }, 10_000)).toEqual({ batteries: 5000 });
});
