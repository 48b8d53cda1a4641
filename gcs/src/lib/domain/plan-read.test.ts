import { describe, expect, it } from 'vitest';
import { emptyPlan, makeItem, type Plan } from './plan';
import { draftOf, planOf } from './plan-edit';
import { readPlan } from './plan-read';

const HOME = { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 690 };

describe('reading a stored plan', () => {
  it('gives back what was stored', () => {
    const plan: Plan = {
      items: [makeItem('takeoff', { at: HOME, alt_m: 50 }), makeItem('return_to_launch')],
      home: HOME,
      fence: {
        zones: [{ inclusion: true, shape: 'circle', points: [{ lat_deg: 40, lon_deg: -3 }], radius_m: 500 }],
        return_point: null,
      },
      rally: [{ lat_deg: 40, lon_deg: -3, alt_m: 60, frame: 3 }],
      complex_items: [{ kind: 'survey', json: '{"angle":33}' }],
      planned_for: { cruise_speed_m_s: 21, hover_speed_m_s: null, vehicle_type: 20, firmware_type: 12 },
    };
    expect(planOf(draftOf(plan)), 'and an edit keeps what a file holds beside its items').toEqual(plan);
    expect(readPlan(JSON.parse(JSON.stringify(plan)))).toEqual(plan);
    expect(readPlan(emptyPlan())).toEqual(emptyPlan());
  });

  it.each([
    null,
    [],
    'plan',
    { items: 3 },
    { items: [null] },
    { items: [{ command: 16 }] },
    { items: [{ command: 16, name: 'x', frame: 3, params: [0, 0, 0, 0, 0, 'a', 0] }] },
    { items: [{ command: 16, name: 'x', frame: 3, params: [0, 0] }] },
    { items: Array.from({ length: 20_000 }, () => null) },
  ])('takes nothing from %j', (value) => expect(readPlan(value)).toBeNull());

  it('leaves out a home that is off the globe', () => {
    expect(readPlan({ items: [], home: { ...HOME, lat_deg: 140 } })).toEqual(emptyPlan());
  });
});
