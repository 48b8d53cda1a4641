"""Modes that circle: CIRCLE and LOITER."""

from __future__ import annotations

import math

from vencejo.sim.autopilot.interface import Mode

from .base import FlightMode

__all__ = ["MODES"]


class CircleMode(FlightMode):
    """A constant bank that drifts with the wind, at the altitude of entry."""

    number = Mode.CIRCLE
    auto_throttle = True
    navigates = True

    def enter(self) -> None:
        self._nav.stay()
        self._nav.reset_slope()

    def update(self) -> None:
        self._plane.pilot.fly_bank(math.radians(self._plane.bank_limit_deg() / 3.0))
        self._energy.order()


class LoiterMode(FlightMode):
    """Circles the position of entry."""

    number = Mode.LOITER
    auto_throttle = True
    navigates = True

    def enter(self) -> None:
        nav = self._nav
        nav.stay()
        nav.reset_loiter()
        nav.reset_slope()
        nav.target_alt_m = nav.next.alt_m

    def navigate(self) -> None:
        self._nav.fly_circle()

    def update(self) -> None:
        self._energy.order()


MODES = (CircleMode, LoiterMode)
