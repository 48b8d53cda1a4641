"""Writes the age of an old picture into it, for people at viewers that show whatever they are given."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

__all__ = ["age_text", "stamped"]

_GLYPHS: Final = {
    "0": "01110 10001 10011 10101 11001 10001 01110",
    "1": "00100 01100 00100 00100 00100 00100 01110",
    "2": "01110 10001 00001 00110 01000 10000 11111",
    "3": "01110 10001 00001 00110 00001 10001 01110",
    "4": "00010 00110 01010 10010 11111 00010 00010",
    "5": "11111 10000 11110 00001 00001 10001 01110",
    "6": "00110 01000 10000 11110 10001 10001 01110",
    "7": "11111 00001 00010 00100 01000 01000 01000",
    "8": "01110 10001 10001 01110 10001 10001 01110",
    "9": "01110 10001 10001 01111 00001 00010 01100",
    "O": "01110 10001 10001 10001 10001 10001 01110",
    "L": "10000 10000 10000 10000 10000 10000 11111",
    "D": "11110 10001 10001 10001 10001 10001 11110",
    "h": "10000 10000 10110 11001 10001 10001 10001",
    "m": "00000 00000 11010 10101 10101 10101 10101",
    "s": "00000 00000 01111 10000 01110 00001 11110",
    " ": "00000 00000 00000 00000 00000 00000 00000",
}
"""Five by seven pixels each, rows from the top."""
_ROOM: Final = 96
"""Width of a picture in pixels of the text, which sets the text's size."""
_INK: Final = (255, 220, 0)


def age_text(age_s: float) -> str:
    """An age as text: ``"OLD 12 s"``, in minutes from two on, in hours from two on, 99 hours at most."""
    seconds = max(0, int(age_s))
    if seconds < 120:
        return f"OLD {seconds} s"
    return f"OLD {seconds // 60} m" if seconds < 7200 else f"OLD {min(seconds // 3600, 99)} h"


def stamped(rgb: NDArray[np.uint8], text: str) -> NDArray[np.uint8]:
    """A copy of a picture with a text in its upper left corner, in yellow on black.

    Parameters
    ----------
    rgb : height × width × 3 bytes
    text : str
        Of `age_text`. What has no room is cut off.
    """
    glyphs = [np.array([[bit == "1" for bit in row] for row in _GLYPHS[sign].split()]) for sign in text]
    gap = np.zeros((7, 1), bool)
    line = np.hstack([part for glyph in glyphs for part in (gap, glyph)] + [gap])
    line = np.pad(line, 1)
    scale = max(1, rgb.shape[1] // _ROOM)
    large = np.kron(line, np.ones((scale, scale), bool))[: rgb.shape[0], : rgb.shape[1]]
    marked = rgb.copy()
    marked[: large.shape[0], : large.shape[1]] = np.where(large[..., None], np.array(_INK, np.uint8), np.uint8(0))
    return marked
