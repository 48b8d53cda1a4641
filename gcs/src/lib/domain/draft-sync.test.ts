import { describe, expect, it } from 'vitest';
import { type LocalDraft, markOf, meet, type Meeting, type ServerDraft } from './draft-sync';

const local = (changes: Partial<LocalDraft>): LocalDraft => ({
  base: 3,
  mark: 'mine',
  isChanged: false,
  isEmpty: false,
  ...changes,
});
const server = (changes: Partial<ServerDraft>): ServerDraft => ({
  revision: 4,
  mark: 'theirs',
  isEmpty: false,
  ...changes,
});

describe('two drafts', () => {
  it.each<[string, LocalDraft, ServerDraft | null, Meeting]>([
    ['ours goes to a server that has none', local({ base: 0, isChanged: true }), null, 'push'],
    ['nothing is nothing', local({ base: 0, isEmpty: true }), null, 'none'],
    ['the same are the same, whatever their history', local({ mark: 'theirs', base: 1 }), server({}), 'adopt'],
    ['a change of what is there is saved', local({ base: 4, isChanged: true }), server({}), 'push'],
    [
      'another browser is offered what is there',
      local({ base: 0, isEmpty: true, isChanged: true }),
      server({}),
      'offer',
    ],
    ['a draft that was not touched gives way when one wants', local({}), server({}), 'offer'],
    ['two that were both changed are for a person', local({ isChanged: true }), server({}), 'conflict'],
    ['one that was emptied takes nothing away', local({ isChanged: true }), server({ isEmpty: true }), 'push'],
  ])('%s', (_, mine, theirs, expected) => expect(meet(mine, theirs)).toBe(expected));

  it('are told apart', () => {
    const texts = ['', 'a', 'ab', 'ba', 'a'.repeat(1000), `${'a'.repeat(999)}b`];
    expect(new Set(texts.map(markOf)).size).toBe(texts.length);
    expect(markOf('plan')).toBe(markOf('plan'));
  });
});
