"""Aircraft far away: a station on board tells where its plane is, and does what a ground station of the same fleet orders.

On the ground, `Fleet` makes every aircraft of an organisation a vehicle of a station, like one at a link. On board, `Aircraft`
speaks for the plane that the station hears. It alone decides who may act: one ground station at a time has control, orders are
signed, done at most once, and mean nothing once somebody else has control. Whoever acts on board comes before all of them.

Nothing is encrypted yet, so addresses are of this machine alone; another machine is reached through a tunnel.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vencejo import _native
from vencejo._closing import Closing
from vencejo.errors import VencejoError
from vencejo.station import Station, default_record_dir

__all__ = ["Aircraft", "AircraftStatus", "FarAircraft", "Fleet", "default_key_file", "has_fleet"]


def has_fleet() -> bool:
    """Whether this build can join fleets; wheels can."""
    return hasattr(_native, "FleetGround")


def default_key_file(org: str) -> Path:
    """Where a ground station's own key is: ``fleet/ORG.key`` in the data folder, readable by its owner alone."""
    return default_record_dir().parent / "fleet" / f"{org}.key"


def _class(name: str) -> Any:
    if not has_fleet():
        raise VencejoError("this build of Vencejo has no fleets: build it with the feature `fleet`, or install a wheel")
    return getattr(_native, name)


@dataclass(frozen=True, kw_only=True)
class AircraftStatus:
    """How it goes on board.

    Attributes
    ----------
    is_connected : bool
        Whether a router is reached.
    problem : str or None
        What the network said when it was not.
    holder : str or None
        Who has control of the plane, near or far.
    rate_hz : float
        How often the plane's state is told.
    """

    is_connected: bool
    problem: str | None
    holder: str | None
    rate_hz: float


class Aircraft(Closing):
    """The plane that a station on board hears, in a fleet.

    From now on the station's heartbeat goes out only while somebody has control: the autopilot's ground-station failsafe counts
    it. Close it, or use it in a ``with`` statement, inside that of its station.

    Parameters
    ----------
    station : Station
        A station on board: MAVLink component 191 of the vehicle's system id.
    org, name : str
        The organisation, and the plane's name there: 1 to 32 of ``a-z``, ``0-9`` and ``-``.
    dial : str
        Where the fleet's router is, such as ``"tcp/127.0.0.1:7447"``. It is dialled for ever.
    trust, chiefs : iterable of str, optional
        Public keys of the ground stations whose orders it takes; those of ``chiefs`` may take control from the others at once.
        Without any, it only tells where it is.
    uplink_kbit_s : float, optional
        What the uplink carries, where that is known: states fill 60 % of it at most.

    Raises
    ------
    InvalidRequest
        For a name, a key or an address that cannot be.
    """

    def __init__(
        self,
        station: Station,
        *,
        org: str,
        name: str,
        dial: str = "tcp/127.0.0.1:7447",
        trust: Iterable[str] = (),
        chiefs: Iterable[str] = (),
        uplink_kbit_s: float | None = None,
    ) -> None:
        keys = [*((key, False) for key in trust), *((key, True) for key in chiefs)]
        uplink_bit_s = None if uplink_kbit_s is None else uplink_kbit_s * 1000
        self._native = _class("FleetAircraft")(
            station._native, org=org, name=name, dial=dial, trust=keys, uplink_bit_s=uplink_bit_s
        )

    @property
    def status(self) -> AircraftStatus:
        """How it goes."""
        is_connected, problem, holder, rate_hz = self._native.status()
        return AircraftStatus(is_connected=is_connected, problem=problem, holder=holder, rate_hz=rate_hz)

    def close(self) -> None:
        """Leave the fleet."""
        self._native.close()


@dataclass(frozen=True, kw_only=True)
class FarAircraft:
    """An aircraft of a fleet, as a ground station sees it.

    Attributes
    ----------
    name : str
    system_id : int or None
        By which its vehicle is known in this station; ``None`` before it has said anything.
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
        Where it is the fleet's router; with port 0 a free one is taken (`endpoint`).
    router : str, optional
        Another router that it uses, in place of being one.
    key_file : path, optional
        Its own key; made where there is none.

    Raises
    ------
    InvalidRequest
        For a name or an address that cannot be.
    LinkError
        When the address is taken, or the router is not reached.
    """

    def __init__(
        self,
        station: Station,
        *,
        org: str,
        listen: str = "tcp/127.0.0.1:7447",
        router: str | None = None,
        key_file: str | Path | None = None,
    ) -> None:
        self._native = _class("FleetGround")(
            station._native,
            org=org,
            listen=None if router else listen,
            dial=router,
            key_file=default_key_file(org) if key_file is None else Path(key_file),
        )

    @property
    def endpoint(self) -> str:
        """Where the network is joined: where aircraft dial, when this is the router."""
        return str(self._native.endpoint)

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
