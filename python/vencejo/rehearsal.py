"""Rehearsal: a plan as the plane would really fly it in a wind, before it does.

A point mass flies the plan under ArduPlane's own laws: it cuts corners by the waypoint radius, drifts in turns, reaches heights
later than the line says, circles until its height is there, flares, and says where it comes down. What ArduPlane does at each item,
and the formulas with their sources, stand in the core (``crates/flight/src/rehearsal``).

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

import os
from collections.abc import Callable, Mapping
from dataclasses import astuple, dataclass, field, replace
from typing import Any, Final, Literal, cast

from vencejo import _native
from vencejo.errors import InvalidRequest
from vencejo.findings import Finding
from vencejo.geodesy import distance_m
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

CLEARANCE_M: Final = 30.0
"""Height above the ground that a flight should keep unless another is said, metres."""

Ground = Callable[[float, float], float | None]
"""Height of the ground at a latitude and longitude, metres above mean sea level; ``None`` where it is not known."""

AirframeOrigin = Literal["parameters", "simulator", "flight"]
"""What was taken for the plane: a foam pusher with what the parameters say of it, the plane of ArduPilot's simulator, or one that was
learned from a recorded flight."""

Ending = Literal[
    "landed", "returned", "unlimited", "endless", "ground", "held", "grounded", "not-rehearsed", "too-long"
]
"""How a rehearsed flight ends: at rest on the ground; circling over home or a rally point; in a circle that the mission orders without
end; never, for a jump repeats for ever; where the ground comes before a landing; where the wind does not let the plane come nearer;
on the ground, which it does not leave; at an item that is not rehearsed (quadplanes, scripts); after six hours."""


@dataclass(frozen=True)
class Airframe:
    """What flies: lift, drag and thrust per mass, at airspeeds as the autopilot has them.

    Attributes
    ----------
    cruise_m_s : float
        Airspeed that the rest is given at.
    drag_m_s2 : float
        In level flight at it.
    induced : float
        Part of that drag which lift induces, 0 to 1.
    thrust_full_m_s2 : float
        At full throttle.
    throttle_cruise : float
        Of level flight at it, 0 to 1.
    attack_rad, level_pitch_rad : float
        Angle of attack above that of no lift, and pitch of the fuselage, in level flight at it.
    pitot : float
        True airspeed over what the autopilot takes for it.
    skid : float
        A bank turns the plane ``1 / (1 + skid)`` as fast as in a coordinated turn.
    power_cruise_w : float or None
        Electrical power of level flight at it.
    is_simulated : bool
        Whether ArduPilot's simulator flies it, whose pitot and ground are its own.
    power_exponent : float
        Of the power over the throttle.
    voltage_v : float or None
        Of the battery in flight.
    thrust_static_m_s2 : float or None
        At full throttle standing still, no less than ``thrust_full_m_s2``; ``None``: not known, or no propeller's.
    ground_drag_m_s2 : float or None
        What holds it back on the ground after a landing beside its drag: its wheels, brakes, or belly; ``None``: not known, and it slides.
    """

    cruise_m_s: float
    drag_m_s2: float
    induced: float
    thrust_full_m_s2: float
    throttle_cruise: float
    attack_rad: float
    level_pitch_rad: float
    pitot: float
    skid: float
    power_cruise_w: float | None
    is_simulated: bool = False
    power_exponent: float = 2.5
    voltage_v: float | None = None
    thrust_static_m_s2: float | None = None
    ground_drag_m_s2: float | None = None


@dataclass(frozen=True)
class Battery:
    """What is said of a battery in place of what the plane's parameters (``BATT_*``) and its monitor do; ``None``: as those.

    Attributes
    ----------
    capacity_mah : float, optional
        Charge of a full one, 1 to 1,000,000.
    voltage_v : float, optional
        Its voltage while the engine runs, 1 to 1,000.
    charge_pct : float, optional
        What it holds at the start, % of its capacity, 0 to 100; full where nobody says another.
    reserve_pct : float, optional
        What should be left at the landing, likewise; the higher of ``BATT_LOW_MAH`` and ``BATT_CRT_MAH``, else 20.
    power_cruise_w : float, optional
        Power that is drawn from it in level flight at cruise, 0.1 to 1,000,000; that of the airframe where nobody says another.
    """

    capacity_mah: float | None = None
    voltage_v: float | None = None
    charge_pct: float | None = None
    reserve_pct: float | None = None
    power_cruise_w: float | None = None


@dataclass(frozen=True)
class BatteryLeft:
    """What a flight leaves of a battery.

    Attributes
    ----------
    capacity_wh : float
        Energy of a full one, its charge times its voltage.
    left_wh : float
        At the end; below 0 the flight wants as much more than it holds.
    reserve : float
        Part of the capacity that should be left, 0 to 1.
    empty_s : float or None
        When it is empty, since the start; ``None``: it is not.
    empty_item : int or None
        The item that is flown then, counted from 1; ``None`` in a return and where it is not empty.
    """

    capacity_wh: float
    left_wh: float
    reserve: float
    empty_s: float | None
    empty_item: int | None

    @property
    def left(self) -> float:
        """Part of the capacity that is left, 1 at most; below 0 as :attr:`left_wh`."""
        return self.left_wh / self.capacity_wh


@dataclass(frozen=True)
class Learned:
    """What a recorded flight taught.

    Attributes
    ----------
    airframe : Airframe
    wind : Wind
        Of that flight.
    moments : int
        How many it rests on.
    airspeed_error_m_s : float
        What is left between measured and modelled airspeeds, RMS.
    """

    airframe: Airframe
    wind: Wind
    moments: int
    airspeed_error_m_s: float


def learn(
    path: str | os.PathLike[str], *, parameters: Mapping[str, float] | None = None, system_id: int | None = None
) -> Learned:
    """Learn a plane from a recording of its flight (a ``.tlog``): its pitot, turns, lift, drag, thrust, power, and the wind.

    What the flight does not show keeps the value that the parameters, or a foam pusher, have. At 10 Hz of position, attitude and
    VFR_HUD, with turns all round and changes of speed and height, two minutes are enough.

    Parameters
    ----------
    path : path
    parameters : mapping of str to float, optional
        The vehicle's.
    system_id : int, optional
        Which vehicle of the recording; the first that tells its position by default.

    Raises
    ------
    FileFormatError
        When the file cannot be read.
    InvalidRequest
        When the recording holds no flight that is long enough and flies in more than one direction.
    """
    numbers = {name: float(value) for name, value in (parameters or {}).items()}
    learned = _native.learn_plane(os.fspath(path), parameters=numbers, system=system_id)
    if learned is None:
        raise InvalidRequest(
            f"{os.fspath(path)}: no flight to learn from: it takes a minute or two in the air, with position, attitude and airspeed, "
            "in more than one direction"
        )
    return _learned(learned)


def _learned(learned: Any) -> Learned:
    airframe, wind, moments, error = learned
    return Learned(Airframe(**airframe), Wind(*wind), moments, error)


class Elevation:
    """Heights of the ground from a file: SRTM (``N40W004.hgt``, ``.hgt.gz``), GeoTIFF, or a folder of them.

    Called with a latitude and a longitude it gives the height there, bilinear between the file's own, in metres above the file's
    datum, which is mean sea level with SRTM and Copernicus; ``None`` where it has none.

    Parameters
    ----------
    path : path-like
    below_sea_level : bool, optional
        Whether heights of GeoTIFFs below sea level are land; by default they are the sea's floor, and the ground is the water's
        surface, 0 m.

    Raises
    ------
    FileFormatError
        When it cannot be read, or holds no heights.
    """

    def __init__(self, path: str | os.PathLike[str], *, below_sea_level: bool = False) -> None:
        self._native = _native.Elevation(path, below_sea_level)

    def __call__(self, lat_deg: float, lon_deg: float) -> float | None:
        """Height at a place, metres above mean sea level."""
        return self._native(lat_deg, lon_deg)


@dataclass(frozen=True, slots=True)
class Moment:
    """One moment of a rehearsed flight.

    Attributes
    ----------
    time_s : float
        Since its beginning.
    lat_deg, lon_deg : float
    alt_amsl_m, alt_rel_home_m : float
        Above mean sea level and above home, metres.
    alt_asked_m : float
        Height that the autopilot asks for, metres above home.
    clearance_m : float or None
        Height above the ground below, metres; ``None`` where that is not known.
    airspeed_m_s, groundspeed_m_s, climb_m_s : float
        Equivalent airspeed, speed over ground, climb.
    course_deg, heading_deg : float
        Over ground and of the nose, degrees from true north, 0 to 360.
    bank_deg, pitch_deg : float
        To the right and up positive.
    throttle : float
        0 to 1.
    item : int or None
        Item that is flown, counted from 1; ``None`` in a return and after the landing.
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
    """One item on the way, in the order flown; jumps repeat them.

    Attributes
    ----------
    item : int
        Counted from 1.
    begins_s : float
        When the plane begins to fly to it.
    reached_s : float or None
        When it counts as reached or done; ``None``: never.
    nearest_m : float or None
        How near the plane comes to its place; ``None`` for what is no waypoint and no landing.
    """

    item: int
    begins_s: float
    reached_s: float | None
    nearest_m: float | None


@dataclass(frozen=True)
class Rehearsal:
    """A plan, flown.

    Attributes
    ----------
    airframe : {"parameters", "simulator", "flight"}
        What was taken for the plane; see :data:`AirframeOrigin`.
    findings : tuple of Finding
        What the flight shows to be wrong or doubtful in the plan, which lines on a map do not: waypoints missed, heights not
        reached, the ground near or not known, the fence left, a touch-down far from its point or with the wind behind.
    track : tuple of Moment
        Five a second, with the first and the last.
    passages : tuple of Passage
    ending : str
        See :data:`Ending`.
    touch_down : Moment or None
        Where the ground is touched.
    duration_s, distance_m : float
        Until the end, over ground.
    energy_wh : float or None
        ``None`` where the plane's power is not known.
    battery : BatteryLeft or None
        ``None`` where that cannot be told.
    battery_unknown : {"power", "capacity", "voltage"} or None
        What is not known, so that it cannot.
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

    def touch_down_off_m(self, plan: Plan) -> float | None:
        """Distance from the plan's first landing point to where the ground is touched, metres; ``None`` without one of them."""
        land = next((item for item in plan.items if item.command == Command.NAV_LAND), None)
        if self.touch_down is None or land is None or land.lat_deg is None or land.lon_deg is None:
            return None
        down = GeoPoint(self.touch_down.lat_deg, self.touch_down.lon_deg)
        return distance_m(down, GeoPoint(land.lat_deg, land.lon_deg))


@dataclass(frozen=True)
class Doubts:
    """How much may be otherwise than expected, as standard deviations.

    Attributes
    ----------
    wind_speed_m_s, wind_from_deg : float
        Of the wind's speed and direction.
    gust_m_s : float
        Gusts of each flight.
    thrust, drag, power : float
        As parts of them.
    """

    wind_speed_m_s: float = 1.5
    wind_from_deg: float = 15.0
    gust_m_s: float = 1.0
    thrust: float = 0.05
    drag: float = 0.1
    power: float = 0.1


@dataclass(frozen=True, slots=True)
class Range:
    """Of nine flights in ten: one in twenty has less than ``low``, one in twenty more than ``high``."""

    low: float
    median: float
    high: float


@dataclass(frozen=True, slots=True)
class Breadth:
    """How far flights lie from the expected one at a moment of it.

    Attributes
    ----------
    time_s : float
        Of the expected flight.
    across_m : Range
        Across its course, to the right positive.
    height_m : Range
        Higher positive.
    """

    time_s: float
    across_m: Range
    height_m: Range


@dataclass(frozen=True)
class Spread:
    """What many flights of one plan show.

    Attributes
    ----------
    expected : Rehearsal
        The flight in the expected wind.
    runs : int
        Flights beside it.
    endings : dict of str to int
        How many ended how, the most first; see :data:`Ending`.
    duration_s : Range
        Of those that ended as the expected one.
    energy_wh : Range or None
        Of the same; ``None`` where the plane's power is not known.
    battery_left : Range or None
        Part of the battery that the same leave; ``None`` where that cannot be told.
    below_reserve : int or None
        How many of all flights leave less than its reserve; ``None`` likewise.
    touch_down_m : Range or None
        Distance of touch-downs from the expected one.
    corridor : tuple of Breadth
        A moment every five seconds.
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
    """Fly a plan many times in winds and with planes that are not quite those expected, on all processors.

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
        When the plan has no home, or one that is no place, and for a number of runs out of its range.
    """
    if not 1 <= runs <= 100_000:
        raise InvalidRequest(f"runs is {runs}, should be 1 to 100,000")
    expected, flown, endings, duration_s, energy_wh, left, touch_down_m, corridor = _native.rehearse_many(
        _plan(plan)._to_native(),
        _given(parameters, airframe, battery, wind, clearance_m=clearance_m),
        ground,
        doubts=astuple(doubts or Doubts()),
        runs=runs,
        seed=int(_within("seed", seed, 0, 2**64 - 1)),
    )
    battery_left, below_reserve = left
    return Spread(
        _of_native(expected),
        flown,
        cast("dict[Ending, int]", dict(endings)),
        Range(*duration_s),
        None if energy_wh is None else Range(*energy_wh),
        None if battery_left is None else Range(*battery_left),
        below_reserve,
        None if touch_down_m is None else Range(*touch_down_m),
        tuple(Breadth(time_s, Range(*across), Range(*height)) for time_s, across, height in corridor),
    )


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
    """Fly a plan from its home, on the ground; one that does not begin with a take-off is begun in the air over home.

    Parameters
    ----------
    plan : Plan
        With a home.
    parameters : mapping of str to float, optional
        The vehicle's, as :func:`vencejo.params.load_params` or ``vehicle.params`` give them; a missing name has the value
        of ArduPilot's simulated plane. Names from before ArduPlane 4.5 are understood.
    airframe : Airframe, optional
        As :func:`learn` gives it; else as the parameters tell it.
    battery : Battery, optional
        What is said of it in place of what the parameters do. What is left of it is told where capacity, voltage and the plane's power are
        known: no parameter has the last two, a learned airframe does.
    wind : Wind, optional
        60 m above home and higher; below it fades as over open land, or as ArduPilot's simulator lets it when the parameters are those
        of one. Calm by default.
    gust_m_s : float, optional
        Standard deviation of the gusts, metres a second, 0 to 20.
    seed : int, optional
        Which gusts; the same seed gives the same flight.
    heading_deg : float, optional
        Where the nose points on the ground, −360 to 360; into the wind by default.
    ground : callable, optional
        Height of the ground at a latitude and longitude, metres above mean sea level, ``None`` where it is not known; an
        :class:`Elevation` is one. It is called beforehand for places some 30 m apart around the plan. Heights count from the one at
        home, on which the plane stands. Without it the ground is level and not known.
    clearance_m : float, optional
        Height above the ground that the flight should keep; after a take-off and on an approach half the height above the field is
        enough.

    Raises
    ------
    InvalidRequest
        When the plan has no home, or one that is no place, and for a number out of its range.
    """
    given = _given(
        parameters,
        airframe,
        battery,
        wind,
        clearance_m=clearance_m,
        gust_m_s=gust_m_s,
        seed=seed,
        heading_deg=heading_deg,
    )
    return _of_native(_native.rehearse(_plan(plan)._to_native(), given, ground))


def _plan(plan: object) -> Plan:
    """A plan; anything else has no items that could be flown."""
    if not isinstance(plan, Plan):
        kind = type(plan).__name__
        raise TypeError(
            f"a Plan is wanted, not {kind}: Plan.load() reads one from a file, vehicle.download() from a vehicle"
        )
    return plan


def _profile(airframe: Airframe | None, battery: Battery | None) -> dict[str, Any]:
    return {"airframe": airframe, "battery": battery}


def _given(
    parameters: Mapping[str, float] | None,
    airframe: Airframe | None,
    battery: Battery | None,
    wind: Wind | None,
    *,
    clearance_m: float = CLEARANCE_M,
    gust_m_s: float = 0.0,
    seed: int = 0,
    heading_deg: float | None = None,
) -> dict[str, Any]:
    """What a plan is rehearsed with."""
    return {
        "parameters": {name: float(value) for name, value in (parameters or {}).items()},
        "profile": _profile(airframe, battery),
        "wind": _blowing(wind),
        "gust_m_s": _within("gust_m_s", gust_m_s, 0.0, 20.0),
        "seed": int(_within("seed", seed, 0, 2**64 - 1)),
        "heading_deg": _heading(heading_deg),
        "clearance_m": _within("clearance_m", clearance_m, 0.0, 1_000.0),
    }


@dataclass(frozen=True)
class Fix:
    """A change that resolves a finding: it was tried, and no error is there that was not.

    Attributes
    ----------
    finding : Finding
    does : str
        Stable name of what it does: ``"set-param"``, ``"delete-item"``, ``"add-takeoff"``, ``"raise-takeoff"``, ``"add-landing"``,
        ``"turn-landing"``, ``"add-circle"``, ``"raise"``, ``"move-away"`` or ``"set-parameter"``.
    message : str
        It in English.
    plan : Plan
        The plan with it. For ``"set-parameter"`` it is as it was: the figures ``name`` and ``value`` say what to set on the vehicle.
    figures : mapping of str to bool, int, float, str or None
        By name; a name ends in its unit.
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
    """Find changes that resolve what a check or a rehearsal finds in a plan; each is tried before it is told.

    Of several that would do the first is told. What follows from one another is found by asking again for the plan with the change.

    Parameters
    ----------
    plan, parameters, wind, ground, clearance_m
        As for :func:`rehearse`. A plan without a home is checked and not rehearsed.
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
        wind=_blowing(wind),
        on_ground=on_ground,
        ground=ground,
        clearance_m=_within("clearance_m", clearance_m, 0.0, 1_000.0),
    )
    return tuple(
        Fix(
            findings_of([finding])[0],
            does,
            message,
            replace(Plan._from_native(changed), settings=plan.settings),
            figures,
        )
        for finding, does, figures, message, changed in told
    )


def _within(name: str, value: float, least: float, most: float) -> float:
    """A number in its range; not-a-number is in none."""
    if not least <= value <= most:
        raise InvalidRequest(f"{name} is {value}, should be {least:,} to {most:,}")
    return value


def _blowing(wind: Wind | None) -> tuple[float, float]:
    """Direction and speed of a wind, calm by default."""
    if wind is None:
        return (0.0, 0.0)
    return (
        _within("wind.from_deg", wind.from_deg, -360.0, 360.0),
        _within("wind.speed_m_s", wind.speed_m_s, 0.0, 60.0),
    )


def _heading(heading_deg: float | None) -> float | None:
    return None if heading_deg is None else _within("heading_deg", heading_deg, -360.0, 360.0)


def _of_native(flown: Any) -> Rehearsal:
    airframe, findings, track, passages, ending, touch_down, duration_s, distance_m, energy_wh, battery, lacks = flown
    return Rehearsal(
        airframe,
        findings_of(findings),
        tuple(_moment(moment) for moment in track),
        tuple(Passage(*passage) for passage in passages),
        ending,
        None if touch_down is None else _moment(touch_down),
        duration_s,
        distance_m,
        energy_wh,
        None if battery is None else BatteryLeft(*battery),
        lacks,
    )


def _moment(moment: Any) -> Moment:
    place, speeds, angles, throttle, item = moment
    return Moment(*(*place, *speeds, *angles, throttle, item))
