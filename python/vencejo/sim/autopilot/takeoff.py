"""The take-off: throttle suppressed until the launch is felt, ground roll or hand launch, and climb.

Shared by NAV_TAKEOFF, mode TAKEOFF and the climb after an aborted landing.
"""

from __future__ import annotations

import math

from .interface import Severity
from .navigator import Navigator
from .plane import Plane

__all__ = ["Takeoff"]

_COURSE_SPEED_M_S = 5.0
_COURSE_WAIT_S = 0.3
_THROWN_AFTER_S = 4.0
"""Time from arming to the throw of a plane whose motor waits for it (TKOFF_THR_MINACC)."""
_THROW_S, _THROW_M_S = 0.36, 9.0
"""Duration of a throw by hand, and the ground speed that it gives."""
_REPORT_S = 2.0
_TIMEOUT_S = 0.1


class Takeoff:
    """The take-off of one plane."""

    def __init__(self, plane: Plane, nav: Navigator) -> None:
        self._plane = plane
        self._nav = nav
        self.pitch_deg = 0.0
        self.altitude_rel_m: float | None = None
        """Height above home where the climb ends."""
        self._timer_s: float | None = None
        self._reported_s = -10.0
        self._fast_since_s: float | None = None
        self._level_off_m: float | None = None
        self._level_off_s: float | None = None
        self._start_alt_m = 0.0
        self._triggered_s: float | None = None
        self._waits_since_s: float | None = None
        self._throw_s: float | None = None
        """Start of the throw."""
        self._thrown = False

    def begin_climb(self, pitch_deg: float, altitude_rel_m: float) -> None:
        """Climb with at least this pitch to a height above home."""
        self.pitch_deg = pitch_deg
        self.altitude_rel_m = altitude_rel_m
        self._fast_since_s = None
        self._level_off_m = self._level_off_s = None
        self._start_alt_m = self._plane.here().alt_m

    def reset(self) -> None:
        """Restart the launch sequence, after a disarming."""
        self._timer_s = None
        self._triggered_s = self._waits_since_s = self._throw_s = None
        self._thrown = False

    def check_launch(self) -> bool:
        """The launch sequence, 10 times a second while the throttle is suppressed; True when it may be opened.

        As Plane::auto_takeoff_check: the plane waits without a word for the acceleration TKOFF_THR_MINACC, then for
        TKOFF_THR_DELAY, and then needs the ground speed TKOFF_THR_MINSPD.
        """
        plane, tune, now = self._plane, self._plane.tune, self._plane.time_s
        if not plane.armed:
            self.reset()
            return False
        self._waits_since_s = now if self._waits_since_s is None else self._waits_since_s
        accel_m_s2 = self._forward_accel_m_s2()
        least_m_s2, counts = tune["TKOFF_THR_MINACC"], tune["TKOFF_ACCEL_CNT"]
        # One throw is one event; the shaking that TKOFF_ACCEL_CNT asks for is not simulated.
        if self._timer_s is None and least_m_s2 > 0 and (accel_m_s2 < least_m_s2 or counts > 1):
            return False
        delay_s = min(12.7, tune["TKOFF_THR_DELAY"] * 0.1)
        if self._timer_s is None:
            self._timer_s = now
            text = f"Armed AUTO, xaccel = {accel_m_s2:.1f} m/s/s, waiting {delay_s:.1f} sec"
            self._report(Severity.INFO, text)
        waited_s = now - self._timer_s
        if waited_s > delay_s + _TIMEOUT_S + 1e-6:
            self._report(Severity.WARNING, "Timeout AUTO")
            self._timer_s = None
            return False
        est = plane.est
        if not -30.0 < math.degrees(est.pitch_rad) < 45.0 or abs(math.degrees(est.roll_rad)) > 30.0:
            plane.say(Severity.WARNING, "Bad launch AUTO")
            self._timer_s = None
            return False
        least_m_s, speed_m_s = tune["TKOFF_THR_MINSPD"], self._groundspeed_m_s()
        if waited_s + 1e-6 < delay_s or (least_m_s > 0 and speed_m_s <= least_m_s):
            return False
        plane.say(Severity.INFO, f"Triggered AUTO. GPS speed = {speed_m_s:.1f}")
        self._timer_s = None
        self._triggered_s = now
        self._start_alt_m = plane.here().alt_m
        return True

    def _report(self, severity: Severity, text: str) -> None:
        """Send a text, one every two seconds at most."""
        if self._plane.time_s - self._reported_s > _REPORT_S - 1e-6:
            self._reported_s = self._plane.time_s
            self._plane.say(severity, text)

    # A throw moves the plane at once, when it ends; its acceleration and speed are those of the hand.

    @property
    def _thrown_for_s(self) -> float | None:
        """Time since a throw began that has not ended."""
        return None if self._throw_s is None or self._thrown else self._plane.time_s - self._throw_s

    def _groundspeed_m_s(self) -> float:
        since_s = self._thrown_for_s
        return self._plane.est.groundspeed_m_s if since_s is None else _THROW_M_S * since_s / _THROW_S

    def _forward_accel_m_s2(self) -> float:
        plane = self._plane
        if self._thrown_for_s is not None:
            return _THROW_M_S / _THROW_S
        return plane.est.forward_accel_m_s2 - 9.81 * math.sin(plane.est.pitch_rad)

    def throw(self) -> None:
        """Hand launch, while a take-off is being flown or waits: the plane leaves the hand at flying speed.

        It is thrown once the motor runs; where the motor waits for the throw, some seconds after the arming.
        """
        plane, now = self._plane, self._plane.time_s
        if self._thrown or not plane.armed:
            return
        if self._throw_s is None:
            waits = plane.tune["TKOFF_THR_MINACC"] > 0 and self._triggered_s is None
            since_s, after_s = (self._waits_since_s, _THROWN_AFTER_S) if waits else (self._triggered_s, 0.3)
            if since_s is None or now - since_s < after_s:
                return
            self._throw_s = now
        if now - self._throw_s + 1e-6 < _THROW_S:
            return
        self._thrown = True
        body = plane.body
        if body.height_m > 1.0 or plane.est.groundspeed_m_s > 5.0:
            return
        # At eye level, pitched up 12°.
        body.place(
            body.lat_deg,
            body.lon_deg,
            body.yaw_rad,
            height_m=1.7,
            pitch_rad=math.radians(12.0),
            speed_m_s=_THROW_M_S,
            wind_ne_m_s=(plane.wind.north_m_s, plane.wind.east_m_s),
        )

    # NAV_TAKEOFF, 10 times a second

    def verify(self) -> bool:
        """Hold the course of the ground roll; True when the altitude is reached."""
        plane = self._plane
        nav = self._nav
        est = plane.est
        wait_s = _COURSE_WAIT_S if plane.body.on_wheels else 0.0
        if nav.hold_course_rad is None and not plane.throttle_suppressed:
            if self._fast_since_s is None and est.groundspeed_m_s > _COURSE_SPEED_M_S:
                self._fast_since_s = plane.time_s
            if self._fast_since_s is not None and plane.time_s - self._fast_since_s >= wait_s:
                course = math.atan2(est.velocity_e_m_s, est.velocity_n_m_s)
                degrees = math.degrees(course) % 360.0
                nav.hold_course_rad = course
                plane.say(
                    Severity.INFO,
                    f"Holding course {int(degrees * 100)} at {est.groundspeed_m_s:.1f}m/s "
                    f"({math.degrees(est.yaw_rad - course):.1f})".replace("(-0.0)", "(0.0)"),
                )
        if nav.hold_course_rad is None:
            plane.pilot.fly_level()
        else:
            plane.pilot.fly_heading(nav.hold_course_rad)
        reached = self.altitude_rel_m is not None and plane.alt_rel_home_m > self.altitude_rel_m
        if not reached and not self.is_level:
            return False
        plane.say(Severity.INFO, f"Takeoff complete at {plane.alt_rel_home_m:.2f}m")
        nav.hold_course_rad = None
        nav.stay()
        nav.next_crosstrack = False
        return True

    # control

    def order_climb(self, airspeed_m_s: float) -> None:
        """Full throttle; pitch controls the airspeed, above a minimum pitch that fades over the last seconds."""
        plane = self._plane
        tune = plane.tune
        est = plane.est
        slow = max(tune["TKOFF_ROTATE_SPD"], tune["AIRSPEED_MIN"])
        throttle = (tune["TKOFF_THR_MAX"] or tune["THR_MAX"]) * 0.01
        if plane.body.on_wheels and est.airspeed_m_s < slow:
            # Ground roll, until the plane can fly.
            plane.pilot.fly_pitch(0.0, plane.throttle_ramp(throttle))
            return
        low = self._pitch_min_deg()
        # Pitch and throttle decrease with the remaining height. ArduPlane lowers its minimum pitch only: at full
        # throttle it overshoots to hold its airspeed, and descends again (62.7 m for 50 m in guided-flight.tlog).
        left = self._left()
        high = max(low, min(tune["PTCH_LIM_MAX_DEG"], tune["TECS_PITCH_MAX"] or tune["PTCH_LIM_MAX_DEG"]) * left)
        cruise = min(throttle, tune["TRIM_THROTTLE"] * 0.01)
        throttle = cruise + (throttle - cruise) * left
        plane.pilot.fly_energy(
            height_m=plane.home.alt_m + (self.altitude_rel_m or 0.0),
            airspeed_m_s=airspeed_m_s,
            climbout=True,
            pitch_min_rad=math.radians(low),
            pitch_max_rad=math.radians(high),
            throttle_min=throttle,
            throttle_max=throttle,
        )

    def _pitch_min_deg(self) -> float:
        plane = self._plane
        remaining = (self.altitude_rel_m or 0.0) - plane.alt_rel_home_m
        seconds = plane.tune["TKOFF_PLIM_SEC"]
        climb = -plane.est.velocity_d_m_s
        if self._level_off_m is not None:
            return self.pitch_deg * self._left()
        if seconds > 0 and climb > 0.1 and plane.alt_rel_home_m >= 10.0 and 0 < remaining / climb <= seconds:
            self._level_off_m = max(0.1, remaining)
            self._level_off_s = plane.time_s
            plane.say(Severity.INFO, f"Takeoff level-off starting at {int(remaining)}m")
        return self.pitch_deg

    def _left(self) -> float:
        """Remaining share of the level-off's height; 1 before it."""
        if self._level_off_m is None:
            return 1.0
        remaining = (self.altitude_rel_m or 0.0) - self._plane.alt_rel_home_m
        return max(0.0, min(1.0, remaining / self._level_off_m))

    @property
    def is_level(self) -> bool:
        """Whether the level-off has timed out; the last metres are climbed in cruise (check_takeoff_timeout_level_off).

        ArduPlane allows TKOFF_PLIM_SEC at the full climb rate; here the climb rate falls to zero, so twice that time.
        """
        if self._level_off_s is None:
            return False
        return self._plane.time_s - self._level_off_s > 2.0 * self._plane.tune["TKOFF_PLIM_SEC"]

    def bank_limit_deg(self, full_deg: float) -> float:
        """Bank limit: LEVEL_ROLL_LIMIT near the ground, rising to ``full_deg`` at three times TKOFF_LVL_ALT."""
        plane = self._plane
        level = plane.tune["LEVEL_ROLL_LIMIT"]
        low = max(0.0, plane.tune["TKOFF_LVL_ALT"])
        height = plane.here().alt_m - self._start_alt_m
        part = min(1.0, max(0.0, (height - low) / max(1.0, 2.0 * low)))
        return level + part * max(0.0, full_deg - level)
