"""Replay of recordings in a station: ``.tlog`` files, and the histories (``.mcap``) of a fleet's aircraft.

Each recorded aircraft appears as a vehicle of its own, next to the live ones, whatever its system id was. It accepts no
orders, and lives in the time of its recording: while the replay is paused, its values do not age.

A link string such as ``"tlog:flight.tlog"`` also plays a recording, as a link: to follow or forward its messages under their
own system ids.

Examples
--------
>>> from vencejo import Station
>>> from vencejo.replay import Replay
>>> with Station(record=False) as station, Replay(station, "flight.tlog", speed=4) as replay:  # doctest: +SKIP
...     plane = station.wait_vehicle()
...     replay.seek(120.0)
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import Final, NamedTuple

from vencejo import _native
from vencejo._closing import Closing
from vencejo._forking import belongs_here
from vencejo.station import Station

__all__ = ["Replay", "ReplayLink", "ReplayStatus", "replay_link"]

_LINK: Final = re.compile(r"tlog:(?P<path>.+?)(?:\?(?:speed=(?P<speed>[^&]+))?&?(?P<loop>loop=true)?)?")
"""A link string of a recording, as the core writes it."""


class ReplayLink(NamedTuple):
    """A recording that a link string names.

    Attributes
    ----------
    path : Path
        The file.
    speed : float
        Times the recorded pace.
    repeat : bool
        Whether it begins anew at the end.
    """

    path: Path
    speed: float
    repeat: bool


def replay_link(link: str) -> ReplayLink | None:
    """Read a link string such as ``"tlog:flight.tlog?speed=2"``; ``None`` for one that names no recording.

    Raises
    ------
    LinkError
        For a link string that cannot be read.
    """
    found = _LINK.fullmatch(_native.describe_link(link))
    if found is None:
        return None
    return ReplayLink(Path(found["path"]), float(found["speed"] or 1.0), repeat=found["loop"] is not None)


@dataclass(frozen=True, kw_only=True)
class ReplayStatus:
    """State of a replay.

    Attributes
    ----------
    system_ids : tuple of int
        Ids of its vehicles in the station.
    start : datetime or None
        Beginning of the recording (UTC), if it has it.
    time : datetime or None
        Time in the recording now (UTC).
    position_s, duration_s : float
        Position in the recording, and its duration, s. Pauses of more than an hour count nothing.
    speed : float
        Times the recorded pace.
    is_paused : bool
        Whether it stands still.
    is_over : bool
        Whether it has reached the end, where it stays.
    seeks : int
        How often it went to another position. With each, its vehicles begin anew.
    fault : str or None
        Why it cannot go on.
    """

    system_ids: tuple[int, ...]
    start: datetime | None
    time: datetime | None
    position_s: float
    duration_s: float
    speed: float
    is_paused: bool
    is_over: bool
    seeks: int
    fault: str | None


class Replay(Closing):
    """Replay of a recording in a station. A file that is replayed already goes to `start_s` instead.

    Close it, or use it in a ``with`` statement, inside that of its station.

    Parameters
    ----------
    station : Station
        The station in which it appears.
    path : path
        A ``.tlog`` file, or the ``.mcap`` file of a fleet's aircraft; it may be damaged.
    speed : float, optional
        Times the recorded pace, 0.01 to 10,000.
    start_s : float, optional
        From where in the file, s.
    repeat : bool, optional
        Whether it begins anew at the end.

    Raises
    ------
    FileFormatError
        When it cannot be read, or holds no state of an aircraft.
    InvalidRequest
        For a speed or a position out of range.
    Busy
        When too many recordings are being replayed.
    """

    def __init__(
        self,
        station: Station,
        path: str | os.PathLike[str],
        *,
        speed: float = 1.0,
        start_s: float = 0.0,
        repeat: bool = False,
    ) -> None:
        self._native = _native.Replay(station._native, os.fspath(path), speed=speed, start_s=start_s, repeat=repeat)
        belongs_here(self)

    @property
    def name(self) -> str:
        """The aircraft; the file's name without its ending when the recording names none."""
        return self._native.name

    @property
    def path(self) -> Path:
        """The file."""
        return Path(self._native.path)

    @property
    def status(self) -> ReplayStatus:
        """The present state."""
        found = self._native.status()
        start, now = (_utc(found.pop(name)) for name in ("start_unix_s", "unix_s"))
        return ReplayStatus(system_ids=tuple(found.pop("system_ids")), start=start, time=now, **found)

    def pause(self) -> None:
        """Stop where it is."""
        self._native.pause()

    def play(self) -> None:
        """Go on; at the end, from the beginning."""
        self._native.play()

    def set_speed(self, speed: float) -> None:
        """Go on at another pace: 0.01 to 10,000 times the recorded one.

        Raises
        ------
        InvalidRequest
            For a speed out of range.
        """
        self._native.set_speed(speed)

    def seek(self, position_s: float) -> None:
        """Go to a position in the recording, s. Its vehicles begin anew there, with what was known then.

        Raises
        ------
        InvalidRequest
            For a negative position.
        """
        self._native.seek(position_s)

    def close(self) -> None:
        """End it; its vehicles disappear. Can be called again."""
        self._native.close()


def _utc(unix_s: float | None) -> datetime | None:
    return None if unix_s is None else datetime.fromtimestamp(unix_s, timezone.utc)
