"""Modes flown by stick: MANUAL, STABILIZE, FBWA, FBWB and CRUISE."""

from __future__ import annotations

import math

from vencejo.sim.autopilot.geo import Spot, distance_m
from vencejo.sim.autopilot.interface import Mode

from .base import Controls, FlightMode

__all__ = ["MODES"]


class ManualMode(FlightMode):
    """The sticks move the surfaces directly."""

    number = Mode.MANUAL
    stick = True

    def update(self) -> None:
        rc = self._plane.rc
        self._plane.pilot.stick_aileron(rc.stick(1))
        self._plane.pilot.stick_elevator(rc.stick(2), rc.throttle())


class StabilizeMode(FlightMode):
    """Levels with centred sticks; large deflections move the surfaces directly."""

    number = Mode.STABILIZE
    stick = True

    def update(self) -> None:
        plane = self._plane
        roll, pitch = plane.rc.stick(1), plane.rc.stick(2)
        if abs(roll) > 0.5:
            plane.pilot.stick_aileron(roll)
        else:
            plane.pilot.fly_bank(2.0 * roll * math.radians(plane.bank_limit_deg()))
        if abs(pitch) > 0.5:
            plane.pilot.stick_elevator(pitch, plane.rc.throttle())
        else:
            plane.pilot.fly_pitch(plane.stick_pitch_rad(2.0 * pitch), plane.rc.throttle())


class FbwaMode(FlightMode):
    """The sticks demand bank and pitch, within limits."""

    number = Mode.FBWA
    stick = True

    def update(self) -> None:
        plane = self._plane
        plane.pilot.fly_bank(plane.rc.stick(1) * math.radians(plane.bank_limit_deg()))
        plane.pilot.fly_pitch(plane.stick_pitch_rad(plane.rc.stick(2)), plane.rc.throttle())


class FbwbMode(FlightMode):
    """The sticks demand bank and climb rate, the throttle stick airspeed; altitude is held."""

    number = Mode.FBWB
    stick = True
    auto_throttle = True

    def enter(self) -> None:
        self._nav.target_alt_m = self._plane.here().alt_m

    def navigate(self) -> None:
        """Move the target altitude with the stick."""
        self._climb_with_stick()

    def update(self) -> None:
        plane = self._plane
        plane.pilot.fly_bank(plane.rc.stick(1) * math.radians(plane.bank_limit_deg()))
        self._energy.order()

    def adjust_altitude(self) -> None:
        """Nothing: the stick moves the target altitude."""

    def _climb_with_stick(self) -> None:
        plane = self._plane
        self._nav.target_alt_m += plane.rc.stick(2) * plane.tune["FBWB_CLIMB_RATE"] * 0.1


class CruiseMode(FbwbMode):
    """As FBWB, and holds the course over ground while the roll stick is centred."""

    number = Mode.CRUISE

    def __init__(self, controls: Controls) -> None:
        super().__init__(controls)
        self._start: Spot | None = None
        self._course_rad = 0.0

    def enter(self) -> None:
        super().enter()
        self._start = None

    def navigate(self) -> None:
        plane = self._plane
        self._climb_with_stick()
        free = abs(plane.rc.stick(1)) < 0.01 and abs(plane.rc.stick(4)) < 0.01
        if not free:
            self._start = None
        elif self._start is None and plane.est.groundspeed_m_s > 3.0 and abs(plane.est.roll_rad) < math.radians(5.0):
            self._start = plane.here()
            self._course_rad = math.atan2(plane.est.velocity_e_m_s, plane.est.velocity_n_m_s)
        if self._start is not None:
            nav = self._nav
            nav.previous = self._start
            # The target stays a kilometre ahead.
            nav.next = self._start.moved(self._course_rad, distance_m(self._start, plane.here()) + 1000.0)
            nav.next.alt_m = nav.target_alt_m

    def update(self) -> None:
        plane = self._plane
        if self._start is None:
            plane.pilot.fly_bank(plane.rc.stick(1) * math.radians(plane.bank_limit_deg()))
        else:
            self._nav.fly_leg(self._nav.previous, self._nav.next)
        self._energy.order()


MODES = (ManualMode, StabilizeMode, FbwaMode, FbwbMode, CruiseMode)
