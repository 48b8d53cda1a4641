"""Terrain data of the plane: heights requested from a station, stored in grids as by ArduPlane (AP_Terrain).

A grid has 28 heights northward by 32 eastward, aligned to the whole degree south-west of it, and is filled in blocks of
4 by 4. Missing blocks are requested again every two seconds, those of the grid below the plane first.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from vencejo.sim.autopilot.interface import Parameters, StoredItem

__all__ = ["Terrain", "TerrainRequest"]

_SIDE = 4
_ROWS, _COLUMNS = 28, 32
_ROWS_APART, _COLUMNS_APART = 24, 28
"""Spacing of grids, in heights: neighbours overlap by a block."""
_BLOCKS_EAST = 8
_WHOLE = (1 << 56) - 1
_M_PER_E7 = 0.011131884502145034
_AGAIN_S = 2.0
_DEGREE = 10_000_000
_AROUND = 0.7
"""Reach of the grids around the plane, in sizes of a grid."""
_WAYPOINT = 16
_ITEM_AROUND = 10
"""Reach of the terrain around a waypoint, in spacings."""


class TerrainRequest(NamedTuple):
    """Content of TERRAIN_REQUEST."""

    lat_e7: int
    lon_e7: int
    spacing_m: int
    mask: int


class _Place(NamedTuple):
    """A position within its grid."""

    corner: tuple[int, int]
    row: int
    column: int
    part_north: float
    part_east: float


@dataclass
class _Grid:
    bitmap: int = 0
    heights: list[list[int]] = field(default_factory=lambda: [[0] * _COLUMNS for _ in range(_ROWS)])
    used: int = 0


def _longitude_scale(lat_e7: float) -> float:
    return max(0.01, math.cos(math.radians(lat_e7 * 1e-7)))


class Terrain:
    """The grids of one plane. They survive a reboot, as on an SD card.

    Parameters
    ----------
    params : Parameters
        TERRAIN_ENABLE, TERRAIN_SPACING, TERRAIN_CACHE_SZ and TERRAIN_OFS_MAX are read.
    """

    def __init__(self, params: Parameters) -> None:
        self._params = params
        self._grids: dict[tuple[int, int], _Grid] = {}
        self._spacing_m = 0
        self._uses = 0
        self._asked_s: dict[object, float] = {}
        self._offset_m: float | None = None
        self._reference: tuple[float, float, float] | None = None
        self._here: tuple[float, float] | None = None
        self._items: tuple[int, int, int] | None = (0, 1, 0)
        """Revision of the mission, and the item and position being searched; None once all were found."""
        self._revision = -1
        self._home: tuple[float, float] | None = None
        self._last_m: float | None = None
        self._made = 0
        self._looked: tuple[tuple[int, int], int, int, int] | None = None
        """The square of the last search around the plane, and the number of grids created until then."""

    @property
    def enabled(self) -> bool:
        """TERRAIN_ENABLE."""
        return self._params.get("TERRAIN_ENABLE") != 0

    # queries

    def height_m(self, lat_deg: float, lon_deg: float) -> float | None:
        """Terrain altitude above mean sea level; None while it is unknown, and then it is requested.

        It is shifted by at most TERRAIN_OFS_MAX, so that it matched the plane's altitude at arming.
        """
        if not self.enabled:
            return None
        place = self._place(lat_deg, lon_deg)
        grid = self._grid(place.corner)
        corners = [(place.row + up, place.column + right) for up in (0, 1) for right in (0, 1)]
        if not all(grid.bitmap >> (row // _SIDE * _BLOCKS_EAST + column // _SIDE) & 1 for row, column in corners):
            return None
        south_west, south_east, north_west, north_east = (grid.heights[row][column] for row, column in corners)
        west = south_west + (north_west - south_west) * place.part_north
        east = south_east + (north_east - south_east) * place.part_north
        return west + (east - west) * place.part_east + (self._offset_m or 0.0)

    def below_m(self, lat_deg: float, lon_deg: float) -> float | None:
        """Terrain altitude below the plane, or the last known one."""
        if (height_m := self.height_m(lat_deg, lon_deg)) is not None:
            self._last_m = height_m
        return self._last_m

    def spacing_at(self, lat_deg: float, lon_deg: float) -> int:
        """Spacing of the heights known at a position, metres; 0 without any."""
        return 0 if self.height_m(lat_deg, lon_deg) is None else self._spacing_m

    def statistics(self) -> tuple[int, int]:
        """Number of missing and of loaded blocks."""
        loaded = sum(grid.bitmap.bit_count() for grid in self._grids.values())
        return len(self._grids) * 56 - loaded, loaded

    def prearm(self) -> str | None:
        """The failing pre-arm check of terrain, in ArduPlane's words."""
        if not self.enabled:
            return "terrain disabled"
        pending, _ = self.statistics()
        home = None if self._home is None else self.height_m(*self._home)
        if pending or self._last_m is None or home is None or self._items is not None:
            return "waiting for terrain data"
        return None

    # updates

    def armed(self, lat_deg: float, lon_deg: float, alt_amsl_m: float) -> None:
        """Set the reference altitude, when the plane is armed on the ground."""
        self._reference, self._offset_m = (lat_deg, lon_deg, alt_amsl_m), None

    def update(
        self, here: tuple[float, float], home: tuple[float, float] | None, mission: Sequence[StoredItem], revision: int
    ) -> None:
        """Search the terrain around the plane, home and waypoints; ten times a second."""
        if not self.enabled:
            return
        spacing_m = max(1, int(self._params.get("TERRAIN_SPACING")))
        if spacing_m != self._spacing_m:
            self._grids.clear()
            self._spacing_m, self._revision, self._looked = spacing_m, -1, None
        self._here, self._home = here, home
        if home is not None:
            self.height_m(*home)
        self.below_m(*here)
        self._look_at_items(mission, revision)
        self._look_around(*here)
        if self._reference is not None and self._offset_m is None:
            lat_deg, lon_deg, alt_m = self._reference
            limit = self._params.get("TERRAIN_OFS_MAX")
            if limit > 0 and (height_m := self.height_m(lat_deg, lon_deg)) is not None:
                self._offset_m = max(-limit, min(limit, alt_m - height_m))

    def request(self, link: object, now_s: float) -> TerrainRequest | None:
        """The request due on a link, None without one."""
        if not self.enabled or self._here is None or now_s - self._asked_s.get(link, -math.inf) < _AGAIN_S:
            return None
        first = self._place(*self._here).corner
        for corner in (first, *self._grids):
            grid = self._grids.get(corner)
            if grid is not None and grid.bitmap != _WHOLE:
                self._asked_s[link] = now_s
                return TerrainRequest(*corner, self._spacing_m, _WHOLE & ~grid.bitmap)
        return None

    def restart(self) -> None:
        """Reset after a reboot."""
        self._asked_s.clear()
        self._offset_m = self._reference = None

    def forget(self, link: object) -> None:
        """Remove a link."""
        self._asked_s.pop(link, None)

    def take(self, lat_e7: int, lon_e7: int, spacing_m: int, bit: int, heights: list[int]) -> None:
        """TERRAIN_DATA; unrequested data is ignored."""
        grid = self._grids.get((lat_e7, lon_e7))
        if grid is None or spacing_m != self._spacing_m or bit >= 56:
            return
        row, column = bit // _BLOCKS_EAST * _SIDE, bit % _BLOCKS_EAST * _SIDE
        for index, height_m in enumerate(heights):
            grid.heights[row + index // _SIDE][column + index % _SIDE] = height_m
        grid.bitmap |= 1 << bit

    # grids

    def _look_around(self, lat_deg: float, lon_deg: float) -> None:
        """Load the grids around a position; again only in a new square, or when one may have been evicted."""
        place = self._place(lat_deg, lon_deg)
        square = (place.corner, place.row, place.column)
        if self._looked == (*square, self._made):
            return
        for north in (-1, 0, 1):
            for east in (-1, 0, 1):
                around = self._moved(lat_deg, lon_deg, north * _AROUND * _ROWS, east * _AROUND * _COLUMNS)
                self._grid(self._place(*around).corner)
        self._looked = (*square, self._made)

    def _look_at_items(self, mission: Sequence[StoredItem], revision: int) -> None:
        """Search five positions at each waypoint in turn, within the capacity of the cache."""
        if revision != self._revision:
            self._revision, self._items = revision, (revision, 1, 0)
        if self._items is None:
            return
        pending, _ = self.statistics()
        if pending:
            return
        _, index, corner = self._items
        for _ in range(100):
            while index < len(mission) and (
                mission[index].command != _WAYPOINT or (mission[index].lat_deg, mission[index].lon_deg) == (0.0, 0.0)
            ):
                index, corner = index + 1, 0
            if index >= len(mission):
                self._items = None
                return
            place = (mission[index].lat_deg, mission[index].lon_deg)
            if corner < 4:
                bearing = math.radians(45 + 90 * corner)
                place = self._moved(*place, _ITEM_AROUND * math.cos(bearing), _ITEM_AROUND * math.sin(bearing))
            if self.height_m(*place) is None:
                break
            index, corner = (index, corner + 1) if corner < 4 else (index + 1, 0)
        self._items = (revision, index, corner)

    def _moved(self, lat_deg: float, lon_deg: float, rows: float, columns: float) -> tuple[float, float]:
        """The position a number of spacings north and east."""
        north_deg = rows * self._spacing_m / _M_PER_E7 * 1e-7
        east_deg = columns * self._spacing_m / _M_PER_E7 * 1e-7 / _longitude_scale((lat_deg + north_deg / 2.0) * 1e7)
        return max(-90.0, min(90.0, lat_deg + north_deg)), (lon_deg + east_deg + 180.0) % 360.0 - 180.0

    def _place(self, lat_deg: float, lon_deg: float) -> _Place:
        """AP_Terrain::calculate_grid_info."""
        spacing = max(1, self._spacing_m)
        lat_e7, lon_e7 = round(lat_deg * 1e7), round(lon_deg * 1e7)
        south, west = lat_e7 // _DEGREE * _DEGREE, lon_e7 // _DEGREE * _DEGREE
        north = (lat_e7 - south) * _M_PER_E7 / spacing
        east = (lon_e7 - west) * _M_PER_E7 * _longitude_scale((lat_e7 + south) / 2) / spacing
        grid_row, grid_column = int(north) // _ROWS_APART * _ROWS_APART, int(east) // _COLUMNS_APART * _COLUMNS_APART
        d_lat = int(grid_row * spacing / _M_PER_E7)
        d_lon = int(grid_column * spacing / _M_PER_E7 / _longitude_scale(south + d_lat / 2))
        row, column = int(north) - grid_row, int(east) - grid_column
        return _Place((south + d_lat, west + d_lon), row, column, north - int(north), east - int(east))

    def _grid(self, corner: tuple[int, int]) -> _Grid:
        """The grid at a corner; a new one replaces the least recently used one."""
        grid = self._grids.get(corner)
        if grid is None:
            if len(self._grids) >= max(1, int(self._params.get("TERRAIN_CACHE_SZ"))):
                del self._grids[min(self._grids, key=lambda known: self._grids[known].used)]
            grid = self._grids[corner] = _Grid()
            self._made += 1
        self._uses += 1
        grid.used = self._uses
        return grid
