"""Long forms of rows that take hours: run by `make soak`, not by `make test`.

How long and how often is said from outside: VENCEJO_SOAK_S seconds of faults (an hour; 259,200 is three days), and VENCEJO_SOAK_TIMES
times what is counted (1,000). The long forms of the Rust tests take VENCEJO_TEST_SEEDS, _FRAMES, _KILLS and _HOURS.
"""

from __future__ import annotations

import contextlib
import gc
import os
import random
import sys
import time
from pathlib import Path

import pytest
import vencejo

from tests.faults.mock import MockPlane
from tests.faults.test_links import descriptors, native_threads, resident_bytes
from tests.faults.test_transfers import holds, mission
from tests.support import wait_for

pytestmark = [pytest.mark.soak, pytest.mark.timeout(0)]

SECONDS = float(os.environ.get("VENCEJO_SOAK_S", "3600"))
TIMES = int(os.environ.get("VENCEJO_SOAK_TIMES", "1000"))
VEHICLES = 3
EVERY_S = 300.0
"""A fault of another kind every five minutes; in a short run eleven times in total."""
WARM_UP = 0.1
"""Fraction of the time after which memory is first measured."""
DAY_S = 86_400.0


def silence(mock: MockPlane) -> None:
    """Be silent for longer than it takes to count as lost."""
    mock.heartbeats = False


def noise(mock: MockPlane) -> None:
    """Send a megabyte of nonsense."""
    mock.say(random.Random(8).randbytes(1 << 20))


FAULTS = {
    "reset": lambda mock: mock.cut(reset=True),
    "closed": lambda mock: mock.cut(reset=False),
    "restart": lambda mock: mock.reboot(),
    "silence": silence,
    "noise": noise,
}


def is_fresh(plane: vencejo.Vehicle) -> bool:
    heartbeat = plane.telemetry.heartbeat
    return heartbeat is not None and heartbeat.freshness == "fresh"


@pytest.mark.fault(
    62, figure="3 vehicles, a fault of 5 kinds each 5 minutes: each comes back and takes a mission; < 1 MiB a day more"
)
def test_three_vehicles_through_one_fault_after_the_other(tmp_path: Path) -> None:
    """Memory is compared from the end of the warm-up on; a short run has the tolerance of a day."""
    choose = random.Random(62)
    every_s = min(EVERY_S, SECONDS / 11)
    with contextlib.ExitStack() as stack:
        mocks = [stack.enter_context(MockPlane(system_id=number + 1)) for number in range(VEHICLES)]
        station = stack.enter_context(vencejo.Station(*(mock.link for mock in mocks), record=tmp_path))
        planes = [station.wait_vehicle(mock.system_id) for mock in mocks]
        events: list[list[str]] = [[] for _ in planes]
        for plane, told in zip(planes, events, strict=True):
            stack.enter_context(plane.on_event(lambda event, told=told: told.append(event.kind)))  # type: ignore[misc]
        began = time.monotonic()
        held: tuple[float, int, int, int] | None = None
        rounds = 0
        while time.monotonic() - began < SECONDS:
            name = choose.choice(sorted(FAULTS))
            at = choose.randrange(VEHICLES)
            mock, plane, told = mocks[at], planes[at], events[at]
            told.clear()
            mock.do(lambda mock=mock, name=name: FAULTS[name](mock))  # type: ignore[misc]
            if name == "silence":
                wait_for(lambda plane=plane: not is_fresh(plane), "the silence")  # type: ignore[misc]
                mock.heartbeats = True
            if name == "restart":
                wait_for(lambda told=told: "rebooted" in told, "the restart")  # type: ignore[misc]
            wait_for(lambda: all(is_fresh(plane) for plane in planes), f"all of them after {name}", timeout_s=60.0)
            plan = mission(rounds % 10_000)
            for number, each in enumerate(planes):
                assert each.upload(plan).state == "verified", (name, number)
                assert holds(mocks[number], plan), (name, number)
                assert mocks[number].acts() == []
                mocks[number].received.clear()
            rounds += 1
            if held is None and time.monotonic() - began > WARM_UP * SECONDS:
                gc.collect()
                held = (time.monotonic(), resident_bytes(), descriptors(), native_threads())
            time.sleep(max(0.0, began + rounds * every_s - time.monotonic()))
        assert held is not None
        assert rounds >= 10
        gc.collect()
        since_s, memory, files, threads = held
        days = max(1.0, (time.monotonic() - since_s) / DAY_S)
        grown = resident_bytes() - memory
        sys.stdout.write(f"{rounds} faults in {time.monotonic() - began:.0f} s: {grown / 1024:.0f} KiB more\n")
        # A short run includes the allocator's fluctuations, which do not accumulate over days.
        assert grown < days * (1 << 20) + (4 << 20)
        assert descriptors() <= files + VEHICLES
        assert native_threads() <= threads


@pytest.mark.fault(13, figure="1,000 broken connections from Python: back each time, no descriptor more")
def test_a_link_breaks_again_and_again() -> None:
    with MockPlane() as mock, vencejo.connect(mock.link, record=False) as plane:
        before = descriptors()
        for number in range(TIMES):
            connections = mock.connections
            mock.do(lambda reset=number % 2 == 0: mock.cut(reset=reset))  # type: ignore[misc]
            wait_for(lambda connections=connections: mock.connections > connections, "connecting again")  # type: ignore[misc]
            assert plane.params["WP_RADIUS"] == 50.0
            mock.received.clear()
        assert descriptors() <= before
        assert plane.telemetry.invalid_values == 0
