"""Sources whose pictures ended the process that reads them, time and again: they are left alone for a while, also after a restart."""

from __future__ import annotations

import contextlib
import hashlib
import time
from collections.abc import Callable
from pathlib import Path
from typing import Final

from vencejo.storage import make_folder, write_file

__all__ = ["Aside"]

DEATHS: Final = 3
"""Processes that a source may end before it is set aside."""
REST_S: Final = 600.0
"""How long it is left alone then, before it is tried once more."""
SOUND_S: Final = 30.0
"""A source that has given pictures for this long counts as sound again, s."""


class Aside:
    """The crash record of one source.

    Parameters
    ----------
    folder : Path
        Where recordings go; a note is beside them.
    location : str
        The source. It may hold a password, so that its hash alone is written.
    unix_s : callable, optional
        The time of day.
    """

    def __init__(self, folder: Path, location: str, *, unix_s: Callable[[], float] = time.time) -> None:
        self._note = folder / ".set-aside" / hashlib.sha256(location.encode()).hexdigest()[:32]
        self._unix_s = unix_s
        self._deaths = 0
        self._since_s: float | None = None
        self.wait_s = 0.0
        """How long to leave it alone from now on; 0 while it is not set aside."""

    def left(self) -> tuple[str, float] | None:
        """Why a former run set it aside, and how long it still is; ``None`` when it did not, or long ago."""
        try:
            rest_s = self._note.stat().st_mtime + REST_S - self._unix_s()
            why = self._note.read_text(encoding="utf-8")[:500]
        except (OSError, UnicodeDecodeError):
            return None
        # One more death is enough: it is still the same source.
        self._deaths = DEATHS - 1
        return (why, rest_s) if 0.0 < rest_s <= REST_S else None

    def died(self, why: str) -> str:
        """Count a process that it ended; the reason to tell."""
        self._deaths += 1
        self._since_s = None
        if self._deaths < DEATHS:
            return why
        self.wait_s = REST_S
        why = f"set aside, and tried again after {REST_S / 60:g} minutes: {why}"
        with contextlib.suppress(OSError):
            make_folder(self._note.parent)
            write_file(self._note, why.encode())
        return why

    def came(self, now_s: float) -> None:
        """A picture came. After a while of pictures it is sound again."""
        if self._since_s is None:
            self._since_s = now_s
        elif self._deaths > 0 and now_s - self._since_s > SOUND_S:
            self._deaths, self.wait_s = 0, 0.0
            self._note.unlink(missing_ok=True)
