"""Shared by several test folders: a simulated plane as a process, and waiting for a condition."""

from __future__ import annotations

import contextlib
import json
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import TracebackType

import pytest

ROOT = Path(__file__).resolve().parent.parent
FIXTURES = ROOT / "tests" / "fixtures"
CAPTURES = FIXTURES / "captures"
HOME = (40.3332, -3.7978, 600.0)
"""Home of the recordings and of the simulated plane: degrees, degrees, metres above mean sea level."""


def uncaught(monkeypatch: pytest.MonkeyPatch) -> list[threading.ExceptHookArgs]:
    """Record exceptions that reach the interpreter's hook for threads; it accepts nothing else."""
    told: list[threading.ExceptHookArgs] = []

    def hook(args: threading.ExceptHookArgs) -> None:
        threading.__excepthook__(args)
        told.append(args)

    monkeypatch.setattr(threading, "excepthook", hook)
    return told


class Metronome:
    """Time measured as the sum of short sleeps, each counted at its nominal duration.

    A duration on this clock was spent waiting, not preempted on a busy machine: for limits of wall-clock time.
    """

    TICK_S = 0.02

    def __init__(self) -> None:
        self._ticks = 0
        self.longest_s = 0.0
        """Longest actual duration of one sleep: how long the machine delayed a thread that only had to wake up."""
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    @property
    def now_s(self) -> float:
        """Return the seconds since the start."""
        return self._ticks * self.TICK_S

    def __enter__(self) -> Metronome:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._is_over.set()
        self._thread.join()

    def _run(self) -> None:
        slept_at = time.monotonic()
        while not self._is_over.wait(self.TICK_S):
            self._ticks += 1
            now = time.monotonic()
            self.longest_s, slept_at = max(self.longest_s, now - slept_at), now


@contextlib.contextmanager
def simulated_plane(*options: str, link: str = "tcp:127.0.0.1:0") -> Iterator[str]:
    """Run a simulated plane in a process, ready to arm (tests/booted.py); yield its link string."""
    command = [sys.executable, str(ROOT / "tests" / "booted.py"), "--link", link, *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            line = process.stdout.readline()
            assert line, f"the simulator did not start: exit status {process.wait(10)}"
            yield str(json.loads(line)["listening"])
        finally:
            process.terminate()


@contextlib.contextmanager
def reserved_ports(count: int = 1) -> Iterator[list[int]]:
    """Reserve TCP ports for programs that are restarted on the same port: no other program gets them meanwhile.

    A port that is bound without listening is not assigned automatically, and refuses connections; a program that binds
    it explicitly, with SO_REUSEADDR as servers do, gets it (socket(7)).
    """
    with contextlib.ExitStack() as kept:
        sockets = [kept.enter_context(socket.socket()) for _ in range(count)]
        for one in sockets:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            one.bind(("127.0.0.1", 0))
        yield [int(one.getsockname()[1]) for one in sockets]


def wait_for(condition: Callable[[], bool], what: str, timeout_s: float = 120.0) -> None:
    """Wait until a condition holds; the timeout only ends a failed test."""
    deadline = time.monotonic() + timeout_s
    while not condition():
        assert time.monotonic() < deadline, f"{what}: not within {timeout_s} s"
        time.sleep(0.01)
