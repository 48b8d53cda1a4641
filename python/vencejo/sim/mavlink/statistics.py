"""The statistics of a plane in its STAT_* parameters (AP_Stats)."""

from __future__ import annotations

import math
from collections.abc import Callable

from vencejo.sim.autopilot.interface import Snapshot
from vencejo.sim.params import Parameter, ParamStore

__all__ = ["Statistics"]

_FLUSH_S = 30.5
"""Interval of parameter updates, as recorded; they are updated at the end of a flight too."""
_LEAST_STEP_M = 0.5
"""Shorter distances within a second count as noise."""


class Statistics:
    """Flight time, run time, flights and distance of one plane; call :meth:`update` ten times a simulated second.

    Parameters
    ----------
    params : ParamStore
        The parameter store.
    changed : callable
        Receives each parameter changed by an update.
    """

    def __init__(self, params: ParamStore, changed: Callable[[Parameter], None]) -> None:
        self._params = params
        self._changed = changed
        self._start()

    def _start(self) -> None:
        self._values = {
            name: self._params.get(name) for name in ("STAT_FLTTIME", "STAT_RUNTIME", "STAT_FLTCNT", "STAT_DISTFLWN")
        }
        self._flushed_s = 0.0
        self._looked_s: float | None = None
        self._place: tuple[float, float, float] | None = None
        self._was_flying = False

    def restart(self) -> None:
        """Count a boot."""
        self._params.set("STAT_BOOTCNT", self._params.get("STAT_BOOTCNT") + 1.0)
        self._start()

    def update(self, now: Snapshot) -> None:
        """Accumulate, and update the parameters when that is due."""
        ends = self._was_flying and not now.is_flying
        if now.is_flying and not self._was_flying:
            self._values["STAT_FLTCNT"] += 1.0
        self._was_flying = now.is_flying
        if self._looked_s is None or now.time_s - self._looked_s >= 1.0:
            self._count(now)
        if ends or now.time_s - self._flushed_s >= _FLUSH_S:
            self._flushed_s = now.time_s
            self._flush()

    def _count(self, now: Snapshot) -> None:
        seconds = now.time_s - (self._looked_s or 0.0)
        self._looked_s = now.time_s
        self._values["STAT_RUNTIME"] += seconds
        place = (now.north_m, now.east_m, now.down_m) if now.is_flying else None
        if now.is_flying:
            self._values["STAT_FLTTIME"] += seconds
        if place is not None and self._place is not None:
            step_m = math.dist(place, self._place)
            self._values["STAT_DISTFLWN"] += step_m if step_m >= _LEAST_STEP_M else 0.0
        self._place = place

    def _flush(self) -> None:
        for name, value in self._values.items():
            before = self._params.get(name)
            after = self._params.set(name, value)
            if after.value != before:
                self._changed(after)
