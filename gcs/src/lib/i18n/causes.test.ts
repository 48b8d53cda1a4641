import { expect, it } from 'vitest';
// The codes of findings.
import checks from '../../../../crates/flight/src/checks.rs?raw';
import api from '../../../../schemas/openapi.json';
import { en } from './messages';

interface Coded {
  readonly oneOf: readonly { readonly properties: { readonly code: { readonly enum: readonly string[] } } }[];
}

it('says every cause that the server can give', () => {
  const cause = (api as unknown as { components: { schemas: { Cause: Coded } } }).components.schemas.Cause;
  const codes = cause.oneOf.flatMap(({ properties }) => properties.code.enum);
  expect(codes.length).toBeGreaterThan(40);
  expect(codes.filter((code) => !(`problem.${code}` in en))).toEqual([]);
});

it('says every finding of the checks, with its remedy', () => {
  const codes = [...checks.matchAll(/^ {4}\w+ = "([a-z-]+)",$/gm)].map(([, code]) => code ?? '');
  expect(codes.length).toBeGreaterThan(20);
  const isSaid = (code: string): boolean => `finding.${code}` in en && `finding.${code}.remedy` in en;
  expect(codes.filter((code) => !isSaid(code))).toEqual([]);
});
