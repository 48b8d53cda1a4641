"""The approach to a landing point, so that nobody tunes the heights of the last waypoints.

The plane descends in circles beside the extended final leg until it has the height of the leg's beginning, leaves the
circle along it, and flies one straight slope to the point: the pattern of QGroundControl's fixed-wing landing, with
ArduPlane's DO_LAND_START before it, so that "land" and RTL find it. Whatever height it came from, the slope is the same.
"""

from __future__ import annotations

import math
from typing import Final

from vencejo.plan import MissionItem

__all__ = ["FINAL_ALT_M", "FINAL_M", "LOITER_RADIUS_M", "approach"]

FINAL_M: Final = 500.0
"""Length of the final leg: about 30 s at 16 m/s, enough to settle on it after the circle."""
FINAL_ALT_M: Final = 40.0
"""Height at its beginning: a slope of 1 in 12.5 (4.6 degrees), which a foam plane flies without flaps."""
LOITER_RADIUS_M: Final = 80.0
"""ArduPlane's default radius (WP_LOITER_RAD)."""
_EARTH_M: Final = 6_371_008.8
"""Mean radius (IUGG). Over a kilometre or two the sphere is right to half a per cent, and the legs need no more."""


def _moved(lat_deg: float, lon_deg: float, bearing_rad: float, distance_m: float) -> tuple[float, float]:
    north, east = distance_m * math.cos(bearing_rad), distance_m * math.sin(bearing_rad)
    lat = lat_deg + math.degrees(north / _EARTH_M)
    lon = lon_deg + math.degrees(east / (_EARTH_M * math.cos(math.radians(lat_deg))))
    return lat, (lon + 540.0) % 360.0 - 180.0


def _bearing_rad(from_: tuple[float, float], to: tuple[float, float]) -> float:
    """Bearing at the start of the great circle between two positions in degrees."""
    lat1, lat2 = math.radians(from_[0]), math.radians(to[0])
    east = math.radians(to[1] - from_[1])
    return math.atan2(
        math.sin(east) * math.cos(lat2),
        math.cos(lat1) * math.sin(lat2) - math.sin(lat1) * math.cos(lat2) * math.cos(east),
    )


def approach(before: tuple[float, float] | None, point: tuple[float, float]) -> list[MissionItem]:
    """The items that land at a point.

    Parameters
    ----------
    before : (lat_deg, lon_deg) or None
        Where the plane comes from: the final leg has the direction from there to the point, which is how whoever
        places the last poses chooses the runway's. ``None``, or the same place: from the south.
    point : (lat_deg, lon_deg)
        Where it is to land, at home's height.

    Returns
    -------
    list of MissionItem
        DO_LAND_START, the circle down, and NAV_LAND.
    """
    course = 0.0 if before is None or before == point else _bearing_rad(before, point)
    leaves = _moved(*point, course + math.pi, FINAL_M)
    # Clockwise, so its centre lies to the right of where it is left.
    centre = _moved(*leaves, course + math.pi / 2, LOITER_RADIUS_M)
    return [
        MissionItem.land_start(*leaves, alt_rel_home_m=FINAL_ALT_M),
        MissionItem.loiter_to_altitude(*centre, alt_rel_home_m=FINAL_ALT_M, radius_m=LOITER_RADIUS_M),
        MissionItem.land(*point),
    ]
