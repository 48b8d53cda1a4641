"""Replaces the generated parts of hand-written files, between two marker lines."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from pathlib import Path

END = "# (end of what is written by a script)"


def begin(script: str) -> str:
    """Return the line above a generated part."""
    return f"# Written by scripts/{Path(script).name}: do not edit."


def refilled(file: Path, script: str, parts: Sequence[str]) -> str:
    """Return the content of a file with new generated parts; each begins and ends with a line break."""
    mark, rest = begin(script), iter(parts)
    place = re.compile(rf"({re.escape(mark)}\n).*?(^ *{re.escape(END)}\n)", re.MULTILINE | re.DOTALL)
    old = file.read_text(encoding="utf-8")
    if (found := len(place.findall(old))) != len(parts):
        raise SystemExit(f"{file} has {found} places between '{mark}' and '{END}', not {len(parts)}")
    return place.sub(lambda marks: marks[1] + next(rest) + marks[2], old)


def main(file: Path, text: str) -> int:
    """Write the file, or with --check return whether it is current as the exit code."""
    if "--check" in sys.argv:
        return 0 if file.read_text(encoding="utf-8") == text else 1
    file.write_text(text, encoding="utf-8")
    return 0
