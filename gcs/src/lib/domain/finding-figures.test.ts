import { expect, it } from 'vitest';
// Where the messages are written.
import checks from '../../../../crates/flight/src/checks.rs?raw';
import { findingFigures } from './finding-figures';

const figures = (code: string, message: string, remedy = '') => findingFigures({ code, message, remedy });

it('finds the figures in the words of the checks', () => {
  expect(figures('short-leg', 'the leg to item 3 (NAV_WAYPOINT) is 12 m long, the plane turns within 49 m')).toEqual({
    length: '12',
    turn: '49',
  });
  expect(figures('far-first', 'item 2 (NAV_WAYPOINT), the first destination, lies 8.3 km from the plane')).toEqual({
    distance: '8.3',
  });
  expect(figures('param-out-of-range', 'item 1 (NAV_TAKEOFF): Minimum pitch is 95 °', 'choose from 0 to 90')).toEqual({
    label: 'Minimum pitch',
    value: '95',
    min: '0',
    max: '90',
  });
  expect(figures('param-changed', 'item 4 (NAV_LOITER_TURNS): Radius of 80.5 m is kept as 80')).toEqual({
    label: 'Radius',
    value: '80.5',
    kept: '80',
  });
  expect(figures('param-changed', 'item 4 (DO_JUMP): Repeats of 1.5  is kept as 1')).toMatchObject({ value: '1.5' });
  expect(figures('outside-fence', 'item 3 (NAV_WAYPOINT) lies outside inclusion zone 2 of the fence')).toEqual({
    zone: '2',
  });
});

it('tells a finding without figures when it is worded otherwise', () => {
  expect(figures('short-leg', 'another sentence')).toBeNull();
  expect(figures('no-takeoff', 'the mission begins with item 1')).toBeNull();
});

it('is worded as the checks still are', () => {
  for (const words of [
    '{length_m:.0} m long, the plane turns within {turn_m:.0} m',
    'drops {drop_m:.0} m in {length_m:.0} m',
    '{name}: {label} is {value} {unit}',
    '{label} of {value} {unit} is kept as {kept}',
    'crosses fence zone {}',
    'has {count} items, the vehicle holds {max}',
  ])
    expect(checks).toContain(words);
});
