"""Surveys: the lines from which a plane photographs an area or a corridor, and what its pictures will show.

Lines lie across the wind, so that the ground speed is the same in both directions; their order lets the plane turn from
one to the next, and each has a straight lead-in on which the plane settles. The survey is rehearsed at once: where each
picture is taken, how much of the area is covered, and which lines were missed. The formulas and their sources are
documented in the core (``crates/flight/src/survey``).

The ground is level unless altitudes count from the terrain; obstacles are not known.

Examples
--------
>>> from vencejo import GeoPoint, Plan
>>> from vencejo.landing import Wind
>>> from vencejo.survey import CAMERAS, design_survey
>>> field = (GeoPoint(40.33, -3.80), GeoPoint(40.33, -3.79), GeoPoint(40.337, -3.79), GeoPoint(40.337, -3.80))
>>> survey = design_survey(
...     field,
...     camera=CAMERAS["Sony a6000 16mm"],
...     gsd_m=0.03,
...     wind=Wind(from_deg=0.0, speed_m_s=5.0),
...     ground_rel_home_m=0.0,
... )
>>> survey.course_from, round(survey.height_m), survey.cautions
('across-wind', 123, ())
>>> survey.flown.covered, survey.flown.findings
(1.0, ())
>>> plan = survey.placed_in(Plan())
>>> [item.kind for item in plan.settings.complex_items]
['survey']
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Literal, TypedDict

from vencejo import _native
from vencejo._given import NUMBER, WHOLE, check
from vencejo.errors import InvalidRequest
from vencejo.findings import Finding
from vencejo.landing import Wind
from vencejo.plan import ComplexItem, GeoPoint, Home, MissionItem, Plan, findings_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = [
    "CAMERAS",
    "Camera",
    "FlownLine",
    "FlownSurvey",
    "Hole",
    "Photo",
    "Survey",
    "SurveyCaution",
    "SurveyOptions",
    "design_corridor",
    "design_survey",
    "redesign",
]


@dataclass(frozen=True)
class Camera:
    """Geometry and speed of a survey camera.

    Attributes
    ----------
    sensor_width_mm, sensor_height_mm : float
        Size of the sensor, 0.5 to 200.
    image_width_px, image_height_px : int
        Size of the picture, 16 to 100,000.
    focal_length_mm : float
        The real focal length, not the 35 mm equivalent, 0.5 to 2,000.
    min_interval_s : float
        Minimum time between two pictures, 0 to 60; 0 if it is not known.
    """

    sensor_width_mm: float
    sensor_height_mm: float
    image_width_px: int
    image_height_px: int
    focal_length_mm: float
    min_interval_s: float = 0.0

    def __post_init__(self) -> None:
        check(self, sensor_width_mm=NUMBER, sensor_height_mm=NUMBER, focal_length_mm=NUMBER, min_interval_s=NUMBER)
        check(self, image_width_px=WHOLE, image_height_px=WHOLE)


CAMERAS: Final[Mapping[str, Camera]] = MappingProxyType({name: Camera(*data) for name, data in _native.CAMERAS})
"""Common cameras of small planes, by the names that QGroundControl has for them."""


@dataclass(frozen=True)
class SurveyCaution:
    """A warning about a survey, to be read before it is flown.

    Attributes
    ----------
    code : str
        ``"ground-not-known"``, ``"camera-too-slow"``, ``"along-wind"``, ``"tight-turns"``, ``"gaps"`` or
        ``"speed-not-taken"``.
    message : str
    """

    code: str
    message: str


@dataclass(frozen=True)
class Photo:
    """A picture of the rehearsed flight.

    Attributes
    ----------
    time_s : float
        Time since the start, seconds.
    lat_deg, lon_deg, alt_rel_home_m : float
        Position of the plane.
    heading_deg, bank_deg, pitch_deg : float
        Attitude of the plane; a bank to the right is positive.
    shows : tuple of GeoPoint or None
        Corners of the ground in the picture; ``None`` if it reaches beyond the horizon, and without a camera.
    """

    time_s: float
    lat_deg: float
    lon_deg: float
    alt_rel_home_m: float
    heading_deg: float
    bank_deg: float
    pitch_deg: float
    shows: tuple[GeoPoint, ...] | None


@dataclass(frozen=True)
class Hole:
    """Ground that no picture covers.

    Attributes
    ----------
    point : GeoPoint
        Its centre.
    area_m2 : float
    """

    point: GeoPoint
    area_m2: float


@dataclass(frozen=True)
class FlownLine:
    """A line as it was flown.

    Attributes
    ----------
    off_m : float or None
        Greatest distance from the line while pictures are taken; ``None`` if it is not flown.
    photos : int
    is_missed : bool
        Whether it is not flown, or so far off that no overlap with the next line is left.
    """

    off_m: float | None
    photos: int
    is_missed: bool


@dataclass(frozen=True)
class FlownSurvey:
    """Coverage of a survey when it is flown as rehearsed.

    Attributes
    ----------
    photos : tuple of Photo
    covered, overlapped : float or None
        Parts of the area in at least one picture, and in ``views_promised`` pictures, 0 to 1; ``None`` without a
        camera.
    views_promised : int
        Number of pictures of each point that the overlap promises.
    holes : tuple of Hole
        The largest holes, at most 20.
    lines : tuple of FlownLine
        As ``Survey.lines``.
    duration_s : float
    findings : tuple of Finding
        ``survey-line-missed``, ``survey-holes``.
    """

    photos: tuple[Photo, ...]
    covered: float | None
    overlapped: float | None
    views_promised: int
    holes: tuple[Hole, ...]
    lines: tuple[FlownLine, ...]
    duration_s: float
    findings: tuple[Finding, ...]


@dataclass(frozen=True)
class Survey:
    """A survey, ready to be placed in a mission.

    Attributes
    ----------
    items : tuple of MissionItem
        Waypoints and camera commands; the first waypoint leads to the first line, the last one away from the last line.
    lines : tuple of tuple of GeoPoint
        Uninterrupted stretches that are photographed, in flight order.
    course_deg : float
        Course of the first line, degrees from true north.
    course_from : {"asked", "across-wind", "along-area", "corridor"}
        What the course follows from.
    height_m : float
        Height above the ground.
    gsd_m : float or None
        Ground sampling distance; ``None`` without a camera.
    footprint_m : tuple of float or None
        Size of the ground in a picture, across and along the track.
    spacing_m : float
        Distance between two lines.
    trigger_m : float or None
        Distance between two pictures; ``None`` if the camera is not triggered.
    turn_radius_m, lead_in_m, lead_out_m : float
        Turn radius, and the straight distance flown before the first and after the last picture of a line.
    groundspeed_m_s : tuple of float
        Lowest and highest ground speed on the lines.
    crab_deg : float
        Greatest angle between heading and course on the lines.
    area_m2, line_m, length_m : float
        Area of the polygon, total length of photographed lines, total length flown.
    duration_s : float
        Duration of the whole survey, in this wind.
    photos : int
    cautions : tuple of SurveyCaution
    flown : FlownSurvey
        The rehearsed flight.
    complex_item : ComplexItem
        The survey as QGroundControl's survey or corridor, for a ``.plan`` file.
    """

    items: tuple[MissionItem, ...]
    lines: tuple[tuple[GeoPoint, ...], ...]
    course_deg: float
    course_from: Literal["asked", "across-wind", "along-area", "corridor"]
    height_m: float
    gsd_m: float | None
    footprint_m: tuple[float, float] | None
    spacing_m: float
    trigger_m: float | None
    turn_radius_m: float
    lead_in_m: float
    lead_out_m: float
    groundspeed_m_s: tuple[float, float]
    crab_deg: float
    area_m2: float
    line_m: float
    length_m: float
    duration_s: float
    photos: int
    cautions: tuple[SurveyCaution, ...]
    flown: FlownSurvey
    complex_item: ComplexItem

    def placed_in(self, plan: Plan, *, before: int | None = None, replacing: ComplexItem | None = None) -> Plan:
        """The plan with this survey inserted before an item, counted from 1; at its end by default.

        With `replacing`, one of ``plan.settings.complex_items``, it replaces that one. Jumps keep their target items.
        Saved as ``.plan``, the survey can be opened and edited in QGroundControl.

        Raises
        ------
        InvalidRequest
            When the plan no longer has the items of the survey to be replaced unchanged.
        """
        complex_items = plan.settings.complex_items
        index = len(plan.items) if before is None else max(0, min(before - 1, len(plan.items)))
        gone = 0
        if replacing is not None:
            parts = dict(
                zip(complex_items, _native.complex_parts(plan._to_native(), plan._native_settings()), strict=True)
            )
            first, gone = parts.get(replacing, (None, 0))
            if first is None:
                raise InvalidRequest(
                    f"the plan has no {replacing.kind} with its items as it made them; place it with before="
                )
            index = first
        added = len(self.items) - gone

        def moved(item: MissionItem) -> MissionItem:
            target = item.params[0]
            if item.name != "DO_JUMP" or target is None or target <= index + gone:
                return item
            return replace(item, params=(target + added, *item.params[1:]))

        items = tuple(moved(item) for item in plan.items)
        kept = (*(complex for complex in complex_items if complex != replacing), self.complex_item)
        return replace(
            plan,
            items=(*items[:index], *self.items, *items[index + gone :]),
            settings=replace(plan.settings, complex_items=kept),
        )


class SurveyOptions(TypedDict, total=False):
    """Keyword arguments of `design_survey` and `design_corridor`.

    Either ``camera`` and one of ``gsd_m`` and ``height_m`` are given, or ``height_m`` and ``spacing_m`` without a
    camera. All others are optional.

    Attributes
    ----------
    camera : Camera or None
        One of `CAMERAS`, or another.
    is_landscape : bool
        Whether the wide side of the picture lies across the track; default True.
    gsd_m, height_m : float or None
        Ground sampling distance (ground covered by a pixel), 0.0005 to 10 m, or height above the ground, 5 to 10,000 m.
    front_overlap, side_overlap : float
        Overlap with the next picture on the line, and with pictures of the next line, 0 to 0.95; default 0.75 and 0.65.
    spacing_m, trigger_m : float or None
        Distance between lines, and between pictures, instead of those that follow from the overlaps.
    wind : Wind or None
        Expected wind; calm by default.
    margin_m : float or None
        How far beyond the edge pictures reach; by default as far as the overlap needs to hold up to the edge.
    lead_in_m : float or None
        Straight distance before a line; by default until the plane has settled on it.
    is_above_terrain : bool
        Whether altitudes count from the terrain (frame 10), which the vehicle has to know, instead of home; default
        False.
    ground_rel_home_m : float or None
        Height of the ground above home. By default it is that of home, and a caution says so.
    airspeed_m_s : float or None
        Airspeed set by an item, 5 to 60; by default the plane's cruise.
    home : Home or None
        Home, where altitudes count from; its altitude above sea level widens turns.
    coming_from : GeoPoint or None
        Begin at the end nearest to this position; by default downwind, so that the survey proceeds against the wind.
    max_items : int
        Items that the vehicle can store, home included; default 650.
    parameters : mapping of str to float or None
        The vehicle's parameters, as :func:`vencejo.params.load_params` gives them, for its turns. A missing one has the
        value of ArduPilot's simulated plane.
    """

    camera: Camera | None
    is_landscape: bool
    gsd_m: float | None
    height_m: float | None
    front_overlap: float
    side_overlap: float
    spacing_m: float | None
    trigger_m: float | None
    wind: Wind | None
    margin_m: float | None
    lead_in_m: float | None
    is_above_terrain: bool
    ground_rel_home_m: float | None
    airspeed_m_s: float | None
    home: Home | None
    coming_from: GeoPoint | None
    max_items: int
    parameters: Mapping[str, float] | None


_DEFAULTS: Final[SurveyOptions] = {
    "camera": None,
    "is_landscape": True,
    "gsd_m": None,
    "height_m": None,
    "front_overlap": 0.75,
    "side_overlap": 0.65,
    "spacing_m": None,
    "trigger_m": None,
    "wind": None,
    "margin_m": None,
    "lead_in_m": None,
    "is_above_terrain": False,
    "ground_rel_home_m": None,
    "airspeed_m_s": None,
    "home": None,
    "coming_from": None,
    "max_items": 650,
    "parameters": None,
}


def design_survey(
    area: Sequence[GeoPoint], *, course_deg: float | None = None, **options: Unpack[SurveyOptions]
) -> Survey:
    """Lay out a survey of an area, and rehearse it.

    Parameters
    ----------
    area : sequence of GeoPoint
        Its corners in order, 3 to 1,000. It may be concave, and may not cross itself.
    course_deg : float, optional
        Course of the lines, degrees from true north; by default across the wind, in calm air along the area.
    **options
        Keyword arguments of `SurveyOptions`, such as ``camera`` and ``gsd_m``.

    Raises
    ------
    InvalidRequest
        For a value out of its range, an area that crosses itself or is too small, too many items, and a wind that is
        too strong; the message names the option or the corner, and what to change.
    """
    return _design(area, None, course_deg, options)


def design_corridor(line: Sequence[GeoPoint], width_m: float, **options: Unpack[SurveyOptions]) -> Survey:
    """Lay out a survey of a strip along a line, ``width_m`` wide (0 to 5,000; 0: one pass), and rehearse it.

    Its passes are parallel to the line. A corner that would bank the camera off the strip is flown straight on, and the
    next leg is begun anew. Options and exceptions are those of `design_survey`.

    Examples
    --------
    >>> from vencejo import GeoPoint
    >>> road = (GeoPoint(40.33, -3.80), GeoPoint(40.34, -3.80), GeoPoint(40.34, -3.785))
    >>> corridor = design_corridor(road, 40.0, camera=CAMERAS["Sony a6000 16mm"], height_m=120.0)
    >>> len(corridor.lines), corridor.flown.covered
    (2, 1.0)
    """
    return _design(line, width_m, None, options)


def redesign(complex_item: ComplexItem, **changes: Any) -> Survey:
    """Lay out a survey or corridor of a plan again with changed options, and rehearse it.

    Parameters
    ----------
    complex_item : ComplexItem
        One of ``plan.settings.complex_items``. QGroundControl's own give their area, camera, overlap, height and angle.
    **changes
        Arguments of `design_survey` or `design_corridor`: options, ``course_deg`` and ``area``, or ``line`` and
        ``width_m``. Give ``home`` and ``parameters`` again: they are not stored in plans.

    Raises
    ------
    InvalidRequest
        For an item that is not a survey or is incomplete; and as `design_survey`.
    TypeError
        For an unknown argument.

    Examples
    --------
    >>> from vencejo import GeoPoint, Plan
    >>> field = (GeoPoint(40.33, -3.80), GeoPoint(40.33, -3.79), GeoPoint(40.337, -3.79), GeoPoint(40.337, -3.80))
    >>> plan = design_survey(field, camera=CAMERAS["Sony a6000 16mm"], height_m=120.0).placed_in(Plan())
    >>> [old] = plan.settings.complex_items
    >>> lower = redesign(old, height_m=90.0)
    >>> plan = lower.placed_in(plan, replacing=old)
    >>> plan.items == lower.items, lower.height_m
    (True, 90.0)
    """
    known = _native.survey_of(complex_item.kind, complex_item.json)
    if known is None:
        raise InvalidRequest(f"a {complex_item.kind} cannot be laid out again; give a survey or a corridor")
    places, width_m, asked = known
    place, wind, camera = asked["coming_from"], asked["wind"], asked["camera"]
    given: dict[str, Any] = asked | {
        "coming_from": None if place is None else GeoPoint(*place),
        "wind": None if wind is None else Wind(*wind),
        "camera": None if camera is None else Camera(*camera),
    }
    # Each follows from the other: a change of one drops the other.
    for one, other in (("gsd_m", "height_m"), ("height_m", "gsd_m")):
        if changes.get(one) is not None:
            given[other] = None
    if width_m is None:
        return design_survey(changes.pop("area", _points(places)), **(given | changes))
    del given["course_deg"]
    line, width_m = changes.pop("line", _points(places)), changes.pop("width_m", width_m)
    return design_corridor(line, width_m, **(given | changes))


_CONVERTED: Final = frozenset({"camera", "wind", "home", "coming_from", "parameters"})
"""Options that the core takes in another form."""


def _design(
    places: Sequence[GeoPoint], width_m: float | None, course_deg: float | None, options: SurveyOptions
) -> Survey:
    if unknown := options.keys() - _DEFAULTS.keys():
        raise TypeError(f"surveys have no option {', '.join(sorted(unknown))}; they have {', '.join(_DEFAULTS)}")
    given: SurveyOptions = {**_DEFAULTS, **options}
    camera, wind, home, coming_from = given["camera"], given["wind"], given["home"], given["coming_from"]
    whole = {"max_items": (given["max_items"], 1, 65_535)}
    if camera is not None:
        pixels = {"image_width_px": camera.image_width_px, "image_height_px": camera.image_height_px}
        whole |= {name: (count, 16, 100_000) for name, count in pixels.items()}
    for name, (value, low, high) in whole.items():
        if not low <= value <= high:
            raise InvalidRequest(f"survey: {name} is {value}, should be {low} to {high}")
    asked: dict[str, Any] = {name: value for name, value in given.items() if name not in _CONVERTED} | {
        "course_deg": course_deg,
        "camera": None if camera is None else astuple(camera),
        "wind": None if wind is None else (wind.from_deg, wind.speed_m_s),
        "home": None if home is None else (home.lat_deg, home.lon_deg, home.alt_amsl_m),
        "coming_from": None if coming_from is None else (coming_from.lat_deg, coming_from.lon_deg),
    }
    laid = _native.design_survey(
        [(place.lat_deg, place.lon_deg) for place in places],
        width_m=width_m,
        asked=asked,
        parameters={name: float(value) for name, value in (given["parameters"] or {}).items()},
    )
    flown = laid["flown"]
    flown |= {
        "photos": tuple(
            Photo(time_s, lat, lon, alt, heading, bank, pitch, None if shows is None else _points(shows))
            for time_s, (lat, lon, alt), (heading, bank, pitch), shows in flown["photos"]
        ),
        "holes": tuple(Hole(GeoPoint(*place), area_m2) for place, area_m2 in flown["holes"]),
        "lines": tuple(FlownLine(*line) for line in flown["lines"]),
        "findings": findings_of(flown["findings"]),
    }
    laid |= {
        "items": tuple(MissionItem(*item) for item in laid["items"]),
        "lines": tuple(_points(line) for line in laid["lines"]),
        "cautions": tuple(SurveyCaution(*caution) for caution in laid["cautions"]),
        "complex_item": ComplexItem(*laid["complex_item"]),
        "flown": FlownSurvey(**flown),
    }
    return Survey(**laid)


def _points(places: Sequence[tuple[float, float]]) -> tuple[GeoPoint, ...]:
    return tuple(GeoPoint(*place) for place in places)
