"""Histories of a fleet's aircraft: their files, and gaps in them. `vencejo.replay` replays them.

`vencejo.fleet` writes the files (``.mcap``) on board and on the ground. Foxglove and the Python package ``mcap`` read
them too: each file contains its schemas.

Examples
--------
>>> from vencejo.history import contents, kept
>>> for aircraft in kept():  # doctest: +SKIP
...     print(aircraft.name, aircraft.gaps)
>>> contents("plane7_2026-11-25T08-00-00Z.mcap").duration_s  # doctest: +SKIP
3599.8
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path

from vencejo import _native
from vencejo.enrolment import native
from vencejo.errors import VencejoError
from vencejo.station import default_history_dir

__all__ = ["Contents", "Gap", "Kept", "StreamContents", "contents", "kept"]


@dataclass(frozen=True, kw_only=True)
class StreamContents:
    """The records of one stream in a file.

    Attributes
    ----------
    boot : int
        Id of a start of the station on board; it differs for each.
    stream : str
        ``"state"``, ``"event"`` or ``"audit"``: orders with their senders and answers.
    ranges : tuple of (int, int)
        Ranges of record numbers, first and last. Numbers are consecutive within a boot, so those in between are
        missing.
    """

    boot: int
    stream: str
    ranges: tuple[tuple[int, int], ...]

    @property
    def count(self) -> int:
        """Number of records."""
        return sum(last - first + 1 for first, last in self.ranges)

    @property
    def missing(self) -> int:
        """Number of records missing between the first and the last."""
        return self.ranges[-1][1] - self.ranges[0][0] + 1 - self.count if self.ranges else 0


@dataclass(frozen=True, kw_only=True)
class Contents:
    """Contents of a history file.

    Attributes
    ----------
    aircraft : str or None
        Its name in its fleet, if the file has it.
    streams : tuple of StreamContents
    start : datetime or None
        Estimated time of the first record (UTC): a computer without a clock of its own begins in 1970.
    duration_s : float
        How long the station on board ran in it.
    skipped_bytes : int
        Bytes that were damaged, or the beginning of something that was never written to its end.
    """

    aircraft: str | None
    streams: tuple[StreamContents, ...]
    start: datetime | None
    duration_s: float
    skipped_bytes: int


def contents(path: str | os.PathLike[str]) -> Contents:
    """Read a whole history file, damaged ones too, and return what it contains.

    Raises
    ------
    FileFormatError
        When it cannot be read, or is not an MCAP file.
    VencejoError
        In a build without fleets.
    """
    aircraft, streams, start_ns, duration_s, skipped = native("history_contents")(os.fspath(path))
    return Contents(
        aircraft=aircraft,
        streams=tuple(
            StreamContents(boot=boot, stream=stream, ranges=tuple(ranges)) for boot, stream, ranges in streams
        ),
        start=None if start_ns is None else datetime.fromtimestamp(start_ns / 1e9, timezone.utc),
        duration_s=duration_s,
        skipped_bytes=skipped,
    )


@dataclass(frozen=True, kw_only=True)
class Gap:
    """A range of record numbers missing in an archive.

    Attributes
    ----------
    boot : str
        16 hexadecimal digits.
    stream : str
        ``"state"``, ``"event"`` or ``"audit"``.
    first, last : int
    is_lost : bool
        Whether the aircraft has them no more; else they are fetched when it is there.
    """

    boot: str
    stream: str
    first: int
    last: int
    is_lost: bool


@dataclass(frozen=True, kw_only=True)
class Kept:
    """The archive of one aircraft.

    Attributes
    ----------
    name : str
    folder : Path
        Where.
    files : tuple of Path
        Sorted by name, which is by time if the clock was set.
    bytes : int
        Their size together.
    records : dict of str to int
        How many of each stream were ever in it; some may have been deleted since, to make room. On board it is empty:
        there all is kept.
    gaps : tuple of Gap
        What is missing of it on the ground.
    """

    name: str
    folder: Path
    files: tuple[Path, ...]
    bytes: int
    records: dict[str, int]
    gaps: tuple[Gap, ...]


def kept(folder: str | os.PathLike[str] | None = None) -> list[Kept]:
    """List the archives in a folder, by aircraft; by default those of all fleets here, remote and on board.

    Raises
    ------
    VencejoError
        When the notes beside an archive's files are damaged.
    """
    if folder is None:
        top = default_history_dir()
        folders = sorted(path for path in [*top.glob("ground/*"), top / "board"] if path.is_dir())
        return [each for path in folders for each in kept(path)]
    where = Path(folder)
    return [_kept(where, *found) for found in _native.history_kept(os.fspath(folder))]


def _kept(
    folder: Path,
    name: str,
    files: list[tuple[str, int]],
    records: dict[str, int],
    gaps: list[tuple[str, str, int, int, bool]] | None,
    problem: str | None,
) -> Kept:
    if problem is not None:
        raise VencejoError(f"{folder}: {problem}")
    return Kept(
        name=name,
        folder=folder,
        files=tuple(folder / name for name, _ in files),
        bytes=sum(size for _, size in files),
        records={stream: count for stream, count in records.items() if count},
        gaps=tuple(
            Gap(boot=boot, stream=stream, first=first, last=last, is_lost=is_lost)
            for boot, stream, first, last, is_lost in gaps or ()
        ),
    )
