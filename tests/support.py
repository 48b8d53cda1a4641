"""What several test folders use: a simulated plane as a process of its own, and waiting for a condition."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FIXTURES = ROOT / "tests" / "fixtures"
CAPTURES = FIXTURES / "captures"
HOME = (40.3332, -3.7978, 600.0)
"""Home of the recordings and of the simulated plane: degrees, degrees, metres above sea level."""


@contextlib.contextmanager
def simulated_plane(*options: str, link: str = "tcp:127.0.0.1:0") -> Iterator[str]:
    """A simulated plane in its own process; gives the link string to reach it."""
    command = [sys.executable, "-m", "vencejo.sim", "--link", link, *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            line = process.stdout.readline()
            assert line, f"the simulator did not start: exit status {process.wait(10)}"
            yield str(json.loads(line)["listening"])
        finally:
            process.terminate()


def wait_for(condition: Callable[[], bool], what: str, timeout_s: float = 120.0) -> None:
    """Wait until a condition holds; the time-out only ends a test that has failed."""
    deadline = time.monotonic() + timeout_s
    while not condition():
        assert time.monotonic() < deadline, f"{what}: not within {timeout_s} s"
        time.sleep(0.01)
