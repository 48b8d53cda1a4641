import { expect, it } from 'vitest';
import { FrameQueue } from './frames';

it('hands out once per frame what came since, joined', () => {
  const frames: (() => void)[] = [];
  const seen: [number, string][] = [];
  let afters = 0;
  const queue = new FrameQueue<number, string>({
    join: (waiting, next) => waiting + next,
    flush: (key, value) => seen.push([key, value]),
    after: () => (afters += 1),
    schedule: (run) => frames.push(run),
  });
  queue.push(1, 'a');
  queue.push(2, 'b');
  queue.push(1, 'c');
  expect(frames).toHaveLength(1);
  frames.shift()!();
  expect(seen).toEqual([
    [1, 'ac'],
    [2, 'b'],
  ]);
  expect(afters).toBe(1);
  queue.push(1, 'd');
  expect(frames).toHaveLength(1);
  frames.shift()!();
  expect(seen.at(-1)).toEqual([1, 'd']);
});
