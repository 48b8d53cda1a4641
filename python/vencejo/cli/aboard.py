"""The links of a running `vencejo onboard`, which it writes down for `vencejo fleet doctor`."""

from __future__ import annotations

import contextlib
import json
import re
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, TYPE_CHECKING

if sys.platform != "win32":
    import fcntl

if TYPE_CHECKING:
    from vencejo.enrolment import Check
    from vencejo.fleet import AircraftStatus

KNOWS = sys.platform != "win32"
"""Whether this system has the locks that show that the program runs."""


def without_counts(text: str | None) -> str | None:
    """States of links without their numbers, which change all the time."""
    return None if text is None else re.sub(r"\d+", "", text)


@dataclass(frozen=True, kw_only=True)
class PlaneLinks:
    """The links to one autopilot.

    Attributes
    ----------
    name : str or None
        The plane's name, if it was given.
    links : tuple[str, ...]
        Link strings.
    silent_since : float or None
        When the autopilot was last heard, or the program was started, seconds since 1970; ``None`` while it is heard.
    states : str or None
        The links and their states while it is silent.
    """

    name: str | None
    links: tuple[str, ...]
    silent_since: float | None
    states: str | None

    @classmethod
    def of(cls, name: str | None, links: tuple[str, ...], status: AircraftStatus) -> PlaneLinks:
        """Those that a status shows now."""
        silent_s = status.autopilot_silent_s
        since = None if silent_s is None else time.time() - silent_s
        return cls(name=name, links=links, silent_since=since, states=status.links)


class LinkNote:
    """The file that `vencejo onboard` keeps locked while it runs; written when a state changes."""

    def __init__(self, path: Path | None = None) -> None:
        self._path = _file() if path is None else path
        self._open: IO[str] | None = None
        self._written: list[tuple[str | None, str | None]] | None = None

    def __enter__(self) -> LinkNote:
        # Without it the doctor knows nothing of the link, which ends nothing.
        with contextlib.suppress(OSError):
            if KNOWS and self._path.parent.is_dir():
                file = self._path.open("a", encoding="utf-8")
                try:
                    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except OSError:  # another one runs
                    file.close()
                    raise
                self._open = file
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._open is not None:
            self._open.close()

    def write(self, planes: Sequence[PlaneLinks]) -> None:
        """Write the present states, if any has changed."""
        states = [(plane.name, without_counts(plane.states)) for plane in planes]
        if self._open is None or states == self._written:
            return
        self._written = states
        with contextlib.suppress(OSError):
            self._open.truncate(0)
            self._open.write(json.dumps([asdict(plane) for plane in planes]))
            self._open.flush()


def running(path: Path | None = None) -> list[PlaneLinks] | None:
    """The links of the running program; ``None`` if none runs."""
    try:
        with (_file() if path is None else path).open(encoding="utf-8") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
            except BlockingIOError:
                planes = json.load(file)
                return [PlaneLinks(**{**plane, "links": tuple(plane["links"])}) for plane in planes]
    except (OSError, ValueError, TypeError, KeyError):  # none, or just being written
        pass
    return None


def link_checks(path: Path | None = None) -> list[Check]:
    """Whether `vencejo onboard` runs here, and hears its autopilot."""
    from vencejo.enrolment import Check

    if not KNOWS:
        return []
    planes = running(path)
    if planes is None:
        message = "vencejo onboard is not running here, so nothing is known of the link to the autopilot"
        remedy = "start it with that link: vencejo onboard --link /dev/serial0,921600"
        return [Check(ok=False, message=message, remedy=remedy)]
    return [_checked(plane) for plane in planes]


def _checked(plane: PlaneLinks) -> Check:
    from vencejo.enrolment import Check

    of = "" if plane.name is None else f" of {plane.name}"
    if plane.silent_since is None:
        return Check(ok=True, message=f"the autopilot{of} is heard on {', '.join(plane.links)}")
    silent_s = max(0.0, time.time() - plane.silent_since)
    return Check(
        ok=False,
        message=f"no message of the autopilot{of} for {silent_s:.0f} s: {plane.states}",
        remedy="check the cable, the baud rate, the serial port of this computer, and that the autopilot is on",
    )


def _file() -> Path:
    from vencejo.enrolment import fleet_folder

    return fleet_folder() / "onboard.json"
