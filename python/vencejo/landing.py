"""Landing design: the items that bring a fixed-wing plane down on a point, none of their heights tuned by hand.

The plane goes round a circle that touches the extended final leg until it has the height of the leg's beginning, leaves it
along the tangent, and flies one straight slope to the point: whatever height it came from, the slope is the same. The
formulas and their sources stand in the core (``crates/flight/src/landing.rs``).

Nothing here knows the ground or what stands on it: look at the way down before you send it.

Examples
--------
>>> from vencejo import GeoPoint, MissionItem, Plan
>>> from vencejo.landing import Wind, design_landing
>>> field = GeoPoint(40.3332, -3.7978)
>>> landing = design_landing(field, wind=Wind(from_deg=270.0, speed_m_s=5.0))
>>> landing.direction, landing.course_deg, landing.headwind_m_s
('into-wind', 270.0, 5.0)
>>> [caution.code for caution in landing.cautions]
['ground-not-known']
>>> plan = Plan(items=(MissionItem.takeoff(40.3332, -3.8, alt_rel_home_m=50.0), *landing.items))
>>> [item.name for item in plan]
['NAV_TAKEOFF', 'DO_LAND_START', 'NAV_LOITER_TO_ALT', 'NAV_LAND']
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vencejo import _native
from vencejo._given import NUMBER, check
from vencejo.plan import Command, GeoPoint, MissionItem, Plan

__all__ = ["Landing", "LandingCaution", "Wind", "design_landing", "landing_item"]


@dataclass(frozen=True)
class Wind:
    """Wind over the field.

    Attributes
    ----------
    from_deg : float
        Where it comes from, degrees from true north.
    speed_m_s : float
        Metres a second, 0 to 60.
    """

    from_deg: float
    speed_m_s: float

    def __post_init__(self) -> None:
        check(self, from_deg=NUMBER, speed_m_s=NUMBER)

    @property
    def is_calm(self) -> bool:
        """Whether it is too weak to have a direction to land into: below 1 m/s."""
        return self.speed_m_s < _native.CALM_WIND_M_S


@dataclass(frozen=True)
class LandingCaution:
    """What the pilot should know of a landing before it is flown.

    Attributes
    ----------
    code : str
        ``"ground-not-known"``, ``"steep-approach"`` (more than 1 in 10) or ``"tailwind"``.
    message : str
    """

    code: str
    message: str


@dataclass(frozen=True)
class Landing:
    """A landing, ready to be the end of a mission.

    Attributes
    ----------
    items : tuple of MissionItem
        DO_LAND_START where asked for, NAV_LOITER_TO_ALT, NAV_LAND; heights above home.
    course_deg : float
        Course of the final leg at the point, degrees from true north, 0 to 360.
    direction : {"course", "coming-from", "into-wind"}
        What gave it.
    leaves : GeoPoint
        Where the circle is left and the final leg begins.
    leaves_alt_rel_home_m : float
        Height there, metres above home.
    final_m : float
        Length of the final leg, metres.
    slope : float
        Its height over its length.
    radius_m : float
        Radius of the circle, metres.
    headwind_m_s, groundspeed_m_s : float or None
        On the final leg; a negative headwind comes from behind. ``None`` when no wind is known.
    cautions : tuple of LandingCaution
    """

    items: tuple[MissionItem, ...]
    course_deg: float
    direction: Literal["course", "coming-from", "into-wind"]
    leaves: GeoPoint
    leaves_alt_rel_home_m: float
    final_m: float
    slope: float
    radius_m: float
    headwind_m_s: float | None
    groundspeed_m_s: float | None
    cautions: tuple[LandingCaution, ...]


def design_landing(
    at: GeoPoint,
    *,
    course_deg: float | None = None,
    coming_from: GeoPoint | None = None,
    wind: Wind | None = None,
    ground_rel_home_m: float | None = None,
    airspeed_m_s: float | None = None,
    slope: float | None = None,
    final_height_m: float | None = None,
    radius_m: float | None = None,
    is_clockwise: bool = True,
    has_land_start: bool = True,
) -> Landing:
    """Design a landing at a point.

    Its direction is the runway's course where that is given; else the one that leads from where the plane comes from; else
    into the wind.

    Parameters
    ----------
    at : GeoPoint
        Where to touch down.
    course_deg : float, optional
        Course of the final leg, degrees from true north.
    coming_from : GeoPoint, optional
        Where the plane comes from; nearer than 20 m it gives no direction.
    wind : Wind, optional
        Lengthens the leg and widens the circle as it needs; below 1 m/s it gives no direction.
    ground_rel_home_m : float, optional
        Height of the ground at the point above home, metres, -1000 to 1000. When it is not known home's is taken, and a
        caution says so.
    airspeed_m_s : float, optional
        Of the approach, 5 to 60 m/s, default 22 (ArduPlane's AIRSPEED_CRUISE).
    slope : float, optional
        Steepest slope of the final leg, 0.02 to 0.25, default 0.08 (1 in 12.5).
    final_height_m : float, optional
        Height above the ground where the final leg begins, 15 to 200 m, default 40.
    radius_m : float, optional
        Smallest radius of the circle, 20 to 500 m, default 80.
    is_clockwise : bool, optional
        Whether the circle lies to the right of the final leg, flown clockwise.
    has_land_start : bool, optional
        Whether DO_LAND_START goes before it, by which "land" and a return find it. An ArduPlane whose RTL_AUTOLAND is 0 does
        not arm with one.

    Raises
    ------
    InvalidRequest
        For a position that is none, a value out of its range, when nothing gives a direction, and when the wind is too strong
        for the plane to come in.
    """
    items, course, direction, leaves, final_m, slope_flown, radius, headwind, groundspeed, cautions = (
        _native.design_landing(
            (at.lat_deg, at.lon_deg),
            course_deg=course_deg,
            coming_from=None if coming_from is None else (coming_from.lat_deg, coming_from.lon_deg),
            wind=None if wind is None else (wind.from_deg, wind.speed_m_s),
            ground_rel_home_m=ground_rel_home_m,
            airspeed_m_s=airspeed_m_s,
            slope=slope,
            final_height_m=final_height_m,
            radius_m=radius_m,
            is_clockwise=is_clockwise,
            has_land_start=has_land_start,
        )
    )
    return Landing(
        tuple(MissionItem(*item) for item in items),
        course,
        direction,
        GeoPoint(*leaves[:2]),
        leaves[2],
        final_m,
        slope_flown,
        radius,
        headwind,
        groundspeed,
        tuple(LandingCaution(*caution) for caution in cautions),
    )


def landing_item(plan: Plan) -> int | None:
    """The item, counted from 1, from which a mission's landing is flown; ``None`` when it has none.

    It is DO_LAND_START where there is one before the landing, else the place before the landing, from which its last leg
    leads (a circle down to the right height, or a waypoint), else the landing itself.

    Examples
    --------
    >>> from vencejo import MissionItem, Plan
    >>> there, here = (40.3332, -3.7978), (40.3402, -3.7978)
    >>> places = [MissionItem.waypoint(*here, alt_rel_home_m=60.0), MissionItem.change_airspeed(14.0)]
    >>> landing_item(Plan(items=(*places, MissionItem.land(*there))))
    1
    """
    land = next((number for number, item in enumerate(plan.items) if item.command == Command.NAV_LAND), None)
    if land is None:
        return None
    before = list(enumerate(plan.items[:land], 1))
    starts = [number for number, item in before if item.command == Command.DO_LAND_START]
    if starts:
        return starts[-1]
    ways = [(number, item) for number, item in before if item.is_nav]
    if ways and ways[-1][1].command != Command.NAV_TAKEOFF and ways[-1][1].lat_deg:
        return ways[-1][0]
    return land + 1
