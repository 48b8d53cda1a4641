"""Renders the camera's picture: sky, sun, ground in haze, airfield."""

from __future__ import annotations

import functools
import math
import threading
from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt
from cv2.typing import MatLike

from . import ground
from .airfield import Face, airfield, home_mark, landing_mark
from .view import EARTH_RADIUS_M, Array, Pinhole, Pose, ned_from_body

__all__ = ["SUN_AZIMUTH_DEG", "SUN_ELEVATION_DEG", "Renderer"]

SUN_AZIMUTH_DEG = 135.0
SUN_ELEVATION_DEG = 38.0

_HAZE = (222, 212, 202)
_ZENITH = (178, 118, 52)
_HAZE_M = 9_000.0
"""Distance at which haze reaches one half."""
_SKY_ROWS = 512
_SKY_COLUMN = ground.SIZE_PX * 13 // 8
"""Free part of the pyramid, below its second level."""
_DETAIL_BELOW_M = 40.0
"""Height below which single tufts of grass are visible."""
_DETAIL_PERIOD_M = 6.0
_NEAREST_M = 0.15
_FARTHEST_FACE_M = 6_000.0


class Renderer:
    """One camera over one airfield.

    Parameters
    ----------
    heading_deg : float
        Direction of the runway, degrees true.
    camera : Pinhole, optional
    """

    def __init__(self, heading_deg: float, camera: Pinhole | None = None) -> None:
        self.camera = camera if camera is not None else Pinhole()
        with _PAINTING:
            self._atlas, self._sky_row, self._detail = _world()
        self._fixed = airfield(heading_deg)
        self._marked: tuple[object, ...] | None = None
        self.mark((0.0, 0.0), ())
        column, row = self.camera.centre_px
        self._right = ((np.arange(self.camera.width_px) - column) / self.camera.focal_px).astype(np.float32)
        self._down = ((np.arange(self.camera.height_px) - row) / self.camera.focal_px).astype(np.float32)

    def mark(self, home_m: tuple[float, float], landings_m: Sequence[tuple[float, float]]) -> None:
        """Set the positions of home and the landing points: north and east in metres."""
        wanted = (home_m, *landings_m)
        if wanted == self._marked:
            return
        self._marked = wanted
        faces = [*self._fixed, *home_mark(*home_m)]
        for landing in landings_m:
            faces += landing_mark(*landing)
        self._faces_shown: list[Face] = faces
        self._corners = np.concatenate([face.corners_m for face in faces])
        self._starts = np.cumsum([0, *(len(face.corners_m) for face in faces[:-1])])

    def render(self, pose: Pose) -> MatLike:
        """The picture from a pose: rows × columns × (blue, green, red)."""
        picture = self._land_and_sky(pose)
        self._sun(picture, pose)
        self._paint_faces(picture, pose)
        return picture

    # ground and sky: one look-up per pixel

    def _land_and_sky(self, pose: Pose) -> MatLike:
        north, east, height = pose.lens_m()
        rotation = ned_from_body(pose.roll_rad, pose.pitch_rad, pose.yaw_rad).astype(np.float32)
        # Direction of each pixel: ahead + right · column + down · row.
        to_north, to_east, to_down = (
            (rotation[axis, 0] + rotation[axis, 1] * self._right)[None, :] + (rotation[axis, 2] * self._down)[:, None]
            for axis in range(3)
        )
        level = np.sqrt(to_north * to_north + to_east * to_east)
        np.maximum(level, 1e-6, out=level)
        slope = to_down / level
        # Intersection of the view ray with the curved ground: h − d t + d²/2R = 0, in a form without cancellation.
        under = slope * slope
        under -= np.float32(2.0 * height / EARTH_RADIUS_M)
        land = (slope > 0) & (under >= 0)
        reach = np.sqrt(np.maximum(under, 0, out=under), out=under)
        reach += slope
        np.maximum(reach, 1e-7, out=reach)
        distance = np.divide(np.float32(2.0 * height), reach, out=reach)
        share = distance / level
        to_north *= share
        to_east *= share
        columns, rows = self._atlas_places(north, east, to_north, to_east, distance, slope)
        # Sky: by elevation.
        sky = np.maximum(-slope, 0)
        sky /= sky + np.float32(0.35)
        sky *= np.float32(_SKY_ROWS - 2)
        sky += np.float32(self._sky_row + 1)
        columns = np.where(land, columns, np.float32(_SKY_COLUMN))
        rows = np.where(land, rows, sky)
        picture = cv2.remap(self._atlas, columns, rows, cv2.INTER_LINEAR)
        if height < _DETAIL_BELOW_M:
            self._grass(picture, land, north, east, to_north, to_east, distance, height)
        thick = distance / (distance + np.float32(_HAZE_M))
        thick[~land] = 0
        return _hazed(picture, thick)

    def _atlas_places(
        self, north: float, east: float, to_north: Array, to_east: Array, distance: Array, slope: Array
    ) -> tuple[Array, Array]:
        """Column and row in the pyramid, at the level whose pixels match the footprint of a camera pixel."""
        size = ground.SIZE_PX
        period = ground.PERIOD_M
        x = to_east * np.float32(1.0 / period)
        x += np.float32(east / period % 1.0)
        x -= np.floor(x)
        y = to_north * np.float32(-1.0 / period)
        y -= np.float32(north / period % 1.0)
        y -= np.floor(y)
        # Footprint of a pixel, m²: (d/f)² (1 + t²)^1.5 / t.
        texel = period / size
        cover = distance * distance
        cover *= np.float32((1.0 / (self.camera.focal_px * texel)) ** 2)
        cover *= 1 + slope * slope
        cover /= np.maximum(slope, 1e-6)
        # 2⁻ᵏ with k half the binary exponent of the area, by the bits of the number.
        exponent = (cover.view(np.int32) >> 23) - 127
        np.clip((exponent + 1) >> 1, 0, int(math.log2(size)), out=exponent)
        part = ((127 - exponent) << 23).astype(np.int32).view(np.float32) * np.float32(size)
        x -= 2
        x *= part
        x += np.float32(2 * size - 0.5)
        y *= part
        y -= np.float32(0.5)
        np.maximum(y, 0, out=y)
        return x, y

    def _grass(
        self,
        picture: MatLike,
        land: npt.NDArray[np.bool_],
        north: float,
        east: float,
        to_north: Array,
        to_east: Array,
        distance: Array,
        height: float,
    ) -> None:
        """Brightness of single tufts, fading with distance; a texture at half resolution."""
        half = (slice(None, None, 2), slice(None, None, 2))
        scale = 256.0 / _DETAIL_PERIOD_M
        seen = land[half]
        x = to_east[half] * np.float32(scale / 256.0) + np.float32(east * scale / 256.0 % 1.0)
        y = to_north[half] * np.float32(-scale / 256.0) - np.float32(north * scale / 256.0 % 1.0)
        for axis in (x, y):
            axis[~seen] = 0
            axis -= np.floor(axis)
            axis *= 256
        tufts = cv2.remap(self._detail, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
        # Tufts smaller than a pixel are invisible.
        near = np.float32(4.0 * math.sqrt(height) + 2.0)
        weight = near / (near + distance[half] ** 2 / near)
        weight[~seen] = 0
        light = (tufts.astype(np.float32) - 128) * weight
        light *= np.float32(1.0 / 128.0)
        light += 1
        light = cv2.resize(light, (picture.shape[1], picture.shape[0]), interpolation=cv2.INTER_LINEAR)
        cv2.multiply(picture, cv2.cvtColor(light, cv2.COLOR_GRAY2BGR), dst=picture, dtype=cv2.CV_8U)

    # the sun

    def _sun(self, picture: MatLike, pose: Pose) -> None:
        azimuth, elevation = math.radians(SUN_AZIMUTH_DEG), math.radians(SUN_ELEVATION_DEG)
        ned = np.array(
            (math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth), -math.sin(elevation))
        )
        ahead, right, down = ned @ ned_from_body(pose.roll_rad, pose.pitch_rad, pose.yaw_rad)
        if ahead < 0.2:
            return
        column, row = self.camera.pixel(np.array(((right, down, ahead),)))[0]
        if not (-60 < column < self.camera.width_px + 60 and -60 < row < self.camera.height_px + 60):
            return
        centre = (round(column * 16), round(row * 16))
        for radius, colour in ((26, (224, 196, 160)), (17, (236, 222, 200)), (10, (250, 250, 250))):
            cv2.circle(picture, centre, radius * 16, colour, -1, cv2.LINE_AA, 4)

    # the airfield

    def _paint_faces(self, picture: MatLike, pose: Pose) -> None:
        if math.hypot(pose.north_m, pose.east_m) > _FARTHEST_FACE_M:
            return
        camera = self.camera
        points = camera.from_world(pose, self._corners)
        least = np.array((_NEAREST_M, 0.0, 0.0, 0.0, 0.0))
        outside = np.less(points @ _sides(camera, 1.0), least)
        # Visible unless all corners lie outside one side; unclipped when no corner is far outside any.
        seen = np.invert(np.logical_and.reduceat(outside, self._starts).any(axis=1))
        beyond = np.less(points @ _sides(camera, 2.0), least)
        whole = np.invert(np.logical_or.reduceat(beyond, self._starts).any(axis=1))
        solid: list[tuple[float, npt.NDArray[np.float64], tuple[float, ...]]] = []
        for number in np.flatnonzero(seen):
            face = self._faces_shown[number]
            start = self._starts[number]
            piece = points[start : start + len(face.corners_m)]
            distance = float(np.linalg.norm(piece.mean(axis=0)))
            haze = distance / (distance + _HAZE_M)
            colour = tuple(part + (far - part) * haze for part, far in zip(face.colour, _HAZE, strict=True))
            if not whole[number]:
                piece = _clipped(piece, camera)
                if len(piece) < 3:
                    continue
            if face.solid:
                solid.append((distance, piece, colour))
            else:
                self._fill(picture, piece, colour)
        for _, piece, colour in sorted(solid, key=lambda entry: -entry[0]):
            self._fill(picture, piece, colour)

    def _fill(self, picture: MatLike, piece: npt.NDArray[np.float64], colour: tuple[float, ...]) -> None:
        corners = np.rint(self.camera.pixel(piece) * 16).astype(np.int32)
        cv2.fillConvexPoly(picture, corners, colour, cv2.LINE_AA, 4)


def _sides(camera: Pinhole, margin: float) -> npt.NDArray[np.float64]:
    """Clipping planes: times a point (right, down, ahead) the distance inside each, the near plane first."""
    wide = margin * camera.width_px / 2 / camera.focal_px
    high = margin * camera.height_px / 2 / camera.focal_px
    return np.array(((0, -1, 1, 0, 0), (0, 0, 0, -1, 1), (1, wide, wide, high, high)), np.float64)


def _clipped(piece: npt.NDArray[np.float64], camera: Pinhole) -> npt.NDArray[np.float64]:
    """Clip a face to the view (Sutherland and Hodgman, Comm. ACM 17, 1974)."""
    for side, normal in enumerate(_sides(camera, 2.0).T):
        inside = piece @ normal - (_NEAREST_M if side == 0 else 0.0)
        kept = []
        for k in range(len(piece)):
            a, b = inside[k - 1], inside[k]
            if (a >= 0) != (b >= 0):
                kept.append(piece[k - 1] + (piece[k] - piece[k - 1]) * (a / (a - b)))
            if b >= 0:
                kept.append(piece[k])
        if len(kept) < 3:
            return np.empty((0, 3))
        piece = np.array(kept)
    return piece


_PAINTING = threading.Lock()


@functools.cache
def _world() -> tuple[MatLike, int, MatLike]:
    """Pyramid with the sky, the sky's row in it, and the grass: painted once for all cameras."""
    return *_with_sky(ground.pyramid(ground.fields())), ground.detail()


def _with_sky(atlas: MatLike) -> tuple[MatLike, int]:
    """Sky colours by elevation, in the free part of the pyramid: rows from the horizon to the zenith."""
    row = ground.SIZE_PX + 1 - _SKY_ROWS
    part = np.linspace(0.0, 1.0, _SKY_ROWS, dtype=np.float32)[:, None] ** 0.8
    colours = np.array(_HAZE, np.float32) + (np.array(_ZENITH, np.float32) - np.array(_HAZE, np.float32)) * part
    atlas[row:, _SKY_COLUMN - 4 : _SKY_COLUMN + 4] = colours[:, None, :].astype(np.uint8)
    return atlas, row


def _hazed(picture: MatLike, thick: Array) -> MatLike:
    """Blend the picture with a given share of haze."""
    veil = np.empty_like(picture)
    veil[:] = _HAZE
    return cv2.blendLinear(picture, veil, 1 - thick, thick)
