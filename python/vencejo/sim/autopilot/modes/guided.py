"""GUIDED: to a point, at the orders of a ground station; and AVOID_ADSB, which flies like it."""

from __future__ import annotations

import math

from vencejo.sim.autopilot.geo import Spot, wrap_pi
from vencejo.sim.autopilot.interface import Mode

from .base import Controls, FlightMode

__all__ = ["MODES", "GuidedMode"]

_CLIMB_SHARE = 0.03
"""Share of the rate of GUIDED_CHANGE_ALTITUDE at which ArduPlane 4.8-dev climbs: measured with 1, 3 and 10 m/s."""


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
        self._held: tuple[Spot, float] | None = None
        """Altitude of GUIDED_CHANGE_ALTITUDE, as a spot, and its climb rate."""
        self._speed: tuple[float, float] | None = None
        """Airspeed of GUIDED_CHANGE_SPEED and its acceleration."""
        self._forced: dict[str, tuple[float, float]] = {}
        """Roll and pitch (radians) and throttle of SET_ATTITUDE_TARGET, each with the time until which it is flown."""

    def enter(self) -> None:
        """Enter the mode."""
        self.radius_m = 0.0
        self.go_to(self._plane.here())

    def forget(self) -> None:
        """Forget the commanded heading, altitude, airspeed and attitude: at every change of mode, refused or not."""
        self.heading = None
        self._held = self._speed = None
        self._energy.guided_airspeed_m_s = None
        self._forced.clear()

    def go_to(self, spot: Spot) -> None:
        """Set a new target."""
        self.heading = None
        self._nav.set_guided(spot)
        if self.radius_m > 0:
            self._nav.loiter.clockwise = self.clockwise

    def force(self, roll_rad: float | None, pitch_rad: float | None, throttle: float | None) -> None:
        """Fly an attitude and throttle for GUIDED_TIMEOUT (ModeGuided::update); None is left to guidance."""
        until_s = self._plane.time_s + self._plane.tune["GUIDED_TIMEOUT"]
        for name, value in (("roll", roll_rad), ("pitch", pitch_rad), ("throttle", throttle)):
            if value is not None:
                self._forced[name] = (value, until_s)

    def _force_of(self, name: str) -> float | None:
        value, until_s = self._forced.get(name, (0.0, 0.0))
        return value if self._plane.time_s < until_s else None

    def bank_max_deg(self, limit_deg: float) -> float:
        """The bank limit of a commanded heading."""
        return limit_deg if self.heading is None else min(limit_deg, math.degrees(self.heading[2]))

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
        plane = self._plane
        roll_rad, pitch_rad, throttle = map(self._force_of, ("roll", "pitch", "throttle"))
        if roll_rad is not None:
            plane.pilot.fly_bank(roll_rad)
        if pitch_rad is None:
            self._energy.order(throttle=throttle)
        else:
            low_rad, high_rad = plane.stick_pitch_rad(-1.0), plane.stick_pitch_rad(1.0)
            pitch_rad = max(low_rad, min(high_rad, pitch_rad))
            plane.pilot.fly_pitch(pitch_rad, plane.throttle if throttle is None else throttle)

    def hold_altitude(self, alt_m: float, *, follows_ground: bool, rate_m_s: float) -> None:
        """Hold an altitude until the mode is left: as in ArduPlane, whatever altitude a later command gives."""
        self._held = (Spot(0.0, 0.0, alt_m, follows_ground=follows_ground), rate_m_s)
        self._nav.target_alt_m = self._plane.here().alt_m

    def hold_airspeed(self, airspeed_m_s: float, accel_m_s2: float) -> None:
        """Hold an airspeed until the mode is left: as in ArduPlane, whatever DO_CHANGE_SPEED says later."""
        self._speed = (airspeed_m_s, accel_m_s2)
        if accel_m_s2 <= 0:
            self._energy.guided_airspeed_m_s = airspeed_m_s
        elif self._energy.guided_airspeed_m_s is None:
            self._energy.guided_airspeed_m_s = self._energy.airspeed_m_s()

    def adjust_altitude(self) -> None:
        """Set the target altitude, and move the target airspeed; 10 times a second."""
        nav, energy = self._nav, self._energy
        if self._speed is not None and energy.guided_airspeed_m_s is not None:
            wanted_m_s, accel_m_s2 = self._speed
            change = wanted_m_s - energy.guided_airspeed_m_s
            energy.guided_airspeed_m_s += max(-0.1 * accel_m_s2, min(0.1 * accel_m_s2, change))
        if self._held is None:
            nav.adjust_altitude()
            return
        spot, rate_m_s = self._held
        ground_m = self._plane.ground_rel_home_m() if spot.follows_ground else None
        change = spot.alt_m + (ground_m or 0.0) - nav.target_alt_m
        # ArduPlane's target is the present altitude plus the climb of one main loop, which is hardly a climb.
        step_m = math.inf if rate_m_s <= 0 else 0.1 * _CLIMB_SHARE * rate_m_s
        nav.target_alt_m += max(-step_m, min(step_m, change))


class AvoidAdsbMode(GuidedMode):
    """Circles where it was entered; ArduPlane enters it at anybody's request, with or without traffic."""

    number = Mode.AVOID_ADSB
    navigates = False


MODES = (GuidedMode, AvoidAdsbMode)
