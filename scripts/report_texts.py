"""Writes the Spanish texts shared by printed reports and the page to python/vencejo/data/texts.es.json.

They come from gcs/src/lib/i18n.

Run it when findings or commands get new texts: `python3 scripts/report_texts.py`. A test checks that the file is
current.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TEXTS = ROOT / "gcs" / "src" / "lib" / "i18n"
TARGET = ROOT / "python" / "vencejo" / "data" / "texts.es.json"
ENTRY = re.compile(
    r"""^\s+(?:'([^']+)'|(\w+)):\s*(?:'((?:[^'\\]|\\.)*)'|"((?:[^"\\]|\\.)*)"),$""",
    re.MULTILINE,
)


def entries(path: Path) -> dict[str, str]:
    """Return the texts in a file of the page by key."""
    found = ENTRY.findall(path.read_text(encoding="utf-8"))
    return {quoted or bare: re.sub(r"\\(.)", r"\1", single or double) for quoted, bare, single, double in found}


def texts() -> str:
    """Return the file's intended content."""
    findings = {key.removeprefix("finding."): text for key, text in entries(TEXTS / "findings.es.ts").items()}
    notes = {key: text for key, text in entries(TEXTS / "files.es.ts").items() if key.startswith("note.")}
    shared = {"commands": entries(TEXTS / "commands.es.ts"), "findings": findings, "notes": notes}
    return json.dumps(shared, ensure_ascii=False, indent=1, sort_keys=True) + "\n"


if __name__ == "__main__":
    TARGET.write_text(texts(), encoding="utf-8")
