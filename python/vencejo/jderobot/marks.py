"""The take-off and landing marks of ArDroneExtra: a mission uses them up, or they act alone when none follows."""

from __future__ import annotations

import threading
from dataclasses import dataclass

__all__ = ["Marks", "Taken"]


@dataclass(frozen=True)
class Taken:
    """Marks that were set.

    Attributes
    ----------
    takeoff, land : bool
    """

    takeoff: bool = False
    land: bool = False


class Marks:
    """Holds the marks; each is given out once, whichever thread asks.

    Time comes in as an argument, in seconds on any clock that does not jump.

    Parameters
    ----------
    alone_after_s : float
        How long after the last mark they act alone.
    """

    def __init__(self, alone_after_s: float) -> None:
        self._alone_after_s = alone_after_s
        self._lock = threading.Lock()
        self._set = Taken()
        self._due_s: float | None = None

    def mark(self, now_s: float, *, takeoff: bool = False, land: bool = False) -> None:
        """Set one, or both; the wait for a mission begins anew."""
        with self._lock:
            self._set = Taken(self._set.takeoff or takeoff, self._set.land or land)
            self._due_s = now_s + self._alone_after_s

    def take(self) -> Taken:
        """Use them up."""
        with self._lock:
            return self._take()

    @property
    def due_s(self) -> float | None:
        """When the marks act alone; ``None`` without marks."""
        return self._due_s

    def take_due(self, now_s: float) -> Taken:
        """Use them up when it is time for them to act alone."""
        with self._lock:
            return self._take() if self._due_s is not None and now_s >= self._due_s else Taken()

    def _take(self) -> Taken:
        taken, self._set, self._due_s = self._set, Taken(), None
        return taken
