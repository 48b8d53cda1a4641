"""Terrain elevation for rehearsals and landings: from files, or from any function of a position.

`vencejo.rehearsal` has the same names.
"""

from __future__ import annotations

import os
from collections.abc import Callable

from vencejo import _native

__all__ = ["Elevation", "Ground"]

Ground = Callable[[float, float], float | None]
"""Height of the ground at a latitude and longitude, metres above mean sea level; ``None`` where it is not known."""


class Elevation:
    """Terrain elevation from a file: SRTM (``N40W004.hgt``, ``.hgt.gz``), GeoTIFF, or a folder of them.

    Calling it with a latitude and a longitude returns the bilinearly interpolated elevation, in metres above the file's
    datum, which is mean sea level for SRTM and Copernicus; ``None`` where the file has no data.

    Parameters
    ----------
    path : path-like
    below_sea_level : bool, optional
        Whether elevations of GeoTIFFs below sea level are land; by default they are the sea floor, and the ground is
        the water surface, 0 m.

    Raises
    ------
    FileFormatError
        When it cannot be read, or holds no elevations.
    """

    def __init__(self, path: str | os.PathLike[str], *, below_sea_level: bool = False) -> None:
        self._native = _native.Elevation(path, below_sea_level)

    def __call__(self, lat_deg: float, lon_deg: float) -> float | None:
        """Elevation at a position, metres above mean sea level."""
        return self._native(lat_deg, lon_deg)
