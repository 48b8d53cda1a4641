"""Fixtures for all tests, however pytest was started; and the order in which tests begin."""

import os
import signal
import threading
from pathlib import Path

import pytest

# A shell starts background jobs with SIGINT ignored, and child processes inherit that. Tests that send SIGINT start
# programs; with a handler here, those begin with the default again.
if threading.current_thread() is threading.main_thread() and signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(autouse=True)
def _own_data_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A data folder for each test, so that leftovers, such as a mission marked as mixed, do not affect others."""
    monkeypatch.setenv("VENCEJO_DATA", str(tmp_path / "vencejo-data"))


BUSY = ("tests/house/test_wheel.py", "tests/browser")
"""Tests that take longest and need a core for themselves: they compile, or render without a graphics card."""
WAITING = (
    "tests/cli/test_demo.py",
    "tests/jderobot/test_flights.py",
    "tests/flights",
    "tests/faults/test_links.py",
    "tests/faults/test_clocks.py",
    "tests/sim/test_mavlink_flight.py",
    "tests/sim/test_flight_missions.py",
    "tests/sim/test_flight_commands.py",
)
"""Tests that take long because they wait for a plane."""


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Let half of the workers begin with the busy tests and half with the waiting ones; short ones come last.

    xdist's worksteal initially gives each worker a contiguous part of the list. No test may rely on the order.
    """
    workers = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    if workers == 1:
        return
    busy, waiting = (
        [item for place in places for item in items if item.nodeid.startswith(place)] for places in (BUSY, WAITING)
    )
    short = [item for item in items if not item.nodeid.startswith(BUSY + WAITING)]
    total, items[:] = len(items), []
    for number in range(workers):
        pair = number // 2
        stretch = waiting[pair :: workers // 2] if number % 2 else busy[pair :: (workers + 1) // 2]
        room = max(0, (total - len(items)) // (workers - number) - len(stretch))
        items += stretch + short[:room]
        del short[:room]
    items += short
