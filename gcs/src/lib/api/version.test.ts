import { expect, it } from 'vitest';
import schema from '../../../../schemas/openapi.json';
import { PAGE_VERSION } from './version';

it('is that of the server, else every page would be told that the server was updated', () => {
  expect(PAGE_VERSION).toBe(schema.info.version);
});
