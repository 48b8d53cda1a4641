"""How the plane executes each mission command: its start, and the condition that completes it.

Checked against ArduPlane's ``start_command`` and ``verify_command`` (ArduPlane/commands_logic.cpp, 4.8-dev). Commands
that ArduPlane stores but does not fly are listed in :data:`PASSED_OVER`; docs/simulated-plane.md has the whole table.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from vencejo.sim.autopilot.energy import Energy
from vencejo.sim.autopilot.geo import Spot, distance_m
from vencejo.sim.autopilot.interface import Mode, Severity, StoredItem
from vencejo.sim.autopilot.landing import Landing
from vencejo.sim.autopilot.navigator import Navigator
from vencejo.sim.autopilot.plane import Plane
from vencejo.sim.autopilot.takeoff import Takeoff

from .mission import MissionRunner
from .names import AT_ONCE, Cmd, is_nav

__all__ = ["PASSED_OVER", "Commands"]

_SCRIPT_SILENCE_S = 1.0
"""Time that ArduPlane waits for a script to take control (Plane::nav_scripting_active)."""

PASSED_OVER = frozenset(
    {
        Cmd.NAV_ARC_WAYPOINT,
        Cmd.NAV_VTOL_TAKEOFF,
        Cmd.NAV_VTOL_LAND,
        Cmd.NAV_GUIDED_ENABLE,
        Cmd.NAV_PAYLOAD_PLACE,
        Cmd.NAV_SET_YAW_SPEED,
    }
)
"""Navigation commands that ArduPlane stores and announces but cannot start; the mission continues with the next item.

Arcs, external guidance and yaw at a speed belong to ArduCopter and Rover: ``Plane::start_command`` has no case for
them. ``QuadPlane::do_vtol_takeoff`` and ``do_vtol_land`` refuse while Q_ENABLE is 0.
"""


class Commands:
    """Starts and verifies the commands of a mission."""

    def __init__(
        self,
        plane: Plane,
        nav: Navigator,
        mission: MissionRunner,
        climbout: Takeoff,
        landing: Landing,
        energy: Energy,
        change_mode: Callable[[Mode, str], object],
    ) -> None:
        self._plane = plane
        self._nav = nav
        self._mission = mission
        self._climbout = climbout
        self._landing = landing
        self._energy = energy
        self._change_mode = change_mode
        self.takeoff_complete = True
        self._condition_s = 0.0
        self._delay_until_s = 0.0
        self._change_alt_kind = 0
        self._script_until_s: float | None = None
        self._script_attitude = (0.0, 0.0)
        self._script_throttle = 0.0
        self._starts: dict[int, Callable[[StoredItem], bool | None]] = {
            Cmd.NAV_WAYPOINT: self._start_waypoint,
            Cmd.NAV_LOITER_UNLIM: self._start_loiter,
            Cmd.NAV_LOITER_TURNS: self._start_loiter_turns,
            Cmd.NAV_LOITER_TIME: self._start_loiter_time,
            Cmd.NAV_LOITER_TO_ALT: self._start_loiter,
            Cmd.NAV_RETURN_TO_LAUNCH: self._return,
            Cmd.NAV_LAND: landing.begin,
            Cmd.NAV_TAKEOFF: self._start_takeoff,
            Cmd.NAV_CONTINUE_AND_CHANGE_ALT: self._start_change_alt,
            Cmd.NAV_ALTITUDE_WAIT: lambda _: None,
            Cmd.NAV_DELAY: self._start_delay,
            Cmd.NAV_SCRIPT_TIME: self._start_script,
            Cmd.CONDITION_DELAY: self._start_condition_delay,
            Cmd.CONDITION_DISTANCE: lambda _: None,
            Cmd.DO_CHANGE_SPEED: self._change_speed,
            Cmd.DO_SET_HOME: self._set_home,
            Cmd.DO_RETURN_PATH_START: lambda _: None,
            Cmd.DO_LAND_START: lambda _: None,
            Cmd.DO_AUTOTUNE_ENABLE: lambda item: plane.autotune(on=item.p1 != 0),
            Cmd.DO_INVERTED_FLIGHT: self._inverted,
            Cmd.DO_FENCE_ENABLE: self._fence,
            Cmd.DO_GRIPPER: self._gripper,
            Cmd.DO_SET_RESUME_REPEAT_DIST: self._repeat_dist,
            Cmd.DO_SET_CAM_TRIGG_DIST: self._trigger_distance,
            Cmd.DO_DIGICAM_CONTROL: lambda _: plane.take_picture(),
            Cmd.IMAGE_START_CAPTURE: lambda _: plane.take_picture(),
            Cmd.DO_SET_ROI: lambda _: None,
            Cmd.DO_SET_ROI_LOCATION: lambda _: None,
            Cmd.DO_SET_ROI_NONE: lambda _: None,
            Cmd.DO_MOUNT_CONTROL: lambda _: None,
            Cmd.DO_VTOL_TRANSITION: lambda _: plane.say(Severity.NOTICE, "VTOL not available"),
            Cmd.DO_ENGINE_CONTROL: lambda _: None,
        }
        self._verifies: dict[int, Callable[[StoredItem], bool]] = {
            Cmd.NAV_WAYPOINT: self._verify_waypoint,
            Cmd.NAV_LOITER_UNLIM: self._verify_loiter_unlimited,
            Cmd.NAV_LOITER_TURNS: self._verify_loiter_turns,
            Cmd.NAV_LOITER_TIME: self._verify_loiter_time,
            Cmd.NAV_LOITER_TO_ALT: self._verify_loiter_to_alt,
            Cmd.NAV_RETURN_TO_LAUNCH: lambda _: False,
            Cmd.NAV_LAND: self._verify_land,
            Cmd.NAV_TAKEOFF: self._verify_takeoff,
            Cmd.NAV_CONTINUE_AND_CHANGE_ALT: self._verify_change_alt,
            Cmd.NAV_ALTITUDE_WAIT: self._verify_altitude_wait,
            Cmd.NAV_DELAY: lambda _: plane.armed or plane.time_s >= self._delay_until_s,
            Cmd.NAV_SCRIPT_TIME: self._verify_script,
            Cmd.CONDITION_DELAY: lambda _: plane.time_s >= self._condition_s,
            Cmd.CONDITION_DISTANCE: lambda item: self._nav.distance < max(0.0, item.p1),
        }

    def start(self, item: StoredItem) -> bool:
        """Start a command; False when this plane cannot execute it."""
        start = self._starts.get(item.command)
        if is_nav(item.command):
            self.takeoff_complete = True
            if self._landing.active and item.command != Cmd.NAV_LAND:
                self._landing.end()
        if start is None:
            # Payload commands without a simulated payload only have to be announced; others are passed over.
            return item.command in AT_ONCE
        return start(item) is not False

    def verify(self, item: StoredItem) -> bool:
        """True when a command is complete."""
        verify = self._verifies.get(item.command)
        if verify is not None:
            return verify(item)
        if item.command not in self._starts:
            self._plane.say(Severity.WARNING, f"Skipping invalid cmd #{item.command}")
        return True

    # waypoints

    def _start_waypoint(self, item: StoredItem) -> None:
        self._nav.set_next(self._plane.spot_of(item))

    def _verify_waypoint(self, item: StoredItem) -> bool:
        plane = self._plane
        nav = self._nav
        nav.hold_course_rad = None
        here = plane.here()
        target = nav.next
        if item.p3 > 0 and distance_m(nav.previous, target) > 0:
            # The waypoint counts only this far beyond it.
            target = target.moved(math.atan2(target.e_m - nav.previous.e_m, target.n_m - nav.previous.n_m), item.p3)
        nav.fly_leg(nav.previous if nav.crosstrack else here, target)
        passed = nav.passed(nav.previous, target)
        limit = plane.tune["WP_MAX_RADIUS"]
        if limit > 0 and nav.distance > limit:
            if passed and item.p3 <= 0:
                nav.previous = here
            return False
        if item.p2 > 0:
            acceptance = item.p2
        elif item.p3 > 0:
            acceptance = 0.0
        else:
            acceptance = nav.turn_distance()
        distance = distance_m(here, target)
        if distance <= acceptance:
            plane.say(Severity.INFO, f"Reached waypoint #{item.seq} dist {int(distance)}m")
            return True
        if passed:
            plane.say(Severity.INFO, f"Passed waypoint #{item.seq} dist {int(distance)}m")
            return True
        return False

    # loiters

    def _start_loiter(self, item: StoredItem) -> None:
        plane = self._plane
        spot = plane.spot_of(item)
        radius = item.p2 if item.command == Cmd.NAV_LOITER_TO_ALT else item.p3
        spot.anticlockwise = radius < 0
        spot.exit_tangent = item.p4 == 1
        self._nav.set_next(spot)
        self._nav.loiter.clockwise = not spot.anticlockwise

    def _start_loiter_turns(self, item: StoredItem) -> None:
        self._start_loiter(item)
        self._nav.loiter.total_rad = max(0.0, item.p1) * math.tau

    def _start_loiter_time(self, item: StoredItem) -> None:
        self._start_loiter(item)
        self._nav.loiter.duration_s = max(0.0, item.p1)

    def _verify_loiter_unlimited(self, item: StoredItem) -> bool:
        self._nav.fly_circle(abs(item.p3))
        return False

    def _verify_loiter_turns(self, item: StoredItem) -> bool:
        loiter = self._nav.loiter
        self._nav.fly_circle(abs(item.p3))
        if not self._nav.on_circle:
            return False
        if not loiter.goal_met:
            if loiter.turned_rad <= loiter.total_rad or not loiter.counting:
                return False
            self._goal_met()
        return self._leave_circle("Loiter orbits complete", self._next_target())

    def _verify_loiter_time(self, item: StoredItem) -> bool:
        plane, loiter = self._plane, self._nav.loiter
        # A timed loiter always uses WP_LOITER_RAD.
        self._nav.fly_circle()
        if loiter.started_s is None or not loiter.counting:
            return False
        if not loiter.goal_met:
            if plane.time_s - loiter.started_s <= loiter.duration_s:
                return False
            self._goal_met()
        return self._leave_circle("Loiter time complete", self._next_target())

    def _verify_loiter_to_alt(self, item: StoredItem) -> bool:
        self._nav.fly_circle(abs(item.p2))
        return self.loiter_to_alt_is_done(self._next_target())

    def loiter_to_alt_is_done(self, target: Spot | None) -> bool:
        """Whether the altitude of the circle is reached, and the plane lined up for ``target``."""
        plane, loiter = self._plane, self._nav.loiter
        if not loiter.goal_met:
            if not loiter.counting or not (loiter.reached_alt or loiter.stuck):
                return False
            if loiter.stuck:
                plane.say(Severity.INFO, f"Loiter to alt was stuck at {int(plane.here().alt_m)}")
            self._goal_met()
        return self._leave_circle("Loiter to alt complete", target)

    def _goal_met(self) -> None:
        self._nav.loiter.goal_met = True
        self._nav.loiter.turned_rad = 0.0

    def _next_target(self) -> Spot | None:
        current = self._mission.nav
        following = None if current is None else self._mission.next_nav(current.seq + 1)
        return None if following is None else self._plane.spot_of(following, or_none=True)

    def _leave_circle(self, text: str, target: Spot | None) -> bool:
        if not self._nav.lined_up(target):
            return False
        self._plane.say(Severity.INFO, text)
        return True

    # take-off and landing

    def _start_takeoff(self, item: StoredItem) -> None:
        plane = self._plane
        nav = self._nav
        spot = plane.spot_of(item)
        nav.previous = plane.here()
        # ArduPlane ignores the position of a take-off item and climbs straight ahead.
        nav.next = Spot(plane.home.n_m, plane.home.e_m, spot.alt_m)
        nav.hold_course_rad = None
        nav.reset_slope()
        self.takeoff_complete = False
        self._climbout.begin_climb(item.p1 if item.p1 > 0 else 4.0, spot.alt_m - plane.home.alt_m)

    def _verify_takeoff(self, item: StoredItem) -> bool:
        if not self._climbout.verify():
            return False
        self.takeoff_complete = True
        return True

    def _verify_land(self, item: StoredItem) -> bool:
        self._landing.verify()
        return False

    # heights and waits

    def _start_change_alt(self, item: StoredItem) -> None:
        plane = self._plane
        nav = self._nav
        if distance_m(nav.previous, nav.next) < 0.1:
            # There is no leg to continue: use the present course.
            est = plane.est
            course = math.atan2(est.velocity_e_m_s, est.velocity_n_m_s)
            nav.hold_course_rad = None
            nav.next = nav.next.moved(course, 1000.0)
        else:
            nav.next = nav.next.copy()
        nav.next.alt_m, nav.next.follows_ground = plane.alt_of(item), item.frame == 10
        self._change_alt_kind = int(item.p1)
        nav.reset_slope()
        nav.reset_loiter()

    def _verify_change_alt(self, item: StoredItem) -> bool:
        plane = self._plane
        nav = self._nav
        if distance_m(plane.here(), nav.next) < 200.0:
            nav.next = nav.next.moved(
                math.atan2(nav.next.e_m - nav.previous.e_m, nav.next.n_m - nav.previous.n_m), 300.0
            )
        nav.fly_leg(nav.previous, nav.next)
        error = nav.above_next_m
        if self._change_alt_kind == 1:
            return error >= 0.0
        if self._change_alt_kind == 2:
            return error <= 0.0
        return abs(error) <= 5.0

    def _verify_altitude_wait(self, item: StoredItem) -> bool:
        plane = self._plane
        # The altitude of this command is always above mean sea level.
        if plane.here().alt_m > item.p1:
            plane.say(Severity.INFO, "Reached altitude")
            return True
        sink = plane.est.velocity_d_m_s
        if item.p2 > 0 and sink > item.p2:
            plane.say(Severity.INFO, f"Reached descent rate {sink:.1f} m/s")
            return True
        return False

    def _start_delay(self, item: StoredItem) -> None:
        seconds = item.p1 if item.p1 > 0 else self._until_utc_s(int(item.p2), int(item.p3), int(item.p4))
        self._delay_until_s = self._plane.time_s + seconds
        self._plane.say(Severity.INFO, f"Delaying {int(seconds)} sec")

    def _until_utc_s(self, hour: int, minute: int, second: int) -> float:
        """Seconds until the next matching time of day; −1 matches any value (AP_RTC::get_time_utc).

        0 while the time is unknown.
        """
        now_s = self._plane.utc_s()
        if now_s is None:
            return 0.0
        if hour != -1:
            period_s = 86_400.0
        elif minute != -1:
            period_s = 3_600.0
        elif second != -1:
            period_s = 60.0
        else:
            return 0.0
        # Elements above the first given one are ignored; those below it count, −1 as the number −1.
        wanted_s = (hour * 3_600.0 if hour != -1 else 0.0) + (minute * 60.0 if period_s > 60.0 else 0.0) + second
        left_s = wanted_s - now_s % period_s
        return left_s + period_s if left_s < 0 else left_s

    # NAV_SCRIPT_TIME without a script

    def _start_script(self, _item: StoredItem) -> None:
        plane, est = self._plane, self._plane.est
        self._script_until_s = plane.time_s + _SCRIPT_SILENCE_S
        self._script_attitude = (est.roll_rad, est.pitch_rad)
        self._script_throttle = plane.throttle

    @property
    def scripted(self) -> bool:
        """True while the plane waits for a script to control it."""
        return self._script_until_s is not None and self._mission.nav_command == Cmd.NAV_SCRIPT_TIME

    def order_script(self) -> None:
        """Hold the attitude and throttle at which the item began.

        ArduPlane holds the angular rates of that moment, which are close to zero between waypoints.
        """
        roll_rad, pitch_rad = self._script_attitude
        self._plane.pilot.fly_bank(roll_rad)
        self._plane.pilot.fly_pitch(pitch_rad, self._script_throttle)

    def _verify_script(self, _item: StoredItem) -> bool:
        plane = self._plane
        if self._script_until_s is not None and plane.time_s > self._script_until_s:
            # No script takes control: this plane runs none.
            self._script_until_s = None
            plane.say(Severity.INFO, "NavScript time out")
        return self._script_until_s is None

    def _start_condition_delay(self, item: StoredItem) -> None:
        self._condition_s = self._plane.time_s + max(0.0, item.p1)

    # immediate commands

    def _return(self, _item: StoredItem) -> None:
        self._change_mode(Mode.RTL, "mission command")

    def _change_speed(self, item: StoredItem) -> None:
        self._energy.change_speed(int(item.p1), item.p2, item.p3)

    def _set_home(self, item: StoredItem) -> None:
        plane = self._plane
        if item.p1 == 1:
            plane.set_home(None, None, None)
        else:
            plane.set_home(item.lat_deg, item.lon_deg, plane.alt_of(item))

    def _inverted(self, item: StoredItem) -> None:
        if item.p1 in (0, 1):
            self._plane.say(Severity.INFO, f"Set inverted {int(item.p1)}")

    def _fence(self, item: StoredItem) -> None:
        if self._plane.on_fence_enable is not None:
            self._plane.on_fence_enable(int(item.p1))

    def _gripper(self, item: StoredItem) -> None:
        if int(self._plane.tune["GRIP_ENABLE"]):
            self._plane.say(Severity.INFO, "Gripper Grabbed" if item.p2 == 1 else "Gripper Released")

    def _repeat_dist(self, item: StoredItem) -> None:
        self._mission.repeat_on_resume(max(0.0, item.p1))
        self._plane.say(Severity.INFO, f"Resume repeat dist set to {int(item.p1)} m")

    def _trigger_distance(self, item: StoredItem) -> None:
        self._plane.trigger_distance_m = max(0.0, item.p1)
        if item.p3 == 1:
            self._plane.take_picture()
