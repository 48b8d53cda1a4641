"""Connects a command to a vehicle, and reports how its recording goes."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Final

import typer

from vencejo.cli.common import DEFAULT_LINK, LinkOption, say, status
from vencejo.cli.listening import default_link

if TYPE_CHECKING:
    from vencejo.station import Station
    from vencejo.vehicle import Vehicle

__all__ = ["RECORDED_AGAIN", "OnVehicle", "real_link", "recording_told"]


def real_link(link: str) -> str:
    """The link that was named, or else the default one."""
    return default_link() if link == DEFAULT_LINK else link


RECORDED_AGAIN: Final = "Telemetry is recorded again"
"""Said when a stopped recording resumes."""


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


@dataclass(frozen=True)
class OnVehicle:
    """The options by which a command finds its vehicle."""

    link: LinkOption = DEFAULT_LINK
    system: Annotated[
        int | None,
        typer.Option(
            "--system", metavar="ID", min=1, max=255, help="MAVLink system id; by default the first vehicle heard."
        ),
    ] = None
    timeout: Annotated[
        float,
        typer.Option("--timeout", metavar="SECONDS", min=0.1, help="How long to wait for the vehicle's heartbeat."),
    ] = 30.0

    @contextlib.contextmanager
    def vehicle(
        self, *, rate_hz: float = 10.0, record: bool = False, forward: list[str] | None = None
    ) -> Iterator[Vehicle]:
        """Connect to the vehicle, and close the link at the end.

        Raises
        ------
        LinkError, NoVehicleError
        """
        from vencejo import connect

        link = real_link(self.link)
        with status(f"Waiting for a vehicle on {link} …"):
            vehicle = connect(
                link,
                system_id=self.system,
                timeout_s=self.timeout,
                rate_hz=rate_hz,
                record=record,
                forward_to=forward or (),
            )
        with vehicle, recording_told(vehicle.station):
            yield vehicle
