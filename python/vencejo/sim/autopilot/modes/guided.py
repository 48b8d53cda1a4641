"""GUIDED: to a point, at the orders of a ground station."""

from __future__ import annotations

import math

from vencejo.sim.autopilot.geo import Spot, wrap_pi
from vencejo.sim.autopilot.interface import Mode

from .base import Controls, FlightMode

__all__ = ["MODES", "GuidedMode"]


class GuidedMode(FlightMode):
    """Flies to a point set by the ground station, and circles it."""

    number = Mode.GUIDED
    auto_throttle = True
    navigates = True

    def __init__(self, controls: Controls) -> None:
        super().__init__(controls)
        self.radius_m = 0.0
        self.clockwise = True
        self.heading: tuple[int, float, float] | None = None
        """Kind (0 course, 1 heading), angle in radians, bank limit in radians."""
        self.climb_rate_m_s = 0.0
        self._announced = False

    def enter(self) -> None:
        """Enter the mode."""
        self.radius_m = 0.0
        self.heading = None
        self.climb_rate_m_s = 0.0
        self.go_to(self._plane.here())

    def go_to(self, spot: Spot) -> None:
        """Set a new target."""
        self.heading = None
        self._nav.set_guided(spot)
        if self.radius_m > 0:
            self._nav.loiter.clockwise = self.clockwise

    def navigate(self) -> None:
        """Guide the plane to its target."""
        nav = self._nav
        if self.heading is None:
            nav.fly_circle(self.radius_m)
            return
        kind, angle, _ = self.heading
        est = self._plane.est
        drift = 0.0
        if kind == 0:
            drift = wrap_pi(est.yaw_rad - math.atan2(est.velocity_e_m_s, est.velocity_n_m_s))
        self._plane.pilot.fly_heading(wrap_pi(angle + drift))

    def update(self) -> None:
        """Set the demands on the control laws."""
        self._energy.order()

    def adjust_altitude(self) -> None:
        """Set the target altitude."""
        nav = self._nav
        if self.climb_rate_m_s > 0:
            step = self.climb_rate_m_s * 0.1
            nav.target_alt_m += min(step, max(-step, nav.next_alt_m - nav.target_alt_m))
        else:
            nav.adjust_altitude()


MODES = (GuidedMode,)
