"""Free space to keep on the disk, faults of the disk, and durable writing of files."""

from __future__ import annotations

import os
from dataclasses import dataclass

from vencejo import _native
from vencejo._given import WHOLE, check
from vencejo.errors import InvalidRequest

__all__ = ["Floors", "StorageProblem", "create_file", "install_file", "make_folder", "sync_folder", "write_file"]

_MAPS_MB, _VIDEO_MB, _TELEMETRY_MB = _native.default_floors_mb()


@dataclass(frozen=True, kw_only=True)
class Floors:
    """Free disk space below which writing stops, in megabytes (of 1,000,000 bytes).

    Maps stop first, then video, and the flight recorder last: floors in another order are refused.

    Attributes
    ----------
    maps_mb : int
        For map tiles, offline areas and uploaded files; 0 to 10,000,000, default 2,000.
    video_mb : int
        For recordings and pictures of cameras; 0 to 10,000,000, default 1,000.
    telemetry_mb : int
        For the flight recorder; 0 to 10,000,000, default 500.

    Raises
    ------
    InvalidRequest
        For floors out of range or in the wrong order.

    Examples
    --------
    >>> from vencejo import Floors
    >>> Floors(maps_mb=5000).telemetry_mb
    500
    """

    maps_mb: int = _MAPS_MB
    video_mb: int = _VIDEO_MB
    telemetry_mb: int = _TELEMETRY_MB

    def __post_init__(self) -> None:
        check(self, maps_mb=WHOLE, video_mb=WHOLE, telemetry_mb=WHOLE)
        for name in ("maps_mb", "video_mb", "telemetry_mb"):
            if getattr(self, name) < 0:  # the core counts without a sign
                raise InvalidRequest(f"{name} is {getattr(self, name)}, should be 0 to 10,000,000")
        _native.check_floors_mb(self._mb)

    @property
    def _mb(self) -> tuple[int, int, int]:
        return (self.maps_mb, self.video_mb, self.telemetry_mb)


@dataclass(frozen=True, kw_only=True)
class StorageProblem:
    """Something that is not being kept.

    Attributes
    ----------
    what : str
        ``"telemetry"``, ``"maps"``, ``"missions"``, ``"video"``, ``"draft"``, ``"tokens"``, ``"signing"`` or
        ``"signing_times"``.
    name : str or None
        Which camera or map source; ``None`` where there is one of its kind.
    fault : str
        ``"low_space"``, ``"unwritable"``, ``"unreadable"``, ``"stalled"``, ``"set_aside"`` or ``"ended"``.
    text : str
        The same in words.
    """

    what: str
    name: str | None = None
    fault: str
    text: str


def write_file(path: str | os.PathLike[str], data: bytes) -> None:
    """Write a file as a whole, in the place of one that may be there: as it was or as it is to be, also after a power cut.

    Raises
    ------
    OSError
        Any error of the file system.
    """
    _native.write_file(os.fspath(path), data)


def create_file(path: str | os.PathLike[str], data: bytes) -> bool:
    """Create a file atomically; returns False, and writes nothing, if one of that name exists.

    Raises
    ------
    OSError
        Any error of the file system.
    """
    return _native.create_file(os.fspath(path), data)


def install_file(temporary: str | os.PathLike[str], path: str | os.PathLike[str]) -> None:
    """Move a completely written temporary file to its final name, replacing an existing one.

    Raises
    ------
    OSError
        Any error of the file system.
    """
    _native.install_file(os.fspath(temporary), os.fspath(path))


def make_folder(path: str | os.PathLike[str]) -> None:
    """Create a folder and its parents, so that they survive a power cut.

    Raises
    ------
    OSError
        Any error of the file system.
    """
    _native.make_folder(os.fspath(path))


def sync_folder(path: str | os.PathLike[str]) -> None:
    """Force the entries of a folder to the disk.

    Raises
    ------
    OSError
        Any error of the file system.
    """
    _native.sync_folder(os.fspath(path))
