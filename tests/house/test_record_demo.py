"""The recorder of the README's image interprets a terminal's output."""

from __future__ import annotations

import io
import sys

from rich.console import Console
from rich.live import Live
from rich.text import Text

from tests.house.support import load

record_demo = load("scripts/record_demo.py")


def plain(written: str) -> list[str]:
    """Return the remaining lines without colours."""
    return [Text.from_ansi(line).plain.rstrip() for line in record_demo.screen(written)]


def test_rewritten_lines_leave_their_last_state() -> None:
    assert plain("one\r\ntwo 10 %\rtwo 99 %\r\nthree\r\n") == ["one", "two 99 %", "three"]
    assert plain("a\r\nb\r\n\x1b[1A\x1b[2Kc\r\n") == ["a", "c"]
    assert plain("\x1b[31mred\x1b[0m\r\n") == ["red"]
    assert plain("") == []


def test_a_live_display_leaves_its_last_picture() -> None:
    file = io.StringIO()
    console = Console(file=file, force_terminal=True, width=40, color_system="standard")
    console.print("before")
    with Live(console=console, auto_refresh=False) as live:
        for step in range(3):
            live.update(f"[bold]height[/] {step} m\nspeed {step} m/s", refresh=True)
        live.console.print("a text from the plane")
    console.print("after")
    assert plain(file.getvalue()) == ["before", "a text from the plane", "height 2 m", "speed 2 m/s", "after"]


def test_a_program_runs_in_a_terminal_of_its_own() -> None:
    program = "import os, sys; print(sys.stdout.isatty(), os.get_terminal_size().columns); sys.exit(3)"
    written, code = record_demo.run([sys.executable, "-c", program], 77, 20)
    assert plain(written) == ["True 77"]
    assert code == 3
