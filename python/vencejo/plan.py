"""Plans: missions, fences and rally points, as files and as the vehicle has them.

A `Plan` and its parts are immutable values; a field of the wrong type raises `TypeError` on construction. Items never
include home: the first item is item 1 on an ArduPilot vehicle, whose item 0 is home.

Examples
--------
>>> from vencejo import MissionItem, Plan
>>> plan = Plan(
...     items=(
...         MissionItem.takeoff(40.3332, -3.7978, alt_rel_home_m=50.0, pitch_deg=15.0),
...         MissionItem.waypoint(40.3362, -3.7978, alt_rel_home_m=80.0),
...         MissionItem.return_to_launch(),
...     )
... )
>>> len(plan.items)
3
>>> [finding.code for finding in plan.check() if finding.severity == "error"]
[]
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from vencejo import _native
from vencejo._files import read_bounded
from vencejo._given import FLAG, NONE, NUMBER, WHOLE, check, check_each
from vencejo.errors import FileFormatError, PlanRefused
from vencejo.findings import Finding
from vencejo.items import Command, Frame, GeoPoint, Home, MissionItem
from vencejo.storage import write_file

if TYPE_CHECKING:
    from vencejo.telemetry import HomePosition

__all__ = [
    "Circle",
    "Command",
    "ComplexItem",
    "Fence",
    "Finding",
    "Frame",
    "GeoPoint",
    "Home",
    "MissionItem",
    "Plan",
    "PlanNote",
    "PlanSettings",
    "Polygon",
    "RallyPoint",
]


PLAN_ENDINGS: Final = tuple(f".{ending}" for ending in _native.PLAN_ENDINGS)
"""File name endings that `Plan.save` writes."""


@dataclass(frozen=True)
class Polygon:
    """A fence polygon of at least three corners, to stay inside or outside of."""

    points: tuple[GeoPoint, ...]
    inclusion: bool = True

    def __post_init__(self) -> None:
        check(self, inclusion=FLAG)
        object.__setattr__(self, "points", check_each(self, "points", GeoPoint))


@dataclass(frozen=True)
class Circle:
    """A fence circle, to stay inside or outside of. Radius in metres."""

    center: GeoPoint
    radius_m: float
    inclusion: bool = True

    def __post_init__(self) -> None:
        check(self, center=(GeoPoint,), radius_m=NUMBER, inclusion=FLAG)


@dataclass(frozen=True)
class Fence:
    """A fence: zones to stay inside or outside of.

    Attributes
    ----------
    zones : tuple of Polygon or Circle
    return_point : RallyPoint or None
        Where to fly on a breach, its altitude above home; ``None`` leaves it to the vehicle.
    """

    zones: tuple[Polygon | Circle, ...] = ()
    return_point: RallyPoint | None = None

    def __post_init__(self) -> None:
        check(self, return_point=(RallyPoint, NONE))
        object.__setattr__(self, "zones", check_each(self, "zones", Polygon, Circle))


@dataclass(frozen=True)
class RallyPoint:
    """A point to return to instead of home. Altitude in metres, in its `frame`."""

    lat_deg: float
    lon_deg: float
    alt_m: float
    frame: int = Frame.GLOBAL_RELATIVE_ALT

    def __post_init__(self) -> None:
        check(self, lat_deg=NUMBER, lon_deg=NUMBER, alt_m=NUMBER, frame=WHOLE)
        if not 0 <= self.frame <= 0xFF:
            raise ValueError(f"a rally point in frame {self.frame}: a MAV_FRAME is 0 to 255")


@dataclass(frozen=True)
class ComplexItem:
    """A complex item of a ``.plan`` file: a survey, a corridor, a landing pattern, a structure scan.

    The mission contains its simple items. It is kept beside them, and written instead of them as long as they are
    unchanged in the mission, so that QGroundControl can edit it again.

    Attributes
    ----------
    kind : str
        ``"survey"``, ``"CorridorScan"``, ``"fwLandingPattern"``, ``"StructureScan"``…
    json : str
        The whole item as JSON.
    """

    kind: str
    json: str

    def __post_init__(self) -> None:
        check(self, kind=(str,), json=(str,))


@dataclass(frozen=True)
class PlanSettings:
    """Settings of a ``.plan`` file beside the plan. QGroundControl uses them for planning; they are not sent to vehicles.

    Attributes
    ----------
    cruise_speed_m_s, hover_speed_m_s : float or None
        Speeds from which times are planned.
    vehicle_type : int or None
        MAV_TYPE; 1 is a fixed-wing plane.
    firmware_type : int or None
        MAV_AUTOPILOT; 3 is ArduPilot.
    complex_items : tuple of ComplexItem
        Complex items of the mission, in the order of the file.
    """

    cruise_speed_m_s: float | None = None
    hover_speed_m_s: float | None = None
    vehicle_type: int | None = None
    firmware_type: int | None = None
    complex_items: tuple[ComplexItem, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "complex_items", check_each(self, "complex_items", ComplexItem))
        speed, kind = (*NUMBER, NONE), (*WHOLE, NONE)
        check(self, cruise_speed_m_s=speed, hover_speed_m_s=speed, vehicle_type=kind, firmware_type=kind)


@dataclass(frozen=True)
class PlanNote:
    """Something that reading a file assumed or left out, or that writing one could not keep.

    Attributes
    ----------
    code : str
        Stable name, such as ``"heights-missing"``; `schemas/openapi.json` lists them (``PlanFileNoteCode``).
    count : int
        Number of altitudes, items, areas… concerned.
    message : str
        The note in English.
    """

    code: str
    count: int
    message: str

    def __str__(self) -> str:
        return self.message


@dataclass(frozen=True)
class Plan:
    """A plan: the mission to fly, the fence to stay in, and rally points to return to.

    Attributes
    ----------
    items : tuple of MissionItem
        The mission, without home.
    home : Home or None
        Planned home. The vehicle sets its own when it arms.
    fence : Fence
    rally : tuple of RallyPoint
    settings : PlanSettings
        Settings kept from file to file.
    notes : tuple of PlanNote
        What reading the file assumed or left out. Not part of the plan: plans that differ only in it are equal.
    """

    items: tuple[MissionItem, ...] = ()
    home: Home | None = None
    fence: Fence = field(default_factory=Fence)
    rally: tuple[RallyPoint, ...] = ()
    settings: PlanSettings = field(default_factory=PlanSettings)
    notes: tuple[PlanNote, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        check(self, home=(Home, NONE), fence=(Fence,), settings=(PlanSettings,))
        object.__setattr__(self, "notes", check_each(self, "notes", PlanNote))
        object.__setattr__(self, "items", check_each(self, "items", MissionItem))
        object.__setattr__(self, "rally", check_each(self, "rally", RallyPoint))

    def __iter__(self) -> Iterator[MissionItem]:
        return iter(self.items)

    def __len__(self) -> int:
        return len(self.items)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Plan:
        """Read a plan file of any kind, recognised by its content.

        These formats hold plans: ``.plan`` and ``.mission`` (QGroundControl), ``.waypoints`` (QGC WPL 110), ``.fen``
        and ``.ral`` (lines of points). Of map formats, ``.kml``, ``.kmz``, ``.geojson``, ``.gpx`` and ``.csv``: lines,
        else points, become waypoints, areas become zones of the fence to stay inside.

        Surveys, corridors and landing patterns become their simple items, and are kept beside them in
        ``settings.complex_items``, so that `save` writes them again. A structure scan becomes one item that no vehicle
        accepts: only QGroundControl can expand it.

        Altitudes keep their reference; `Plan.notes` says where a file has no reference or no altitude.

        Raises
        ------
        FileFormatError
            When the file cannot be read; the message names the line, the JSON path or the placemark.
        """
        path = Path(path)
        try:
            data = read_bounded(path)
        except OSError as error:
            raise FileFormatError(f"{path}: {error.strerror or error}") from error
        try:
            native, settings, notes = _native.parse_plan(data, path.name)
        except FileFormatError as error:
            raise FileFormatError(f"{path}: {error}") from None
        cruise, hover, vehicle, firmware, complex_items = settings
        kept = tuple(ComplexItem(*item) for item in complex_items)
        return replace(
            cls._from_native(native),
            settings=PlanSettings(cruise, hover, vehicle, firmware, kept),
            notes=tuple(PlanNote(*note) for note in notes),
        )

    def save(self, path: str | os.PathLike[str]) -> tuple[PlanNote, ...]:
        """Write a file in the format of its ending: one of `PLAN_ENDINGS`, such as ``.plan`` or ``.waypoints``.

        A ``.waypoints`` file holds the mission alone, or without a mission the fence, else the rally points. A ``.gpx``
        file holds the positions of the mission. The others hold everything.

        Returns
        -------
        tuple of PlanNote
            What the file does not keep; empty if it keeps everything.

        Raises
        ------
        FileFormatError
            For an unknown ending, or a plan that the format cannot hold.
        InvalidRequest
            For a position that is not on Earth.
        """
        path = Path(path)
        try:
            data, notes = _native.format_plan(self._to_native(), self._native_settings(), path.name)
        except FileFormatError as error:
            raise FileFormatError(f"{path}: {error}") from None
        write_file(path, data)
        return tuple(PlanNote(*note) for note in notes)

    @property
    def edited_complex_items(self) -> tuple[ComplexItem, ...]:
        """Complex items whose simple items were changed; `save` writes their simple items instead."""
        edited = _native.edited_complex_items(self._to_native(), self._native_settings())
        return tuple(self.settings.complex_items[index] for index in edited)

    def _native_settings(self) -> _native._Settings:
        settings = self.settings
        return (
            settings.cruise_speed_m_s,
            settings.hover_speed_m_s,
            settings.vehicle_type,
            settings.firmware_type,
            [(item.kind, item.json) for item in settings.complex_items],
        )

    def check(
        self,
        *,
        position: GeoPoint | Home | HomePosition | None = None,
        on_ground: bool | None = None,
        parameters: Mapping[str, float] | None = None,
    ) -> tuple[Finding, ...]:
        """Find what would make the plan fail or be refused.

        Parameters
        ----------
        position : GeoPoint, Home or HomePosition, optional
            Position of the vehicle or its home; finds plans for another place.
        on_ground : bool, optional
            Whether the vehicle is on the ground; then the mission must begin with a take-off.
        parameters : mapping, optional
            An ArduPlane's, such as those of `vencejo.load_params`: its speeds, bank and fence options.

        Returns
        -------
        tuple of Finding
            The findings, errors first.

        Raises
        ------
        InvalidRequest
            For a position that is not on Earth.
        """
        at = None if position is None else (position.lat_deg, position.lon_deg)
        given = {name: float(value) for name, value in (parameters or {}).items()}
        return findings_of(_native.check_plan(self._to_native(), at, on_ground, given))

    def require_sound(
        self,
        *,
        position: GeoPoint | Home | HomePosition | None = None,
        on_ground: bool | None = None,
        parameters: Mapping[str, float] | None = None,
    ) -> tuple[Finding, ...]:
        """Check the plan, and raise if it has an error; returns the warnings.

        Raises
        ------
        PlanRefused
        """
        return refuse_errors(self.check(position=position, on_ground=on_ground, parameters=parameters))

    @property
    def length_m(self) -> float | None:
        """Length of the mission's path in metres, circles included; ``None`` if it has no end or no position."""
        return _native.mission_length_m(self._to_native())

    def _to_native(self) -> _native._Plan:
        back = self.fence.return_point
        return (
            _home_tuple(self.home),
            [(int(item.command), int(item.frame), item.params, item.autocontinue) for item in self.items],
            [_zone_tuple(zone) for zone in self.fence.zones],
            None if back is None else (back.lat_deg, back.lon_deg, back.alt_m),
            [(point.lat_deg, point.lon_deg, point.alt_m, int(point.frame)) for point in self.rally],
        )

    @classmethod
    def _from_native(cls, native: _native._Plan) -> Plan:
        home, items, zones, return_point, rally = native
        return cls(
            items=tuple(MissionItem(*item) for item in items),
            home=None if home is None else Home(*home),
            fence=Fence(
                tuple(_zone(zone) for zone in zones), None if return_point is None else RallyPoint(*return_point)
            ),
            rally=tuple(RallyPoint(*point) for point in rally),
        )


def findings_of(found: Sequence[dict[str, Any]]) -> tuple[Finding, ...]:
    """Findings as the core gives them, errors first."""
    findings = [Finding(**finding) for finding in found]
    return tuple(sorted(findings, key=lambda finding: finding.severity != "error"))


def refuse_errors(findings: tuple[Finding, ...]) -> tuple[Finding, ...]:
    """The findings, if there is no error among them; raises `PlanRefused` otherwise."""
    errors = [str(finding) for finding in findings if finding.severity == "error"]
    if errors:
        raise PlanRefused("the plan was not sent: " + "; ".join(errors), findings)
    return findings


def _home_tuple(home: Home | None) -> tuple[float, float, float] | None:
    return None if home is None else (home.lat_deg, home.lon_deg, home.alt_amsl_m)


def _zone_tuple(zone: Polygon | Circle) -> _native._Zone:
    if isinstance(zone, Circle):
        return (zone.inclusion, [(zone.center.lat_deg, zone.center.lon_deg)], zone.radius_m)
    return (zone.inclusion, [(point.lat_deg, point.lon_deg) for point in zone.points], None)


def _zone(zone: _native._Zone) -> Polygon | Circle:
    inclusion, points, radius_m = zone
    corners = _points(points)
    if radius_m is not None:
        return Circle(corners[0], radius_m, inclusion)
    return Polygon(corners, inclusion)


def _points(points: Iterable[tuple[float, float]]) -> tuple[GeoPoint, ...]:
    return tuple(GeoPoint(lat_deg, lon_deg) for lat_deg, lon_deg in points)
