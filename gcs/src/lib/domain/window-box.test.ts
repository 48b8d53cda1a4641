import { describe, expect, it } from 'vitest';
import { clampBox, MIN_HEIGHT, MIN_WIDTH, readBox } from './window-box';

describe('a window', () => {
  it('stays in its room', () => {
    const box = { x: 900, y: -50, width: 300, height: 240 };
    expect(clampBox(box, 1000, 800)).toEqual({ x: 700, y: 0, width: 300, height: 240 });
  });

  it('keeps a size that can be used, in a room that is too small too', () => {
    const box = { x: 10, y: 10, width: 5, height: 5000 };
    expect(clampBox(box, 1000, 800)).toEqual({ x: 10, y: 0, width: MIN_WIDTH, height: 800 });
    expect(clampBox(box, 100, 100)).toEqual({ x: 0, y: 0, width: MIN_WIDTH, height: MIN_HEIGHT });
  });

  it('is read back as it was stored, and nothing else is', () => {
    const box = { x: 1, y: 2, width: 300, height: 400 };
    expect(readBox(JSON.parse(JSON.stringify(box)))).toEqual(box);
    for (const other of [null, 3, {}, { ...box, x: null }, { ...box, width: 'wide' }])
      expect(readBox(other)).toBeNull();
  });
});
