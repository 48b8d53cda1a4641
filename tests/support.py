"""What several test folders use: a simulated plane as a process of its own, and waiting for a condition."""

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
"""Home of the recordings and of the simulated plane: degrees, degrees, metres above sea level."""


def uncaught(monkeypatch: pytest.MonkeyPatch) -> list[threading.ExceptHookArgs]:
    """What the interpreter's own hook is told of exceptions that end up in a thread; it takes nothing but what is made for it."""
    told: list[threading.ExceptHookArgs] = []

    def hook(args: threading.ExceptHookArgs) -> None:
        threading.__excepthook__(args)
        told.append(args)

    monkeypatch.setattr(threading, "excepthook", hook)
    return told


class Metronome:
    """Seconds as a busy machine lets them pass: the sum of short sleeps, each counted as it was asked for.

    What takes so long by it has waited, not been kept from running: for bars that are times of the clock.
    """

    TICK_S = 0.02

    def __init__(self) -> None:
        self._ticks = 0
        self.longest_s = 0.0
        """How long the longest of the sleeps took by the clock: so long the machine kept somebody from running who only had to wake up."""
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    @property
    def now_s(self) -> float:
        """Seconds since it began."""
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
    """A simulated plane in its own process, ready to arm (tests/booted.py); gives the link string to reach it."""
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
    """TCP ports of this machine for programs that are to come back where they were: nobody else is given them meanwhile.

    A port that is bound and not listened at is given to nobody, and refuses; who asks for it by its number, with SO_REUSEADDR as servers
    do, has it (socket(7)).
    """
    with contextlib.ExitStack() as kept:
        sockets = [kept.enter_context(socket.socket()) for _ in range(count)]
        for one in sockets:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            one.bind(("127.0.0.1", 0))
        yield [int(one.getsockname()[1]) for one in sockets]


def wait_for(condition: Callable[[], bool], what: str, timeout_s: float = 120.0) -> None:
    """Wait until a condition holds; the time-out only ends a test that has failed."""
    deadline = time.monotonic() + timeout_s
    while not condition():
        assert time.monotonic() < deadline, f"{what}: not within {timeout_s} s"
        time.sleep(0.01)
