"""The camera geometry: projection of world points to pixels, and back to directions.

A pinhole camera in the nose, looking along the body's x axis, its rows parallel to the wings. The world is north, east,
up in metres from home; the ground falls away from the camera with the square of the distance over twice the Earth's
radius, which puts the horizon at its true dip (A. French, "How far away is the horizon?", Am. J. Phys. 50, 1982,
without refraction).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

__all__ = ["EARTH_RADIUS_M", "NOSE_M", "Array", "Pinhole", "Pose", "ned_from_body"]

Array = npt.NDArray[np.float32]

EARTH_RADIUS_M = 6_371_008.8
"""Mean radius (IUGG)."""
NOSE_M = 0.35
"""Distance of the lens ahead of the centre of gravity."""


@dataclass(frozen=True, slots=True)
class Pose:
    """True position and attitude of the plane."""

    north_m: float
    east_m: float
    up_m: float
    """Height of the centre of gravity above the ground at home."""
    roll_rad: float
    pitch_rad: float
    yaw_rad: float

    def lens_m(self) -> tuple[float, float, float]:
        """North, east, up of the lens; never below the ground."""
        forward = ned_from_body(self.roll_rad, self.pitch_rad, self.yaw_rad)[:, 0] * NOSE_M
        return (
            self.north_m + float(forward[0]),
            self.east_m + float(forward[1]),
            max(0.05, self.up_m - float(forward[2])),
        )


@dataclass(frozen=True, slots=True)
class Pinhole:
    """The camera's geometry: square pixels, no distortion. Pixel (0, 0) is the centre of the upper left one."""

    width_px: int = 640
    height_px: int = 480
    fov_deg: float = 70.0
    """Horizontal field of view."""

    @property
    def focal_px(self) -> float:
        """Focal length."""
        return self.width_px / 2.0 / math.tan(math.radians(self.fov_deg) / 2.0)

    @property
    def centre_px(self) -> tuple[float, float]:
        """Column and row of the optical axis."""
        return (self.width_px - 1) / 2.0, (self.height_px - 1) / 2.0

    def from_world(self, pose: Pose, points_m: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Camera coordinates (right, down, forward; metres) of points (north, east, up), one a row."""
        north, east, up = pose.lens_m()
        way = points_m - np.array((north, east, up))
        fall = (way[:, 0] ** 2 + way[:, 1] ** 2) / (2.0 * EARTH_RADIUS_M)
        ned = np.column_stack((way[:, 0], way[:, 1], fall - way[:, 2]))
        body = ned @ ned_from_body(pose.roll_rad, pose.pitch_rad, pose.yaw_rad)
        return body[:, (1, 2, 0)]

    def pixel(self, camera_m: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Column and row of camera coordinates in front of the camera."""
        column, row = self.centre_px
        scale = self.focal_px / camera_m[:, 2]
        return np.column_stack((column + camera_m[:, 0] * scale, row + camera_m[:, 1] * scale))


def ned_from_body(roll_rad: float, pitch_rad: float, yaw_rad: float) -> npt.NDArray[np.float64]:
    """Rotation from body axes (ahead, right, down) to north, east, down (J. Diebel 2006, eq. 287, transposed)."""
    cr, sr = math.cos(roll_rad), math.sin(roll_rad)
    cp, sp = math.cos(pitch_rad), math.sin(pitch_rad)
    cy, sy = math.cos(yaw_rad), math.sin(yaw_rad)
    return np.array(
        (
            (cp * cy, sr * sp * cy - cr * sy, cr * sp * cy + sr * sy),
            (cp * sy, sr * sp * sy + cr * cy, cr * sp * sy - sr * cy),
            (-sp, sr * cp, cr * cp),
        )
    )
