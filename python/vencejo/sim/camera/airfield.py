"""The objects at home: runway, home mark, landing mark, hangar and mast.

The runway lies along the start heading, from 20 m behind home, 300 m long and 16 m wide.
Points are north, east, up in metres from home.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

__all__ = ["RUNWAY_BEHIND_M", "RUNWAY_LENGTH_M", "RUNWAY_WIDTH_M", "Face", "airfield", "home_mark", "landing_mark"]

RUNWAY_BEHIND_M = 20.0
RUNWAY_LENGTH_M = 300.0
RUNWAY_WIDTH_M = 16.0

_ASPHALT = (86, 82, 80)
_WHITE = (238, 238, 238)
_ORANGE = (20, 110, 250)
_SUN_NE = (-math.sqrt(0.5), math.sqrt(0.5))
"""Horizontal direction of the sun: south-east."""


@dataclass(frozen=True, slots=True)
class Face:
    """A plane convex polygon of one colour (blue, green, red)."""

    corners_m: npt.NDArray[np.float64]
    colour: tuple[int, int, int]
    solid: bool = False
    """Upright: painted after the ground, the far ones first."""


def airfield(heading_deg: float) -> list[Face]:
    """All fixed faces, in painting order."""
    place = _Place(0.0, 0.0, heading_deg)
    half = RUNWAY_WIDTH_M / 2.0
    start, end = -RUNWAY_BEHIND_M, RUNWAY_LENGTH_M - RUNWAY_BEHIND_M
    # In segments: a long thin face that is near and far at once clips better that way.
    faces = [place.flat(along, along + 50.0, -half, half, _ASPHALT) for along in np.arange(start, end, 50.0)]
    for side in (-half + 0.6, half - 0.6):
        faces += [
            place.flat(along, along + 50.0, side - 0.25, side + 0.25, _WHITE) for along in np.arange(start, end, 50.0)
        ]
    for along in np.arange(start + 27.0, end - 20.0, 15.0):
        faces.append(place.flat(along, along + 8.0, -0.25, 0.25, _WHITE))
    for begin in (start + 2.0, end - 10.0):
        for stripe in range(-3, 4):
            if stripe:
                middle = stripe * 2.0
                faces.append(place.flat(begin, begin + 8.0, middle - 0.6, middle + 0.6, _WHITE))
    faces += _hangar(place, along=40.0, right=38.0)
    faces += _mast(place, along=60.0, right=-20.0)
    return faces


def home_mark(north_m: float, east_m: float) -> list[Face]:
    """A white ring 6 m across, with four rays to the cardinal points."""
    place = _Place(north_m, east_m, 0.0)
    return [
        *place.ring(3.0, 2.5, _WHITE),
        place.flat(3.0, 5.0, -0.25, 0.25, _WHITE),
        place.flat(-5.0, -3.0, -0.25, 0.25, _WHITE),
        place.flat(-0.25, 0.25, 3.0, 5.0, _WHITE),
        place.flat(-0.25, 0.25, -5.0, -3.0, _WHITE),
    ]


def landing_mark(north_m: float, east_m: float) -> list[Face]:
    """An orange cross of 12 m in a ring, at a landing point."""
    place = _Place(north_m, east_m, 45.0)
    return [
        *place.ring(7.0, 6.2, _ORANGE),
        place.flat(-6.0, 6.0, -0.7, 0.7, _ORANGE),
        place.flat(-0.7, 0.7, -6.0, 6.0, _ORANGE),
    ]


class _Place:
    """Points ahead and to the right of a position with a heading."""

    def __init__(self, north_m: float, east_m: float, heading_deg: float) -> None:
        self._north, self._east = north_m, east_m
        self._cos, self._sin = math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg))

    def point(self, along: float, right: float, up: float = 0.0) -> tuple[float, float, float]:
        north = self._north + along * self._cos - right * self._sin
        return north, self._east + along * self._sin + right * self._cos, up

    def face(
        self, corners: Sequence[tuple[float, float, float]], colour: tuple[int, int, int], *, solid: bool = False
    ) -> Face:
        return Face(np.array([self.point(*corner) for corner in corners], np.float64), colour, solid)

    def flat(self, start: float, end: float, left: float, right: float, colour: tuple[int, int, int]) -> Face:
        return self.face(((start, left, 0), (end, left, 0), (end, right, 0), (start, right, 0)), colour)

    def ring(self, outer: float, inner: float, colour: tuple[int, int, int]) -> list[Face]:
        faces = []
        for k in range(16):
            a, b = math.tau * k / 16, math.tau * (k + 1) / 16
            corners = [
                (r * math.cos(t), r * math.sin(t), 0.0) for r, t in ((outer, a), (outer, b), (inner, b), (inner, a))
            ]
            faces.append(self.face(corners, colour))
        return faces


def _shaded(colour: tuple[int, int, int], light: float) -> tuple[int, int, int]:
    return tuple(min(255, round(part * light)) for part in colour)  # type: ignore[return-value]


def _box(
    place: _Place, along: float, right: float, size: tuple[float, float, float], colour: tuple[int, int, int]
) -> list[Face]:
    """An upright box with a roof; walls are lit by their angle to the sun."""
    long, wide, high = size
    corners = [(along, right), (along + long, right), (along + long, right + wide), (along, right + wide)]
    faces = []
    for k in range(4):
        (a0, r0), (a1, r1) = corners[k], corners[(k + 1) % 4]
        p, q = place.point(a0, r0), place.point(a1, r1)
        span = math.hypot(q[0] - p[0], q[1] - p[1])
        outward = ((q[1] - p[1]) / span, -(q[0] - p[0]) / span)
        light = 0.62 + 0.38 * max(0.0, outward[0] * _SUN_NE[0] + outward[1] * _SUN_NE[1])
        wall = [(a0, r0, 0.0), (a1, r1, 0.0), (a1, r1, high), (a0, r0, high)]
        faces.append(place.face(wall, _shaded(colour, light), solid=True))
    faces.append(place.face([(a, r, high) for a, r in corners], _shaded(colour, 1.05), solid=True))
    return faces


def _hangar(place: _Place, *, along: float, right: float) -> list[Face]:
    return _box(place, along, right, (24.0, 16.0, 6.5), (178, 188, 196))


def _mast(place: _Place, *, along: float, right: float) -> list[Face]:
    return [
        *_box(place, along, right, (0.25, 0.25, 6.0), (215, 215, 215)),
        *_box(place, along - 0.1, right - 0.1, (0.45, 2.4, 0.5), (40, 90, 245)),
    ]
