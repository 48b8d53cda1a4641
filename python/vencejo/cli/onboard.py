"""The command `vencejo onboard`: a station on board, for those who are far away."""

from __future__ import annotations

import contextlib
import threading
from typing import TYPE_CHECKING, Annotated

import typer

from vencejo.cli.common import ForwardOption, JsonOption, RecordOption, put_json, say
from vencejo.cli.serve import ON_BOARD_COMPONENT

if TYPE_CHECKING:
    from vencejo.fleet import AircraftStatus


def onboard(
    fleet: Annotated[str, typer.Option("--fleet", metavar="ORG", help="The organisation whose fleet it is in.")],
    name: Annotated[
        str, typer.Option("--name", metavar="NAME", help="The plane's name there: 1 to 32 of a-z, 0-9 and '-'.")
    ],
    link: Annotated[
        list[str],
        typer.Option(
            "--link",
            "-l",
            metavar="LINK",
            envvar="VENCEJO_LINK",
            help="Where the autopilot is, such as /dev/serial0,921600.",
        ),
    ],
    dial: Annotated[
        str, typer.Option("--dial", metavar="ADDRESS", help="Where the fleet's router is; it is dialled for ever.")
    ] = "tcp/127.0.0.1:7447",
    trust: Annotated[
        list[str] | None,
        typer.Option(
            "--trust",
            metavar="KEY",
            help="Key of a ground station whose orders it takes; `vencejo serve --fleet` shows it. Repeatable.",
        ),
    ] = None,
    chief: Annotated[
        list[str] | None,
        typer.Option("--chief", metavar="KEY", help="The same for one that may take control from the others at once."),
    ] = None,
    uplink: Annotated[
        float | None,
        typer.Option(
            "--uplink",
            metavar="KBIT",
            min=1.0,
            max=1_000_000.0,
            help="What the uplink carries, kbit/s; states fill 60 % of it at most.",
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
            "--rate", metavar="HZ", min=4.0, max=50.0, help="How often the autopilot tells its state on board."
        ),
    ] = 10.0,
    record: RecordOption = True,
    forward: ForwardOption = None,
    json: JsonOption = False,
) -> None:
    """Bring a plane into a fleet: on its companion computer, until Ctrl-C.

    It dials out and listens nowhere. What it tells is where the plane is; what it takes are signed orders of the ground stations
    that it trusts, one of which at a time has control. The autopilot hears of a ground station only while one has.

    Nothing is encrypted yet, so the router's address is of this machine: bring it here with a tunnel, such as
    ssh -L 7447:127.0.0.1:7447 ground.

    Example: vencejo onboard --fleet acme --name plane7 --link /dev/serial0,921600 --trust 3b6a27bc...
    """
    from vencejo import Station
    from vencejo.fleet import Aircraft

    with (
        Station(
            *link,
            system_id=system,
            component_id=ON_BOARD_COMPONENT,
            rate_hz=rate,
            heartbeat=False,
            record=record,
            forward_to=forward or (),
        ) as station,
        Aircraft(
            station, org=fleet, name=name, dial=dial, trust=trust or (), chiefs=chief or (), uplink_kbit_s=uplink
        ) as aircraft,
    ):
        if not (trust or chief or json):
            say("It takes no orders: no --trust. It only tells where the plane is.")
        told: tuple[bool, str | None] | None = None
        forever = threading.Event()
        with contextlib.suppress(KeyboardInterrupt):
            while True:
                told = tell_status(aircraft.status, told, json=json)
                if forever.wait(0.5):
                    return


def tell_status(status: AircraftStatus, told: tuple[bool, str | None] | None, *, json: bool) -> tuple[bool, str | None]:
    """Say what is new; gives what holds now."""
    now = (status.is_connected, status.holder)
    if now == told:
        return now
    if json:
        put_json({"is_connected": status.is_connected, "holder": status.holder, "problem": status.problem})
    elif not status.is_connected:
        say(f"Not in the fleet yet: {status.problem or 'no plane is heard'}")
    else:
        say(f"In the fleet. Control: {status.holder or 'nobody'}")
    return now
