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

A runway has two directions and a circle on either side of each; the best for the wind comes first, with its reasons:

>>> from vencejo.landing import Runway, landing_alternatives
>>> strip = Runway(field, GeoPoint(40.3332, -3.7943))
>>> best, *others = landing_alternatives(strip, wind=Wind(from_deg=250.0, speed_m_s=6.0))
>>> round(best.landing.course_deg), best.verdict, [reason.code for reason in best.reasons]
(270, 'good', ['headwind', 'crosswind', 'comes-to-rest'])
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, TypeAlias

from vencejo import _native
from vencejo._given import NUMBER, check
from vencejo.plan import Command, GeoPoint, Home, MissionItem, Plan

__all__ = [
    "Landing",
    "LandingAlternative",
    "LandingCaution",
    "LandingPart",
    "LandingReason",
    "Runway",
    "Wind",
    "design_landing",
    "landing_alternatives",
    "landing_item",
    "move_landing",
]

LandingPart: TypeAlias = Literal["point", "final-leg", "circle"]
"""A part of a landing: where it touches down, where its final leg begins, the centre of its circle."""


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
        for name in ("from_deg", "speed_m_s"):
            object.__setattr__(self, name, float(getattr(self, name)))

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
        ``"ground-not-known"``, ``"steep-approach"`` (more than 1 in 10), ``"tailwind"`` or ``"ground-near"``.
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


@dataclass(frozen=True)
class Runway:
    """A line to land on, in either direction; 20 m to 10 km long.

    Attributes
    ----------
    begin, end : GeoPoint
        Its ends.

    Raises
    ------
    InvalidRequest
        For another length, or an end that is no position.
    """

    begin: GeoPoint
    end: GeoPoint

    def __post_init__(self) -> None:
        check(self, begin=(GeoPoint,), end=(GeoPoint,))
        self._measured()

    @property
    def length_m(self) -> float:
        """Its length, metres."""
        return self._measured()[0]

    @property
    def course_deg(self) -> float:
        """Course from ``begin`` to ``end``, degrees from true north, 0 to 360."""
        return self._measured()[1]

    @property
    def aim(self) -> GeoPoint:
        """The landing point from ``begin`` to ``end``: in the middle, on a runway of more than 300 m at 150 m (ICAO Annex 14)."""
        return GeoPoint(*self._measured()[2])

    def _measured(self) -> tuple[float, float, tuple[float, float]]:
        return _native.runway(_place(self.begin), _place(self.end))


@dataclass(frozen=True)
class LandingReason:
    """What speaks for or against a landing.

    Attributes
    ----------
    code : str
        ``"calm"``, ``"headwind"``, ``"tailwind"``, ``"crosswind"`` (from 2 m/s on), ``"steep"`` (more than 1 in 10), ``"ground-near"``,
        ``"comes-to-rest"`` (where the rehearsed plane does), ``"before-runway"``, ``"beyond-runway"`` (it touches down or rolls there) or ``"does-not-land"``.
    message : str
        With its figures.
    """

    code: str
    message: str


@dataclass(frozen=True)
class LandingAlternative:
    """A landing to choose, as the plane would fly it.

    Attributes
    ----------
    landing : Landing
    is_clockwise : bool
        Whether its circle is flown clockwise, to the right of the final leg.
    crosswind_m_s : float or None
        The wind across the final leg, positive from the right; ``None`` when no wind is known.
    ending : str
        How the rehearsed approach ends (`vencejo.rehearsal.Ending`).
    touch_down_m, rest_m : float or None
        Where it touches the ground and where it comes to rest, metres beyond the point along the final leg, negative before it; ``None`` where
        it does not.
    duration_s : float
        Time of the approach from where the plane comes from, or from home.
    verdict : {"good", "doubtful", "bad"}
        Whether to fly it: nothing speaks against it, something does, the rehearsed plane does not come down where it should.
    reasons : tuple of LandingReason
    """

    landing: Landing
    is_clockwise: bool
    crosswind_m_s: float | None
    ending: str
    touch_down_m: float | None
    rest_m: float | None
    duration_s: float
    verdict: Literal["good", "doubtful", "bad"]
    reasons: tuple[LandingReason, ...]


def design_landing(
    at: GeoPoint | Runway,
    *,
    course_deg: float | None = None,
    coming_from: GeoPoint | None = None,
    wind: Wind | None = None,
    ground_rel_home_m: float | None = None,
    airspeed_m_s: float | None = None,
    slope: float | None = None,
    final_height_m: float | None = None,
    radius_m: float | None = None,
    is_clockwise: bool | None = None,
    has_land_start: bool | None = None,
    parameters: Mapping[str, float] | None = None,
    home: Home | None = None,
    ground: Callable[[float, float], float | None] | None = None,
) -> Landing:
    """Design a landing at a point or on a runway.

    Its direction is the course where that is given; else the one that leads from where the plane comes from; else into the wind. Of a runway's
    two directions the one nearer to the course is flown, else the one with the wind ahead, in calm air from its beginning.

    Parameters
    ----------
    at : GeoPoint or Runway
        Where to touch down.
    course_deg : float, optional
        Course of the final leg, degrees from true north.
    coming_from : GeoPoint, optional
        Where the plane comes from; nearer than 20 m it gives no direction, and to a runway none.
    wind : Wind, optional
        Lengthens the leg and widens the circle as it needs; below 1 m/s it gives no direction.
    ground_rel_home_m : float, optional
        Height of the ground at the point above home, metres, -1000 to 1000. When it is not known home's is taken, and a
        caution says so.
    airspeed_m_s : float, optional
        Approach airspeed, 5 to 60 m/s. Default: TECS_LAND_ARSPD of ``parameters``, else 22 (AIRSPEED_CRUISE of ArduPilot's
        simulated plane).
    slope : float, optional
        Steepest slope of the final leg, 0.02 to 0.25; default 0.08 (1 in 12.5), and no more than ``parameters`` let the plane sink without power
        (TECS_SINK_MIN).
    final_height_m : float, optional
        Height above the ground where the final leg begins, 15 to 200 m, default 40.
    radius_m : float, optional
        Smallest radius of the circle, 20 to 500 m; that of ``parameters`` (WP_LOITER_RAD, or what cruise needs), else 80.
    is_clockwise : bool, optional
        Whether the circle lies to the right of the final leg, flown clockwise; as the plane circles, else yes.
    has_land_start : bool, optional
        Whether DO_LAND_START goes before it, by which "land" and a return find it; where RTL_AUTOLAND looks for it, without ``parameters`` yes. An
        ArduPlane whose RTL_AUTOLAND is 0 does not arm with one.
    parameters : mapping of str to float, optional
        The plane's parameters, as `vencejo.params.load_params` or ``vehicle.params.all()`` give them; a missing one has the
        value of ArduPilot's simulated plane.
    home : Home, optional
        Where heights count from; without it ``ground`` says nothing.
    ground : callable, optional
        Height of the ground, as for `vencejo.rehearsal.rehearse`. It gives the height at the point where ``ground_rel_home_m`` does not, and a
        caution where it comes near the final leg or the circle. What stands on it no map of heights knows.

    Raises
    ------
    InvalidRequest
        For a position that is none, a value out of its range, when nothing gives a direction, and when the wind is too strong
        for the plane to come in.
    """
    return _landing(_native.design_landing(_site(at), _asked(locals()), _start(home), ground))


def landing_alternatives(
    at: GeoPoint | Runway,
    *,
    course_deg: float | None = None,
    coming_from: GeoPoint | None = None,
    wind: Wind | None = None,
    ground_rel_home_m: float | None = None,
    airspeed_m_s: float | None = None,
    slope: float | None = None,
    final_height_m: float | None = None,
    radius_m: float | None = None,
    is_clockwise: bool | None = None,
    has_land_start: bool | None = None,
    parameters: Mapping[str, float] | None = None,
    home: Home | None = None,
    ground: Callable[[float, float], float | None] | None = None,
) -> tuple[LandingAlternative, ...]:
    """All landings at a point or on a runway, the best for this wind first.

    Each direction (of a runway, of a course that is given, else twelve 30 degrees apart) with its circle on either side, each rehearsed
    (`vencejo.rehearsal`) from where the plane comes from, else from ``home``, 30 m above the beginning of the final leg. Those that come down well are
    first, then the one with less tailwind, less crosswind, that comes to rest nearer to the point, and that is down first. Directions in which
    the wind does not let the plane come in are left out.

    Parameters
    ----------
    at, course_deg, coming_from, wind, ground_rel_home_m, airspeed_m_s, slope, final_height_m, radius_m, is_clockwise, has_land_start, parameters
        As `design_landing` takes them; ``is_clockwise`` is the side that comes first of two that are as good.
    home : Home, optional
        Where heights count from; the point at sea level when it is not given.
    ground : callable, optional
        As `design_landing` takes it, with ``home``: a landing that the ground comes near ranks lower.

    Raises
    ------
    InvalidRequest
        As `design_landing`, when there is none.
    """
    found = _native.landing_alternatives(_site(at), _asked(locals()), _start(home), ground)
    return tuple(
        LandingAlternative(
            _landing(landing),
            clockwise,
            crosswind,
            *flown,
            verdict,
            tuple(LandingReason(*reason) for reason in reasons),
        )
        for landing, clockwise, crosswind, flown, verdict, reasons in found
    )


def move_landing(
    items: Sequence[MissionItem],
    part: LandingPart,
    to: GeoPoint,
    *,
    wind: Wind | None = None,
    ground_rel_home_m: float | None = None,
    parameters: Mapping[str, float] | None = None,
) -> Landing:
    """A landing as it was designed, with one part somewhere else; the rest follows.

    Moved by its point it keeps course and slope; the beginning of the final leg, or the circle, gives course and length, and with them the slope (0.02 to
    0.25). Heights stay.

    Parameters
    ----------
    items : sequence of MissionItem
        Those of a `Landing`, as they are in a mission.
    part : {"point", "final-leg", "circle"}
    to : GeoPoint
    wind, parameters : optional
        As `design_landing` takes them: the leg grows and the circle widens as they need.
    ground_rel_home_m : float, optional
        Height of the ground above home where the point is moved to; without it the point keeps its height.

    Raises
    ------
    InvalidRequest
        As `design_landing`, and for items that are no such landing.
    """
    asked = _asked(locals())
    rows = [(item.command, item.frame, item.params, item.autocontinue) for item in items]
    return _landing(_native.move_landing(rows, part, _place(to), asked))


def _place(point: GeoPoint) -> tuple[float, float]:
    return point.lat_deg, point.lon_deg


def _start(home: Home | None) -> tuple[float, float, float] | None:
    return None if home is None else (home.lat_deg, home.lon_deg, home.alt_amsl_m)


def _site(at: GeoPoint | Runway) -> Any:
    return (_place(at.begin), _place(at.end)) if isinstance(at, Runway) else _place(at)


_ASKED: Final = (
    *("course_deg", "ground_rel_home_m", "airspeed_m_s", "slope", "final_height_m", "radius_m"),
    *("is_clockwise", "has_land_start"),
)


def _asked(given: Mapping[str, Any]) -> dict[str, Any]:
    """What is asked of a landing, as the core takes it, of a function's arguments."""
    coming_from, wind, parameters = given.get("coming_from"), given["wind"], given["parameters"]
    return {name: given.get(name) for name in _ASKED} | {
        "coming_from": None if coming_from is None else _place(coming_from),
        "wind": None if wind is None else (wind.from_deg, wind.speed_m_s),
        "parameters": None if parameters is None else {name: float(value) for name, value in parameters.items()},
    }


def _landing(found: Any) -> Landing:
    items, course, direction, leaves, final_m, slope, radius, headwind, groundspeed, cautions = found
    return Landing(
        tuple(MissionItem(*item) for item in items),
        course,
        direction,
        GeoPoint(*leaves[:2]),
        leaves[2],
        final_m,
        slope,
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
