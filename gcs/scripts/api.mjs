// Generates src/lib/api/schema.d.ts from the committed API description; with --check only compares.
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import openapiTS, { astToString } from 'openapi-typescript';

const description = new URL('../../schemas/openapi.json', import.meta.url);
const target = new URL('../src/lib/api/schema.d.ts', import.meta.url);
const banner = '// Generated from schemas/openapi.json by `npm run api`. Do not edit.\n\n';

const generated = banner + astToString(await openapiTS(description, { arrayLength: true }));
if (process.argv.includes('--check')) {
  const committed = existsSync(target) ? readFileSync(target, 'utf8') : '';
  if (committed !== generated) {
    console.error('src/lib/api/schema.d.ts differs from schemas/openapi.json: run `npm run api`');
    process.exit(1);
  }
} else {
  writeFileSync(target, generated);
}
