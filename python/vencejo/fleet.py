"""Aircraft far away: a station on board tells where its plane is, and does what a ground station of the same fleet orders.

On the ground, `Fleet` makes every aircraft of an organisation a vehicle of a station, like one at a link. On board, `Aircraft`
speaks for the plane that the station hears. It alone decides who may act: one ground station at a time has control, orders are
signed, done at most once, and mean nothing once somebody else has control. Whoever acts on board comes before all of them.

Over TLS or QUIC both ends show certificates of the fleet's own authority (`vencejo.enrolment`); in the clear, addresses are of this
machine alone.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from vencejo import _native
from vencejo._closing import Closing
from vencejo._forking import belongs_here
from vencejo.enrolment import Organisation, default_key_file, native
from vencejo.enrolment import member_file as default_member_file
from vencejo.station import Station, default_history_dir

__all__ = ["Aircraft", "AircraftStatus", "FarAircraft", "Fleet", "default_key_file", "has_fleet"]

BOARD_HISTORY_MB = 256
"""What an aircraft's history may take on board, MB: a day with an operator, a week without."""
GROUND_HISTORY_MB = 4096
"""The same of all aircraft's on the ground."""


def has_fleet() -> bool:
    """Whether this build can join fleets; wheels can."""
    return hasattr(_native, "FleetGround")


@dataclass(frozen=True, kw_only=True)
class AircraftStatus:
    """How it goes on board.

    Attributes
    ----------
    is_connected : bool
        Whether a router is reached.
    problem : str or None
        What the network said when it was not, or why it may hear nothing.
    holder : str or None
        Who has control of the plane, near or far.
    rate_hz : float
        How often the plane's state is told.
    certificate_ends : datetime or None
        When its certificate ends (UTC); it is renewed 30 days before. ``None`` in the clear.
    """

    is_connected: bool
    problem: str | None
    holder: str | None
    rate_hz: float
    certificate_ends: datetime | None


class Aircraft(Closing):
    """The plane that a station on board hears, in a fleet.

    From now on the station's heartbeat goes out only while somebody has control: the autopilot's ground-station failsafe counts
    it. Close it, or use it in a ``with`` statement, inside that of its station.

    Parameters
    ----------
    station : Station
        A station on board: MAVLink component 191 of the vehicle's system id.
    org, name : str, optional
        The organisation, and the plane's name there: 1 to 32 of ``a-z``, ``0-9`` and ``-``. By default those of the fleet that this
        computer has joined (`vencejo.enrolment.join`).
    dial : str or iterable of str, optional
        Where the fleet's router is, such as ``"tls/ground.local:7447"``. It is dialled for ever; of several, the next when one is gone. By
        default those that it was told of when it joined; else ``"tcp/127.0.0.1:7447"``.
    trust, chiefs : iterable of str, optional
        Public keys of ground stations whose orders it takes, beside those on its fleet's list; those of ``chiefs`` may take control
        from the others at once. Without any, it only tells where it is.
    uplink_kbit_s : float, optional
        What the uplink carries, where that is known: states fill 60 % of it at most.
    history : bool or path, optional
        Whether what it tells and is ordered is kept on this computer's disk, and where: by default in `default_history_dir`, within
        `history_mb`. What a ground station did not hear it fetches from there later.
    history_mb : float, optional
        What that may take, MB; 256 by default. The oldest is deleted to make room.
    history_frames : bool, optional
        Whether every MAVLink message of the autopilot is kept there too; not by default.
    member_file : path, optional
        Where this computer's place in a fleet is kept, with its certificate; by default in the data folder.

    Raises
    ------
    InvalidRequest
        For a name, a key or an address that cannot be; for an encrypted address without a certificate.
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
        """How it goes."""
        is_connected, problem, holder, rate_hz, ends = self._native.status()
        return AircraftStatus(
            is_connected=is_connected,
            problem=problem,
            holder=holder,
            rate_hz=rate_hz,
            certificate_ends=None if ends is None else datetime.fromtimestamp(ends, timezone.utc),
        )

    def close(self) -> None:
        """Leave the fleet."""
        self._native.close()


def _addresses(given: str | Iterable[str] | None) -> list[str]:
    return [given] if isinstance(given, str) else list(given or ())


def _history(where: bool | str | Path, mb: float, side: str, *more: bool) -> tuple[Any, ...] | None:
    """Where a history is kept, and within how many bytes; ``None``: nowhere."""
    if where is False:
        return None
    folder = default_history_dir() / side if where is True else Path(where)
    return (folder, int(mb * 1_000_000), *more)


@dataclass(frozen=True, kw_only=True)
class FarAircraft:
    """An aircraft of a fleet, as a ground station sees it.

    Attributes
    ----------
    name : str
    system_id : int or None
        By which its vehicle is known in this station, from 256 to 65,535; ``None`` before it has said anything.
    is_present : bool
        Whether the station on board is reachable, as far as the network knows; a cut is known some seconds later.
    age_s : float
        Time since it said something.
    holder, asking : str or None
        Who has control of it, and who asks for that.
    """

    name: str
    system_id: int | None
    is_present: bool
    age_s: float
    holder: str | None
    asking: str | None


class Fleet(Closing):
    """A ground station of a fleet: each aircraft is a vehicle of its station.

    Control of an aircraft is asked for with the first act on it, kept while an operator of the station has control, and given up
    then. Close it, or use it in a ``with`` statement, inside that of its station.

    Parameters
    ----------
    station : Station
        Where the aircraft appear.
    org : str
        The organisation.
    listen : str, optional
        Where it is a router of the fleet; with port 0 a free one is taken (`endpoint`). By default ``"tls/0.0.0.0:7447"`` where the fleet's
        authority is on this machine; else ``"tcp/127.0.0.1:7447"``, but where this machine has joined the fleet by a token: then only if that was for a router
        (`Organisation.enrol_station`), at the port that was said there.
    router : str or iterable of str, optional
        Another router that it uses, in place of being one; of several, the next when one is gone. With `listen`, or where it was enrolled as a
        router, it is linked with all of them instead. By default, where it has joined by a token, those of the fleet's list.
    door : str, optional
        Where aircraft join with a token and get their next certificate, such as ``"0.0.0.0:7448"``; nowhere by default, nor in the
        clear.
    key_file : path, optional
        Its own key; made where there is none.
    history : bool or path, optional
        Whether what is heard of the aircraft is kept here, and where: by default in `default_history_dir`, within `history_mb`. What was
        not heard is fetched when an aircraft is there again.
    history_mb : float, optional
        What that may take, MB; 4,096 by default. The oldest is deleted to make room.
    folder : path, optional
        Where fleets' authorities are; by default in the data folder.

    Raises
    ------
    InvalidRequest
        For a name or an address that cannot be; for an encrypted address without certificates.
    LinkError
        When the address is taken, or the router is not reached.
    """

    def __init__(
        self,
        station: Station,
        *,
        org: str,
        listen: str | None = None,
        router: str | Iterable[str] | None = None,
        door: str | None = None,
        key_file: str | Path | None = None,
        history: bool | str | Path = True,
        history_mb: float = GROUND_HISTORY_MB,
        folder: str | Path | None = None,
    ) -> None:
        self.org = org
        organisation = Organisation(org, folder=folder)
        has_joined = organisation.folder.with_suffix(".json").is_file()
        if listen is None and not router and (organisation.exists or not has_joined):
            listen = "tls/0.0.0.0:7447" if organisation.exists else "tcp/127.0.0.1:7447"
        self._native = native("FleetGround")(
            station._native,
            org=org,
            listen=listen,
            dial=_addresses(router),
            door=door,
            key_file=default_key_file(org) if key_file is None else Path(key_file),
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
        names = ("name", "system_id", "is_present", "age_s", "holder", "asking")
        return [FarAircraft(**dict(zip(names, far, strict=True))) for far in self._native.aircraft()]

    def close(self) -> None:
        """Leave the fleet; control that it has of aircraft is given up."""
        self._native.close()
