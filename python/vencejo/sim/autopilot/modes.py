"""The flight modes: what each does when it is entered, where it navigates, and what it orders of the control laws."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from .geo import Spot, bearing_rad, distance_m, wrap_pi
from .interface import Mode, Severity
from .mission import RunState
from .names import Cmd

if TYPE_CHECKING:
    from .core import Autopilot

__all__ = ["FlightMode", "GuidedMode", "TakeoffMode", "make_modes"]


class FlightMode:
    """One mode. ``navigate`` and ``update`` run 10 times a second, ``update`` 50 times when a stick flies."""

    number: Mode
    auto_throttle = False
    """The autopilot, not the stick, moves the throttle."""
    stick = False
    """The pilot's sticks matter from step to step."""
    navigates = False
    """The autopilot chooses the way (ArduPlane's ``does_auto_navigation``)."""
    armable = True

    def __init__(self, ap: Autopilot) -> None:
        self._ap = ap

    def enter(self) -> None:
        """The mode begins."""

    def leave(self) -> None:
        """Another mode begins."""

    def navigate(self) -> None:
        """Where to go."""

    def update(self) -> None:
        """Orders to the control laws."""

    def adjust_altitude(self) -> None:
        """Target height."""
        self._ap.nav.adjust_altitude()


class ManualMode(FlightMode):
    """Sticks straight to the surfaces."""

    number = Mode.MANUAL
    stick = True

    def update(self) -> None:
        rc = self._ap.rc
        self._ap.pilot.stick_aileron(rc.stick(1))
        self._ap.pilot.stick_elevator(rc.stick(2), rc.throttle())


class StabilizeMode(FlightMode):
    """Level when the sticks are let go, and the stick adds to the surfaces."""

    number = Mode.STABILIZE
    stick = True

    def update(self) -> None:
        ap = self._ap
        roll, pitch = ap.rc.stick(1), ap.rc.stick(2)
        if abs(roll) > 0.5:
            ap.pilot.stick_aileron(roll)
        else:
            ap.pilot.fly_bank(2.0 * roll * math.radians(ap.bank_limit_deg()))
        if abs(pitch) > 0.5:
            ap.pilot.stick_elevator(pitch, ap.rc.throttle())
        else:
            ap.pilot.fly_pitch(ap.stick_pitch_rad(2.0 * pitch), ap.rc.throttle())


class FbwaMode(FlightMode):
    """Sticks ask for bank and pitch, within limits."""

    number = Mode.FBWA
    stick = True

    def update(self) -> None:
        ap = self._ap
        ap.pilot.fly_bank(ap.rc.stick(1) * math.radians(ap.bank_limit_deg()))
        ap.pilot.fly_pitch(ap.stick_pitch_rad(ap.rc.stick(2)), ap.rc.throttle())


class FbwbMode(FlightMode):
    """Stick asks for bank and climb rate, throttle stick for airspeed; height is held."""

    number = Mode.FBWB
    stick = True
    auto_throttle = True

    def enter(self) -> None:
        self._ap.nav.target_alt_m = self._ap.here().alt_m

    def navigate(self) -> None:
        """Height follows the stick."""
        self._climb_with_stick()

    def update(self) -> None:
        ap = self._ap
        ap.pilot.fly_bank(ap.rc.stick(1) * math.radians(ap.bank_limit_deg()))
        ap.order_energy()

    def adjust_altitude(self) -> None:
        """The stick does."""

    def _climb_with_stick(self) -> None:
        ap = self._ap
        ap.nav.target_alt_m += ap.rc.stick(2) * ap.tune["FBWB_CLIMB_RATE"] * 0.1


class CruiseMode(FbwbMode):
    """As FBWB, and with the roll stick let go the course over ground is held."""

    number = Mode.CRUISE

    def __init__(self, ap: Autopilot) -> None:
        super().__init__(ap)
        self._start: Spot | None = None
        self._course_rad = 0.0

    def enter(self) -> None:
        super().enter()
        self._start = None

    def navigate(self) -> None:
        ap = self._ap
        self._climb_with_stick()
        free = abs(ap.rc.stick(1)) < 0.01 and abs(ap.rc.stick(4)) < 0.01
        if not free:
            self._start = None
        elif self._start is None and ap.est.groundspeed_m_s > 3.0 and abs(ap.est.roll_rad) < math.radians(5.0):
            self._start = ap.here()
            self._course_rad = math.atan2(ap.est.velocity_e_m_s, ap.est.velocity_n_m_s)
        if self._start is not None:
            nav = ap.nav
            nav.previous = self._start
            # Always a kilometre ahead.
            nav.next = self._start.moved(self._course_rad, distance_m(self._start, ap.here()) + 1000.0)
            nav.next.alt_m = nav.target_alt_m

    def update(self) -> None:
        ap = self._ap
        if self._start is None:
            ap.pilot.fly_bank(ap.rc.stick(1) * math.radians(ap.bank_limit_deg()))
        else:
            ap.nav.fly_leg(ap.nav.previous, ap.nav.next)
        ap.order_energy()


class CircleMode(FlightMode):
    """A gentle circle, wherever the wind takes it, at the height of entry."""

    number = Mode.CIRCLE
    auto_throttle = True
    navigates = True
    armable = False

    def enter(self) -> None:
        self._ap.nav.stay()
        self._ap.nav.reset_slope()
        self._ap.nav.target_alt_m = self._ap.here().alt_m

    def update(self) -> None:
        self._ap.pilot.fly_bank(math.radians(self._ap.bank_limit_deg() / 3.0))
        self._ap.order_energy()

    def adjust_altitude(self) -> None:
        """Stays."""


class LoiterMode(FlightMode):
    """Circles around where it was entered."""

    number = Mode.LOITER
    auto_throttle = True
    navigates = True
    armable = False

    def enter(self) -> None:
        nav = self._ap.nav
        nav.stay()
        nav.reset_loiter()
        nav.reset_slope()
        nav.target_alt_m = nav.next.alt_m

    def navigate(self) -> None:
        self._ap.nav.fly_circle()

    def update(self) -> None:
        self._ap.order_energy()


class RtlMode(FlightMode):
    """Home or to the nearest rally point, circles there, and lands if RTL_AUTOLAND says so."""

    number = Mode.RTL
    auto_throttle = True
    navigates = True
    armable = False

    def __init__(self, ap: Autopilot) -> None:
        super().__init__(ap)
        self._asked_for_landing = False

    def enter(self) -> None:
        ap = self._ap
        nav = ap.nav
        self._asked_for_landing = False
        nav.set_guided(ap.return_spot())
        nav.next_crosstrack = False
        radius = ap.tune["RTL_RADIUS"]
        nav.loiter.clockwise = (radius if radius != 0 else ap.tune["WP_LOITER_RAD"]) >= 0

    def navigate(self) -> None:
        ap = self._ap
        nav = ap.nav
        radius = ap.tune["RTL_RADIUS"]
        if radius != 0:
            nav.loiter.clockwise = radius > 0
        nav.fly_circle(abs(radius))
        if self._asked_for_landing:
            return
        autoland = int(ap.tune["RTL_AUTOLAND"])
        there = ap.on_circle and abs(ap.here().alt_m - nav.target_alt_m) < 10.0
        if autoland == 2 or (autoland == 1 and there):
            self._asked_for_landing = True
            if ap.mission.jump_to_landing(ap.distance_to_item):
                ap.enter_auto_to_land()
        elif autoland == 4:
            self._asked_for_landing = True
            if ap.mission.jump_to_return_path(ap.distance_to_item):
                ap.enter_auto_to_land()

    def update(self) -> None:
        self._ap.order_energy()


class GuidedMode(FlightMode):
    """Flies to a point that the ground station gives, and circles it."""

    number = Mode.GUIDED
    auto_throttle = True
    navigates = True

    def __init__(self, ap: Autopilot) -> None:
        super().__init__(ap)
        self.radius_m = 0.0
        self.clockwise = True
        self.heading: tuple[int, float, float] | None = None
        """Kind (0 course, 1 heading), angle in radians, bank limit in radians."""
        self.climb_rate_m_s = 0.0
        self._announced = False

    def enter(self) -> None:
        """Set everything up."""
        self.radius_m = 0.0
        self.heading = None
        self.climb_rate_m_s = 0.0
        self.go_to(self._ap.here())

    def go_to(self, spot: Spot) -> None:
        """A new target."""
        self.heading = None
        self._ap.nav.set_guided(spot)
        if self.radius_m > 0:
            self._ap.nav.loiter.clockwise = self.clockwise

    def navigate(self) -> None:
        """Where to go."""
        nav = self._ap.nav
        if self.heading is None:
            nav.fly_circle(self.radius_m)
            return
        kind, angle, _ = self.heading
        est = self._ap.est
        drift = 0.0
        if kind == 0:
            drift = wrap_pi(est.yaw_rad - math.atan2(est.velocity_e_m_s, est.velocity_n_m_s))
        self._ap.pilot.fly_heading(wrap_pi(angle + drift))

    def update(self) -> None:
        """Orders to the control laws."""
        self._ap.order_energy()

    def adjust_altitude(self) -> None:
        """Target height."""
        nav = self._ap.nav
        if self.climb_rate_m_s > 0:
            step = self.climb_rate_m_s * 0.1
            nav.target_alt_m += min(step, max(-step, nav.next.alt_m - nav.target_alt_m))
        else:
            nav.adjust_altitude()

    def circle_reached(self) -> None:
        """The target is reached."""
        self._ap.item_reached(0)


class TakeoffMode(FlightMode):
    """Takes off straight ahead to TKOFF_ALT and circles TKOFF_DIST away."""

    number = Mode.TAKEOFF
    auto_throttle = True
    navigates = True

    def __init__(self, ap: Autopilot) -> None:
        super().__init__(ap)
        self._start: Spot | None = None
        self.climbing = False

    def enter(self) -> None:
        """Set everything up."""
        self._start = None
        self.climbing = True
        ap = self._ap
        ap.climbout.begin_climb(ap.tune["TKOFF_LVL_PITCH"], ap.tune["TKOFF_ALT"])

    def navigate(self) -> None:
        """Where to go."""
        ap = self._ap
        nav, tune, est = ap.nav, ap.tune, ap.est
        alt, dist = tune["TKOFF_ALT"], tune["TKOFF_DIST"]
        if self._start is None:
            here = ap.here()
            course = math.atan2(est.velocity_e_m_s, est.velocity_n_m_s)
            if ap.is_flying and ap.flying_since_s is not None and ap.time_s - ap.flying_since_s > 10.0:
                if ap.alt_rel_home_m >= alt:
                    ap.say(Severity.INFO, "Above TKOFF alt - loitering")
                    nav.set_guided(here)
                    self.climbing = False
                else:
                    ap.say(Severity.INFO, "Climbing to TKOFF alt then loitering")
                    target = here.moved(course, dist)
                    target.alt_m = ap.home.alt_m + alt
                    nav.set_guided(target)
                self._start = here
            elif not ap.throttle_suppressed and est.groundspeed_m_s > 0.3 * tune["AIRSPEED_MIN"]:
                heading = math.degrees(course) % 360.0
                ap.say(Severity.INFO, f"Takeoff to {alt:.0f}m for {dist:.1f}m heading {heading:.1f} deg")
                target = here.moved(course, dist)
                target.alt_m = here.alt_m + alt
                ap.climbout.altitude_rel_m = target.alt_m - ap.home.alt_m
                nav.set_guided(target)
                self._start = here
        if self._start is None:
            ap.pilot.fly_level()
            return
        if self.climbing:
            high = ap.here().alt_m >= nav.next.alt_m - 2.0
            if high or ap.climbout.is_level or distance_m(self._start, ap.here()) >= dist:
                self.climbing = False
                nav.target_alt_m = nav.next.alt_m
            else:
                ap.pilot.fly_heading(bearing_rad(self._start, nav.next))
                return
        nav.fly_circle()

    def update(self) -> None:
        """Orders to the control laws."""
        if self.climbing:
            self._ap.climbout.order_climb()
        else:
            self._ap.order_energy()


class AutoMode(FlightMode):
    """Flies the mission."""

    number = Mode.AUTO
    auto_throttle = True
    navigates = True

    def enter(self) -> None:
        ap = self._ap
        ap.nav.stay()
        ap.mission.start_or_resume(restart=ap.tune["MIS_RESTART"] == 1 and not ap.resume_forced)

    def leave(self) -> None:
        ap = self._ap
        is_landing = ap.landing.active
        ap.landing.end()
        if ap.mission.state is RunState.RUNNING:
            ap.mission.stop()
            if is_landing:
                ap.mission.restart_landing(ap.distance_to_item)
        ap.nav.hold_course_rad = None

    def navigate(self) -> None:
        ap = self._ap
        for seq in ap.mission.update():
            ap.item_reached(seq)

    def update(self) -> None:
        ap = self._ap
        if ap.mission.state is not RunState.RUNNING:
            # Its mission was removed, or a landing could not be restarted.
            ap.change_mode(Mode.RTL, "mission end")
            ap.say(Severity.INFO, "Aircraft in auto without a running mission")
            return
        item = ap.mission.nav
        command = None if item is None else item.command
        if command == Cmd.NAV_TAKEOFF and not ap.commands.takeoff_complete:
            ap.climbout.order_climb()
        elif ap.landing.active:
            ap.landing.order()
        elif command == Cmd.NAV_ALTITUDE_WAIT:
            ap.pilot.stick_aileron(0.0)
            ap.pilot.stick_elevator(0.0, 0.0)
        elif ap.commands.scripted:
            ap.commands.order_script()
        else:
            ap.order_energy()

    def adjust_altitude(self) -> None:
        if not self._ap.landing.adjust_altitude():
            self._ap.nav.adjust_altitude()


def make_modes(ap: Autopilot) -> dict[int, FlightMode]:
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
    return {int(kind.number): kind(ap) for kind in kinds}
