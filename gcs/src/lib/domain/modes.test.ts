import { expect, it } from 'vitest';
import { followsMission } from './modes';

it('knows the modes that fly a mission, and says when none is known', () => {
  expect(['AUTO', 'AUTO_MISSION', 'GUIDED', 'AUTOTUNE', 'LOITER'].map(followsMission)).toEqual([
    true,
    true,
    false,
    false,
    false,
  ]);
  expect(followsMission(null)).toBeNull();
});
