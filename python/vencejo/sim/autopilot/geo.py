"""The tangent plane of the autopilot's navigation, and its points with an altitude.

The tangent plane touches the ellipsoid at the boot position. North and east are metres along the meridian and the
parallel there (radii of curvature of WGS-84); at 5 km the error against the geodesic is below 3 m, the same for the
plane and its targets.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

__all__ = [
    "EARTH_RADIUS_M",
    "LocalFrame",
    "Spot",
    "bearing_rad",
    "distance_m",
    "ground_distance_m",
    "location_alt_m",
    "wrap_pi",
]

_A = 6_378_137.0
_E2 = 6.694_379_990_14e-3
EARTH_RADIUS_M = 6_371_008.8
"""Mean radius of the Earth (IUGG)."""
_ALT_LIMIT_M = 2**31 / 100.0


def wrap_pi(angle_rad: float) -> float:
    """An angle within −π to π."""
    return (angle_rad + math.pi) % math.tau - math.pi


def location_alt_m(alt_m: float) -> float:
    """An altitude limited to what ArduPilot's Location holds: 32 bits of centimetres."""
    return max(-_ALT_LIMIT_M, min(_ALT_LIMIT_M, alt_m))


@dataclass(slots=True)
class Spot:
    """A point of the tangent plane; ``alt_m`` is above mean sea level."""

    n_m: float
    e_m: float
    alt_m: float
    anticlockwise: bool = False
    """Loiter around it anticlockwise."""
    exit_tangent: bool = False
    """The leg after a loiter here starts where the circle is left, not at its centre."""
    follows_ground: bool = False
    """Its altitude above home counts from the terrain below the plane instead (ArduPlane's ``terrain_alt``)."""

    def moved(self, bearing: float, distance: float) -> Spot:
        """The point ``distance`` metres away along a bearing in radians."""
        return Spot(
            self.n_m + distance * math.cos(bearing),
            self.e_m + distance * math.sin(bearing),
            self.alt_m,
            self.anticlockwise,
            self.exit_tangent,
            self.follows_ground,
        )

    def copy(self) -> Spot:
        """A copy."""
        return replace(self)


def distance_m(a: Spot, b: Spot) -> float:
    """Horizontal distance."""
    return math.hypot(b.n_m - a.n_m, b.e_m - a.e_m)


def bearing_rad(a: Spot, b: Spot) -> float:
    """Bearing from ``a`` to ``b``, −π to π."""
    return math.atan2(b.e_m - a.e_m, b.n_m - a.n_m)


def ground_distance_m(lat1_deg: float, lon1_deg: float, lat2_deg: float, lon2_deg: float) -> float:
    """Distance by ArduPilot's Location::get_distance: on a sphere, longitudes scaled at the mean latitude."""
    north = lat2_deg - lat1_deg
    east = ((lon2_deg - lon1_deg + 180.0) % 360.0 - 180.0) * math.cos(math.radians((lat1_deg + lat2_deg) / 2.0))
    return 111_318.845 * math.hypot(north, east)


class LocalFrame:
    """The tangent plane at a position."""

    __slots__ = ("_east_per_deg", "_north_per_deg", "lat_deg", "lon_deg")

    def __init__(self, lat_deg: float, lon_deg: float) -> None:
        self.lat_deg = lat_deg
        self.lon_deg = lon_deg
        sin = math.sin(math.radians(lat_deg))
        w = 1.0 - _E2 * sin * sin
        self._north_per_deg = math.radians(_A * (1.0 - _E2) / w**1.5)
        self._east_per_deg = math.radians(_A / math.sqrt(w)) * max(1e-6, math.cos(math.radians(lat_deg)))

    def to_plane(self, lat_deg: float, lon_deg: float) -> tuple[float, float]:
        """North and east of a position, metres."""
        east = (lon_deg - self.lon_deg + 180.0) % 360.0 - 180.0
        return (lat_deg - self.lat_deg) * self._north_per_deg, east * self._east_per_deg

    def to_earth(self, n_m: float, e_m: float) -> tuple[float, float]:
        """Latitude and longitude of a point, degrees."""
        lon = self.lon_deg + e_m / self._east_per_deg
        return self.lat_deg + n_m / self._north_per_deg, (lon + 180.0) % 360.0 - 180.0
