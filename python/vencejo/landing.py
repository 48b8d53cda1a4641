"""Landing design: the mission items that land a fixed-wing plane at a point, without altitudes tuned by hand.

The plane descends in a circle that touches the extended final leg until it has the altitude of the leg's beginning,
leaves it along the tangent, and flies one straight slope to the point: the slope is the same from any altitude. The
formulas and their sources are documented in the core (``crates/flight/src/landing.rs``).

Obstacles are not known, nor is the ground without a map of it: check the approach before you send it.

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
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias, TypedDict

from vencejo import _native
from vencejo._given import NONE, NUMBER, check, check_argument
from vencejo.plan import Command, GeoPoint, Home, MissionItem, Plan

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = [
    "Landing",
    "LandingAlternative",
    "LandingCaution",
    "LandingOptions",
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
"""A part of a landing: its touch-down point, the beginning of its final leg, the centre of its circle."""


@dataclass(frozen=True)
class Wind:
    """Wind over the field.

    Attributes
    ----------
    from_deg : float
        Direction that it comes from, degrees from true north.
    speed_m_s : float
        Speed, 0 to 60 m/s.
    """

    from_deg: float
    speed_m_s: float

    def __post_init__(self) -> None:
        check(self, from_deg=NUMBER, speed_m_s=NUMBER)
        for name in ("from_deg", "speed_m_s"):
            object.__setattr__(self, name, float(getattr(self, name)))

    @property
    def is_calm(self) -> bool:
        """Whether it is too weak to choose a landing direction by: below 1 m/s."""
        return self.speed_m_s < _native.CALM_WIND_M_S


@dataclass(frozen=True)
class LandingCaution:
    """A warning about a landing, to be read before it is flown.

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
    """A designed landing, ready to end a mission.

    Attributes
    ----------
    items : tuple of MissionItem
        DO_LAND_START if asked for, NAV_LOITER_TO_ALT, NAV_LAND; altitudes above home.
    course_deg : float
        Course of the final leg at the point, degrees from true north, 0 to 360.
    direction : {"course", "coming-from", "into-wind"}
        What the course follows from.
    leaves : GeoPoint
        Where the plane leaves the circle and the final leg begins.
    leaves_alt_rel_home_m : float
        Altitude there, metres above home.
    final_m : float
        Length of the final leg, metres.
    slope : float
        Height of the final leg over its length.
    radius_m : float
        Radius of the circle, metres.
    headwind_m_s, groundspeed_m_s : float or None
        On the final leg; a tailwind is negative. ``None`` if no wind is known.
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
        For any other length, or an end that is not a position.
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
        """The landing point from ``begin`` to ``end``: the middle, or 150 m in on a runway longer than 300 m (ICAO Annex 14)."""
        return GeoPoint(*self._measured()[2])

    def _measured(self) -> tuple[float, float, tuple[float, float]]:
        return _native.runway(_place(self.begin), _place(self.end))


@dataclass(frozen=True)
class LandingReason:
    """An argument for or against a landing.

    Attributes
    ----------
    code : str
        ``"calm"``, ``"headwind"``, ``"tailwind"``, ``"crosswind"`` (from 2 m/s on), ``"steep"`` (more than 1 in 10),
        ``"ground-near"``, ``"comes-to-rest"`` (where the rehearsed plane does), ``"before-runway"``,
        ``"beyond-runway"`` (it touches down or rolls there) or ``"does-not-land"``.
    message : str
        The reason in English, with its figures.
    """

    code: str
    message: str


@dataclass(frozen=True)
class LandingAlternative:
    """A landing to choose from, as rehearsed.

    Attributes
    ----------
    landing : Landing
    is_clockwise : bool
        Whether its circle is flown clockwise, to the right of the final leg.
    crosswind_m_s : float or None
        Crosswind on the final leg, positive from the right; ``None`` if no wind is known.
    ending : str
        How the rehearsed approach ends (`vencejo.rehearsal.Ending`).
    touch_down_m, rest_m : float or None
        Where it touches down and comes to rest, metres beyond the point along the final leg, negative before it;
        ``None`` if it does not.
    duration_s : float
        Duration of the approach from where the plane comes from, or from home.
    verdict : {"good", "doubtful", "bad"}
        Good: nothing speaks against it; doubtful: something does; bad: the rehearsed plane does not come down where it
        should.
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


class LandingOptions(TypedDict, total=False):
    """Keyword arguments of `design_landing` and `landing_alternatives`; all are optional.

    Attributes
    ----------
    course_deg : float or None
        Course of the final leg, degrees from true north.
    coming_from : GeoPoint or None
        Where the plane comes from. It gives the direction, unless it is nearer than 20 m or the landing is on a runway.
    wind : Wind or None
        Lengthens the leg and widens the circle as necessary; below 1 m/s it gives no direction.
    ground_rel_home_m : float or None
        Height of the ground at the point above home, metres, -1000 to 1000. By default it is that of home, and a
        caution says so.
    airspeed_m_s : float or None
        Approach airspeed, 5 to 60 m/s. Default: TECS_LAND_ARSPD of ``parameters``, else 22 (AIRSPEED_CRUISE of
        ArduPilot's simulated plane).
    slope : float or None
        Steepest slope of the final leg, 0.02 to 0.25; default 0.08 (1 in 12.5), and at most what ``parameters`` let the
        plane sink without power (TECS_SINK_MIN).
    final_height_m : float or None
        Height above the ground where the final leg begins, 15 to 200 m, default 40.
    radius_m : float or None
        Smallest radius of the circle, 20 to 500 m. Default: WP_LOITER_RAD of ``parameters``, or what cruise needs, else
        80.
    is_clockwise : bool or None
        Whether the circle lies to the right of the final leg, flown clockwise. Default: as the plane circles, else
        True. `landing_alternatives` lists this side first of two equally good ones.
    has_land_start : bool or None
        Whether DO_LAND_START precedes the landing, by which "land" and a return find it. Default: if RTL_AUTOLAND of
        ``parameters`` uses it, and True without ``parameters``. An ArduPlane whose RTL_AUTOLAND is 0 does not arm with
        one.
    parameters : mapping of str to float or None
        The plane's parameters, as `vencejo.params.load_params` or ``vehicle.params.all()`` give them; a missing one has
        the value of ArduPilot's simulated plane.
    home : Home or None
        Home, where altitudes count from. `design_landing` ignores ``ground`` without it; `landing_alternatives` takes
        the point at sea level.
    ground : callable or None
        Terrain elevation, as for `vencejo.rehearsal.rehearse`. It gives the height at the point if
        ``ground_rel_home_m`` does not, and a caution where it comes near the final leg or the circle. Obstacles are not
        known.
    """

    course_deg: float | None
    coming_from: GeoPoint | None
    wind: Wind | None
    ground_rel_home_m: float | None
    airspeed_m_s: float | None
    slope: float | None
    final_height_m: float | None
    radius_m: float | None
    is_clockwise: bool | None
    has_land_start: bool | None
    parameters: Mapping[str, float] | None
    home: Home | None
    ground: Callable[[float, float], float | None] | None


def design_landing(at: GeoPoint | Runway, **options: Unpack[LandingOptions]) -> Landing:
    """Design a landing at a point or on a runway.

    Its direction is the given course; else from where the plane comes from; else into the wind. On a runway the
    direction nearer to the course is taken, else the one with the headwind, in calm air from its beginning.

    Parameters
    ----------
    at : GeoPoint or Runway
        Where to touch down.
    **options
        Keyword arguments of `LandingOptions`, such as ``wind`` and ``parameters``.

    Raises
    ------
    InvalidRequest
        For an invalid position, a value out of its range, when nothing gives a direction, and when the wind is too
        strong for the plane to come in.
    """
    return _landing(
        _native.design_landing(_site(at), _asked(options), _start(options.get("home")), options.get("ground"))
    )


def landing_alternatives(at: GeoPoint | Runway, **options: Unpack[LandingOptions]) -> tuple[LandingAlternative, ...]:
    """List the landings at a point or on a runway, the best for this wind first.

    Each direction (of the runway, of the given course, else twelve at 30 degrees) is combined with its circle on either
    side and rehearsed (`vencejo.rehearsal`) from where the plane comes from, else from ``home``, 30 m above the
    beginning of the final leg. They are sorted by verdict, then by less tailwind, less crosswind, a smaller distance
    from the point to where the plane comes to rest, and a shorter duration. Directions in which the wind is too strong
    for the plane to come in are left out. A landing near which the ground comes ranks lower.

    Parameters
    ----------
    at : GeoPoint or Runway
        Where to touch down.
    **options
        Keyword arguments of `LandingOptions`.

    Raises
    ------
    InvalidRequest
        As `design_landing`, when no landing is possible.
    """
    found = _native.landing_alternatives(_site(at), _asked(options), _start(options.get("home")), options.get("ground"))
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
    """Move one part of a designed landing; the rest follows.

    Moving the point keeps course and slope. Moving the beginning of the final leg, or the circle, changes course and
    length, and with them the slope (0.02 to 0.25). Altitudes stay.

    Parameters
    ----------
    items : sequence of MissionItem
        The items of a `Landing`, as they are in a mission.
    part : {"point", "final-leg", "circle"}
    to : GeoPoint
    wind, parameters : optional
        As in `LandingOptions`: the leg grows and the circle widens as necessary.
    ground_rel_home_m : float, optional
        Height of the ground above home at the new point; by default the point keeps its height.

    Raises
    ------
    InvalidRequest
        As `design_landing`, and for items that are not such a landing.
    """
    asked = _asked({"wind": wind, "ground_rel_home_m": ground_rel_home_m, "parameters": parameters})
    rows = [(item.command, item.frame, item.params, item.autocontinue) for item in items]
    return _landing(_native.move_landing(rows, part, _place(to), asked))


def _place(point: GeoPoint) -> tuple[float, float]:
    return point.lat_deg, point.lon_deg


def _start(home: Home | None) -> tuple[float, float, float] | None:
    return None if home is None else (home.lat_deg, home.lon_deg, home.alt_amsl_m)


def _site(at: GeoPoint | Runway) -> Any:
    check_argument("at", at, GeoPoint, Runway)
    return (_place(at.begin), _place(at.end)) if isinstance(at, Runway) else _place(at)


_ASKED: Final = (
    *("course_deg", "ground_rel_home_m", "airspeed_m_s", "slope", "final_height_m", "radius_m"),
    *("is_clockwise", "has_land_start"),
)


def _asked(options: LandingOptions) -> dict[str, Any]:
    """The options as the core takes them."""
    if unknown := options.keys() - LandingOptions.__annotations__.keys():
        known = ", ".join(LandingOptions.__annotations__)
        raise TypeError(f"landings have no option {', '.join(sorted(unknown))}; they have {known}")
    coming_from, wind, parameters = options.get("coming_from"), options.get("wind"), options.get("parameters")
    check_argument("coming_from", coming_from, GeoPoint, NONE)
    check_argument("wind", wind, Wind, NONE)
    return {name: options.get(name) for name in _ASKED} | {
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
    """The item, counted from 1, at which a mission's landing begins; ``None`` without a landing.

    It is the DO_LAND_START before the landing; else the item with a position before it, where its last leg begins (a
    circle down to its altitude, or a waypoint); else the landing itself.

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
