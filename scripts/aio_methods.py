#!/usr/bin/env python3
"""Writes the methods of python/vencejo/aio.py from those of python/vencejo/vehicle.py: the same, as coroutines.

Methods of `Vehicle` and `Parameters` wait through `_wait`, or through another waiting method; here each becomes a
coroutine. The constructors, waiting and closing of both classes are written by hand.

Usage: ``python3 scripts/aio_methods.py [--check]``
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from scripts.marked import main, refilled  # noqa: E402

PACKAGE = ROOT / "python/vencejo"
SOURCE = PACKAGE / "vehicle.py"
FILE = PACKAGE / "aio.py"
WIDTH = 120
BY_HAND = {"close", "stream", "wait_until", "messages", "events", "_wait", "_wait_change"}
"""Methods of `Vehicle` with a hand-written asyncio counterpart."""


def folded(signature: re.Match[str]) -> str:
    """Format a signature as the formatter does: on three lines if it is too long for one."""
    name, arguments, result = signature.groups()
    return signature[0] if len(signature[0]) <= WIDTH else f"{name}\n        {arguments}\n    {result}"


def methods(source: str, owner: ast.ClassDef) -> Iterator[str]:
    """Yield the methods of a class as coroutines, except subscription (``params[name]``), which cannot be one."""
    own = [node for node in owner.body if isinstance(node, ast.FunctionDef)]
    taken = [
        node for node in own if node.name not in BY_HAND and (not node.name.startswith("__") or node.name == "__init__")
    ]
    waiting = [node.name for node in taken if node.name != "__init__" and not node.decorator_list]
    lines = source.splitlines()
    for node in taken:
        first = min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])
        text = "\n".join(lines[first - 1 : node.end_lineno])
        if node.name in waiting:
            text = text.replace("    def ", "    async def ", 1)
            text = re.sub(r"^( *async def \w+\()(.*)(\) -> .*)$", folded, text, count=1, flags=re.MULTILINE)
        text = re.sub(r"(?<!await )\bself\.((?:_vehicle\.)?_wait)\(", r"await self.\1(", text)
        text = re.sub(
            rf"^( +>>> (?:\w+ = )?)(plane\.(?:{'|'.join(waiting)})\()", r"\1await \2", text, flags=re.MULTILINE
        )
        text = re.sub(rf"(?<!await )\bself\.({'|'.join(waiting)})\(", r"await self.\1(", text)
        yield re.sub(r"\b(Parameters|Vehicle)\b(?=[:(]| ?->|\) ->)", r"Async\1", text)


def text() -> str:
    """Return the file's intended content."""
    source = SOURCE.read_text(encoding="utf-8")
    classes = {node.name: node for node in ast.parse(source).body if isinstance(node, ast.ClassDef)}
    parts = ["\n" + "\n\n".join(methods(source, classes[name])) + "\n\n" for name in ("Vehicle", "Parameters")]
    return refilled(FILE, __file__, parts)


if __name__ == "__main__":
    sys.exit(main(FILE, text()))
