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
from typing import IO, TYPE_CHECKING, Any

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
        When the autopilot was last heard, or the program was started, by `time.monotonic`, which is one clock for all
        programs and no time from the network sets; ``None`` while it is heard.
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
        since = None if silent_s is None else time.monotonic() - silent_s
        return cls(name=name, links=links, silent_since=since, states=status.links)

    @property
    def silent_s(self) -> float | None:
        """How long the autopilot has been silent; ``None`` while it is heard."""
        return None if self.silent_since is None else max(0.0, time.monotonic() - self.silent_since)

    def as_json(self) -> dict[str, Any]:
        """As `vencejo fleet status` prints them."""
        silent_s = None if self.silent_s is None else round(self.silent_s, 1)
        return {"name": self.name, "link": list(self.links), "autopilot_silent_s": silent_s, "links": self.states}


class LinkNote:
    """The file that `vencejo onboard` keeps while it runs, which a lock beside it shows; written when a state changes."""

    def __init__(self, path: Path | None = None) -> None:
        self._path = _file() if path is None else path
        self._lock: IO[bytes] | None = None
        self._written: list[tuple[str | None, str | None]] | None = None

    def __enter__(self) -> LinkNote:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._lock is not None:
            self._lock.close()

    def write(self, planes: Sequence[PlaneLinks]) -> None:
        """Write the present states, if any has changed; nothing while another program has the file."""
        states = [(plane.name, without_counts(plane.states)) for plane in planes]
        # Without it the doctor knows nothing of the link, which ends nothing.
        with contextlib.suppress(OSError):
            if not self._is_locked() or states == self._written:
                return
            # Whoever reads it meanwhile gets all of the one before.
            new = self._path.with_name(f".{self._path.name}.new")
            new.write_text(json.dumps([asdict(plane) for plane in planes]), encoding="utf-8")
            new.replace(self._path)
            self._written = states

    def _is_locked(self) -> bool:
        """Whether the file is this program's, now or from before: a doctor may have the lock for a moment."""
        if self._lock is None and KNOWS and self._path.parent.is_dir():
            lock = _lock_of(self._path).open("wb")
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                lock.close()
                raise
            self._lock = lock
        return self._lock is not None


def running(path: Path | None = None) -> list[PlaneLinks] | None:
    """The links of the running program; ``None`` if none runs, or this system cannot tell."""
    if not KNOWS:
        return None
    path = _file() if path is None else path
    with contextlib.suppress(OSError, ValueError, TypeError, KeyError), _lock_of(path).open("rb") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            planes = json.loads(path.read_text(encoding="utf-8"))
            return [PlaneLinks(**{**plane, "links": tuple(plane["links"])}) for plane in planes]
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
    if (silent_s := plane.silent_s) is None:
        return Check(ok=True, message=f"the autopilot{of} is heard on {', '.join(plane.links)}")
    return Check(
        ok=False,
        message=f"no message of the autopilot{of} for {silent_s:.0f} s: {plane.states}",
        remedy="check the cable, the baud rate, the serial port of this computer, and that the autopilot is on",
    )


def _lock_of(path: Path) -> Path:
    return path.with_name(f".{path.name}.lock")


def _file() -> Path:
    from vencejo.enrolment import fleet_folder

    # Every .json there is the membership of a ground station.
    return fleet_folder() / "onboard.links"
