// Makes JavaScript of the Slice files, as modules "jderobot/…" and "vencejo/vencejo": `npm run slices`. An argument is another folder of modules.
"use strict";
const { mkdirSync, readdirSync } = require("node:fs");
const { join } = require("node:path");
const slice2js = require("slice2js");

const slices = join(__dirname, "..", "..", "python", "vencejo", "jderobot", "slice");
for (const name of ["jderobot", "vencejo"]) {
  const out = join(process.argv[2] ?? join(__dirname, "node_modules"), name);
  mkdirSync(out, { recursive: true });
  // Of the two dialects of Mission a program takes one.
  const files = readdirSync(join(slices, name)).filter((file) => file.endsWith(".ice") && file !== "mission_sequence.ice");
  slice2js
    .compile([`-I${slices}`, "--output-dir", out, ...files.map((file) => join(slices, name, file))], { stdio: "inherit" })
    .on("exit", (code) => (process.exitCode ||= code ?? 1));
}
