// Puts each file of the app beside itself as it is sent, compressed once for all; fails the build when what is loaded at first is then
// larger than a field network should carry.
import { readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { basename, join } from 'node:path';
import { gzipSync } from 'node:zlib';

const LIMIT_KB = 400;
/** What is smaller is sent as it is. */
const WORTH_PACKING = 1024;
/** Chunks that are fetched when a person opens what needs them: everything else counts. */
const LATER = [
  /^\w+Content-/, // panels (`ui/base/Lazy.svelte`)
  /^projection-transform-/, // proj4, for sources in UTM and the like
];

function files(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) =>
    entry.isDirectory() ? files(join(folder, entry.name)) : [join(folder, entry.name)],
  );
}

const line = (bytes, text) => console.log(`${(bytes / 1024).toFixed(1).padStart(8)} kB  ${text}`);

let first = 0;
let later = 0;
for (const file of files('dist')) {
  const bytes = readFileSync(file);
  const packed = gzipSync(bytes, { level: 9 });
  const size = packed.length;
  if (bytes.length > WORTH_PACKING && size < bytes.length) writeFileSync(`${file}.gz`, packed);
  if (LATER.some((name) => name.test(basename(file)))) later += size;
  else first += size;
  if (bytes.length > 100_000) line(size, file);
}
line(first, `compressed at first (limit ${LIMIT_KB} kB)`);
line(later, 'more when it is needed');
if (first > LIMIT_KB * 1024) process.exit(1);
