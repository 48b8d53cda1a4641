"""The ground texture: fields, hedges and trees in morning sun, with grid lines every 100 m, thicker every 500 m.

One square kilometre that repeats in all directions, with the pyramid of its smaller copies (L. Williams, "Pyramidal
parametrics", SIGGRAPH 1983) so that distant ground does not flicker. It is the same for every plane.
"""

from __future__ import annotations

import random

import cv2
import numpy as np
import numpy.typing as npt
from cv2.typing import MatLike

__all__ = ["PERIOD_M", "SIZE_PX", "detail", "fields", "pyramid"]

PERIOD_M = 1000.0
"""Period of the texture, metres."""
SIZE_PX = 2048
"""Pixels per period; a power of two."""

_SEED = "vencejo land"
_LEAST_FIELD_PX = 130
_PALETTE = (  # blue, green, red
    (62, 118, 92), (58, 128, 104), (72, 140, 120), (96, 168, 176), (110, 176, 196),
    (76, 108, 132), (88, 122, 150), (66, 132, 116), (84, 152, 140), (70, 112, 84),
)  # fmt: skip
_HEDGE = (42, 84, 58)
_TRACK = (150, 172, 186)
_TREE = (34, 74, 44)
_SHADOW = (30, 52, 40)
_SHADOW_PX = (-5, -5)
"""The sun is in the south-east: shadows fall to the north-west, left and up in the texture."""
_GRID = np.array((235, 240, 240), np.float32)


def fields() -> MatLike:
    """The texture from above, north up; opposite edges match."""
    source = random.Random(_SEED)
    land = np.zeros((SIZE_PX, SIZE_PX, 3), np.float32)
    lots = [(0, 0, SIZE_PX, SIZE_PX)]
    hedges: list[tuple[int, int, int, int]] = []
    while lots:
        x0, y0, x1, y1 = lots.pop()
        wide, high = x1 - x0, y1 - y0
        if max(wide, high) > 2.6 * _LEAST_FIELD_PX or (
            min(wide, high) > 1.6 * _LEAST_FIELD_PX and source.random() < 0.5
        ):
            part = source.uniform(0.35, 0.65)
            if wide > high:
                x = x0 + round(wide * part)
                lots += [(x0, y0, x, y1), (x, y0, x1, y1)]
                hedges.append((x, y0, x, y1))
            else:
                y = y0 + round(high * part)
                lots += [(x0, y0, x1, y), (x0, y, x1, y1)]
                hedges.append((x0, y, x1, y))
            continue
        land[y0:y1, x0:x1] = source.choice(_PALETTE)
        # Furrows, 4 m apart.
        across = source.random() < 0.5
        furrow = 1.0 + 0.05 * np.sin(np.arange(wide if across else high, dtype=np.float32) * (2.0 * np.pi / 8.0))
        land[y0:y1, x0:x1] *= furrow[None, :, None] if across else furrow[:, None, None]
    land *= _cloudy()[:, :, None]
    picture: MatLike = np.clip(land, 0, 255).astype(np.uint8)
    for x0, y0, x1, y1 in hedges:
        if source.random() < 0.25:
            cv2.line(picture, (x0, y0), (x1, y1), _TRACK, 6)
            continue
        cv2.line(picture, (x0 - 2, y0 - 2), (x1 - 2, y1 - 2), _SHADOW, 3)
        cv2.line(picture, (x0, y0), (x1, y1), _HEDGE, 4)
        for _ in range((x1 - x0 + y1 - y0) // 45):
            along = source.random()
            _tree(picture, source, round(x0 + (x1 - x0) * along), round(y0 + (y1 - y0) * along))
    for _ in range(160):
        _tree(picture, source, source.randrange(SIZE_PX), source.randrange(SIZE_PX))
    return _with_grid(picture)


def pyramid(land: MatLike) -> MatLike:
    """The mipmap pyramid of the texture, side by side in one image of double width.

    Level k begins at column 2 S (1 − 2⁻ᵏ) and is S 2⁻ᵏ wide. Each level is repeated below itself, so that interpolation
    across its edge finds valid pixels.
    """
    atlas: MatLike = np.zeros((SIZE_PX + 1, 2 * SIZE_PX, 3), np.uint8)
    level: MatLike = land
    column = 0
    while level.shape[0] >= 1:
        size = level.shape[0]
        high = min(2 * size, SIZE_PX + 1)
        atlas[:high, column : column + size] = np.concatenate((level, level))[:high]
        column += size
        if size == 1:
            break
        level = cv2.resize(level, (size // 2, size // 2), interpolation=cv2.INTER_AREA).reshape(size // 2, size // 2, 3)
    return atlas


def detail() -> MatLike:
    """Grass close up: brightness around 128, 256 × 256 repeating pixels."""
    noise = np.random.default_rng(7).normal(0.0, 1.0, (256, 256)).astype(np.float32)
    sum_ = np.zeros_like(noise)
    for blur, weight in ((0, 6.0), (2, 14.0), (7, 26.0)):
        octave = noise if blur == 0 else cv2.GaussianBlur(np.tile(noise, (3, 3)), (0, 0), blur)[256:512, 256:512]
        sum_ += weight * octave / float(octave.std())
    grass: MatLike = np.clip(128.0 + sum_, 40, 216).astype(np.uint8)
    return grass


def _cloudy() -> npt.NDArray[np.float32]:
    """Slow changes of brightness, with the period of the texture."""
    noise = np.random.default_rng(3).normal(0.0, 1.0, (64, 64)).astype(np.float32)
    wide = cv2.GaussianBlur(np.tile(noise, (3, 3)), (0, 0), 1.5)[64:128, 64:128]
    wide = np.tile(wide / float(wide.std()), (2, 2))
    big = cv2.resize(wide, (2 * SIZE_PX, 2 * SIZE_PX), interpolation=cv2.INTER_CUBIC)
    return 1.0 + 0.06 * big[SIZE_PX // 2 : SIZE_PX // 2 + SIZE_PX, SIZE_PX // 2 : SIZE_PX // 2 + SIZE_PX]


def _tree(picture: MatLike, source: random.Random, x: int, y: int) -> None:
    radius = source.randint(3, 8)
    cv2.circle(picture, (x + _SHADOW_PX[0], y + _SHADOW_PX[1]), radius, _SHADOW, -1, cv2.LINE_AA)
    cv2.circle(picture, (x, y), radius, _TREE, -1, cv2.LINE_AA)
    cv2.circle(picture, (x + 1, y + 1), max(1, radius - 3), (52, 104, 66), -1, cv2.LINE_AA)


def _with_grid(picture: MatLike) -> MatLike:
    """Grid lines through home and every 100 m from it."""
    metre_px = SIZE_PX / PERIOD_M
    share = np.zeros(SIZE_PX, np.float32)
    for line_m in range(0, int(PERIOD_M), 100):
        half_m = 1.6 if line_m % 500 == 0 else 0.6
        centre = line_m * metre_px
        for pixel in range(int(centre - half_m * metre_px) - 1, int(centre + half_m * metre_px) + 2):
            cover = min(pixel + 0.5, centre + half_m * metre_px) - max(pixel - 0.5, centre - half_m * metre_px)
            share[pixel % SIZE_PX] = max(share[pixel % SIZE_PX], min(1.0, max(0.0, cover)))
    alpha = (0.55 * np.maximum(share[:, None], share[None, :]))[:, :, None]
    return (picture + (_GRID - picture) * alpha).astype(np.uint8)
