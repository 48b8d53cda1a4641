import { describe, expect, it } from 'vitest';
import { bearing_deg, destination, distance_m, length_m } from './geo';
import type { LastKnown } from './ghost';
import { alongTrack, type Flight, followRoute } from './ghost-route';
import { wrap180_deg } from './lonlat';
import { makeItem, withParam } from './plan';
import { PLANE_ROUTE } from './route';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978 };
const at = (bearing: number, distance: number) => destination(HOME, bearing, distance);
const north: LastKnown = {
  at: HOME,
  course_deg: 0,
  heading_deg: 0,
  groundspeed_m_s: 20,
  turn_rate_deg_s: 0,
};
const corner = destination(at(0, 1000), 90, 2000);
const flight: Flight = {
  items: [makeItem('waypoint', { at: at(0, 1000) }), makeItem('waypoint', { at: corner })],
  home: HOME,
  current: 1,
  airspeed_m_s: null,
  wind: null,
};

describe('followRoute', () => {
  it('goes straight before the turn and on the next leg after it', () => {
    const before = followRoute(north, flight, 40)!;
    expect(distance_m(HOME, before.at)).toBeCloseTo(800, 0);
    const after = followRoute(north, flight, 90)!;
    expect(Math.abs(wrap180_deg(bearing_deg(at(0, 1000), after.at) - 90))).toBeLessThan(2);
    // the corner is cut by the turn, so a little more than 800 m of the second leg are flown
    expect(distance_m(at(0, 1000), after.at)).toBeGreaterThan(795);
    expect(distance_m(at(0, 1000), after.at)).toBeLessThan(860);
    expect(after.course_deg).toBeCloseTo(90, 0);
    expect(after).toMatchObject({ elapsed_s: 90, isOnRoute: true });
    expect(length_m(after.path)).toBeCloseTo(after.reach_m, 0);
  });

  it('never cuts more than half of a leg, and moves on all the time', () => {
    let previous = followRoute(north, flight, 0)!.at;
    for (let time_s = 1; time_s < 150; time_s += 1) {
      const { at: now } = followRoute(north, flight, time_s)!;
      expect(distance_m(previous, now)).toBeGreaterThan(15);
      expect(distance_m(previous, now)).toBeLessThan(20.5);
      previous = now;
    }
  });

  it('knows the wind: slower against it, with the nose into it', () => {
    const windy = { ...flight, airspeed_m_s: 20, wind: { from_deg: 90, speed_m_s: 6 } };
    expect(alongTrack(90, 20, windy.wind).groundspeed_m_s).toBeCloseTo(14, 6);
    expect(alongTrack(270, 20, windy.wind).groundspeed_m_s).toBeCloseTo(26, 6);
    const { groundspeed_m_s, heading_deg } = alongTrack(0, 20, windy.wind);
    expect(groundspeed_m_s).toBeCloseTo(Math.sqrt(400 - 36), 6);
    expect(heading_deg).toBeCloseTo((Math.asin(0.3) * 180) / Math.PI, 6);
    const calm = followRoute(north, { ...windy, wind: { from_deg: 90, speed_m_s: 0 } }, 100)!;
    expect(followRoute(north, windy, 100)!.reach_m).toBeLessThan(calm.reach_m - 200);
  });

  it('goes round circles, as often as they are counted, and for ever in an endless one', () => {
    const turns = withParam(withParam(makeItem('loiter_turns', { at: at(0, 1000) }), 0, 2), 2, -80);
    const items = [turns, makeItem('waypoint', { at: at(270, 3000) })];
    const radii = [60, 70, 80, 90].map((time_s) => followRoute(north, { ...flight, items }, time_s)!.at);
    for (const one of radii) expect(distance_m(one, at(0, 1000))).toBeCloseTo(80, 0);
    const gone = followRoute(north, { ...flight, items }, 150)!;
    expect(distance_m(gone.at, at(0, 1000))).toBeGreaterThan(200);
    const endless = [withParam(makeItem('loiter_unlimited', { at: at(0, 1000) }), 2, 80)];
    expect(distance_m(followRoute(north, { ...flight, items: endless }, 290)!.at, at(0, 1000))).toBeCloseTo(80, 0);
  });

  it('passes straight over an arc unless the vehicle flies arcs', () => {
    const arc = withParam(makeItem('arc_waypoint', { at: at(90, 1500) }), 0, 180);
    const items = [makeItem('waypoint', { at: at(0, 400) }), arc, makeItem('waypoint', { at: at(0, 3000) })];
    const plane = followRoute(north, { ...flight, items }, 80)!;
    expect(Math.abs(wrap180_deg(bearing_deg(HOME, plane.at)))).toBeLessThan(1);
    const copter = followRoute(north, { ...flight, items, route: { ...PLANE_ROUTE, fliesArcs: true } }, 80)!;
    expect(distance_m(copter.at, plane.at)).toBeGreaterThan(300);
  });

  it('takes an endless jump, returns home when the mission is over, and stays where it landed', () => {
    const loop = [...flight.items, withParam(withParam(makeItem('jump'), 0, 1), 1, -1)];
    const back = followRoute(north, { ...flight, items: loop, current: 2 }, 200)!;
    expect(distance_m(back.at, corner)).toBeGreaterThan(1000);
    const home = followRoute({ ...north, at: at(0, 500) }, { ...flight, items: flight.items.slice(0, 1) }, 200)!;
    expect(distance_m(home.at, HOME)).toBeCloseTo(60, 0);
    const landing = [makeItem('land', { at: at(0, 400) })];
    expect(distance_m(followRoute(north, { ...flight, items: landing }, 100)!.at, at(0, 400))).toBeLessThan(0.1);
  });

  it('does not spin in a jump without a place', () => {
    const idle = [makeItem('change_speed'), withParam(withParam(makeItem('jump'), 0, 1), 1, -1)];
    expect(followRoute(north, { ...flight, items: idle }, 10)!.at).toEqual(HOME);
  });

  it('knows nothing during a take-off, of an item that is not there, or of a plane that stands', () => {
    expect(followRoute(north, { ...flight, items: [makeItem('takeoff', { at: at(0, 200) })] }, 10)).toBeNull();
    expect(followRoute(north, { ...flight, current: 7 }, 10)).toBeNull();
    expect(followRoute({ ...north, groundspeed_m_s: 1 }, flight, 10)).toBeNull();
  });
});
