"""The command `vencejo serve`: the ground station in the browser."""

from __future__ import annotations

import contextlib
import sys
import threading
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, TypeAlias

import typer

from vencejo.cli.camera import CameraOption, for_ice, served_cameras
from vencejo.cli.common import (
    Exit,
    Failed,
    ForwardOption,
    HistoryOption,
    JsonOption,
    RecordOption,
    grouped,
    put_json,
    say,
    told_when_long,
    warn_of_open_key,
)
from vencejo.cli.connecting import RECORDED_AGAIN, why_not_up
from vencejo.cli.fleet import joined
from vencejo.cli.ice import IceOptions, ice_server, tell_ice
from vencejo.cli.listening import ListenOption, default_link
from vencejo.cli.replaying import parted, replayed
from vencejo.cli.ros import ROUTER, Ros2News, Ros2Options

if TYPE_CHECKING:
    from vencejo.fleet import Fleet
    from vencejo.serve import Server
    from vencejo.station import Station
    from vencejo.storage import StorageProblem

ON_BOARD_COMPONENT: Final = 191
"""`MAV_COMP_ID_ONBOARD_COMPUTER`: who we are on board a vehicle."""


def floor_option(name: str, what: str, default_mb: int) -> Any:
    """The option of one floor of free space."""
    text = f"Free disk space, MB, below which no {what} is written; default {default_mb}."
    return typer.Option(name, metavar="MB", min=0, max=10_000_000, help=text)


AGAIN: Final = {
    "telemetry": RECORDED_AGAIN,
    "maps": "Maps are kept again",
    "video": "Camera '{name}' is recorded again",
    "draft": "The plan's draft is kept again",
}
"""Said when the disk works again."""


@grouped
def serve(
    link: Annotated[
        list[str] | None,
        typer.Option(
            "--link",
            "-l",
            metavar="LINK",
            envvar="VENCEJO_LINK",
            help="Link to vehicles, such as udpin:0.0.0.0:14550 or /dev/ttyACM0,115200; repeatable. By default UDP port 14550: "
            "see --listen.",
        ),
    ] = None,
    listen: ListenOption = None,
    host: Annotated[
        str, typer.Option("--host", metavar="ADDRESS", help="Address to listen on; 0.0.0.0 lets other machines in.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="0 takes a free one.")] = 8765,
    token: Annotated[bool, typer.Option("--token", help="Demand a token on a loopback address too.")] = False,
    allow_host: Annotated[
        list[str] | None,
        typer.Option("--allow-host", metavar="NAME", help="A name of this machine that browsers use; repeatable."),
    ] = None,
    allow_origin: Annotated[
        list[str] | None,
        typer.Option(
            "--allow-origin",
            metavar="ORIGIN",
            help="Another page's origin that may use the API, such as https://plane.example; repeatable.",
        ),
    ] = None,
    cert: Annotated[
        Path | None, typer.Option("--cert", metavar="FILE", help="Certificate chain (PEM), for TLS.")
    ] = None,
    key: Annotated[Path | None, typer.Option("--key", metavar="FILE", help="Its key (PEM).")] = None,
    plain_http: Annotated[
        bool,
        typer.Option(
            "--plain-http",
            help="Let other machines in without TLS: anyone in the network can read the traffic, tokens included.",
        ),
    ] = False,
    rate: Annotated[
        float, typer.Option("--rate", metavar="HZ", min=4.0, max=50.0, help="Rate at which vehicles send their state.")
    ] = 10.0,
    on_board: Annotated[
        int | None,
        typer.Option(
            "--on-board",
            metavar="SYSTEM",
            min=1,
            max=255,
            help="Run as companion computer of this vehicle: send heartbeats only while an operator is connected.",
        ),
    ] = None,
    maps: Annotated[
        Path | None,
        typer.Option(
            "--maps", metavar="FOLDER", help="Folder of map sources and their cache; by default in the data folder."
        ),
    ] = None,
    open_browser: Annotated[bool, typer.Option("--open", help="Open a browser on this machine.")] = False,
    record: RecordOption = True,
    maps_floor: Annotated[int | None, floor_option("--maps-floor", "maps", 2000)] = None,
    video_floor: Annotated[int | None, floor_option("--video-floor", "video", 1000)] = None,
    telemetry_floor: Annotated[int | None, floor_option("--telemetry-floor", "telemetry", 500)] = None,
    forward: ForwardOption = None,
    fleet: Annotated[
        str | None,
        typer.Option(
            "--fleet",
            metavar="ORG",
            help="Show the aircraft of this organisation, which `vencejo onboard` connects over a network.",
        ),
    ] = None,
    join: Annotated[
        str | None,
        typer.Option(
            "--join",
            metavar="TOKEN",
            help="Join another ground station's fleet with a token of `vencejo fleet enrol --station`; afterwards --fleet alone.",
        ),
    ] = None,
    fleet_listen: Annotated[
        str | None,
        typer.Option(
            "--fleet-listen",
            metavar="ADDRESS",
            help="Address that aircraft of the fleet dial: tls/0.0.0.0:7447 once `vencejo fleet init` has made certificates, also "
            "quic/…; before, tcp/127.0.0.1:7447. Port 0 takes a free one. With --fleet-router both routers are linked.",
        ),
    ] = None,
    fleet_door: Annotated[
        str | None,
        typer.Option(
            "--fleet-door",
            metavar="HOST:PORT",
            help="Address where aircraft join the fleet with a token; by default port 7448 of the address that they dial.",
        ),
    ] = None,
    fleet_router: Annotated[
        list[str] | None,
        typer.Option(
            "--fleet-router",
            metavar="ADDRESS",
            help="Another router of the fleet to use, instead of being one; known already after joining with a token. "
            "Repeatable: tried in turn. With --fleet-listen, or enrolled as a router, it is linked with all of them.",
        ),
    ] = None,
    history: HistoryOption = True,
    camera: CameraOption = None,
    *,
    ros: Ros2Options,
    ice: IceOptions,
    json: JsonOption = False,
) -> None:
    """Serve the ground station to browsers until Ctrl-C.

    On this machine everybody may use it. With another address, such as --host 0.0.0.0, browsers need a token: it is
    made at the first start, kept in the data folder, and shown with its whole address and a QR code. It also needs TLS
    (--cert, --key), or to be told to do without it (--plain-http).

    Without --link, vehicles are heard on UDP port 14550. Who may send there is asked at the first start and kept; where
    nobody can be asked it is this machine alone. --listen machine, network (and the private networks that this machine
    is in) or everyone says it without being asked.

    Example: vencejo serve --link udpin:0.0.0.0:14550

    Example: vencejo serve --listen network

    Example: vencejo serve --link /dev/ttyACM0,115200 --host 0.0.0.0 --plain-http

    A recording given as a link, tlog:flight.tlog?speed=2, appears as a vehicle of its own, with pause, speed and seeking.

    Example: vencejo serve --fleet acme

    Example: vencejo serve --join vf1.CiBj...

    Example: vencejo serve --ros2

    Example: vencejo serve --camera nose=/dev/video0 --camera belly=rtsp://192.168.1.10/live
    """
    from vencejo import Floors, Station
    from vencejo.enrolment import Organisation, station_file
    from vencejo.serve import Server

    router = ros.router()
    if join is not None:
        found = joined(join, as_station=True)
        if fleet not in (None, found.org):
            raise Failed(f"the token is of the fleet {found.org}: leave out --fleet {fleet}", Exit.USAGE)
        fleet = found.org
    if fleet is None and (fleet_listen, fleet_door, fleet_router or None) != (None, None, None):
        raise Failed("--fleet-listen, --fleet-door and --fleet-router are for --fleet ORG or --join TOKEN", Exit.USAGE)
    if (
        fleet is not None
        and fleet_listen is None
        and not fleet_router
        and ros.is_at_default
        and (Organisation(fleet).exists or not station_file(fleet).is_file())
    ):
        raise Failed(
            f"--ros2 looks for the router of ROS 2 at {ROUTER}, where that of the fleet would be: give one of them "
            "another port, with --fleet-listen tls/0.0.0.0:7449 (aircraft dial it) or --ros2-router tcp/127.0.0.1:7450",
            Exit.USAGE,
        )
    if listen is not None and link:
        raise Failed("--listen is for the default link: leave it out, or --link (VENCEJO_LINK)", Exit.USAGE)
    given = {"maps_mb": maps_floor, "video_mb": video_floor, "telemetry_mb": telemetry_floor}
    floors = Floors(**{name: mb for name, mb in given.items() if mb is not None})

    settings = ice.settings()
    system_id, component_id = (255, 190) if on_board is None else (on_board, ON_BOARD_COMPONENT)
    warn_of_open_key(key)
    # What is forwarded goes over links.
    live, recordings = (link or [], []) if forward else parted(link or [])
    with (
        Station(
            *(live if link else [default_link(listen, ask=not json)]),
            system_id=system_id,
            component_id=component_id,
            rate_hz=rate,
            heartbeat=on_board is None,
            record=record,
            forward_to=forward or (),
            floors=floors,
        ) as station,
        Server(
            station,
            host=host,
            port=port,
            # Letting other machines in over Ice needs tokens here too.
            tokens=token or (settings is not None and settings.lets_others_in),
            allow_hosts=allow_host or (),
            allow_origins=allow_origin or (),
            certificate=cert,
            key=key,
            plain_http=plain_http,
            on_board=on_board is not None,
            maps_folder=maps,
            floors=floors,
        ) as server,
        replayed(station, recordings),
        joined_fleet(station, fleet, listen=fleet_listen, door=fleet_door, router=fleet_router, history=history) as far,
        ros.gateway(station, router) as gateway,
        served_cameras(server, camera, floors) as cameras,
        ice_server(station, settings, lambda: server.tokens, **for_ice(cameras)) as interfaces,
    ):
        tell(server, json=json, ice=None if interfaces is None else interfaces.proxies, fleet=far)
        if open_browser:
            open_page(server)
        with told_when_long(lambda: why_not_up(station)):
            wait(server, Ros2News(gateway), FleetNews(far))


def joined_fleet(
    station: Station, org: str | None, *, listen: str | None, door: str | None, router: list[str] | None, history: bool
) -> contextlib.AbstractContextManager[Fleet | None]:
    """The fleet to join; ``None`` without an organisation."""
    if org is None:
        return contextlib.nullcontext()
    from vencejo.fleet import Fleet

    if door is None:
        # Unless it is a router, it listens on all its addresses.
        host = "0.0.0.0" if listen is None else listen.partition("/")[2].rpartition(":")[0]
        door = f"{host}:7448"
    # Its people come before the scripts beside it; after a crash, what it had need not run out first.
    return Fleet(station, org=org, listen=listen, door=door, router=router, overrules=True, history=history)


def tell(
    server: Server, *, json: bool = False, ice: Mapping[str, str] | None = None, fleet: Fleet | None = None
) -> None:
    """Say where the server is: a line of JSON, or addresses with their tokens and a QR code."""
    from vencejo.serve import has_app

    tokens = server.tokens
    operator = with_token(server.urls[0], tokens.operator if tokens else None)
    if json:
        viewer = with_token(server.urls[0], tokens.viewer if tokens else None)
        put_json(
            {
                "url": server.url,
                "operator_url": operator,
                "viewer_url": viewer,
                "has_app": has_app(),
                **({"ice": ice} if ice else {}),
                **({"fleet": {"endpoint": fleet.endpoint, "key": fleet.key, "door": fleet.door}} if fleet else {}),
            }
        )
        return
    if not has_app():
        say("The pages are not in this build; the API is: see /api/v1/openapi.json")
    if tokens is None:
        print(f"The ground station is at {server.url}", flush=True)
    else:
        print(f"To command:  {operator}")
        print(f"To look:     {with_token(server.urls[0], tokens.viewer)}")
        for url in server.urls[1:]:
            print(f"Also at:     {url}")
        print(qr_code(operator), end="", flush=True)
    tell_ice(ice)
    if fleet is not None:
        from vencejo.enrolment import member, station_file

        place = member(file=station_file(fleet.org))
        if fleet.door is None and place is not None:
            print(
                f"This is {place.name} of the fleet {fleet.org}, as {place.role}; its router is at {fleet.endpoint}",
                flush=True,
            )
        elif fleet.door is None:
            print(f"Aircraft dial {fleet.endpoint} and trust this station with: --trust {fleet.key}", flush=True)
        else:
            print(
                f"The fleet's router is at {fleet.endpoint}; bring an aircraft in with: vencejo fleet enrol NAME",
                flush=True,
            )
    say("Ctrl-C ends it.")


def with_token(url: str, token: str | None) -> str:
    """The whole address. The token stands behind ``#``, which browsers keep to themselves."""
    return url + "/" if token is None else f"{url}/#token={token}"


def qr_code(text: str) -> str:
    """A QR code for the terminal: two modules a character, dark on light whatever the terminal's colours are."""
    import io

    import segno

    out = io.StringIO()
    segno.make(text, error="l", micro=False).terminal(out=out, compact=True, border=2)
    shown = out.getvalue()
    encoding = sys.stdout.encoding or "ascii"
    try:
        shown.encode(encoding)
    except UnicodeEncodeError:
        return ""  # a terminal without block characters
    return shown


def open_page(server: Server) -> None:
    """Open the page in a browser here, if there is one."""
    import webbrowser

    tokens = server.tokens
    with contextlib.suppress(webbrowser.Error):
        webbrowser.open(with_token(server.url, tokens.operator if tokens else None))


class FleetNews:
    """Reports changes of the connection to a fleet."""

    def __init__(self, fleet: Fleet | None) -> None:
        self._fleet = fleet
        self._told: str | None = None

    def tell(self) -> None:
        """Report on standard error what has changed since the last call."""
        if self._fleet is None:
            return
        problem = self._fleet.status.problem
        if problem != self._told:
            say("In the fleet" if problem is None else f"Not in the fleet: {problem}")
        self._told = problem


def wait(server: Server, *news: Ros2News | FleetNews) -> None:
    """Wait for Ctrl-C or SIGTERM, and report faults of the disk, of ROS 2 and of the fleet as they come."""
    forever = threading.Event()
    told: Told = {}
    with contextlib.suppress(KeyboardInterrupt):
        while True:
            told = tell_storage(server.storage_problems, told)
            for each in news:
                each.tell()
            if forever.wait(0.5):
                return


Told: TypeAlias = dict[tuple[str, str | None], frozenset[str]]
"""Reported faults, by kind of storage and name of the camera or map source."""


def tell_storage(problems: Iterable[StorageProblem], told: Told) -> Told:
    """Report on standard error what is no longer stored, and what is stored again; returns the present faults."""
    now: Told = {}
    for problem in problems:
        key = (problem.what, problem.name)
        now[key] = now.get(key, frozenset()) | {problem.fault}
        if problem.fault not in told.get(key, ()):
            say(f"Warning: {problem.text}")
    for what, name in sorted(told.keys() - now.keys(), key=str):
        if what in AGAIN:
            say(AGAIN[what].format(name=name))
    return now
