"""Modes that circle: CIRCLE, LOITER and LOITER_ALT_QLAND."""

from __future__ import annotations

import math

from vencejo.sim.autopilot.interface import Mode, Severity

from .base import FlightMode

__all__ = ["MODES"]

_QRTL_ALT_M = 15.0
"""Q_RTL_ALT's default; the parameter does not exist without Q_ENABLE."""


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


class LoiterAltQlandMode(LoiterMode):
    """Circles down to Q_RTL_ALT for a vertical landing, which a plane without Q_ENABLE is refused, again and again.

    ArduPlane enters it without Q_ENABLE (ModeLoiterAltQLand): the plane keeps circling there.
    """

    number = Mode.LOITER_ALT_QLAND

    def enter(self) -> None:
        plane, nav = self._plane, self._nav
        spot = nav.next.copy() if nav.on_circle else plane.here()  # a circle that is being flown is kept
        super().enter()
        spot.alt_m, spot.follows_ground = plane.home.alt_m + _QRTL_ALT_M, False
        nav.set_guided(spot)
        self._try_to_land()

    def navigate(self) -> None:
        self._try_to_land()
        super().navigate()

    def _try_to_land(self) -> None:
        if (self._nav.above_next_m < 0.0 and self._nav.on_circle) or self._plane.body.on_wheels:
            self._plane.say(Severity.INFO, "Q_ENABLE 0")


MODES = (CircleMode, LoiterMode, LoiterAltQlandMode)
