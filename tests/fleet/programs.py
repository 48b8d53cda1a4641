"""`vencejo` commands as programs of their own, which tell of themselves in lines of JSON."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.clock import Clock

__all__ = ["Program", "command"]


class Program:
    """A `vencejo` command that tells of itself in lines of JSON."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self.process = process

    def line(self) -> dict[str, Any]:
        """The next line."""
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert line, f"it ended with {self.process.wait(10)}"
        told: dict[str, Any] = json.loads(line)
        return told

    def until(self, **wanted: object) -> dict[str, Any]:
        """The next line with these values."""
        while True:
            told = self.line()
            if all(told.get(name) == value for name, value in wanted.items()):
                return told


@contextlib.contextmanager
def command(data: Path, *args: str, clock: Clock | None = None) -> Iterator[Program]:
    """A running command with a data folder, and maybe a clock, of its own."""
    env = {**os.environ, "VENCEJO_DATA": str(data), **(clock.env if clock else {})}
    with subprocess.Popen(
        [sys.executable, "-m", "vencejo.cli", *args, "--json", "--no-record"],
        stdout=subprocess.PIPE,
        text=True,
        env=env,
    ) as process:
        try:
            yield Program(process)
        finally:
            process.terminate()
