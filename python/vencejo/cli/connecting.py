"""Connects a command to a vehicle, over the link that was named or the usual one, and says what becomes of the recording."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from vencejo.cli.common import DEFAULT_LINK, say, status
from vencejo.cli.listening import default_link

if TYPE_CHECKING:
    from vencejo.station import Station
    from vencejo.vehicle import Vehicle

__all__ = ["RECORDED_AGAIN", "real_link", "recording_told", "vehicle_on"]


def real_link(link: str) -> str:
    """The link that was named, or the one of those who name none."""
    return default_link() if link == DEFAULT_LINK else link


RECORDED_AGAIN: Final = "Telemetry is recorded again"
"""What is said when a recording that stopped goes on."""


@contextlib.contextmanager
def recording_told(station: Station) -> Iterator[None]:
    """Say on standard error when the recording of a station stops, and when it goes on."""
    if station.recorder is None:
        yield
        return
    ended = threading.Event()

    def look() -> None:
        was_told = False
        while not ended.wait(0.5):
            info = station.recorder
            problem = None if info is None else info.problem
            if problem is not None and not was_told:
                say(f"Warning: telemetry is not being recorded: {problem}")
            elif problem is None and was_told:
                say(RECORDED_AGAIN)
            was_told = problem is not None

    thread = threading.Thread(target=look, name="recording", daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


@contextlib.contextmanager
def vehicle_on(
    link: str,
    *,
    system_id: int | None = None,
    timeout_s: float = 30.0,
    rate_hz: float = 10.0,
    record: bool = False,
    forward: list[str] | None = None,
) -> Iterator[Vehicle]:
    """Connect to a vehicle, and close the link at the end."""
    from vencejo import connect

    link = real_link(link)
    with status(f"Waiting for a vehicle on {link} …"):
        vehicle = connect(
            link,
            system_id=system_id,
            timeout_s=timeout_s,
            rate_hz=rate_hz,
            record=record,
            forward_to=forward or (),
        )
    with vehicle, recording_told(vehicle.station):
        yield vehicle
