// Fails the build when the app, compressed as it is sent, is larger than a field network should carry.
import { readdirSync, readFileSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { gzipSync } from 'node:zlib';

const LIMIT_KB = 400;

function files(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) =>
    entry.isDirectory() ? files(join(folder, entry.name)) : [join(folder, entry.name)],
  );
}

let total = 0;
for (const file of files('dist')) {
  const size = gzipSync(readFileSync(file), { level: 9 }).length;
  total += size;
  if (statSync(file).size > 100_000) console.log(`${(size / 1024).toFixed(1).padStart(8)} kB  ${file}`);
}
console.log(`${(total / 1024).toFixed(1).padStart(8)} kB  compressed in all (limit ${LIMIT_KB} kB)`);
if (total > LIMIT_KB * 1024) process.exit(1);
