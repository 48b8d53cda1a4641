import type OlMap from 'ol/Map';
import { describe, expect, it, vi } from 'vitest';
import { destination } from '$lib/domain/geo';
import { makeItem, withParam } from '$lib/domain/plan';
import { projection, WORLD_M } from './frame';
import { RoutePainter } from './route-painter';
import { routeView, toLine, toXY } from './route-view';
import { NO_PROFILE } from '$lib/domain/profile';
import { wayOf } from '$lib/domain/way';
import { type VehicleMark, VehiclePainter } from './vehicle-painter';
import { placeOf, viewAt, ViewControl } from './view-control';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 690 };
const SIZE = { width: 800, height: 600 };

describe('projection', () => {
  const view = projection(toXY(HOME), 2, SIZE);

  it('puts the centre in the middle, north up', () => {
    expect(view.pixel(toXY(HOME))).toEqual([400, 300]);
    const [x, y] = view.pixel(toXY(destination(HOME, 0, 100)));
    expect(x).toBeCloseTo(400, 6);
    expect(y).toBeLessThan(300);
  });

  it('shows the copy of the world that is nearest', () => {
    const edge = projection([WORLD_M / 2 - 100, 0], 1, SIZE);
    const [x] = edge.pixel([-WORLD_M / 2 + 100, 0]);
    expect(x).toBeCloseTo(600, 6);
  });
});

describe('route', () => {
  const items = [
    makeItem('takeoff', { at: destination(HOME, 270, 250), alt_m: 50 }),
    makeItem('change_speed'),
    withParam(makeItem('loiter_turns', { at: destination(HOME, 0, 800), alt_m: 80 }), 2, -90),
    withParam(makeItem('jump'), 0, 3),
    makeItem('return_to_launch'),
  ];
  const circle = { kind: 'turns', radius_m: 80, is_clockwise: false, is_own_radius: true, length_m: 500 } as const;
  const loiter = { ...circle, time_s: 25, is_estimate: false, changed_before: 1 };
  const leg = { kind: 'flown', length_m: 900, course_deg: 10, lat_deg: [40.3, 40.4], lon_deg: [-3.8, -3.8] } as const;
  const stop = { item: 3, leg: { ...leg, from_item: 1, descent: null }, loiter };
  const told = {
    stops: [stop],
    jumps: [{ item: 4, to_item: 3 }],
    end: { item: 6, designed_item: null },
    profile: NO_PROFILE,
  };
  const route = routeView(items, wayOf(items, HOME, false, { items, home: HOME, way: told }));

  it('numbers items as the vehicle counts, actions included', () => {
    expect(route.items.map((item) => item.number)).toEqual([1, 3]);
    expect(route.legs.map((leg) => leg.toIndex)).toEqual([0, 2, 4]);
    expect(route.circles).toMatchObject([{ number: 3, isClockwise: false, isOwnRadius: true }]);
    expect(route.jumps).toHaveLength(1);
  });

  it('does not tear lines at the date line', () => {
    const line = toLine([
      { lat_deg: 0, lon_deg: 179.9 },
      { lat_deg: 0, lon_deg: -179.9 },
      { lat_deg: 0, lon_deg: 179.9 },
    ]);
    expect(Math.abs(line[1]![0] - line[0]![0])).toBeLessThan(30_000);
    expect(line[2]![0]).toBeCloseTo(line[0]![0], 3);
  });

  it('finds what lies at a pixel, a finger wider than a mouse', () => {
    const painter = new RoutePainter();
    painter.route = route;
    const view = projection(toXY(HOME), 4, SIZE);
    const [x, y] = view.pixel(toXY(destination(HOME, 0, 800)));
    expect(painter.itemAt(view, x + 3, y - 3, 10)?.number).toBe(3);
    expect(painter.itemAt(view, x + 18, y, 10)).toBeNull();
    expect(painter.itemAt(view, x + 18, y, 22)?.number).toBe(3);
    expect(painter.itemsWithin(view, 0, 0, 800, 600)).toEqual([1, 3]);
  });

  it('offers handles only while the plan is edited, and not on the way home', () => {
    const painter = new RoutePainter();
    painter.route = route;
    const view = projection(toXY(HOME), 4, SIZE);
    const [x, y] = view.pixel(route.legs[1]!.middle);
    expect(painter.handleAt(view, x, y, 10)).toBeNull();
    painter.status = { ...painter.status, isEditing: true };
    expect(painter.handleAt(view, x, y, 10)?.toIndex).toBe(2);
    const [hx, hy] = view.pixel(route.legs[2]!.middle);
    expect(painter.handleAt(view, hx, hy, 5)).toBeNull();
  });
});

describe('vehicles', () => {
  const view = projection(toXY(HOME), 2, SIZE);
  const standing: VehicleMark = {
    id: 1,
    label: '',
    at: HOME,
    heading_deg: 90,
    course_deg: 90,
    groundspeed_m_s: 0.2,
    isSelected: true,
    isStale: false,
    isRecorded: false,
    level: 'none',
    ghost: null,
  };
  const seen = (changes: Partial<VehicleMark>, target: typeof HOME | null = null): string =>
    Object.assign(new VehiclePainter(), { vehicles: [{ ...standing, ...changes }], target }).seen(view);

  it('are the same to the eye while only the noise of a standing plane changes', () => {
    expect(seen({ at: destination(HOME, 45, 0.05), heading_deg: 90.05, course_deg: 200 })).toBe(seen({}));
  });

  it('are others as soon as one of what is painted is', () => {
    const others = [
      seen({}),
      seen({ at: destination(HOME, 45, 3) }),
      seen({ heading_deg: 91 }),
      seen({ heading_deg: null }),
      seen({ groundspeed_m_s: 15 }),
      seen({ isStale: true }),
      seen({ isRecorded: true }),
      seen({ isSelected: false }),
      seen({ label: 'A' }),
      seen({ level: 'warn' }),
      seen({ ghost: { at: HOME, heading_deg: 90, label: '5 s', path: [HOME] } }),
      seen({}, HOME),
    ];
    expect(new Set(others).size).toBe(others.length);
  });
});

describe('the view', () => {
  it('widens about what it shows, not about what was painted last', () => {
    let tick = (): void => undefined;
    vi.stubGlobal('requestAnimationFrame', (next: () => void) => ((tick = next), 1));
    vi.stubGlobal('cancelAnimationFrame', () => undefined);
    vi.useFakeTimers({ toFake: ['Date', 'performance', 'setTimeout'] });
    const view = viewAt(null);
    view.setViewportSize([SIZE.width, SIZE.height]);
    // A slow display: the last picture is of the world still.
    const painted = projection(toXY(HOME), view.getResolution()!, SIZE);
    const map = {
      getView: () => view,
      getSize: () => [SIZE.width, SIZE.height],
      getCoordinateFromPixel: ([x = 0, y = 0]: number[]) => [
        painted.centre[0] + (x - 400) * painted.resolution,
        painted.centre[1] - (y - 300) * painted.resolution,
      ],
    };
    const control = new ViewControl(map as unknown as OlMap);
    control.keepInSight(HOME);
    expect(view.getZoom()).toBe(16);
    // A panel opens over the plane.
    control.insets = { top: 0, right: 0, bottom: 450, left: 0 };
    control.keepInSight(HOME);
    expect(view.getAnimating()).toBe(true);
    vi.advanceTimersByTime(600);
    tick();
    expect(view.getZoom()).toBeLessThan(16);
    expect(Math.abs(placeOf(view.getCenter()!).lat_deg - HOME.lat_deg)).toBeLessThan(0.1);
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });
});
