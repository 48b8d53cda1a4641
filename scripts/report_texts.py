"""Writes the Spanish texts that printed reports share with the page, from gcs/src/lib/i18n, to python/vencejo/data/texts.es.json.

Run it when findings or commands get a text: `python3 scripts/report_texts.py`. A test compares.
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
    """The texts of a file of the page by their keys."""
    found = ENTRY.findall(path.read_text(encoding="utf-8"))
    return {quoted or bare: re.sub(r"\\(.)", r"\1", single or double) for quoted, bare, single, double in found}


def texts() -> str:
    """The file as it is to be."""
    findings = {key.removeprefix("finding."): text for key, text in entries(TEXTS / "findings.es.ts").items()}
    notes = {key: text for key, text in entries(TEXTS / "files.es.ts").items() if key.startswith("note.")}
    shared = {"commands": entries(TEXTS / "commands.es.ts"), "findings": findings, "notes": notes}
    return json.dumps(shared, ensure_ascii=False, indent=1, sort_keys=True) + "\n"


if __name__ == "__main__":
    TARGET.write_text(texts(), encoding="utf-8")
