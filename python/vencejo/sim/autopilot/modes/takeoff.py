"""TAKEOFF: the take-off without a mission."""

from __future__ import annotations

import math

from vencejo.sim.autopilot.geo import Spot, bearing_rad, distance_m
from vencejo.sim.autopilot.interface import Mode, Severity

from .base import Controls, FlightMode

__all__ = ["MODES", "TakeoffMode"]


class TakeoffMode(FlightMode):
    """Takes off straight ahead to TKOFF_ALT and circles at TKOFF_DIST."""

    number = Mode.TAKEOFF
    auto_throttle = True
    navigates = True
    captures_direction = True

    def __init__(self, controls: Controls) -> None:
        super().__init__(controls)
        self._start: Spot | None = None
        self.climbing = False

    def enter(self) -> None:
        """Enter the mode."""
        self._start = None
        self.climbing = True
        plane = self._plane
        self._climbout.begin_climb(plane.tune["TKOFF_LVL_PITCH"], plane.tune["TKOFF_ALT"])

    def navigate(self) -> None:
        """Guide the plane to its target."""
        plane = self._plane
        nav, tune, est = self._nav, plane.tune, plane.est
        alt, dist = tune["TKOFF_ALT"], tune["TKOFF_DIST"]
        if self._start is None:
            here = plane.here()
            course = math.atan2(est.velocity_e_m_s, est.velocity_n_m_s)
            if plane.is_flying and plane.flying_since_s is not None and plane.time_s - plane.flying_since_s > 10.0:
                if plane.alt_rel_home_m >= alt:
                    plane.say(Severity.INFO, "Above TKOFF alt - loitering")
                    nav.set_guided(here)
                    self.climbing = False
                else:
                    plane.say(Severity.INFO, "Climbing to TKOFF alt then loitering")
                    target = here.moved(course, dist)
                    target.alt_m = plane.home.alt_m + alt
                    nav.set_guided(target)
                self._start = here
            elif not plane.throttle_suppressed and est.groundspeed_m_s > 0.3 * tune["AIRSPEED_MIN"]:
                heading = math.degrees(course) % 360.0
                plane.say(Severity.INFO, f"Takeoff to {alt:.0f}m for {dist:.1f}m heading {heading:.1f} deg")
                target = here.moved(course, dist)
                target.alt_m = here.alt_m + alt
                self._climbout.altitude_rel_m = target.alt_m - plane.home.alt_m
                nav.set_guided(target)
                self._start = here
        if self._start is None:
            plane.pilot.fly_level()
            return
        if self.climbing:
            high = plane.here().alt_m >= nav.next.alt_m - 2.0
            if high or self._climbout.is_level or distance_m(self._start, plane.here()) >= dist:
                self.climbing = False
                nav.target_alt_m = nav.next.alt_m
            else:
                plane.pilot.fly_heading(bearing_rad(self._start, nav.next))
                return
        nav.fly_circle()

    def update(self) -> None:
        """Set the demands on the control laws."""
        if self.climbing:
            self._climbout.order_climb(self._energy.airspeed_m_s())
        else:
            self._energy.order()


MODES = (TakeoffMode,)
