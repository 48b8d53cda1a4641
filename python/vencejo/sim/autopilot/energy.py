"""Speed and altitude by total energy control: the target airspeed, and the demands shared by several modes."""

from __future__ import annotations

import math

from .interface import MavResult, Mode, Severity
from .landing import Landing
from .navigator import Navigator
from .plane import Plane

__all__ = ["Energy"]


class Energy:
    """Target airspeed of one plane, and the control demands that hold it together with the target altitude."""

    def __init__(self, plane: Plane, nav: Navigator, landing: Landing) -> None:
        self._plane = plane
        self._nav = nav
        self._landing = landing
        self.new_airspeed_m_s: float | None = None
        self.guided_airspeed_m_s: float | None = None
        """Airspeed of GUIDED_CHANGE_SPEED while it is held."""
        self.auto_throttle = False
        """Whether the autopilot controls the throttle in the present mode."""

    def order(self, *, throttle: float | None = None) -> None:
        """Demand the target altitude and airspeed, with the throttle free or as given, 0 to 1."""
        tune = self._plane.tune
        high = tune["PTCH_LIM_MAX_DEG"]
        if tune["TECS_PITCH_MAX"] > 0:
            high = min(high, tune["TECS_PITCH_MAX"])
        low = tune["PTCH_LIM_MIN_DEG"]
        if tune["TECS_PITCH_MIN"] < 0:
            low = max(low, tune["TECS_PITCH_MIN"])
        self._plane.pilot.fly_energy(
            height_m=self._nav.target_alt_m,
            airspeed_m_s=self.airspeed_m_s(),
            climbout=False,
            pitch_min_rad=math.radians(low),
            pitch_max_rad=math.radians(high),
            throttle_min=max(0.0, tune["THR_MIN"]) * 0.01 if throttle is None else throttle,
            throttle_max=tune["THR_MAX"] * 0.01 if throttle is None else throttle,
        )

    def airspeed_m_s(self) -> float:
        """Target airspeed, m/s EAS."""
        plane, tune = self._plane, self._plane.tune
        slow, fast = tune["AIRSPEED_MIN"], tune["AIRSPEED_MAX"]
        target = tune["AIRSPEED_CRUISE"]
        if plane.flight_mode in (Mode.FBWB, Mode.CRUISE):
            target = slow + (fast - slow) * plane.rc.throttle()
        elif self._landing.active and not self._landing.aborting:
            target = self._landing.airspeed_m_s()
        elif self.guided_airspeed_m_s is not None:
            target = self.guided_airspeed_m_s
        elif self.new_airspeed_m_s is not None and plane.flight_mode in (Mode.AUTO, Mode.GUIDED):
            target = self.new_airspeed_m_s
        least = tune["MIN_GROUNDSPEED"]
        if least > 0 and self.auto_throttle and plane.flight_mode is not Mode.CIRCLE:
            est = plane.est
            ahead = est.velocity_n_m_s * math.cos(est.yaw_rad) + est.velocity_e_m_s * math.sin(est.yaw_rad)
            target = max(target, est.airspeed_m_s + (least - ahead) / est.eas_to_tas)
        return min(fast, max(slow, target))

    def load_saved(self) -> None:
        """Restore the saved values of the parameters that :meth:`change_speed` sets: after a landing and at a boot."""
        self._plane.tune.load("MIN_GROUNDSPEED", "TRIM_THROTTLE")

    def change_speed(self, kind: int, speed_m_s: float, throttle_pct: float) -> MavResult:
        """Set target airspeed (``kind`` 0), minimum ground speed (1) or cruise throttle.

        The last two are unsaved parameter values: they hold in all modes and after a disarming.
        """
        plane = self._plane
        if not math.isfinite(speed_m_s):
            return MavResult.DENIED
        if kind == 0:
            if speed_m_s == -2.0:
                self.new_airspeed_m_s = None
                return MavResult.ACCEPTED
            if plane.tune["AIRSPEED_MIN"] <= speed_m_s <= plane.tune["AIRSPEED_MAX"]:
                self.new_airspeed_m_s = speed_m_s
                plane.say(Severity.INFO, f"Set airspeed {int(speed_m_s)} m/s")
                return MavResult.ACCEPTED
        elif kind == 1:
            plane.tune.set_unsaved("MIN_GROUNDSPEED", speed_m_s)
            plane.say(Severity.INFO, f"Set groundspeed {int(max(0.0, speed_m_s))}")
            return MavResult.ACCEPTED
        if 0 < throttle_pct <= 100:
            plane.tune.set_unsaved("TRIM_THROTTLE", throttle_pct)
            plane.say(Severity.INFO, f"Set throttle {int(throttle_pct)}")
            return MavResult.ACCEPTED
        return MavResult.FAILED
