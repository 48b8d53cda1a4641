"""Programs that are asked by lines of JSON and answer each with one: nothing may fork once Zenoh runs, so who uses it is one of its own."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from typing import Any

__all__ = ["Asked", "answer_all", "asked", "started"]


class Asked:
    """Such a program, from outside."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._process = process

    def ask(self, do: str, **of: object) -> Any:
        """Has it do one thing, and gives its answer."""
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps({"do": do, **of}) + "\n")
        self._process.stdin.flush()
        return self.line()

    def line(self) -> Any:
        """Its next line."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        assert line, f"{self._process.args!r} ended"
        return json.loads(line)


@contextlib.contextmanager
def started(command: Sequence[object], **env: str) -> Iterator[Asked]:
    """Starts one, and waits until it is ready."""
    with subprocess.Popen(
        [*map(str, command)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env={**os.environ, **env}
    ) as process:
        try:
            program = Asked(process)
            assert program.line() == "ready"
            yield program
        finally:
            process.kill()


def asked(module: str, *args: object, python: str = sys.executable) -> contextlib.AbstractContextManager[Asked]:
    """Starts one of ours."""
    return started([python, "-m", module, *args])


def answer_all(answer: Callable[..., Any]) -> None:
    """Is one: answers until standard input ends."""
    sys.stdout.write('"ready"\n')
    sys.stdout.flush()
    for line in sys.stdin:
        sys.stdout.write(json.dumps(answer(**json.loads(line))) + "\n")
        sys.stdout.flush()
