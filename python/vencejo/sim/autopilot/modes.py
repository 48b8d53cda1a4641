"""The flight modes: their entry, their navigation, and their demands on the control laws."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from .commands import Commands
from .energy import Energy
from .geo import Spot, bearing_rad, distance_m, wrap_pi
from .interface import Mode, Severity
from .landing import Landing, Stage
from .mission import MissionRunner, RunState
from .names import Cmd
from .navigator import Navigator
from .plane import Plane
from .takeoff import Takeoff

__all__ = ["Controls", "FlightMode", "GuidedMode", "TakeoffMode", "make_modes"]


@dataclass(frozen=True, slots=True)
class Controls:
    """The components that a flight mode uses."""

    plane: Plane
    nav: Navigator
    mission: MissionRunner
    climbout: Takeoff
    landing: Landing
    energy: Energy
    commands: Commands
    change_mode: Callable[[Mode, str], object]
    enter_auto_to_land: Callable[[], None]


class FlightMode:
    """One mode. ``navigate`` and ``update`` run 10 times a second, ``update`` 50 times in modes flown by stick."""

    number: Mode
    auto_throttle = False
    """Whether the autopilot controls the throttle."""
    stick = False
    """Whether the mode is flown by stick."""
    navigates = False
    """Whether the autopilot navigates (ArduPlane's ``does_auto_navigation``)."""

    def __init__(self, controls: Controls) -> None:
        self._plane = controls.plane
        self._nav = controls.nav
        self._mission = controls.mission
        self._climbout = controls.climbout
        self._landing = controls.landing
        self._energy = controls.energy
        self._commands = controls.commands
        self._change_mode = controls.change_mode
        self._enter_auto_to_land = controls.enter_auto_to_land

    def enter(self) -> None:
        """Enter the mode."""

    def leave(self) -> None:
        """Leave the mode."""

    def navigate(self) -> None:
        """Guide the plane to its target."""

    def update(self) -> None:
        """Set the demands on the control laws."""

    def adjust_altitude(self) -> None:
        """Set the target altitude."""
        self._nav.adjust_altitude()


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


class RtlMode(FlightMode):
    """Returns to home or the nearest rally point, circles there, and lands by RTL_AUTOLAND."""

    number = Mode.RTL
    auto_throttle = True
    navigates = True

    def __init__(self, controls: Controls) -> None:
        super().__init__(controls)
        self._asked_for_landing = False

    def enter(self) -> None:
        plane = self._plane
        nav = self._nav
        self._asked_for_landing = False
        spot = plane.return_spot()
        # TERRAIN_FOLLOW bits: all modes, or RTL.
        ground_m = plane.ground_rel_home_m(spot) if int(plane.tune["TERRAIN_FOLLOW"]) & (1 | 1 << 4) else None
        if ground_m is not None:
            spot.alt_m, spot.follows_ground = spot.alt_m - ground_m, True
        nav.set_guided(spot)
        nav.next_crosstrack = False
        radius = plane.tune["RTL_RADIUS"]
        nav.loiter.clockwise = (radius if radius != 0 else plane.tune["WP_LOITER_RAD"]) >= 0

    def navigate(self) -> None:
        plane = self._plane
        nav = self._nav
        radius = plane.tune["RTL_RADIUS"]
        if radius != 0:
            nav.loiter.clockwise = radius > 0
        nav.fly_circle(abs(radius))
        if self._asked_for_landing:
            return
        autoland = int(plane.tune["RTL_AUTOLAND"])
        there = nav.on_circle and abs(plane.here().alt_m - nav.target_alt_m) < 10.0
        if autoland == 2 or (autoland == 1 and there):
            self._asked_for_landing = True
            if self._mission.jump_to_landing(plane.distance_to_item):
                self._enter_auto_to_land()
        elif autoland == 4:
            self._asked_for_landing = True
            if self._mission.jump_to_return_path(plane.distance_to_item):
                self._enter_auto_to_land()

    def update(self) -> None:
        self._energy.order()


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


class TakeoffMode(FlightMode):
    """Takes off straight ahead to TKOFF_ALT and circles at TKOFF_DIST."""

    number = Mode.TAKEOFF
    auto_throttle = True
    navigates = True

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


class AutoMode(FlightMode):
    """Flies the mission."""

    number = Mode.AUTO
    auto_throttle = True
    navigates = True

    def enter(self) -> None:
        plane = self._plane
        self._nav.stay()
        self._mission.start_or_resume(restart=plane.tune["MIS_RESTART"] == 1 and not plane.resume_forced)

    def leave(self) -> None:
        plane = self._plane
        is_landing = self._landing.active
        self._landing.end()
        if self._mission.state is RunState.RUNNING:
            self._mission.stop()
            if is_landing:
                self._mission.restart_landing(plane.distance_to_item)
        self._nav.hold_course_rad = None

    def navigate(self) -> None:
        plane = self._plane
        for seq in self._mission.update():
            plane.item_reached(seq)

    def update(self) -> None:
        plane = self._plane
        if self._mission.state is not RunState.RUNNING:
            # The mission was removed, or a landing could not be restarted.
            self._change_mode(Mode.RTL, "mission end")
            plane.say(Severity.INFO, "Aircraft in auto without a running mission")
            return
        command = self._mission.nav_command
        if (command == Cmd.NAV_TAKEOFF and not self._commands.takeoff_complete) or self._landing.aborting:
            self._climbout.order_climb(self._energy.airspeed_m_s())
        elif self._landing.active and self._landing.stage is not Stage.NORMAL:
            self._landing.order()
        elif command == Cmd.NAV_ALTITUDE_WAIT:
            plane.pilot.stick_aileron(0.0)
            plane.pilot.stick_elevator(0.0, 0.0)
        elif self._commands.scripted:
            self._commands.order_script()
        else:
            self._energy.order()

    def adjust_altitude(self) -> None:
        if not self._landing.adjust_altitude():
            self._nav.adjust_altitude()


def make_modes(controls: Controls) -> dict[int, FlightMode]:
    """Every mode of the simulated plane by its number."""
    kinds: tuple[type[FlightMode], ...] = (
        ManualMode,
        CircleMode,
        StabilizeMode,
        FbwaMode,
        FbwbMode,
        CruiseMode,
        AutoMode,
        RtlMode,
        LoiterMode,
        TakeoffMode,
        GuidedMode,
    )
    return {int(kind.number): kind(controls) for kind in kinds}
