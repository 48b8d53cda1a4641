"""Rehearsal: a simulated flight of a plan in a wind, as the plane would really fly it.

A point mass flies the plan under ArduPlane's own laws: it cuts corners by the waypoint radius, drifts in turns, reaches
altitudes later than the drawn line, circles until it has its altitude, flares and touches down. What ArduPlane does at
each item, and the formulas with their sources, are documented in the core (``crates/flight/src/rehearsal``).

Examples
--------
>>> from vencejo import Home, MissionItem, Plan
>>> from vencejo.landing import Wind
>>> from vencejo.rehearsal import rehearse
>>> home = Home(40.3332, -3.7978, alt_amsl_m=600.0)
>>> out, back = MissionItem.waypoint(40.3432, -3.7978, alt_rel_home_m=80.0), MissionItem.return_to_launch()
>>> plan = Plan(home=home, items=(MissionItem.takeoff(40.3332, -3.7978, alt_rel_home_m=50.0), out, back))
>>> flown = rehearse(plan, wind=Wind(from_deg=270.0, speed_m_s=6.0))
>>> flown.ending, flown.airframe
('returned', 'parameters')
>>> [(passage.item, passage.reached_s is not None) for passage in flown.passages]
[(1, True), (2, True), (3, True)]
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, dataclass, field, replace
from typing import Any, Literal

from vencejo import _native
from vencejo._rehearsing import CLEARANCE_M, a_plan, blowing, given, within
from vencejo.airframe import Airframe, AirframeOrigin, Battery, BatteryLeft, Learned, learn
from vencejo.errors import InvalidRequest
from vencejo.findings import Finding
from vencejo.geodesy import distance_m
from vencejo.ground import Elevation, Ground
from vencejo.landing import Wind
from vencejo.plan import Command, GeoPoint, Plan, findings_of

__all__ = [
    "CLEARANCE_M",
    "Airframe",
    "AirframeOrigin",
    "Battery",
    "BatteryLeft",
    "Breadth",
    "Doubts",
    "Elevation",
    "Ending",
    "Fix",
    "Ground",
    "Learned",
    "Moment",
    "Passage",
    "Range",
    "Rehearsal",
    "Spread",
    "fixes",
    "learn",
    "rehearse",
    "rehearse_many",
]

Ending = Literal[
    "landed", "returned", "unlimited", "endless", "ground", "held", "grounded", "not-rehearsed", "too-long"
]
"""How a rehearsed flight ends: at rest on the ground; circling over home or a rally point; in an endless circle of the mission;
never, because a jump repeats for ever; in the ground before a landing; where the wind lets the plane come no nearer; on
the ground
that it never leaves; at an item that is not rehearsed (quadplanes, scripts); after six hours."""


@dataclass(frozen=True, slots=True)
class Moment:
    """One moment of a rehearsed flight.

    Attributes
    ----------
    time_s : float
        Time since its beginning, seconds.
    lat_deg, lon_deg : float
    alt_amsl_m, alt_rel_home_m : float
        Above mean sea level and above home, metres.
    alt_asked_m : float
        Altitude that the autopilot demands, metres above home.
    clearance_m : float or None
        Height above the ground, metres; ``None`` where the ground is not known.
    airspeed_m_s, groundspeed_m_s, climb_m_s : float
        Equivalent airspeed, ground speed, climb rate.
    course_deg, heading_deg : float
        Course over ground and heading of the nose, degrees from true north, 0 to 360.
    bank_deg, pitch_deg : float
        Positive to the right, positive nose up.
    throttle : float
        0 to 1.
    item : int or None
        Current item, counted from 1; ``None`` in a return and after the landing.
    """

    time_s: float
    lat_deg: float
    lon_deg: float
    alt_amsl_m: float
    alt_rel_home_m: float
    alt_asked_m: float
    clearance_m: float | None
    airspeed_m_s: float
    groundspeed_m_s: float
    climb_m_s: float
    course_deg: float
    heading_deg: float
    bank_deg: float
    pitch_deg: float
    throttle: float
    item: int | None


@dataclass(frozen=True, slots=True)
class Passage:
    """One item as flown; passages are in flight order, and jumps repeat items.

    Attributes
    ----------
    item : int
        Counted from 1.
    begins_s : float
        When the plane begins to fly to it.
    reached_s : float or None
        When it counts as reached or done; ``None`` if it never does.
    nearest_m : float or None
        Least distance to its position; ``None`` for items other than waypoints and landings.
    """

    item: int
    begins_s: float
    reached_s: float | None
    nearest_m: float | None


@dataclass(frozen=True)
class Rehearsal:
    """The rehearsed flight of a plan.

    Attributes
    ----------
    airframe : {"parameters", "simulator", "flight"}
        Source of the airframe; see :data:`AirframeOrigin`.
    findings : tuple of Finding
        Problems of the plan that only a flight shows: missed waypoints, altitudes not reached, terrain that is near or
        not known, a fence breach, a touch-down far from its point or with a tailwind.
    track : tuple of Moment
        Five samples a second, with the first and the last.
    passages : tuple of Passage
    ending : str
        See :data:`Ending`.
    touch_down : Moment or None
        Where it touches the ground.
    duration_s, distance_m : float
        Duration and distance over ground, to the end.
    energy_wh : float or None
        ``None`` if the plane's power is not known.
    battery : BatteryLeft or None
        ``None`` if it cannot be computed.
    battery_unknown : {"power", "capacity", "voltage"} or None
        The missing value because of which it cannot.
    """

    airframe: AirframeOrigin
    findings: tuple[Finding, ...]
    track: tuple[Moment, ...]
    passages: tuple[Passage, ...]
    ending: Ending
    touch_down: Moment | None
    duration_s: float
    distance_m: float
    energy_wh: float | None
    battery: BatteryLeft | None = None
    battery_unknown: Literal["power", "capacity", "voltage"] | None = None

    @classmethod
    def _from_native(cls, flown: dict[str, Any]) -> Rehearsal:
        touch_down, battery = flown["touch_down"], flown["battery"]
        parts = {
            "findings": findings_of(flown["findings"]),
            "track": tuple(Moment(**moment) for moment in flown["track"]),
            "passages": tuple(Passage(**passage) for passage in flown["passages"]),
            "touch_down": None if touch_down is None else Moment(**touch_down),
            "battery": None if battery is None else BatteryLeft(**battery),
        }
        return cls(**{**flown, **parts})

    def touch_down_off_m(self, plan: Plan) -> float | None:
        """Distance from the plan's first landing point to the touch-down, metres; ``None`` without either."""
        land = next((item for item in plan.items if item.command == Command.NAV_LAND), None)
        if self.touch_down is None or land is None or land.lat_deg is None or land.lon_deg is None:
            return None
        down = GeoPoint(self.touch_down.lat_deg, self.touch_down.lon_deg)
        return distance_m(down, GeoPoint(land.lat_deg, land.lon_deg))


@dataclass(frozen=True)
class Doubts:
    """Uncertainty of the expected conditions, as standard deviations.

    Attributes
    ----------
    wind_speed_m_s, wind_from_deg : float
        Wind speed and direction.
    gust_m_s : float
        Gusts in each flight.
    thrust, drag, power : float
        Relative to the expected values.
    """

    wind_speed_m_s: float = 1.5
    wind_from_deg: float = 15.0
    gust_m_s: float = 1.0
    thrust: float = 0.05
    drag: float = 0.1
    power: float = 0.1


@dataclass(frozen=True, slots=True)
class Range:
    """The range of nine flights in ten: one in twenty is below ``low``, one in twenty above ``high``."""

    low: float
    median: float
    high: float


@dataclass(frozen=True, slots=True)
class Breadth:
    """Deviation of the flights from the expected one at a moment of it.

    Attributes
    ----------
    time_s : float
        Time of the expected flight.
    across_m : Range
        Across its course, positive to the right.
    height_m : Range
        In altitude, positive upwards.
    """

    time_s: float
    across_m: Range
    height_m: Range


@dataclass(frozen=True)
class Spread:
    """Statistics of many flights of one plan.

    Attributes
    ----------
    expected : Rehearsal
        The flight in the expected wind.
    runs : int
        Number of flights beside it.
    endings : dict of str to int
        Number of flights by ending, the most frequent first; see :data:`Ending`.
    duration_s : Range
        For flights that ended as the expected one.
    energy_wh : Range or None
        For the same flights; ``None`` if the plane's power is not known.
    battery_left : Range or None
        Remaining part of the capacity of the same flights; ``None`` if it cannot be computed.
    below_reserve : int or None
        Number of all flights that end below the reserve; ``None`` likewise.
    touch_down_m : Range or None
        Distance of touch-downs from the expected one.
    corridor : tuple of Breadth
        One entry every five seconds.
    """

    expected: Rehearsal
    runs: int
    endings: dict[Ending, int]
    duration_s: Range
    energy_wh: Range | None
    battery_left: Range | None
    below_reserve: int | None
    touch_down_m: Range | None
    corridor: tuple[Breadth, ...]

    @classmethod
    def _from_native(cls, spread: dict[str, Any]) -> Spread:
        ranges = {
            name: None if spread[name] is None else Range(**spread[name])
            for name in ("duration_s", "energy_wh", "battery_left", "touch_down_m")
        }
        corridor = tuple(
            Breadth(at["time_s"], Range(**at["across_m"]), Range(**at["height_m"])) for at in spread["corridor"]
        )
        expected = Rehearsal._from_native(spread["expected"])
        return cls(
            **{**spread, **ranges, "expected": expected, "endings": dict(spread["endings"]), "corridor": corridor}
        )


def rehearse_many(
    plan: Plan,
    *,
    parameters: Mapping[str, float] | None = None,
    airframe: Airframe | None = None,
    battery: Battery | None = None,
    wind: Wind | None = None,
    doubts: Doubts | None = None,
    runs: int = 200,
    seed: int = 0,
    ground: Ground | None = None,
    clearance_m: float = CLEARANCE_M,
) -> Spread:
    """Rehearse a plan many times with winds and airframes that vary by `doubts`, on all processors. Ctrl-C ends it.

    Parameters
    ----------
    plan, parameters, airframe, battery, wind, ground, clearance_m
        As for :func:`rehearse`.
    doubts : Doubts, optional
    runs : int, optional
        1 to 100,000.
    seed : int, optional
        The same seed gives the same answer.

    Raises
    ------
    InvalidRequest
        When the plan has no home, or an invalid one, and for a number out of its range.
    """
    if not 1 <= runs <= 100_000:
        raise InvalidRequest(f"runs is {runs}, should be 1 to 100,000")
    spread = _native.rehearse_many(
        a_plan(plan)._to_native(),
        given(parameters, airframe, battery, wind, clearance_m=clearance_m),
        ground,
        doubts=astuple(doubts or Doubts()),
        runs=runs,
        seed=int(within("seed", seed, 0, 2**64 - 1)),
    )
    return Spread._from_native(spread)


def rehearse(
    plan: Plan,
    *,
    parameters: Mapping[str, float] | None = None,
    airframe: Airframe | None = None,
    battery: Battery | None = None,
    wind: Wind | None = None,
    gust_m_s: float = 0.0,
    seed: int = 0,
    heading_deg: float | None = None,
    ground: Ground | None = None,
    clearance_m: float = CLEARANCE_M,
) -> Rehearsal:
    """Rehearse a plan from its home on the ground, or in the air over home if it does not begin with a take-off.

    Parameters
    ----------
    plan : Plan
        With a home.
    parameters : mapping of str to float, optional
        The vehicle's parameters, as :func:`vencejo.params.load_params` or ``vehicle.params`` give them; a missing one
        has the value of ArduPilot's simulated plane. Names from before ArduPlane 4.5 are understood.
    airframe : Airframe, optional
        As :func:`learn` returns it; default: derived from the parameters.
    battery : Battery, optional
        Values that replace those of the parameters. The remaining charge is computed if capacity, voltage and the
        plane's power are known; no parameter has the last two, a learned airframe does.
    wind : Wind, optional
        Wind from 60 m above home upwards; below it decreases as over open land, or as in ArduPilot's simulator if the
        parameters are those of one. Calm by default.
    gust_m_s : float, optional
        Standard deviation of the gusts, metres a second, 0 to 20.
    seed : int, optional
        Seed of the gusts; the same seed gives the same flight.
    heading_deg : float, optional
        Heading on the ground, −360 to 360; into the wind by default.
    ground : callable, optional
        Terrain elevation at a latitude and longitude, metres above mean sea level, ``None`` where it is not known; an
        :class:`Elevation` is one. It is called beforehand for positions some 30 m apart around the plan. Heights count
        from the elevation at home, where the plane stands. Without it the ground is level, and its clearance is not
        known.
    clearance_m : float, optional
        Clearance that the flight should keep above the ground; after a take-off and on an approach half the height
        above the field is enough.

    Raises
    ------
    InvalidRequest
        When the plan has no home, or one that is no place, and for a number out of its range.
    """
    conditions = given(
        parameters,
        airframe,
        battery,
        wind,
        clearance_m=clearance_m,
        gust_m_s=gust_m_s,
        seed=seed,
        heading_deg=heading_deg,
    )
    return Rehearsal._from_native(_native.rehearse(a_plan(plan)._to_native(), conditions, ground))


@dataclass(frozen=True)
class Fix:
    """A change that resolves a finding. It was tried, and adds no new error.

    Attributes
    ----------
    finding : Finding
    does : str
        Stable name of the change: ``"set-param"``, ``"delete-item"``, ``"add-takeoff"``, ``"raise-takeoff"``,
        ``"add-landing"``, ``"turn-landing"``, ``"add-circle"``, ``"raise"``, ``"move-away"`` or ``"set-parameter"``.
    message : str
        The change in English.
    plan : Plan
        The changed plan. For ``"set-parameter"`` it is unchanged: the figures ``name`` and ``value`` say what to set on
        the vehicle.
    figures : mapping of str to bool, int, float, str or None
        Figures of the message by name; a name ends in its unit.
    """

    finding: Finding
    does: str
    message: str
    plan: Plan
    figures: Mapping[str, bool | int | float | str | None] = field(default_factory=dict, hash=False)


def fixes(
    plan: Plan,
    *,
    parameters: Mapping[str, float] | None = None,
    wind: Wind | None = None,
    on_ground: bool | None = None,
    ground: Ground | None = None,
    clearance_m: float = CLEARANCE_M,
) -> tuple[Fix, ...]:
    """Find changes that resolve the findings of checks and rehearsal; each is tried before it is returned.

    Of several changes that resolve a finding only the first is returned. Changes that build on each other are found by
    calling it again with the changed plan.

    Parameters
    ----------
    plan, parameters, wind, ground, clearance_m
        As for :func:`rehearse`. A plan without a home is checked but not rehearsed.
    on_ground : bool, optional
        Whether the vehicle is on the ground; then the mission must begin with a take-off.

    Raises
    ------
    InvalidRequest
        For a number out of its range.

    Examples
    --------
    >>> from vencejo import Home, MissionItem, Plan
    >>> from vencejo.rehearsal import fixes
    >>> items = (
    ...     MissionItem.takeoff(40.3332, -3.7978, alt_rel_home_m=50.0),
    ...     MissionItem.waypoint(40.3432, -3.7978, alt_rel_home_m=80.0),
    ... )
    >>> found = fixes(Plan(items=items, home=Home(40.3332, -3.7978, 600.0)))
    >>> [(fix.finding.code, fix.does) for fix in found]
    [('no-landing', 'add-landing')]
    >>> found[0].plan.items[-1].name
    'LAND'
    """
    told = _native.plan_fixes(
        plan._to_native(),
        parameters={name: float(value) for name, value in (parameters or {}).items()},
        wind=blowing(wind),
        on_ground=on_ground,
        ground=ground,
        clearance_m=within("clearance_m", clearance_m, 0.0, 1_000.0),
    )
    return tuple(
        Fix(
            **fix
            | {
                "finding": findings_of([fix["finding"]])[0],
                "plan": replace(Plan._from_native(fix["plan"]), settings=plan.settings),
            }
        )
        for fix in told
    )
