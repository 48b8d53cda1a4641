"""The geofence: enabled fences and their breaches, by ArduPlane's FENCE_* parameters.

The reaction to a breach (FENCE_ACTION) is in :mod:`vencejo.sim.autopilot.fence_response`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntFlag

from vencejo.sim.autopilot.interface import FenceBreach, Parameters, Snapshot
from vencejo.sim.plan_store import FenceShape, FenceStore

__all__ = ["FenceMonitor", "FenceStatus", "FenceType", "fence_names"]

_METRES_PER_DEGREE = 111_318.845
"""Length of a degree of latitude on ArduPilot's sphere (LOCATION_SCALING_FACTOR)."""


class FenceType(IntFlag):
    """Bits of FENCE_TYPE and of a breach."""

    ALT_MAX = 1
    CIRCLE = 2
    POLYGON = 4
    ALT_MIN = 8


_NAMES = {
    FenceType.ALT_MAX: "Max Alt",
    FenceType.CIRCLE: "Circle",
    FenceType.POLYGON: "Polygon",
    FenceType.ALT_MIN: "Min Alt",
}
_KINDS = {
    FenceType.ALT_MIN: FenceBreach.MIN_ALT,
    FenceType.ALT_MAX: FenceBreach.MAX_ALT,
    FenceType.CIRCLE: FenceBreach.CIRCLE,
    FenceType.POLYGON: FenceBreach.POLYGON,
}


def fence_names(breaches: FenceType) -> str:
    """ArduPlane's names of fences, as in "Circle and Polygon"."""
    names = [name for bit, name in _NAMES.items() if bit & breaches]
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + " and " + names[-1] if names else ""


@dataclass(frozen=True, slots=True)
class FenceStatus:
    """Content of FENCE_STATUS."""

    breached: bool
    count: int
    kind: int
    """FENCE_BREACH: 0 none, 1 minimum altitude, 2 maximum altitude, 3 boundary."""
    time_s: float


def _offset_m(lat_deg: float, lon_deg: float, origin: tuple[float, float]) -> tuple[float, float]:
    """North and east of ``origin`` on a flat earth; accurate to a few centimetres at the size of a fence."""
    lon_difference = (lon_deg - origin[1] + 180.0) % 360.0 - 180.0
    scale = math.cos(math.radians((lat_deg + origin[0]) / 2.0))
    return (lat_deg - origin[0]) * _METRES_PER_DEGREE, lon_difference * _METRES_PER_DEGREE * scale


def _inside(shape: FenceShape, lat_deg: float, lon_deg: float) -> bool:
    here = (lat_deg, lon_deg)
    if shape.command in (5003, 5004):
        return math.hypot(*_offset_m(*shape.points[0], here)) <= shape.radius_m
    # Crossing number: a ray to the north from inside crosses the border an odd number of times.
    points = [_offset_m(lat, lon, here) for lat, lon in shape.points]
    inside = False
    for (n1, e1), (n2, e2) in zip(points, points[1:] + points[:1], strict=True):
        if (e1 > 0) != (e2 > 0) and n1 + (n2 - n1) * (0 - e1) / (e2 - e1) > 0:
            inside = not inside
    return inside


def shapes_breached(shapes: Sequence[FenceShape], lat_deg: float, lon_deg: float, *, union: bool) -> bool:
    """Whether a position is outside an inclusion shape or inside an exclusion shape.

    With ``union`` (FENCE_OPTIONS bit 1) being inside one of the inclusion shapes is enough.
    """
    inclusions = [s for s in shapes if s.command in (5001, 5003)]
    exclusions = [s for s in shapes if s.command in (5002, 5004)]
    if any(_inside(shape, lat_deg, lon_deg) for shape in exclusions):
        return True
    inside = [_inside(shape, lat_deg, lon_deg) for shape in inclusions]
    if not inside:
        return False
    return not any(inside) if union else not all(inside)


class FenceMonitor:
    """Checks one plane against its fence; call :meth:`check` about ten times a simulated second."""

    def __init__(self, params: Parameters, store: FenceStore) -> None:
        self._params = params
        self._store = store
        self._param_enable: float | None = None
        self._chosen = FenceType(0)
        self._has_origin = False
        self._above_floor = False
        self._was_flying = False
        self._was_armed = False
        self.breaches = FenceType(0)
        self.status = FenceStatus(breached=False, count=0, kind=0, time_s=0.0)

    @property
    def enabled(self) -> bool:
        """Whether any fence is enabled; FENCE_STATUS is sent only then."""
        return bool(self._enabled)

    @property
    def _enabled(self) -> FenceType:
        """The enabled fences that are present; one enabled before it was loaded counts from then on."""
        return self._chosen & self.present

    @property
    def present(self) -> FenceType:
        """The configured fences (FENCE_TYPE); the polygon only once it is stored, and loaded at the first fix."""
        configured = FenceType(int(self._params.get("FENCE_TYPE")) & 15)
        loaded = self._has_origin and any(shape.command != 5000 for shape in self._store.shapes)
        return configured if loaded else configured & ~FenceType.POLYGON

    def enable(self, on: bool, fences: FenceType) -> None:
        """DO_FENCE_ENABLE and FENCE_AUTOENABLE; breaches of disabled fences are cleared."""
        fences &= FenceType(int(self._params.get("FENCE_TYPE")) & 15)
        self._chosen = (self._chosen | fences) if on else (self._chosen & ~fences)
        self.breaches &= self._enabled

    def reset(self) -> None:
        """Reset after a reboot."""
        self.__init__(self._params, self._store)  # type: ignore[misc]

    def contains(self, lat_deg: float, lon_deg: float, alt_rel_home_m: float | None, now: Snapshot) -> bool:
        """Whether a destination is within the enabled fences; an unknown altitude (None) is not checked."""
        get, enabled = self._params.get, self._enabled
        if alt_rel_home_m is not None:
            if enabled & FenceType.ALT_MAX and alt_rel_home_m > get("FENCE_ALT_MAX"):
                return False
            if enabled & FenceType.ALT_MIN and alt_rel_home_m < get("FENCE_ALT_MIN"):
                return False
        home = (now.home_lat_deg, now.home_lon_deg)
        if enabled & FenceType.CIRCLE and math.hypot(*_offset_m(lat_deg, lon_deg, home)) > get("FENCE_RADIUS"):
            return False
        return not enabled & FenceType.POLYGON or not shapes_breached(
            self._store.shapes, lat_deg, lon_deg, union=self._union
        )

    @property
    def return_point(self) -> tuple[float, float] | None:
        """Return point of FENCE_ACTION 6 and 7: the stored one, or the middle of the first inclusion polygon."""
        shapes = self._store.shapes
        for shape in shapes:
            if shape.command == 5000:
                return shape.points[0]
        for shape in shapes:
            if shape.command == 5001:
                lats, lons = zip(*shape.points, strict=True)
                return (min(lats) + max(lats)) / 2.0, (min(lons) + max(lons)) / 2.0
        return None

    @property
    def _union(self) -> bool:
        return bool(int(self._params.get("FENCE_OPTIONS")) & 2)

    def _automatic(self, now: Snapshot) -> None:
        enable = self._params.get("FENCE_ENABLE")
        if enable != self._param_enable:
            self._param_enable = enable
            self._chosen = FenceType(0)
            self.enable(bool(enable), FenceType(15) & ~FenceType.ALT_MIN)
        mode = int(self._params.get("FENCE_AUTOENABLE"))
        if mode in (1, 2) and now.is_flying != self._was_flying:
            self.enable(now.is_flying, self.present)
        if mode == 3 and now.armed != self._was_armed:
            self.enable(now.armed, self.present & ~FenceType.ALT_MIN)
        self._was_flying, self._was_armed = now.is_flying, now.armed
        if not now.is_flying:
            self._above_floor = False
        elif self._enabled and now.alt_rel_home_m > self._params.get("FENCE_ALT_MIN") + self._params.get(
            "FENCE_MARGIN"
        ):
            # The floor counts only once the plane has climbed above it.
            if not self._above_floor and self.present & FenceType.ALT_MIN:
                self._chosen |= FenceType.ALT_MIN
            self._above_floor = True

    def _crossed(self, now: Snapshot, *, landing: bool) -> FenceType:
        get = self._params.get
        crossed = FenceType(0)
        if self._enabled & FenceType.ALT_MAX and now.alt_rel_home_m >= get("FENCE_ALT_MAX"):
            crossed |= FenceType.ALT_MAX
        floor = self._enabled & FenceType.ALT_MIN and self._above_floor and not landing
        if floor and now.alt_rel_home_m <= get("FENCE_ALT_MIN"):
            crossed |= FenceType.ALT_MIN
        if self._enabled & FenceType.CIRCLE:
            home = (now.home_lat_deg, now.home_lon_deg)
            if math.hypot(*_offset_m(now.lat_deg, now.lon_deg, home)) >= get("FENCE_RADIUS"):
                crossed |= FenceType.CIRCLE
        if self._enabled & FenceType.POLYGON and shapes_breached(
            self._store.shapes, now.lat_deg, now.lon_deg, union=self._union
        ):
            crossed |= FenceType.POLYGON
        return crossed

    def check(self, now: Snapshot, *, landing: bool) -> tuple[FenceType, bool]:
        """The newly breached fences, and whether the last breach has just ended.

        Parameters
        ----------
        now : Snapshot
            The present state.
        landing : bool
            Whether the plane is landing, when the floor is not checked.
        """
        self._has_origin |= now.gps_fix_type >= 3
        self._automatic(now)
        before = self.breaches
        # While disarmed, breaches count for the pre-arm check only.
        self.breaches = self._crossed(now, landing=landing) if self._enabled else FenceType(0)
        new = self.breaches & ~before
        if new and now.armed:
            kind = 1 if new & FenceType.ALT_MIN else 2 if new & FenceType.ALT_MAX else 3
            self.status = FenceStatus(breached=True, count=self.status.count + 1, kind=kind, time_s=now.time_s)
        elif not self.breaches and self.status.breached:
            self.status = FenceStatus(
                breached=False, count=self.status.count, kind=self.status.kind, time_s=self.status.time_s
            )
        return (new if now.armed else FenceType(0)), bool(before) and not self.breaches

    @staticmethod
    def kind(breaches: FenceType) -> FenceBreach:
        """The breach reported to the autopilot, the most severe one."""
        for bit, kind in _KINDS.items():
            if breaches & bit:
                return kind
        raise ValueError("no fence is breached")

    def prearm(self) -> list[str]:
        """The failing pre-arm checks of the fence, in ArduPlane's words."""
        if not self._enabled and not int(self._params.get("FENCE_AUTOENABLE")):
            return []
        get = self._params.get
        if int(get("FENCE_TYPE")) == 0:
            return ["Fences enabled, but none selected"]
        found: list[str] = []
        present = self.present
        if present & FenceType.CIRCLE and get("FENCE_RADIUS") < 0:
            found.append("Invalid Circle FENCE_RADIUS value")
        if present & FenceType.ALT_MAX and get("FENCE_ALT_MAX") < 0:
            found.append("Invalid FENCE_ALT_MAX value")
        if present & FenceType.ALT_MIN and get("FENCE_ALT_MIN") < -100:
            found.append("Invalid FENCE_ALT_MIN value")
        if self.breaches:
            found.append(f"Vehicle breaching {fence_names(self.breaches)}")
        if get("FENCE_MARGIN") < 0:
            found.append("Invalid FENCE_MARGIN value")
        both = FenceType.ALT_MAX | FenceType.ALT_MIN
        if present & both == both and get("FENCE_ALT_MAX") < get("FENCE_ALT_MIN"):
            found.append("FENCE_ALT_MAX < FENCE_ALT_MIN")
        return found[:1]
