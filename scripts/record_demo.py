#!/usr/bin/env python3
"""Makes docs/images/demo.svg, the image in the README, from a real run of `vencejo demo`.

The command runs in a pseudoterminal; its final screen, including the lines scrolled off, becomes the image.

Usage: ``.venv/bin/python scripts/record_demo.py [--columns N] [--rows N] [-- ARGUMENTS OF vencejo demo]``
"""

from __future__ import annotations

import argparse
import fcntl
import os
import pty
import re
import struct
import subprocess
import sys
import termios
from pathlib import Path

from rich.console import Console
from rich.text import Text

ROOT = Path(__file__).resolve().parent.parent
OUTPUT = ROOT / "docs/images/demo.svg"
CONTROL = re.compile(r"\x1b\[([?0-9;]*)([A-Za-z])|\x1b\][^\x07]*\x07|\r|\n")


def run(command: list[str], columns: int, rows: int) -> tuple[str, int]:
    """Run a program in a pseudoterminal; return its output and its exit code."""
    parent, child = pty.openpty()
    fcntl.ioctl(child, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
    environment = {**os.environ, "TERM": "xterm-256color", "COLORTERM": "truecolor", "COLUMNS": str(columns)}
    environment.pop("NO_COLOR", None)
    process = subprocess.Popen(command, stdin=child, stdout=child, stderr=child, env=environment)
    os.close(child)
    written = b""
    while True:
        try:
            piece = os.read(parent, 65536)
        except OSError:  # Linux returns EIO when the other side of a pty is closed
            break
        if not piece:
            break
        written += piece
        sys.stderr.write(".")
        sys.stderr.flush()
    os.close(parent)
    sys.stderr.write("\n")
    return written.decode("utf-8", "replace"), process.wait()


def screen(written: str) -> list[str]:
    """Return the lines that remain on a terminal, with colours.

    Interprets the control sequences of progress displays: return, new line, cursor up, erase. A rewritten line counts
    as fully rewritten.
    """
    lines = [""]
    row, fresh = 0, False
    at = 0

    def put(text: str) -> None:
        nonlocal fresh
        if not text:
            return
        if fresh and re.sub(r"\x1b\[[0-9;]*m", "", text):
            lines[row] = ""
            fresh = False
        lines[row] += text

    for control in CONTROL.finditer(written):
        put(written[at : control.start()])
        at = control.end()
        whole, (count, kind) = control.group(0), control.groups()
        if whole == "\r":
            fresh = True
        elif whole == "\n":
            row, fresh = row + 1, False
            if row == len(lines):
                lines.append("")
        elif kind == "m":
            put(whole)
        elif kind == "A":
            row, fresh = max(0, row - int(count or 1)), True
        elif kind == "K":
            lines[row] = ""
        elif kind == "J":
            del lines[row + 1 :]
            lines[row] = ""
    put(written[at:])
    while lines and not lines[-1].strip():
        lines.pop()
    return lines


def main() -> int:
    """Run the demo and write the image."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--columns", type=int, default=100)
    parser.add_argument("--rows", type=int, default=40, help="keep at most this many lines: the last ones")
    parser.add_argument("arguments", nargs="*", help="passed to `vencejo demo`")
    options = parser.parse_args()
    written, code = run(
        [str(Path(sys.executable).parent / "vencejo"), "demo", "--exit-after-landing", "--no-open", *options.arguments],
        options.columns,
        options.rows,
    )
    if code != 0:
        sys.stderr.write(written)
        print(f"record_demo: vencejo demo ended with {code}", file=sys.stderr)
        return code
    with Path(os.devnull).open("w") as nowhere:
        console = Console(
            record=True, width=options.columns, file=nowhere, force_terminal=True, color_system="truecolor"
        )
        console.print(Text("$ make demo", style="bold"))
        for line in screen(written)[-options.rows :]:
            console.print(Text.from_ansi(line), no_wrap=True, crop=True)
        OUTPUT.write_text(console.export_svg(title="vencejo demo"), encoding="utf-8")
    print(f"wrote {OUTPUT.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
