"""Fleets of remote aircraft: a station on board reports its plane's state and executes orders of the fleet's ground stations.

On the ground, `Fleet` makes every aircraft of an organisation a vehicle of a station, like one on a link. On board,
`Aircraft` represents the plane that the station hears. The aircraft alone decides who may act: one ground station at a
time has control; orders are signed, executed at most once, and void once another station has control. Operators on
board take precedence.

Over TLS or QUIC both ends show certificates of the fleet's own authority (`vencejo.enrolment`). Unencrypted addresses
have to be on this machine.
"""

from __future__ import annotations

import re
import socket
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from vencejo import _native
from vencejo._closing import Closing
from vencejo._forking import belongs_here
from vencejo.enrolment import Organisation, default_key_file, member, native
from vencejo.enrolment import member_file as default_member_file
from vencejo.station import Station, default_history_dir

__all__ = [
    "Aircraft",
    "AircraftStatus",
    "FarAircraft",
    "Fleet",
    "FleetStatus",
    "default_key_file",
    "has_fleet",
    "router_here",
]

BOARD_HISTORY_MB = 256
"""Default size limit of an aircraft's history on board, MB: a day with an operator, a week without."""
GROUND_HISTORY_MB = 4096
"""Default size limit of all aircraft's histories on the ground, MB."""
_PORT = 7447
"""TCP port of a router without encryption."""


def has_fleet() -> bool:
    """Whether this build supports fleets, as wheels do."""
    return hasattr(_native, "FleetGround")


@dataclass(frozen=True, kw_only=True)
class AircraftStatus:
    """State of an aircraft's membership, on board.

    Attributes
    ----------
    is_connected : bool
        Whether it is connected to a router.
    problem : str or None
        Why it is not connected, or why it may receive nothing.
    holder : str or None
        Who has control of the plane, on board or on the ground.
    rate_hz : float
        Rate at which the plane's state is sent.
    certificate_ends : datetime or None
        When its certificate expires (UTC); it is renewed 30 days before. ``None`` without encryption.
    autopilot_silent_s : float or None
        Time since the autopilot was last heard, or since the start if it never was; ``None`` below 5 s.
    links : str or None
        The station's links and their states, in words, while the autopilot is silent.
    """

    is_connected: bool
    problem: str | None
    holder: str | None
    rate_hz: float
    certificate_ends: datetime | None
    autopilot_silent_s: float | None
    links: str | None


class Aircraft(Closing):
    """The plane of a station on board, as a member of a fleet.

    From now on the station's heartbeat is sent only while an operator has control, because the autopilot's
    ground-station failsafe monitors it. Close it, or use it in a ``with`` statement, inside that of its station.

    Parameters
    ----------
    station : Station
        A station on board: MAVLink component 191 of the vehicle's system id.
    org, name : str, optional
        The organisation, and the plane's name there: 1 to 32 of ``a-z``, ``0-9`` and ``-``. By default those of the
        fleet that this computer has joined (`vencejo.enrolment.join`).
    dial : str or iterable of str, optional
        Addresses of the fleet's routers, such as ``"tls/ground.local:7447"``. They are dialled for ever, one after the
        other. Default: those received on joining, else ``"tcp/127.0.0.1:7447"``.
    trust, chiefs : iterable of str, optional
        Public keys of ground stations whose orders are accepted, beside those on the fleet's list; ``chiefs`` may take
        control from the others at once. Without any, it only reports its state.
    uplink_kbit_s : float, optional
        Capacity of the uplink, if it is known: states fill 60 % of it at most.
    history : bool or path, optional
        Whether states, events and orders are stored on this computer, and where: by default in `default_history_dir`,
        within `history_mb`. Ground stations fetch from it later what they missed.
    history_mb : float, optional
        Size limit of the history, MB; default 256. The oldest files are deleted.
    history_frames : bool, optional
        Whether to store every MAVLink message of the autopilot too; default False.
    member_file : path, optional
        File of this computer's fleet membership, with its certificate; by default in the data folder.

    Raises
    ------
    InvalidRequest
        For an invalid name, key or address, and for an encrypted address without a certificate.
    VencejoError
        When the file is damaged.
    """

    def __init__(
        self,
        station: Station,
        *,
        org: str | None = None,
        name: str | None = None,
        dial: str | Iterable[str] | None = None,
        trust: Iterable[str] = (),
        chiefs: Iterable[str] = (),
        uplink_kbit_s: float | None = None,
        history: bool | str | Path = True,
        history_mb: float = BOARD_HISTORY_MB,
        history_frames: bool = False,
        member_file: str | Path | None = None,
    ) -> None:
        keys = [*((key, False) for key in trust), *((key, True) for key in chiefs)]
        uplink_bit_s = None if uplink_kbit_s is None else uplink_kbit_s * 1000
        self._native = native("FleetAircraft")(
            station._native,
            org=org,
            name=name,
            dial=_addresses(dial),
            trust=keys,
            uplink_bit_s=uplink_bit_s,
            member_file=default_member_file() if member_file is None else Path(member_file),
            history=_history(history, history_mb, "board", history_frames),
        )
        belongs_here(self)

    @property
    def status(self) -> AircraftStatus:
        """The present state."""
        is_connected, problem, holder, rate_hz, ends, silence = self._native.status()
        silent_s, links = silence or (None, None)
        return AircraftStatus(
            is_connected=is_connected,
            problem=problem,
            holder=holder,
            rate_hz=rate_hz,
            certificate_ends=None if ends is None else datetime.fromtimestamp(ends, timezone.utc),
            autopilot_silent_s=silent_s,
            links=links,
        )

    def close(self) -> None:
        """Leave the fleet."""
        self._native.close()


def router_here(org: str, *, folder: str | Path | None = None) -> str | None:
    """Address of the fleet's router on this machine, if a program is one, such as ``vencejo serve``; else ``None``.

    Parameters
    ----------
    org : str
        The organisation.
    folder : path, optional
        Folder of the fleets' authorities; by default in the data folder.

    Raises
    ------
    InvalidRequest
        For an invalid name.
    """
    organisation = Organisation(org, folder=folder)
    place = organisation.folder.with_suffix(".json")
    if organisation.exists:
        known = organisation.routers or ["tls/127.0.0.1:7447"]
        return _answering(known, organisation.problem_at)
    if (found := member(file=place)) is not None:
        return _answering(found.routers, lambda address: native("fleet_try")(address, place))
    try:
        socket.create_connection(("127.0.0.1", _PORT), timeout=1.0).close()
    except OSError:
        return None
    # Others listen there too, such as a router of ROS 2.
    here = f"tcp/127.0.0.1:{_PORT}"
    return here if native("fleet_router_answers")(here, org) else None


def _answering(routers: Iterable[str], problem_at: Callable[[str], str | None]) -> str | None:
    """The first of these routers that is on this machine, by its port."""
    here = dict.fromkeys(re.sub(r"/.*:", "/127.0.0.1:", router) for router in routers)
    return next((router for router in here if problem_at(router) is None), None)


def _addresses(given: str | Iterable[str] | None) -> list[str]:
    return [given] if isinstance(given, str) else list(given or ())


def _history(where: bool | str | Path, mb: float, side: str, *more: bool) -> tuple[Any, ...] | None:
    """Folder and size limit (bytes) of a history; ``None`` without one."""
    if where is False:
        return None
    folder = default_history_dir() / side if where is True else Path(where)
    return (folder, int(mb * 1_000_000), *more)


@dataclass(frozen=True, kw_only=True)
class FarAircraft:
    """A remote aircraft of a fleet, as a ground station sees it.

    Attributes
    ----------
    name : str
    system_id : int or None
        Id of its vehicle in this station, 256 to 65,535; ``None`` before its first message.
    is_present : bool
        Whether the station on board is connected; a broken connection is noticed some seconds later.
    age_s : float
        Time since its newest message.
    holder, asking : str or None
        Who has control of it, and who asks for control: the operator's name, after that of the ground station.
    autopilot_silent_s : float or None
        Time since the station on board last heard its autopilot; ``None`` below 5 s, and while the station on board is
        not heard either.
    links : str or None
        The links of the station on board and their states, in words, while the autopilot is silent.
    """

    name: str
    system_id: int | None
    is_present: bool
    age_s: float
    holder: str | None
    asking: str | None
    autopilot_silent_s: float | None
    links: str | None


@dataclass(frozen=True, kw_only=True)
class FleetStatus:
    """How a ground station is in the network of its fleet.

    Attributes
    ----------
    is_connected : bool
        Whether a router answers it; a router itself is always connected.
    problem : str or None
        Why it is not connected: no aircraft is heard then. A router is missed for 5 s before it is reported.
    """

    is_connected: bool
    problem: str | None


class Fleet(Closing):
    """A ground station of a fleet: each aircraft is a vehicle of its station.

    The first request to an aircraft takes control of it if it is free, and it is kept while an operator of the station
    has control. While another ground station has it, ask for it with `Vehicle.request_control`. Close it, or use it in a ``with`` statement, inside that of its station.

    Parameters
    ----------
    station : Station
        The station in which the aircraft appear.
    org : str
        The organisation.
    listen : str, optional
        Address to listen on as a router of the fleet; port 0 picks a free one (`endpoint`). Default: none if another
        program of this machine is a router of the fleet already (`router_here`), such as ``vencejo serve``: it is
        used, unless a `door` is opened. Else ``"tls/0.0.0.0:7447"`` if the fleet's authority is on this machine, or
        ``"tcp/127.0.0.1:7447"``. A machine that joined by a token listens only if the token was for a router
        (`Organisation.enrol_station`), on the port given there.
    router : str or iterable of str, optional
        Other routers to use instead of being one, tried one after the other. With `listen`, or if it was enrolled as a
        router, it is linked with all of them. Default, after joining by a token: those of the fleet's list.
    door : str, optional
        Address where aircraft join with a token and renew their certificate, such as ``"0.0.0.0:7448"``. Default: none;
        there is none without encryption.
    key_file : path, optional
        File of its own key; created if missing.
    overrules : bool, optional
        Whether it takes control of an aircraft, when it acts or asks, from those who have to yield: from another program
        with its key, and, if it is a chief, from an operator. ``vencejo serve`` does. A program that has
        lost control does so again only when it asks. Whom it took control from has it again when the program gives it
        up or ends, unless another asks for it. Programs with one key have control each for itself; that of one that was
        killed ends after 10 s.
    history : bool or path, optional
        Whether the aircraft's messages are stored here, and where: by default in `default_history_dir`, within
        `history_mb`. Missed ones are fetched when an aircraft is connected again.
    history_mb : float, optional
        Size limit of the histories, MB; default 4,096. The oldest files are deleted.
    folder : path, optional
        Folder of the fleets' authorities; by default in the data folder.

    Raises
    ------
    InvalidRequest
        For an invalid name or address, and for an encrypted address without certificates.
    LinkError
        When the address is in use, or the router cannot be reached.
    """

    _is_left = False

    def __init__(
        self,
        station: Station,
        *,
        org: str,
        listen: str | None = None,
        router: str | Iterable[str] | None = None,
        door: str | None = None,
        key_file: str | Path | None = None,
        overrules: bool = False,
        history: bool | str | Path = True,
        history_mb: float = GROUND_HISTORY_MB,
        folder: str | Path | None = None,
    ) -> None:
        self.org = org
        organisation = Organisation(org, folder=folder)
        place = organisation.folder.with_suffix(".json")
        if listen is None and not router and door is None and (here := router_here(org, folder=folder)) is not None:
            joined = None if organisation.exists else member(file=place)
            router = [here, *(joined.routers if joined else ())]
        if listen is None and not router and (organisation.exists or not place.is_file()):
            listen = "tls/0.0.0.0:7447" if organisation.exists else "tcp/127.0.0.1:7447"
        self._native = native("FleetGround")(
            station._native,
            org=org,
            listen=listen,
            dial=_addresses(router),
            door=door,
            key_file=default_key_file(org) if key_file is None else Path(key_file),
            overrules=overrules,
            folder=organisation.folder.parent,
            history=_history(history, history_mb, f"ground/{org}"),
        )
        belongs_here(self)

    @property
    def endpoint(self) -> str:
        """Where the network is joined: where aircraft dial, when this is the router."""
        return str(self._native.endpoint)

    @property
    def door(self) -> str | None:
        """Where aircraft join and get their next certificate, ``HOST:PORT`` here; ``None`` where that is closed."""
        door: str | None = self._native.door
        return door

    @property
    def key(self) -> str:
        """Its public key: what aircraft have to trust."""
        return str(self._native.key)

    @property
    def aircraft(self) -> list[FarAircraft]:
        """The aircraft that were heard of, by name."""
        names = ("name", "system_id", "is_present", "age_s", "holder", "asking", "autopilot_silent_s", "links")
        return [
            FarAircraft(**dict(zip(names, (*far, *(silence or (None, None))), strict=True)))
            for *far, silence in self._native.aircraft()
        ]

    @property
    def status(self) -> FleetStatus:
        """Whether it is connected to the fleet."""
        is_connected, problem = (False, "the fleet was left") if self._is_left else self._native.status()
        return FleetStatus(is_connected=is_connected, problem=problem)

    def close(self) -> None:
        """Leave the fleet; control that it has of aircraft is given up, and requests for it are withdrawn."""
        self._is_left = True
        self._native.close()
