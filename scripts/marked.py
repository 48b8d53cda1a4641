"""What scripts write into a file that people write too: the parts between two marks."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from pathlib import Path

END = "# (end of what is written by a script)"


def begin(script: str) -> str:
    """The line above what this script writes."""
    return f"# Written by scripts/{Path(script).name}: do not edit."


def refilled(file: Path, script: str, parts: Sequence[str]) -> str:
    """The text of a file with these parts between its marks; each begins and ends with a line break."""
    mark, rest = begin(script), iter(parts)
    place = re.compile(rf"({re.escape(mark)}\n).*?(^ *{re.escape(END)}\n)", re.MULTILINE | re.DOTALL)
    old = file.read_text(encoding="utf-8")
    if (found := len(place.findall(old))) != len(parts):
        raise SystemExit(f"{file} has {found} places between '{mark}' and '{END}', not {len(parts)}")
    return place.sub(lambda marks: marks[1] + next(rest) + marks[2], old)


def main(file: Path, text: str) -> int:
    """Write the file, or with --check say by the exit code whether it is what would be written."""
    if "--check" in sys.argv:
        return 0 if file.read_text(encoding="utf-8") == text else 1
    file.write_text(text, encoding="utf-8")
    return 0
