import { describe, expect, it } from 'vitest';
import api from '../../../../schemas/openapi.json';
import { en } from './messages';

interface Schema {
  readonly $ref?: string;
  readonly enum?: readonly string[];
  readonly type?: string | readonly string[];
  readonly oneOf?: readonly Schema[];
  readonly allOf?: readonly Schema[];
  readonly properties?: Readonly<Record<string, Schema>>;
}

const schemas = (api as unknown as { components: { schemas: Readonly<Record<string, Schema>> } }).components.schemas;
const resolve = (schema: Schema): Schema =>
  schema.$ref === undefined ? schema : (schemas[schema.$ref.split('/').at(-1) ?? ''] ?? schema);
const texts: Readonly<Record<string, string>> = en;

it('says every cause that the server can give', () => {
  const codes = (schemas['Cause']?.oneOf ?? []).flatMap(({ properties }) => properties?.['code']?.enum ?? []);
  expect(codes.length).toBeGreaterThan(40);
  expect(codes.filter((code) => !(`problem.${code}` in en))).toEqual([]);
});

it('says every refusal of a vehicle that the server knows, and what to do', () => {
  const codes = schemas['RefusalCode']?.enum ?? [];
  expect(codes.length).toBeGreaterThan(20);
  expect(codes.filter((code) => !(`refusal.${code}` in en && `refusal.${code}.remedy` in en))).toEqual([]);
});

it('says everything that a plan file may leave to say', () => {
  const codes = schemas['PlanFileNoteCode']?.enum ?? [];
  expect(codes.length).toBeGreaterThan(20);
  expect(codes.filter((code) => !(`note.${code}` in en))).toEqual([]);
});

describe('findings of the checks', () => {
  const kinds = (schemas['FindingKind']?.oneOf ?? []).map(({ properties }) => ({
    code: properties?.['code']?.enum?.[0] ?? '',
    figures: properties?.['figures']?.properties ?? {},
  }));

  it('are said, each with its remedy', () => {
    expect(kinds.length).toBeGreaterThan(20);
    const isSaid = (code: string): boolean => `finding.${code}` in en && `finding.${code}.remedy` in en;
    expect(kinds.map(({ code }) => code).filter((code) => !isSaid(code))).toEqual([]);
  });

  it('are told by figures that they have', () => {
    const unknown = kinds.flatMap(({ code, figures }) =>
      Object.entries(texts)
        .filter(([key]) => key === `finding.${code}` || key.startsWith(`finding.${code}.`))
        .flatMap(([key, text]) => [...text.matchAll(/\{(\w+)\}/g)].map(([, name = '']) => ({ key, name })))
        .filter(({ name }) => name !== 'item' && !(name in figures)),
    );
    expect(unknown).toEqual([]);
  });

  it('are told apart by words and flags that they have', () => {
    const known = new Set(
      kinds.flatMap(({ code, figures }) => [
        `finding.${code}`,
        ...Object.entries(figures).flatMap(([name, figure]) => {
          const words = resolve(figure);
          const all = [...(words.enum ?? []), ...(words.oneOf ?? []).flatMap((one) => one.enum ?? [])];
          return [...all, ...(words.type === 'boolean' ? [name.replaceAll('_', '-')] : [])].map(
            (variant) => `finding.${code}.${variant}`,
          );
        }),
      ]),
    );
    const keys = Object.keys(texts)
      .filter((key) => kinds.some(({ code }) => key === `finding.${code}` || key.startsWith(`finding.${code}.`)))
      .map((key) => key.replace(/\.remedy$/, ''));
    expect(keys.length).toBeGreaterThan(40);
    expect(keys.filter((key) => !known.has(key))).toEqual([]);
  });
});
