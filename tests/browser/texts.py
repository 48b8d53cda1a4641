"""The app's texts, as its own catalogues have them: what the page shows is found by them, in either language."""

from __future__ import annotations

import functools
import json
import re
import subprocess
from typing import Literal

from tests.support import ROOT

Language = Literal["en", "es"]

# The catalogues are TypeScript; the compiler that the app is built with turns them into what can be read here.
_READ = """
const ts = require('typescript'), fs = require('fs');
const all = {};
for (const file of fs.readdirSync('src/lib/i18n').filter((name) => /\\.(en|es)\\.ts$/.test(name))) {
  const source = fs.readFileSync('src/lib/i18n/' + file, 'utf8');
  const module = { exports: {} };
  new Function('exports', ts.transpile(source, { module: ts.ModuleKind.CommonJS }))(module.exports);
  const language = file.split('.').at(-2);
  all[language] = Object.assign(all[language] ?? {}, ...Object.values(module.exports));
}
console.log(JSON.stringify(all));
"""


@functools.cache
def catalogues() -> dict[Language, dict[str, str]]:
    """All texts by language and key."""
    command = ["node", "--eval", _READ]
    read = subprocess.run(command, cwd=ROOT / "gcs", capture_output=True, text=True, check=True, timeout=60)
    found: dict[Language, dict[str, str]] = json.loads(read.stdout)
    assert found.keys() == {"en", "es"}
    assert len(found["en"]) > 300
    return found


def text(key: str, /, language: Language = "en", **values: object) -> str:
    """One text with its values in place."""
    return catalogues()[language][key].format(**values)


def pattern(template: str) -> re.Pattern[str]:
    """What a text looks like on the page, whatever its values are."""
    parts = re.split(r"\{\w+\}", " ".join(template.split()))
    return re.compile(".+".join(map(re.escape, parts)), re.DOTALL)
