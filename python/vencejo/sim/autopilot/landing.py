"""The landing: approach along a glide slope to an aim point before the landing point, flare, and roll to rest.

The slope is ArduPlane's (LAND_TYPE 0): straight to the start of the flare, above and before the landing point. The
owner of a real plane tunes that distance (LAND_FLARE_AIM); here it is computed for the airframe, from the float time,
the touchdown speed, the ground roll and the present wind, so that the plane comes to rest on the landing point.
"""

from __future__ import annotations

import math
from enum import IntEnum

from .auto.mission import MissionRunner
from .geo import bearing_rad, distance_m, wrap_pi
from .interface import Severity, StoredItem
from .navigator import Navigator
from .plane import Plane
from .takeoff import Takeoff

__all__ = ["Landing", "Stage"]

_PROJECTION_M = 500.0
_TOUCHDOWN_M_S = 11.7
"""Equivalent airspeed at touchdown, independent of the approach speed: that of the wing at LAND_PITCH_DEG."""
_FLARE_S, _FLARE_S_PER_M, _FLARE_S_PER_M_S = 4.3, 0.5, 0.25
"""Duration of the flare: minimum, per metre of its height, and per m/s of tail wind."""
_ROLL_DECEL_M_S2 = 2.1
"""Deceleration of the ground roll: rolling friction of the airframe file, and drag."""
_GROUND_WIND = 0.6
"""Wind at wing height on the ground, as a share of that on the approach (boundary layer, wind.py)."""


class Stage(IntEnum):
    """Progress of a landing."""

    NORMAL = 0
    """Turning on to the final leg."""
    APPROACH = 1
    """On the glide slope."""
    PREFLARE = 2
    """Slowing down to LAND_PF_ARSPD."""
    FINAL = 3
    """Flare and roll."""


class Landing:
    """The landing of one plane, begun by NAV_LAND."""

    def __init__(self, plane: Plane, nav: Navigator, climbout: Takeoff, mission: MissionRunner) -> None:
        self._plane = plane
        self._nav = nav
        self._climbout = climbout
        self._mission = mission
        self.active = False
        self.stage = Stage.NORMAL
        self.aborting = False
        self._slope: float | None = None
        self._flare_height_m = 0.0
        self._flare_sink_m_s = 0.0
        self._report = False
        self._fresh = False
        self._groundspeed_m_s = 0.0
        self._abort_alt_m = 30.0

    @property
    def flaring(self) -> bool:
        """True from the flare on."""
        return self.active and self.stage is Stage.FINAL

    def begin(self, item: StoredItem) -> None:
        """Start NAV_LAND."""
        plane = self._plane
        self.active = self._nav.is_landing = True
        self.aborting = False
        self.stage = Stage.NORMAL
        self._slope = None
        self._fresh = False
        self._groundspeed_m_s = plane.est.groundspeed_m_s
        self._abort_alt_m = item.p1 if item.p1 > 0 else (self._climbout.altitude_rel_m or 30.0)
        spot = plane.spot_of(item)
        self._nav.set_next(spot)
        plane.say(Severity.INFO, f"Landing approach start at {plane.alt_rel_home_m:.1f}m")

    def end(self) -> None:
        """End the landing: another command or mode takes over."""
        self.active = self._nav.is_landing = False
        self.aborting = False
        self.stage = Stage.NORMAL
        self._report = False

    def request_go_around(self, climb_to_m: float) -> bool:
        """Abort (Plane::trigger_land_abort): by the mission's abort pattern, else straight ahead.

        ``climb_to_m`` is the height above home to climb to without a pattern; 0 selects that of NAV_LAND or of the
        take-off. False when the plane is not landing in AUTO.
        """
        plane = self._plane
        if not self.active or not plane.in_auto:
            return False
        if self._mission.jump_to_abort(plane.distance_to_item):
            return True
        if climb_to_m != 0.0:
            self._abort_alt_m = climb_to_m
        if self.aborting:
            return True
        self.aborting = True
        self.stage = Stage.NORMAL
        self._nav.hold_course_rad = plane.est.yaw_rad
        self._climbout.begin_climb(self._climbout.pitch_deg or 10.0, self._abort_alt_m)
        plane.say(Severity.NOTICE, f"Landing aborted, climbing to {self._abort_alt_m:.0f}m")
        return True

    # navigation, 10 times a second

    def verify(self) -> None:
        """Follow the final leg and determine the stage."""
        plane = self._plane
        nav = self._nav
        if self.aborting:
            course = nav.hold_course_rad
            if course is not None:
                plane.pilot.fly_heading(course)
            if plane.alt_rel_home_m > self._abort_alt_m:
                self.end()
                if not self._mission.restart_landing(plane.distance_to_item):
                    self._mission.stop()
            return
        height = nav.above_next_m
        sink = plane.est.velocity_d_m_s
        # Low-pass filtered, so that gusts do not move the aim point.
        self._groundspeed_m_s += (plane.est.groundspeed_m_s - self._groundspeed_m_s) * 0.05
        if self.stage is Stage.NORMAL and self._fresh:
            track = plane.pilot.output
            lined_up = abs(track.bearing_error_rad) < math.radians(10.0)
            on_line = abs(track.xtrack_error_m) < 5.0
            part = nav.proportion
            below = plane.here().alt_m < nav.previous.alt_m
            if (
                self._mission.previous_nav_command == 31
                or (part >= 0 and lined_up and on_line)
                or (part > 0.15 and lined_up and below)
                or part > 0.5
            ):
                self.stage = Stage.APPROACH
        tune = plane.tune
        approaching = self.stage in (Stage.APPROACH, Stage.PREFLARE)
        flare_seconds = tune["LAND_FLARE_SEC"]
        low = height <= tune["LAND_FLARE_ALT"]
        # At most twice LAND_FLARE_ALT, the highest flare that the aim point allows for.
        soon = flare_seconds > 0 and height <= sink * flare_seconds and nav.proportion > 0.5
        soon = soon and (tune["LAND_FLARE_ALT"] <= 0 or height <= 2.0 * tune["LAND_FLARE_ALT"])
        crashed = abs(sink) < 0.2 and not plane.is_flying
        if self.stage is not Stage.FINAL and ((approaching and (low or soon)) or nav.proportion >= 1.0 or crashed):
            self.stage = Stage.FINAL
            self._report = True
            self._flare_height_m = max(0.5, height)
            self._flare_sink_m_s = max(0.0, sink)
            distance = distance_m(plane.here(), nav.next)
            plane.say(
                Severity.INFO,
                f"Flare {height:.1f}m sink={sink:.2f} speed={plane.est.groundspeed_m_s:.1f} dist={distance:.1f}",
            )
        elif self.stage is Stage.APPROACH and tune["LAND_PF_ARSPD"] > 0:
            by_alt = 0 < height <= tune["LAND_PF_ALT"]
            by_time = tune["LAND_PF_SEC"] > 0 and height <= sink * tune["LAND_PF_SEC"]
            if by_alt or by_time:
                self.stage = Stage.PREFLARE
        self._fresh = True
        # The leg is extended beyond the point, so that the plane does not turn when it floats past it.
        bearing = bearing_rad(nav.previous, nav.next)
        ahead = nav.next.moved(bearing, distance_m(nav.previous, plane.here()) + 200.0)
        nav.fly_leg(nav.previous, ahead)

    def report_rest(self) -> None:
        """Report the distance from the landing point, after disarming."""
        if self._report:
            self._report = False
            distance = distance_m(self._plane.here(), self._nav.next)
            self._plane.say(Severity.INFO, f"Distance from LAND point={distance:.2f}m")

    def airspeed_m_s(self) -> float:
        """Target airspeed: the approach speed plus LAND_WIND_COMP percent of the head wind."""
        tune = self._plane.tune
        cruise, slowest = tune["AIRSPEED_CRUISE"], tune["AIRSPEED_MIN"]
        target = tune["TECS_LAND_ARSPD"] if tune["TECS_LAND_ARSPD"] >= 0 else 0.5 * (cruise + slowest)
        if self.stage is Stage.NORMAL:
            target = cruise
        elif self.stage in (Stage.PREFLARE, Stage.FINAL) and tune["LAND_PF_ARSPD"] > 0:
            target = tune["LAND_PF_ARSPD"]
        part = min(1.0, max(0.0, tune["LAND_WIND_COMP"] * 0.01))
        return min(max(target + part * self._plane.head_wind_m_s(), target), max(cruise, target))

    def adjust_altitude(self) -> bool:
        """Set the target altitude on the glide slope; False while another rule sets it."""
        if not self.active or self.aborting or self.stage is Stage.NORMAL:
            return False
        plane = self._plane
        nav, tune = self._nav, plane.tune
        total = max(1.0, distance_m(nav.previous, nav.next))
        sink_height = nav.previous.alt_m - nav.next.alt_m
        groundspeed = max(0.5, self._groundspeed_m_s)
        # The slope of the last call is the steeper one to the aim point.
        slope = sink_height / total if self._slope is None else self._slope
        sink_rate = groundspeed * max(0.0, slope)

        flare_alt = tune["LAND_FLARE_ALT"]
        aim_height = max(flare_alt, tune["LAND_FLARE_SEC"] * sink_rate)
        if flare_alt > 0:
            aim_height = min(aim_height, 2.0 * flare_alt)
        flare_distance = min(self._distance_to_rest(groundspeed, aim_height), 0.5 * total)

        first = self._slope is None
        slope = (sink_height - aim_height) / (total - flare_distance)
        self._slope = slope
        if first:
            plane.say(Severity.INFO, f"Landing glide slope {math.degrees(math.atan(slope)):.1f} degrees")
        # The end of the slope is below the ground, so that the target altitude has no kink near the runway.
        bearing = bearing_rad(nav.previous, nav.next)
        end = nav.next.moved(bearing, _PROJECTION_M - flare_distance)
        end.alt_m = nav.next.alt_m + aim_height - slope * _PROJECTION_M
        nav.set_proportion(end, end.alt_m - nav.previous.alt_m, 1.0 - nav.proportion_of(nav.previous, end))
        return True

    def _distance_to_rest(self, groundspeed: float, height: float) -> float:
        """Distance over ground from the start of the flare, at ``height``, to rest.

        The duration of the flare and the touchdown speed are fitted to flights of this airframe on slopes of 2° to 7°,
        within 0.4 s and 0.5 m/s: a higher flare and a tail wind lengthen the float, the touchdown airspeed stays the
        same.
        """
        plane = self._plane
        bearing = bearing_rad(self._nav.previous, self._nav.next)
        tail_wind = plane.wind_along_m_s(bearing)
        seconds = _FLARE_S + _FLARE_S_PER_M * height + _FLARE_S_PER_M_S * max(0.0, tail_wind)
        # The default of 50 means as computed.
        seconds *= min(2.0, max(0.0, plane.tune["LAND_FLARE_AIM"] / 50.0))
        touch_speed = max(0.0, _TOUCHDOWN_M_S * plane.est.eas_to_tas + _GROUND_WIND * tail_wind)
        touch_speed = min(touch_speed, groundspeed)
        return 0.5 * (groundspeed + touch_speed) * seconds + touch_speed * touch_speed / (2.0 * _ROLL_DECEL_M_S2)

    # control

    def order(self) -> None:
        """Pitch and throttle demands of the stages after :data:`Stage.NORMAL`."""
        plane = self._plane
        tune = plane.tune
        nav = self._nav
        pitch_max = math.radians(min(tune["PTCH_LIM_MAX_DEG"], tune["TECS_LAND_PMAX"]))
        pitch_min = math.radians(tune["PTCH_LIM_MIN_DEG"])
        if self.stage is not Stage.FINAL:
            plane.pilot.fly_approach(
                height_m=nav.target_alt_m,
                airspeed_m_s=self.airspeed_m_s(),
                proportion=nav.proportion,
                pitch_min_rad=pitch_min,
                pitch_max_rad=pitch_max,
                throttle_max=tune["THR_MAX"] * 0.01,
            )
        elif plane.body.on_wheels:
            plane.pilot.fly_pitch(0.0, 0.0)
        else:
            height = nav.above_next_m
            # The nose must be up before the wheels touch.
            touch = math.radians(tune["LAND_PITCH_DEG"])
            part = min(1.0, max(0.0, (height - tune["TECS_FLARE_HGT"]) / max(0.5, self._flare_height_m)))
            low = touch + part * (math.radians(-12.0) - touch)
            plane.pilot.fly_flare(
                height_m=height,
                start_height_m=self._flare_height_m,
                start_sink_m_s=self._flare_sink_m_s,
                airspeed_m_s=self.airspeed_m_s(),
                pitch_min_rad=low,
                pitch_max_rad=pitch_max,
            )

    def ground_heading_rad(self) -> float | None:
        """Runway heading to hold during the ground roll."""
        if not self.flaring:
            return None
        return wrap_pi(bearing_rad(self._nav.previous, self._nav.next))
