"""Surveys: the lines from which a plane photographs an area or a corridor, and what its pictures really show.

Lines lie across the wind, so that the plane is as fast on the way out as on the way back; they are flown in an order in which it can
turn from one to the next, and each begins with a straight way on which it settles. The survey is rehearsed at once: where each
picture is taken, how much of the area they show, and which lines were missed. The formulas and their sources stand in the core
(``crates/flight/src/survey``).

The ground is level unless heights count from the terrain; nothing is known of what stands on it.

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
from typing import Any, Final, Literal

from vencejo import _native
from vencejo._given import NUMBER, WHOLE, check
from vencejo.errors import InvalidRequest
from vencejo.findings import Finding
from vencejo.landing import Wind
from vencejo.plan import ComplexItem, GeoPoint, Home, MissionItem, Plan, findings_of

__all__ = [
    "CAMERAS",
    "Camera",
    "FlownLine",
    "FlownSurvey",
    "Hole",
    "Photo",
    "Survey",
    "SurveyCaution",
    "design_corridor",
    "design_survey",
    "redesign",
]


@dataclass(frozen=True)
class Camera:
    """What a camera's pictures are made with.

    Attributes
    ----------
    sensor_width_mm, sensor_height_mm : float
        Of the sensor, 0.5 to 200.
    image_width_px, image_height_px : int
        Of the picture, 16 to 100,000.
    focal_length_mm : float
        The real one, not its equivalent on film, 0.5 to 2,000.
    min_interval_s : float
        Least time between two pictures, 0 to 60; 0 when it is not known.
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
"""Cameras that are flown on small planes, by the names that QGroundControl has for them."""


@dataclass(frozen=True)
class SurveyCaution:
    """What the pilot should know of a survey before it is flown.

    Attributes
    ----------
    code : str
        ``"ground-not-known"``, ``"camera-too-slow"``, ``"along-wind"``, ``"tight-turns"`` or ``"gaps"``.
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
        Since the start.
    lat_deg, lon_deg, alt_rel_home_m : float
        Where the plane is.
    heading_deg, bank_deg, pitch_deg : float
        How it flies then; a bank to the right is positive.
    shows : tuple of GeoPoint or None
        The corners of the ground that it shows; ``None`` for one that looks beyond the horizon, and without a camera.
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
    """Ground that no picture shows.

    Attributes
    ----------
    point : GeoPoint
        Its middle.
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
        Farthest from the line while pictures are taken; ``None`` when it is not flown.
    photos : int
    is_missed : bool
        Whether it is not flown, or so far aside that nothing is left of the overlap with the next.
    """

    off_m: float | None
    photos: int
    is_missed: bool


@dataclass(frozen=True)
class FlownSurvey:
    """What the pictures of a survey show when it is flown as rehearsed.

    Attributes
    ----------
    photos : tuple of Photo
    covered, overlapped : float or None
        Part of the area that one picture or more show, and that as many show as the overlap promises, 0 to 1; ``None`` without a
        camera.
    views_promised : int
        How many that is.
    holes : tuple of Hole
        The largest, at most 20.
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
        Waypoints and camera; the first waypoint leads to the first line, the last one away from the last.
    lines : tuple of tuple of GeoPoint
        What is photographed without a stop, in the order flown.
    course_deg : float
        Of the first line, from true north.
    course_from : {"asked", "across-wind", "along-area", "corridor"}
        What gave it.
    height_m : float
        Above the ground.
    gsd_m : float or None
        Ground that a pixel covers; ``None`` without a camera.
    footprint_m : tuple of float or None
        Ground that a picture shows, across and along the track.
    spacing_m : float
        Between two lines.
    trigger_m : float or None
        Between two pictures; ``None`` when the camera is not triggered.
    turn_radius_m, lead_in_m, lead_out_m : float
        Of the turns; straight way before the first picture of a line and after its last.
    groundspeed_m_s : tuple of float
        Slowest and fastest on the lines.
    crab_deg : float
        Between heading and course on the lines, at the most.
    area_m2, line_m, length_m : float
        Of the area; of all that is photographed; of the whole way.
    duration_s : float
        Of the whole way, in this wind.
    photos : int
    cautions : tuple of SurveyCaution
    flown : FlownSurvey
        It, rehearsed.
    complex_item : ComplexItem
        It as QGroundControl's own survey or corridor, for a ``.plan`` file.
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
        """The plan with this survey before the item of that number, counted from 1; at its end when none is given.

        With `replacing`, one of ``plan.settings.complex_items``, it takes that one's place. A jump still leads to the item that it led
        to. Saved as ``.plan``, the survey is one that QGroundControl opens and edits.

        Raises
        ------
        InvalidRequest
            When the items of what it is to replace are not in the plan as it made them.
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


def design_survey(
    area: Sequence[GeoPoint],
    *,
    camera: Camera | None = None,
    is_landscape: bool = True,
    gsd_m: float | None = None,
    height_m: float | None = None,
    front_overlap: float = 0.75,
    side_overlap: float = 0.65,
    spacing_m: float | None = None,
    trigger_m: float | None = None,
    course_deg: float | None = None,
    wind: Wind | None = None,
    margin_m: float | None = None,
    lead_in_m: float | None = None,
    is_above_terrain: bool = False,
    ground_rel_home_m: float | None = None,
    airspeed_m_s: float | None = None,
    home: Home | None = None,
    coming_from: GeoPoint | None = None,
    max_items: int = 650,
    parameters: Mapping[str, float] | None = None,
) -> Survey:
    """Lay out a survey of an area, and rehearse it.

    Either ``gsd_m`` or ``height_m`` is given, and a camera; or without one ``height_m`` and ``spacing_m``.

    Parameters
    ----------
    area : sequence of GeoPoint
        Its corners in order, 3 to 1,000. It may be concave, and may not cross itself.
    camera : Camera, optional
        One of `CAMERAS`, or another.
    is_landscape : bool, optional
        Whether the wide side of the picture lies across the track.
    gsd_m, height_m : float, optional
        Ground that a pixel is to cover, 0.0005 to 10 m, or the height above the ground, 5 to 10,000 m.
    front_overlap, side_overlap : float, optional
        Part of a picture that the next on the line, and those of the next line, show too, 0 to 0.95; default 0.75 and 0.65.
    spacing_m, trigger_m : float, optional
        Distance between lines, and between pictures, in place of those that the overlaps give.
    course_deg : float, optional
        Of the lines; else across the wind, in calm air along the area.
    wind : Wind, optional
        That is expected.
    margin_m : float, optional
        How far beyond the edge pictures reach; else so far that the overlap holds up to the edge.
    lead_in_m : float, optional
        Straight way before a line; else until the plane is settled on it.
    is_above_terrain : bool, optional
        Whether heights count from the ground below (frame 10), which the vehicle has to know, and not from home.
    ground_rel_home_m : float, optional
        Height of the ground above home. When it is not known home's is taken, and a caution says so.
    airspeed_m_s : float, optional
        Set by an item, 5 to 60; else the plane's cruise.
    home : Home, optional
        Where heights count from; its height above the sea makes turns wider.
    coming_from : GeoPoint, optional
        The survey begins at the end that is nearest; else downwind, and goes on against the wind.
    max_items : int, optional
        That the vehicle holds, home with them.
    parameters : mapping of str to float, optional
        The vehicle's, as :func:`vencejo.params.load_params` gives them: how it turns. A missing name has the
        value of ArduPilot's simulated plane.

    Raises
    ------
    InvalidRequest
        For a value out of its range, an area that crosses itself or is too small, too many items, and when the wind is too strong;
        the message names the option or the corner, and what to change.
    """
    return _design(area, None, locals())


def design_corridor(
    line: Sequence[GeoPoint],
    width_m: float,
    *,
    camera: Camera | None = None,
    is_landscape: bool = True,
    gsd_m: float | None = None,
    height_m: float | None = None,
    front_overlap: float = 0.75,
    side_overlap: float = 0.65,
    spacing_m: float | None = None,
    trigger_m: float | None = None,
    wind: Wind | None = None,
    margin_m: float | None = None,
    lead_in_m: float | None = None,
    is_above_terrain: bool = False,
    ground_rel_home_m: float | None = None,
    airspeed_m_s: float | None = None,
    home: Home | None = None,
    coming_from: GeoPoint | None = None,
    max_items: int = 650,
    parameters: Mapping[str, float] | None = None,
) -> Survey:
    """Lay out a survey of a strip along a line, ``width_m`` wide (0 to 5,000; 0: one pass), and rehearse it.

    Its passes are parallel to the line. A corner that would bank the camera off the strip is flown straight over, and the next leg
    begun anew. Everything else is as in `design_survey`.

    Examples
    --------
    >>> from vencejo import GeoPoint
    >>> road = (GeoPoint(40.33, -3.80), GeoPoint(40.34, -3.80), GeoPoint(40.34, -3.785))
    >>> corridor = design_corridor(road, 40.0, camera=CAMERAS["Sony a6000 16mm"], height_m=120.0)
    >>> len(corridor.lines), corridor.flown.covered
    (2, 1.0)
    """
    return _design(line, width_m, locals() | {"course_deg": None})


def redesign(complex_item: ComplexItem, **changes: Any) -> Survey:
    """Lay a survey or corridor out again that is in a plan, from what it was laid out from, and rehearse it.

    Parameters
    ----------
    complex_item : ComplexItem
        One of ``plan.settings.complex_items``. QGroundControl's own give their area, camera, overlap, height and angle.
    **changes
        Arguments of `design_survey`, of which ``home`` and ``parameters`` are nowhere kept; ``area`` with other corners, for a corridor
        ``line`` and ``width_m``.

    Raises
    ------
    InvalidRequest
        For what is no survey, or does not say enough; and as `design_survey`.
    TypeError
        For an argument that there is not.

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
        raise InvalidRequest(f"a {complex_item.kind} is no survey that can be laid out again; give one, or a corridor")
    places, width_m, asked = known
    place, wind, camera = asked["coming_from"], asked["wind"], asked["camera"]
    given: dict[str, Any] = asked | {
        "coming_from": None if place is None else GeoPoint(*place),
        "wind": None if wind is None else Wind(*wind),
        "camera": None if camera is None else Camera(*camera),
    }
    # Either of them gives the other: the one that is said is meant.
    for one, other in (("gsd_m", "height_m"), ("height_m", "gsd_m")):
        if changes.get(one) is not None:
            given[other] = None
    if width_m is None:
        return design_survey(changes.pop("area", _points(places)), **(given | changes))
    del given["course_deg"]
    line, width_m = changes.pop("line", _points(places)), changes.pop("width_m", width_m)
    return design_corridor(line, width_m, **(given | changes))


_ASKED: Final = (
    *("is_landscape", "gsd_m", "height_m", "front_overlap", "side_overlap", "spacing_m", "trigger_m", "course_deg"),
    *("margin_m", "lead_in_m", "is_above_terrain", "ground_rel_home_m", "airspeed_m_s", "max_items"),
)


def _design(places: Sequence[GeoPoint], width_m: float | None, given: dict[str, Any]) -> Survey:
    camera, wind, home, coming_from = given["camera"], given["wind"], given["home"], given["coming_from"]
    whole = {"max_items": (given["max_items"], 1, 65_535)}
    if camera is not None:
        pixels = {"image_width_px": camera.image_width_px, "image_height_px": camera.image_height_px}
        whole |= {name: (count, 16, 100_000) for name, count in pixels.items()}
    for name, (value, low, high) in whole.items():
        if not low <= value <= high:
            raise InvalidRequest(f"survey: {name} is {value}, should be {low} to {high}")
    asked = {name: given[name] for name in _ASKED} | {
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
