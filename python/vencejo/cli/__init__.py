"""The `vencejo` command: a terminal's way to everything that the package does.

One file per command or group of commands, each a thin layer over the package; `commands` has them all. `common` holds
what they share, `follow` the picture of a flight. Whatever a command does not need is imported when a command runs, so
that help is there at once.
"""

from __future__ import annotations

import os
import signal
import sys

__all__ = ["main"]


def main() -> None:
    """Entry point of the ``vencejo`` command."""
    # All until the command runs takes seconds on a small computer: Ctrl-C ends it without the traceback of an import.
    is_usual = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if is_usual:
        signal.signal(signal.SIGINT, lambda *_: os._exit(130))
    _have_outputs()
    from typer.main import get_command

    from vencejo.cli.commands import app
    from vencejo.cli.common import end_by_signal, take_any_character

    command = get_command(app)
    end_by_signal()
    take_any_character()
    if is_usual:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    command(prog_name="vencejo")


def _have_outputs() -> None:
    """Replace outputs that are closed: they are ``None`` then, and a link's socket would take their descriptor."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(os.open(os.devnull, os.O_WRONLY), "w"))
