"""The command `vencejo onboard`: a station on board, for those who are far away."""

from __future__ import annotations

import contextlib
import threading
from dataclasses import dataclass
from datetime import datetime, timezone
from typing import TYPE_CHECKING, Annotated, Final, TypeAlias

import typer

from vencejo.cli.aboard import LinkNote, PlaneLinks, without_counts
from vencejo.cli.common import (
    UNREAD,
    Exit,
    Failed,
    ForwardOption,
    HistoryOption,
    JsonOption,
    RecordOption,
    grouped,
    put_json,
    say,
)
from vencejo.cli.fleet import joined
from vencejo.cli.ros import Ros2News, Ros2Options
from vencejo.cli.serve import ON_BOARD_COMPONENT

if TYPE_CHECKING:
    from vencejo.fleet import AircraftStatus

WARN_DAYS: Final = 20
"""Days before expiry at which a warning is printed; renewal is tried from 30 days on."""


@grouped
def onboard(
    link: Annotated[
        list[str] | None,
        typer.Option(
            "--link",
            "-l",
            metavar="LINK",
            envvar="VENCEJO_LINK",
            help="Link to the autopilot, such as /dev/serial0,921600.",
        ),
    ] = None,
    join: Annotated[
        str | None,
        typer.Option(
            "--join",
            metavar="TOKEN",
            help="Join the fleet with a token of `vencejo fleet enrol`; not needed again once joined.",
        ),
    ] = None,
    fleet: Annotated[
        str | None,
        typer.Option(
            "--fleet",
            metavar="ORG",
            help="Organisation of the fleet; by default the one that was joined.",
        ),
    ] = None,
    name: Annotated[
        str | None, typer.Option("--name", metavar="NAME", help="The plane's name there: 1 to 32 of a-z, 0-9 and '-'.")
    ] = None,
    plane: Annotated[
        list[str] | None,
        typer.Option(
            "--plane",
            metavar="NAME[@SYSTEM]=LINK",
            help="One of several planes of this computer, each with its own link, instead of --name, --system and --link; only "
            "without certificates. Repeatable.",
        ),
    ] = None,
    dial: Annotated[
        list[str] | None,
        typer.Option(
            "--dial",
            metavar="ADDRESS",
            help="Address of the fleet's router, dialled for ever; by default those received on joining, else "
            "tcp/127.0.0.1:7447. Repeatable: tried in turn.",
        ),
    ] = None,
    trust: Annotated[
        list[str] | None,
        typer.Option(
            "--trust",
            metavar="KEY",
            help="Key of a ground station whose orders are accepted, beside those on the fleet's list; `vencejo serve --fleet` shows it. Repeatable.",
        ),
    ] = None,
    chief: Annotated[
        list[str] | None,
        typer.Option(
            "--chief", metavar="KEY", help="As --trust, for one that may take control from the others at once."
        ),
    ] = None,
    uplink: Annotated[
        float | None,
        typer.Option(
            "--uplink",
            metavar="KBIT",
            min=1.0,
            max=1_000_000.0,
            help="Capacity of the uplink, kbit/s; states fill 60 % of it at most.",
        ),
    ] = None,
    system: Annotated[
        int,
        typer.Option(
            "--system", metavar="ID", min=1, max=254, help="The vehicle's MAVLink system id, which is ours on board."
        ),
    ] = 1,
    rate: Annotated[
        float,
        typer.Option(
            "--rate", metavar="HZ", min=4.0, max=50.0, help="Rate at which the autopilot sends its state on board."
        ),
    ] = 10.0,
    *,
    ros: Ros2Options,
    record: RecordOption = True,
    history: HistoryOption = True,
    history_frames: Annotated[
        bool, typer.Option("--history-frames", help="Store every MAVLink message of the autopilot there as well.")
    ] = False,
    forward: ForwardOption = None,
    json: JsonOption = False,
) -> None:
    """Bring a plane into a fleet: on its companion computer, until Ctrl-C.

    It dials out and listens nowhere. What it tells is where the plane is; what it takes are signed orders of the ground
    stations that it trusts, one of which at a time has control. The autopilot hears of a ground station only while one
    has.

    The way is encrypted, and both ends show certificates of the fleet's own authority. With --fleet, --name, --dial and
    --trust it goes without, to a router of this machine alone: bring that here with a tunnel, such as ssh -L
    7447:127.0.0.1:7447 ground.

    Example: vencejo onboard --join vf1.CiBj... --link /dev/serial0,921600

    Example: vencejo onboard --link /dev/serial0,921600

    Example: vencejo onboard --fleet acme --name plane7 --link /dev/serial0,921600 --trust 3b6a27bc...

    Example: vencejo onboard --fleet try --plane plane1@1=tcp:127.0.0.1:5760 --plane plane2@2=tcp:127.0.0.1:5761 --trust 3b6a27bc...
    """
    from vencejo import Station
    from vencejo.enrolment import member
    from vencejo.fleet import Aircraft
    from vencejo.station import default_history_dir

    if plane:
        planes = [plane_of(text, system) for text in plane]
        if fleet is None or name is not None or link or join is not None or ros.ros2:
            raise Failed(
                "--plane is with --fleet, and without --name, --link, --join and --ros2: each plane has its own",
                Exit.USAGE,
            )
        if len({each.name for each in planes}) < len(planes):
            raise Failed("two planes have the same name: give each --plane its own", Exit.USAGE)
    elif not link:
        raise Failed("say where the autopilot is: --link /dev/serial0,921600", Exit.USAGE)
    else:
        planes = [Plane(name, system, tuple(link))]
        if (fleet is None) != (name is None):
            raise Failed(
                "a plane has a name in a fleet: give --fleet and --name, or neither once it has joined one", Exit.USAGE
            )
    router = ros.router()
    if join is not None:
        if fleet is not None:
            raise Failed("the token says which fleet and which name: leave out --fleet and --name", Exit.USAGE)
        joined(join, as_station=False)
    found = member()
    is_member = found is not None and not plane and fleet in (None, found.org) and name in (None, found.name)
    if not is_member and fleet is None:
        raise Failed(
            "this computer is in no fleet yet: --join TOKEN, which `vencejo fleet enrol NAME` gives on the ground",
            Exit.USAGE,
        )
    with contextlib.ExitStack() as aboard:
        heard: list[tuple[str | None, Aircraft]] = []
        news: list[Ros2News] = []
        note = aboard.enter_context(LinkNote())
        for each in planes:
            station = aboard.enter_context(
                Station(
                    *each.links,
                    system_id=each.system,
                    component_id=ON_BOARD_COMPONENT,
                    rate_hz=rate,
                    heartbeat=False,
                    record=record,
                    forward_to=forward or (),
                )
            )
            aircraft = aboard.enter_context(
                Aircraft(
                    station,
                    org=fleet,
                    name=each.name,
                    dial=dial,
                    trust=trust or (),
                    chiefs=chief or (),
                    uplink_kbit_s=uplink,
                    # Each folder has its own limit.
                    history=default_history_dir() / "board" / str(each.name) if history and plane else history,
                    history_frames=history_frames,
                )
            )
            heard.append((each.name if plane else None, aircraft))
            news.append(Ros2News(aboard.enter_context(ros.gateway(station, router))))
        if not (trust or chief or json or is_member):
            say("It takes no orders: no --trust. It only tells where the plane is.")
        told: dict[str | None, Told] = {}
        forever = threading.Event()
        with contextlib.suppress(KeyboardInterrupt):
            while True:
                links: list[PlaneLinks] = []
                for each, (called, aircraft) in zip(planes, heard, strict=True):
                    status = aircraft.status
                    told[called] = tell_status(status, told.get(called), json=json, name=called)
                    links.append(PlaneLinks.of(each.name, each.links, status))
                note.write(links)
                for each_news in news:
                    each_news.tell()
                if forever.wait(0.5):
                    return


@dataclass(frozen=True)
class Plane:
    """A plane that this computer speaks for."""

    name: str | None
    system: int
    links: tuple[str, ...]


def plane_of(text: str, system: int) -> Plane:
    """A plane as it stands in --plane; of that system where it says none."""
    called, separator, link = text.partition("=")
    name, at, number = called.partition("@")
    if not (name and separator and link) or (at and not (number.isdecimal() and 1 <= int(number) <= 254)):
        raise Failed(
            f"--plane {text}: write NAME=LINK or NAME@SYSTEM=LINK, with a system id from 1 to 254, such as "
            "plane7@2=tcp:127.0.0.1:5761",
            Exit.USAGE,
        )
    return Plane(name, int(number) if at else system, (link,))


Told: TypeAlias = tuple[bool, str | None, frozenset[str], str | None]
"""The state last reported: whether it is in the fleet, who has control, the problems (while it is not, one of each
router), and the links of a silent autopilot without their counts."""


def tell_status(status: AircraftStatus, told: Told | None, *, json: bool, name: str | None = None) -> Told:
    """Report changes, with the plane's name if there are several; returns the present state."""
    problems = frozenset({status.problem} if status.problem else ())
    if told is not None and not told[0] and not status.is_connected:
        problems |= told[2]
    now = (status.is_connected, status.holder, problems, without_counts(status.links))
    if now == told:
        return now
    of = "" if name is None else f"{name}: "
    if json:
        called = {} if name is None else {"name": name}
        # A closed output does not end the membership.
        with contextlib.suppress(*UNREAD):
            put_json(
                {
                    **called,
                    "is_connected": status.is_connected,
                    "holder": status.holder,
                    "problem": status.problem,
                    "autopilot_silent_s": status.autopilot_silent_s,
                    "links": status.links,
                }
            )
        return now
    if told is None or now[:3] != told[:3]:
        if not status.is_connected:
            say(f"{of}Not in the fleet yet{'' if status.problem is None else f': {status.problem}'}")
        elif status.problem is not None:
            say(f"{of}Warning: {status.problem}")
        else:
            say(f"{of}In the fleet. Control: {status.holder or 'nobody'}")
            if told is None or not told[0]:
                warn_of_end(status.certificate_ends)
    was_silent = told is not None and told[3] is not None
    if status.autopilot_silent_s is not None and (told is None or now[3] != told[3]):
        say(f"{of}Warning: no message of the autopilot for {status.autopilot_silent_s:.0f} s: {status.links}")
    elif status.autopilot_silent_s is None and was_silent:
        say(f"{of}The autopilot is heard.")
    return now


def warn_of_end(ends: datetime | None) -> None:
    """Say when the certificate ends soon: it should have been renewed."""
    left_days = 90 if ends is None else (ends - datetime.now(timezone.utc)).days
    if left_days < WARN_DAYS:
        say(f"Warning: its certificate ends in {left_days} days, and was not renewed; see: vencejo fleet doctor")
