"""The approach to a landing point, so that nobody tunes the heights of the last waypoints.

The plane descends in circles beside the extended final leg until it has the height of the leg's beginning, leaves the
circle along it, and flies one straight slope to the point: the pattern of QGroundControl's fixed-wing landing, with
ArduPlane's DO_LAND_START before it, so that "land" and RTL find it. Whatever height it came from, the slope is the same.
"""

from __future__ import annotations

from typing import Final

from vencejo.geodesy import bearing_deg, destination
from vencejo.plan import GeoPoint, MissionItem

__all__ = ["FINAL_ALT_M", "FINAL_M", "LOITER_RADIUS_M", "approach"]

FINAL_M: Final = 500.0
"""Length of the final leg: about 30 s at 16 m/s, enough to settle on it after the circle."""
FINAL_ALT_M: Final = 40.0
"""Height at its beginning: a slope of 1 in 12.5 (4.6 degrees), which a foam plane flies without flaps."""
LOITER_RADIUS_M: Final = 80.0
"""ArduPlane's default radius (WP_LOITER_RAD)."""


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
    there = GeoPoint(*point)
    course_deg = 0.0 if before is None or before == point else bearing_deg(GeoPoint(*before), there)
    leaves = destination(there, bearing_deg=course_deg + 180.0, distance_m=FINAL_M)
    # Clockwise, so its centre lies to the right of where it is left.
    centre = destination(leaves, bearing_deg=course_deg + 90.0, distance_m=LOITER_RADIUS_M)
    return [
        MissionItem.land_start(leaves.lat_deg, leaves.lon_deg, alt_rel_home_m=FINAL_ALT_M),
        MissionItem.loiter_to_altitude(
            centre.lat_deg, centre.lon_deg, alt_rel_home_m=FINAL_ALT_M, radius_m=LOITER_RADIUS_M
        ),
        MissionItem.land(*point),
    ]
