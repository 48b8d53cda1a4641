"""Connects a command to a vehicle, and reports how its recording goes."""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Final

import typer

from vencejo.cli.common import DEFAULT_LINK, Exit, Failed, LinkOption, say, status, told_when_long
from vencejo.cli.listening import default_link

if TYPE_CHECKING:
    from vencejo.station import Station
    from vencejo.vehicle import Vehicle

__all__ = ["RECORDED_AGAIN", "OnLink", "OnVehicle", "real_link", "recording_told", "why_not_up"]


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


def why_not_up(station: Station) -> str | None:
    """The links that are not up and why, as a line to print; ``None`` if all are."""
    problems = [f"{link.address}: {link.detail}" for link in station.links if link.state != "up" and link.detail]
    return f"{'; '.join(problems)}. It is tried again" if problems else None


@dataclass(frozen=True)
class OnLink:
    """The options by which a command finds its vehicle on a link."""

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
        from vencejo import Station

        link = real_link(self.link)
        with Station(link, rate_hz=rate_hz, record=record, forward_to=forward or ()) as station:
            with status(f"Waiting for a vehicle on {link} …"), told_when_long(lambda: why_not_up(station)):
                vehicle = station.wait_vehicle(self.system, timeout_s=self.timeout)
            with recording_told(station):
                yield vehicle


_FAR: Final = "An aircraft of a fleet, instead of one on a link"


@dataclass(frozen=True)
class OnVehicle(OnLink):
    """The options by which a command finds its vehicle, on a link or in a fleet."""

    plane: Annotated[
        str | None,
        typer.Option("--plane", metavar="NAME", help="Name of the aircraft.", rich_help_panel=_FAR),
    ] = None
    fleet: Annotated[
        str | None,
        typer.Option(
            "--fleet",
            metavar="ORG",
            help="Its fleet; by default the only one of this computer.",
            rich_help_panel=_FAR,
        ),
    ] = None
    fleet_router: Annotated[
        str | None,
        typer.Option(
            "--fleet-router",
            metavar="ADDRESS",
            help="The fleet's router; by default the one on this machine, else those known here.",
            rich_help_panel=_FAR,
        ),
    ] = None
    take_control: Annotated[
        bool,
        typer.Option(
            "--take-control",
            help="Act although somebody has control: in this same ground station, or an operator if this one is a chief.",
            rich_help_panel=_FAR,
        ),
    ] = False

    @contextlib.contextmanager
    def vehicle(
        self, *, rate_hz: float = 10.0, record: bool = False, forward: list[str] | None = None
    ) -> Iterator[Vehicle]:
        """As on a link; an aircraft of a fleet is recorded on board, and sends at the rate that its network carries.

        Raises
        ------
        LinkError, NoVehicleError
        Failed
            When the options do not fit, the fleet is not reached, or somebody else has control.
        """
        if self.fleet is None and self.plane is None:
            if self.fleet_router is not None or self.take_control:
                raise Failed(
                    "--fleet-router and --take-control are for an aircraft of a fleet: add --plane", Exit.USAGE
                )
            with super().vehicle(rate_hz=rate_hz, record=record, forward=forward) as vehicle:
                yield vehicle
            return
        # The variable is for commands that name nothing.
        if self.link not in (DEFAULT_LINK, os.environ.get("VENCEJO_LINK")) or self.system is not None or forward:
            raise Failed("--link, --system and --forward are for a vehicle on a link, not of a fleet", Exit.USAGE)
        from vencejo.cli.far import far_vehicle

        with far_vehicle(
            self.fleet,
            self.plane,
            router=self.fleet_router,
            timeout_s=self.timeout,
            take_control=self.take_control,
        ) as vehicle:
            yield vehicle
