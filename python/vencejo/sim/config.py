"""The options of the simulator: planes, position, wind, pace and links."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from vencejo.sim.autopilot.geo import EARTH_RADIUS_M
from vencejo.sim.autopilot.interface import SimConfig

__all__ = ["LinkSpec", "SimOptions", "parse_link"]

_LAST_PORT = 65535
_SPACING_M = 12.0
"""Distance between planes parked side by side."""


@dataclass(frozen=True, slots=True)
class LinkSpec:
    """A parsed link string."""

    kind: Literal["tcp", "udpout"]
    """``tcp``: a server for any number of clients; ``udpout``: datagrams to one station."""
    host: str
    port: int

    def __str__(self) -> str:
        return f"{self.kind}:{self.host}:{self.port}"

    def shifted(self, offset: int) -> LinkSpec:
        """The link with its port increased by ``offset`` (port 0, any free one, stays 0)."""
        return LinkSpec(self.kind, self.host, self.port + offset if self.port else 0)


def parse_link(text: str) -> LinkSpec:
    """Read a link string: ``tcp:127.0.0.1:5760`` (a server; also ``tcpin:``) or ``udpout:127.0.0.1:14550``.

    Raises
    ------
    ValueError
        The string is malformed; the message shows the valid forms.

    Examples
    --------
    >>> parse_link("tcp:127.0.0.1:0").port
    0
    """
    kind, _, rest = text.partition(":")
    host, _, port = rest.rpartition(":")
    host = host.removeprefix("//")
    kinds: dict[str, Literal["tcp", "udpout"]] = {"tcp": "tcp", "tcpin": "tcp", "udpout": "udpout"}
    if kind not in kinds or not host or not port.isdecimal() or int(port) > _LAST_PORT:
        raise ValueError(
            f"link {text!r}: write tcp:HOST:PORT for a server (port 0 takes a free one) or udpout:HOST:PORT"
        )
    if kind == "udpout" and int(port) == 0:
        raise ValueError(f"link {text!r}: udpout needs the port of the station")
    return LinkSpec(kinds[kind], host, int(port))


@dataclass(frozen=True, slots=True, kw_only=True)
class SimOptions:
    """Options of the simulator.

    Parameters
    ----------
    home_lat_deg, home_lon_deg : float
        Start position, degrees WGS-84.
    home_alt_amsl_m : float
        Ground elevation there, metres.
    heading_deg : float
        Start heading, degrees true.
    wind_m_s, wind_from_deg : float
        Steady wind: speed, and the direction it comes from, degrees true.
    gust_m_s : float
        Scale of the turbulence; 0 is smooth air.
    seed : int
        The same seed gives the same flight.
    speedup : float
        Simulated seconds per real second, above 0; ``inf`` runs as fast as the machine can.
    planes : int
        Number of planes, 1 to 50, with system ids from ``first_system_id``, parked side by side.
    ports : {"shared", "consecutive"}
        All planes on each link, or plane k on port + k.
    links : tuple of str
        Link strings, see :func:`parse_link`.
    geoid_m : float
        Height of the geoid above the WGS-84 ellipsoid there, metres (−110 to 90); the receiver reports both altitudes.
    launch : {"runway", "hand"}
        Kind of take-off.
    params : mapping
        Parameters that differ from ArduPlane's defaults.
    start_unix_s : float, optional
        Unix time of the boot in SYSTEM_TIME; the real time when None.
    by_hand : bool
        Hold each plane by hand and repeat the poses :data:`vencejo.sim.hand.BY_HAND`, until it is armed.
    camera : str, optional
        ``HOST:PORT`` on loopback of the nose cameras (port 0: a free one); no cameras when None.
    camera_rate_hz : float
        Pictures a second, 1 to 30.
    """

    home_lat_deg: float = 40.3332
    home_lon_deg: float = -3.7978
    home_alt_amsl_m: float = 600.0
    heading_deg: float = 270.0
    wind_m_s: float = 0.0
    wind_from_deg: float = 180.0
    gust_m_s: float = 0.0
    seed: int = 0
    speedup: float = 1.0
    planes: int = 1
    first_system_id: int = 1
    ports: Literal["shared", "consecutive"] = "shared"
    links: tuple[str, ...] = ("tcp:127.0.0.1:5760",)
    geoid_m: float = 51.0
    launch: Literal["runway", "hand"] = "runway"
    params: Mapping[str, float] = field(default_factory=dict)
    start_unix_s: float | None = None
    by_hand: bool = False
    camera: str | None = None
    camera_rate_hz: float = 15.0

    def __post_init__(self) -> None:
        def check(name: str, low: float, high: float) -> None:
            value = getattr(self, name)
            if not low <= value <= high:
                raise ValueError(f"{name} is {value!r}, should be {low:g} to {high:g}")

        check("home_lat_deg", -89.0, 89.0)
        check("home_lon_deg", -180.0, 180.0)
        check("home_alt_amsl_m", -500.0, 9000.0)
        check("geoid_m", -110.0, 90.0)
        check("heading_deg", -360.0, 360.0)
        check("wind_m_s", 0.0, 30.0)
        check("wind_from_deg", -360.0, 360.0)
        check("gust_m_s", 0.0, 30.0)
        check("planes", 1, 50)
        check("camera_rate_hz", 1.0, 30.0)
        check("first_system_id", 1, 256 - self.planes)
        if not self.speedup > 0:
            raise ValueError(f"speedup is {self.speedup!r}, should be above 0")
        for link in self.links:
            last = parse_link(link).shifted(self.planes - 1).port
            if self.ports == "consecutive" and last > _LAST_PORT:
                raise ValueError(
                    f"link {link!r}: plane {self.planes} would be on port {last}, ports end at {_LAST_PORT}"
                )

    def plane(self, number: int) -> SimConfig:
        """Configuration of plane ``number`` (from 0); the planes stand side by side, to the right of the first."""
        right = math.radians(self.heading_deg + 90.0)
        offset_m = number * _SPACING_M
        lat_deg = self.home_lat_deg + math.degrees(offset_m * math.cos(right) / EARTH_RADIUS_M)
        circle_m = EARTH_RADIUS_M * math.cos(math.radians(self.home_lat_deg))
        return SimConfig(
            home_lat_deg=lat_deg,
            home_lon_deg=self.home_lon_deg + math.degrees(offset_m * math.sin(right) / circle_m),
            home_alt_amsl_m=self.home_alt_amsl_m,
            heading_deg=self.heading_deg % 360.0,
            wind_m_s=self.wind_m_s,
            wind_from_deg=self.wind_from_deg % 360.0,
            gust_m_s=self.gust_m_s,
            seed=self.seed + number,
            system_id=self.first_system_id + number,
            geoid_m=self.geoid_m,
            launch=self.launch,
        )
