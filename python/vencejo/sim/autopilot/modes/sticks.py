"""Modes flown by stick: MANUAL, STABILIZE, TRAINING, ACRO, FBWA, AUTOTUNE, FBWB and CRUISE.

With centred sticks and closed throttle FBWA glides with level wings, FBWB holds its height and CRUISE its course too;
ACRO keeps the attitude it has, and MANUAL and TRAINING let the surfaces go.
"""

from __future__ import annotations

import math

from vencejo.sim.autopilot.geo import Spot, distance_m
from vencejo.sim.autopilot.interface import Mode

from .base import Controls, FlightMode

__all__ = ["MODES"]

_ACRO_LEAD_S = 0.3
"""Time by which the attitude demanded by a rate is ahead: that of the attitude laws' response."""
_ACRO_BANK_RAD, _ACRO_PITCH_RAD = math.radians(80.0), math.radians(70.0)


class ManualMode(FlightMode):
    """The sticks move the surfaces directly."""

    number = Mode.MANUAL
    captures_direction = True

    def update(self) -> None:
        rc = self._plane.rc
        self._plane.pilot.stick_aileron(rc.stick(1))
        self._plane.pilot.stick_elevator(rc.stick(2), rc.throttle())


class StabilizeMode(FlightMode):
    """Levels with centred sticks; large deflections move the surfaces directly."""

    number = Mode.STABILIZE
    captures_direction = True

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


class TrainingMode(FlightMode):
    """The sticks move the surfaces directly, up to the limits of bank and pitch, which are held."""

    number = Mode.TRAINING
    captures_direction = True

    def update(self) -> None:
        plane, est = self._plane, self._plane.est
        roll, pitch, throttle = plane.rc.stick(1), plane.rc.stick(2), plane.rc.throttle()
        bank_rad = math.radians(plane.bank_limit_deg())
        if abs(est.roll_rad) >= bank_rad and roll * est.roll_rad >= 0.0:
            plane.pilot.fly_bank(math.copysign(bank_rad, est.roll_rad))
        else:
            plane.pilot.stick_aileron(roll)
        limit_rad = plane.stick_pitch_rad(math.copysign(1.0, est.pitch_rad))
        if abs(est.pitch_rad) >= abs(limit_rad) and pitch * est.pitch_rad >= 0.0:
            plane.pilot.fly_pitch(limit_rad, throttle)
        else:
            plane.pilot.stick_elevator(pitch, throttle)


class AcroMode(FlightMode):
    """The sticks demand rates; without them the attitude is held (ACRO_LOCKING).

    The control laws hold attitudes, so a rate is an attitude that moves with it, up to :data:`_ACRO_BANK_RAD` and
    :data:`_ACRO_PITCH_RAD`.
    """

    number = Mode.ACRO
    captures_direction = True

    def __init__(self, controls: Controls) -> None:
        super().__init__(controls)
        self._roll_rad = self._pitch_rad = 0.0

    def bank_max_deg(self, limit_deg: float) -> float:
        return math.degrees(_ACRO_BANK_RAD)

    def enter(self) -> None:
        self._roll_rad, self._pitch_rad = self._plane.est.roll_rad, self._plane.est.pitch_rad

    def update(self) -> None:
        plane, est = self._plane, self._plane.est
        roll, pitch = plane.rc.stick(1), plane.rc.stick(2)
        if roll != 0.0:
            rate_rad_s = roll * math.radians(plane.tune["ACRO_ROLL_RATE"])
            self._roll_rad = _within(est.roll_rad + _ACRO_LEAD_S * rate_rad_s, _ACRO_BANK_RAD)
        if pitch != 0.0:
            rate_rad_s = pitch * math.radians(plane.tune["ACRO_PITCH_RATE"])
            self._pitch_rad = _within(est.pitch_rad + _ACRO_LEAD_S * rate_rad_s, _ACRO_PITCH_RAD)
        plane.pilot.fly_bank(self._roll_rad)
        plane.pilot.fly_pitch(self._pitch_rad, plane.rc.throttle())


def _within(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))


class FbwaMode(FlightMode):
    """The sticks demand bank and pitch, within limits."""

    number = Mode.FBWA
    captures_direction = True

    def update(self) -> None:
        plane = self._plane
        plane.pilot.fly_bank(plane.rc.stick(1) * math.radians(plane.bank_limit_deg()))
        plane.pilot.fly_pitch(plane.stick_pitch_rad(plane.rc.stick(2)), plane.rc.throttle())


class AutotuneMode(FbwaMode):
    """As FBWA. It announces the tuning, which changes nothing here."""

    number = Mode.AUTOTUNE

    def enter(self) -> None:
        self._plane.autotune(on=True)


class FbwbMode(FlightMode):
    """The sticks demand bank and climb rate, the throttle stick airspeed; altitude is held."""

    number = Mode.FBWB
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


MODES = (ManualMode, StabilizeMode, TrainingMode, AcroMode, FbwaMode, AutotuneMode, FbwbMode, CruiseMode)
