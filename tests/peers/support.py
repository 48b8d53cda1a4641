"""Shared by the tests with other stations: a running plane and a mission."""

from __future__ import annotations

import time
from collections.abc import Callable

from vencejo.sim import SimOptions, SimulatedPlane

from tests.booted import boot

PATIENCE_S = 120.0
"""Time limit of a condition on a slow machine; nothing else waits for it."""

ITEMS: tuple[tuple[float, ...], ...] = (
    # seq, frame, command, current, autocontinue, p1 to p4, x, y, z
    (0, 0, 16, 0, 1, 0, 0, 0, 0, 40.3332, -3.7978, 600.0),
    (1, 3, 22, 0, 1, 12, 0, 0, 0, 40.3332, -3.8013, 60.0),
    (2, 3, 16, 0, 1, 0, 0, 0, 0, 40.3377, -3.8084, 100.0),
    (3, 3, 18, 0, 1, 1, 0, 80, 1, 40.3305, -3.7907, 80.0),
    (4, 3, 16, 0, 1, 0, 0, 0, 0, 40.3332, -3.7901, 40.0),
    (5, 3, 21, 0, 1, 0, 0, 0, 1, 40.3332, -3.7971, 0.0),
)
"""A small mission as MISSION_ITEM has it, home first."""


def eventually(condition: Callable[[], bool]) -> None:
    """Wait for a condition of another thread or process that sends no notification."""
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.01)


def running_plane() -> SimulatedPlane:
    """A simulated plane, with its flight dynamics, on a free TCP port.

    In real time: asked for an item it waits a second, and others are to have that second.
    """
    sim = SimulatedPlane(SimOptions(links=("tcp:127.0.0.1:0",)))
    sim.call(boot, timeout_s=PATIENCE_S)
    return sim
