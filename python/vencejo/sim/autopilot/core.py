"""The autopilot: the flying half of one simulated plane, advanced step by step, and the commands it accepts.

It owns the loop (estimate, navigate at 10 Hz, set-points, control laws, motion) and the state that commands change:
mode, arming, home, speed. Guidance is in :mod:`navigator`, mission commands in :mod:`commands`, flight modes in
:mod:`modes`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from vencejo.sim.hand import CARRY_HEIGHT_M, Hand

from . import boot
from .commands import Commands
from .energy import Energy
from .failsafe import Failsafes
from .fence_response import RTL_COMPLETE_REASON, FenceResponse
from .geo import distance_m, wrap_pi
from .interface import (
    DT_S,
    Armed,
    Disarmed,
    FenceBreach,
    LandedState,
    MavResult,
    MissionState,
    Mode,
    ModeChanged,
    Outlook,
    Parameters,
    PlanView,
    RepositionTarget,
    Severity,
    SimConfig,
    Snapshot,
    StoredItem,
    SystemState,
)
from .landing import Landing
from .mission import MissionRunner, RunState
from .modes import Controls, FlightMode, GuidedMode, TakeoffMode, make_modes
from .names import AT_ONCE, Cmd
from .navigator import Navigator
from .plane import Plane
from .takeoff import Takeoff

__all__ = ["Autopilot"]

_STATION_REASON = "ground station"
_NOT_ENTERED = (Severity.WARNING, "Flight mode change failed")
_REFUSED_MODES: dict[int, tuple[tuple[Severity, str], ...]] = {
    **dict.fromkeys(range(17, 24), ((Severity.INFO, "Q_ENABLE 0"),)),
    24: (_NOT_ENTERED,),
    26: ((Severity.WARNING, "Must already be flying!"), _NOT_ENTERED),
}
"""Refusals of quadplane modes, of THERMAL without SOAR_ENABLE, and of AUTOLAND on the ground."""
_NAVIGATE_TICKS = 10
_STICK_TICKS = 2
_FLYING_TICKS = 20
_LANDED_M_S = 3.0
_HOME_AGAIN_S = 6.0
"""Period at which home follows a disarmed plane, as recorded (Plane::one_second_loop, after more than 5 s)."""
_EARTH_RADIUS_M = 6_371_008.8


class Autopilot(Plane):
    """One simulated plane.

    Parameters
    ----------
    config : SimConfig
        Start position, wind and seed.
    params : Parameters
        The parameter store.
    plan : PlanView
        The stored mission and rally points.
    prearm : callable, optional
        Returns the failing pre-arm checks; by default those of the mode alone.

    Examples
    --------
    >>> from vencejo.sim.autopilot.testing import FixedParameters, FixedPlan
    >>> plane = Autopilot(config=SimConfig(), params=FixedParameters(), plan=FixedPlan())
    >>> for _ in range(100):
    ...     plane.step()
    >>> round(plane.time_s, 2)
    1.0
    """

    def __init__(
        self,
        *,
        config: SimConfig,
        params: Parameters,
        plan: PlanView,
        prearm: Callable[[], list[str]] | None = None,
    ) -> None:
        self.prearm: Callable[[], list[str]] = prearm or (lambda: self.flight_mode.failing_checks)
        self._hand: Hand | None = None
        super().__init__(config, params, plan)

    def _boot(self, lat_deg: float, lon_deg: float) -> None:
        super()._boot(lat_deg, lon_deg)
        self._tick = 0
        self._landings: tuple[tuple[float, float], ...] = ()
        self._landings_revision = -1
        self._flying_probability = 0.0
        self._last_flying_s: float | None = None
        self._ground_heading_rad = self.body.yaw_rad

        self.mission = MissionRunner(self._plan, self)
        self.nav = Navigator(self, self.mission)
        self.climbout = Takeoff(self, self.nav)
        self.landing = Landing(self, self.nav, self.climbout, self.mission)
        self.energy = Energy(self, self.nav, self.landing)
        self.commands = Commands(
            self, self.nav, self.mission, self.climbout, self.landing, self.energy, self.change_mode
        )
        self.failsafes = Failsafes(
            self, self.mission, self.landing, self.change_mode, self._enter_auto, self._climbing_out
        )
        self._fence = FenceResponse(
            self, self.mission, self.landing, self.change_mode, lambda spot: self._guided.go_to(spot)
        )
        self._modes = make_modes(
            Controls(
                self,
                self.nav,
                self.mission,
                self.climbout,
                self.landing,
                self.energy,
                self.commands,
                self.change_mode,
                self.enter_auto_to_land,
            )
        )
        guided = self._modes[Mode.GUIDED]
        assert isinstance(guided, GuidedMode)
        self._guided = guided
        self.mode: FlightMode = self._modes[Mode.MANUAL]
        self.flight_mode = Mode.INITIALISING
        self._pending_texts = list(boot.TEXTS)
        self._origin_set = False
        self._home_due_s = boot.HOME_S
        self._prepare_orders()

    # the loop

    def step(self) -> None:
        """Advance the simulation by :data:`DT_S`."""
        self._tick += 1
        self.time_s = self._tick * DT_S
        tick = self._tick
        if tick % _NAVIGATE_TICKS == 0:
            self._navigate()
            self._prepare_orders()
        elif tick % _STICK_TICKS == 0 and (self.mode.stick or self.landing.flaring):
            self.mode.update()
        est = self.est
        surfaces = self.pilot.step(
            north_m=est.n_m,
            east_m=est.e_m,
            height_m=est.alt_m,
            velocity_north_m_s=est.velocity_n_m_s,
            velocity_east_m_s=est.velocity_e_m_s,
            climb_m_s=-est.velocity_d_m_s,
            roll_rad=est.roll_rad,
            pitch_rad=est.pitch_rad,
            heading_rad=est.yaw_rad,
            roll_rate_rad_s=est.p_rad_s,
            pitch_rate_rad_s=est.q_rad_s,
            yaw_rate_rad_s=est.r_rad_s,
            airspeed_m_s=est.airspeed_m_s,
            eas_to_tas=est.eas_to_tas,
            forward_accel_m_s2=est.forward_accel_m_s2,
            dt_s=DT_S,
        )
        self._surfaces = surfaces
        body, wind, battery = self.body, self.wind, self.battery
        if self._hand is not None:
            self._hand.step(DT_S)
        wind.blow(body.height_m, body.tas_m_s, body.yaw_rad, DT_S)
        body.step(
            surfaces[0],
            surfaces[1],
            surfaces[2],
            surfaces[3],
            battery_v=battery.voltage_v,
            wind_m_s=(wind.north_m_s, wind.east_m_s, wind.down_m_s),
        )
        battery.draw(body.motor_a, DT_S)
        self._estimate()

    def _navigate(self) -> None:
        """The tasks that run 10 times a second."""
        if self.flight_mode is Mode.INITIALISING and self.time_s >= boot.READY_S:
            self.change_mode(Mode.MANUAL, "initialised")
        while self._pending_texts and self._pending_texts[0][0] <= self.time_s:
            _, severity, text = self._pending_texts.pop(0)
            self.say(severity, text)
        if not self._origin_set and self.time_s >= boot.ORIGIN_S:
            self._origin_set = True
            self._put_home(*self._home_lat_lon, self.home.alt_m)
        if self.time_s >= self._home_due_s and not (self.armed or self.home_locked):
            self._home_due_s = self.time_s + _HOME_AGAIN_S
            self._put_home_here()
        self._errors = self.sensors.errors(self.time_s)
        if self.tune.refresh():
            self.pilot.set_params(self.tune.for_pilot())
            self.battery.capacity_mah = self.tune["BATT_CAPACITY"]
        if self.mission.notice_change() and self.in_auto:
            self.nav.reset_slope()
        if self._tick % _FLYING_TICKS == 0:
            self._judge_flying()
        self._estimate_wind()
        self._take_pictures()
        nav = self.nav
        nav.update_distance()
        if self._navigates():
            nav.count_turns()
        self.mode.navigate()
        nav.update_distance()
        self.mode.adjust_altitude()
        self._check_throttle_suppression()
        if self.landing.flaring:
            if self.est.groundspeed_m_s < _LANDED_M_S:
                self.energy.load_saved()
            self._disarm_after_landing()
        self.failsafes.check()

    def _prepare_orders(self) -> None:
        """Set the targets and limits of the control laws."""
        self.mode.update()
        on_ground = self.body.on_wheels
        heading = None
        rudder = 0.0
        if self.mode.stick:
            rudder = self.rc.stick(4)
        if on_ground:
            heading = self.landing.ground_heading_rad()
            if heading is None and self.mode.auto_throttle:
                heading = self.nav.hold_course_rad
                if heading is None:
                    if self.throttle_suppressed:
                        self._ground_heading_rad = self.est.yaw_rad
                    heading = self._ground_heading_rad
        off = not self.armed or (self.mode.auto_throttle and self.throttle_suppressed)
        self.pilot.set_limits(
            bank_max_rad=math.radians(self._bank_max_deg()),
            rudder=rudder,
            ground_heading_rad=heading,
            on_ground=on_ground,
            throttle_off=off,
        )
        if self.config.launch == "hand" and self._climbing_out() and not self.throttle_suppressed:
            self.climbout.throw()

    def _navigates(self) -> bool:
        return self.flight_mode in (Mode.AUTO, Mode.RTL, Mode.LOITER, Mode.GUIDED, Mode.TAKEOFF)

    def _climbing_out(self) -> bool:
        mode = self.mode
        if isinstance(mode, TakeoffMode):
            return mode.climbing
        return self.in_auto and (
            (not self.commands.takeoff_complete and self.mission.nav_command == Cmd.NAV_TAKEOFF)
            or self.landing.aborting
        )

    def _judge_flying(self) -> None:
        """ArduPlane's is-flying estimate, 5 times a second: low-pass filtered motion through air or over ground."""
        est = self.est
        moving = est.groundspeed_m_s >= 1.5
        if self.armed:
            through_air = est.airspeed_m_s >= 0.75 * max(2.0, self.tune["AIRSPEED_MIN"])
            still = est.groundspeed_m_s < 0.3
            guess = (through_air and not still) or moving
            if self.throttle_suppressed and self.mode.auto_throttle and not self.is_flying:
                guess = moving
        else:
            guess = est.groundspeed_m_s > 4.0 and not self.body.on_wheels
        self._flying_probability += 0.15 * (float(guess) - self._flying_probability)
        was_flying = self.is_flying
        self.is_flying = self._flying_probability >= (0.1 if self.armed else 0.9)
        if self.is_flying:
            self._last_flying_s = self.time_s
            if not was_flying:
                self.flying_since_s = self.time_s
        else:
            self.flying_since_s = None

    def _estimate_wind(self) -> None:
        if not self.is_flying or self.body.on_wheels:
            return
        n, e = self._wind_estimate
        rate = 0.1 / 8.0
        self._wind_estimate = (n + (self.wind.north_m_s - n) * rate, e + (self.wind.east_m_s - e) * rate)

    def _check_throttle_suppression(self) -> None:
        if not self.throttle_suppressed or not self.mode.auto_throttle:
            return
        if self._climbing_out():
            already = self.is_flying and self.alt_rel_home_m > 5.0 and self.est.groundspeed_m_s >= 5.0
            if already or self.climbout.check_launch():
                self.throttle_suppressed = False
            return
        if not self.armed:
            return
        moving = self.est.groundspeed_m_s >= 5.0 and self.est.airspeed_m_s >= 5.0
        if abs(self.alt_rel_home_m) >= 10.0 or moving:
            self.throttle_suppressed = False

    def _disarm_after_landing(self) -> None:
        delay = self.tune["LAND_DISARMDELAY"]
        if not self.armed or delay <= 0 or self.is_flying or self._last_flying_s is None:
            return
        if self.time_s - self._last_flying_s >= delay:
            self._disarm()
            self.say(Severity.INFO, "Auto disarmed")
            self.landing.report_rest()

    # limits

    def _bank_max_deg(self) -> float:
        limit = self.bank_limit_deg()
        mode = self.mode
        if self._climbing_out():
            return self.climbout.bank_limit_deg(limit)
        if self.landing.flaring:
            return min(limit, self.tune["LEVEL_ROLL_LIMIT"])
        if isinstance(mode, GuidedMode) and mode.heading is not None:
            return min(limit, math.degrees(mode.heading[2]))
        return limit

    # MissionHost

    def start_command(self, item: StoredItem) -> bool:
        """Start a mission command; outside AUTO it only becomes the current one (start_command_callback)."""
        return self.commands.start(item) if self.in_auto else True

    def verify_command(self, item: StoredItem) -> bool:
        """True when a mission command is complete."""
        return self.commands.verify(item)

    def mission_complete(self) -> None:
        """The last item is complete: return to launch."""
        if self.in_auto:
            self.change_mode(Mode.RTL, "mission end")
            self.say(Severity.INFO, "Mission complete, changing mode to RTL")

    # commands

    def arm(self, *, force: bool = False) -> MavResult:
        """Arm; refused by failing pre-arm checks, and with ``force`` by the mandatory ones alone."""
        if self.armed:
            return MavResult.ACCEPTED
        mandatory = ["Waiting for RC"] if self.failsafes.waits_for_radio else []
        failures = mandatory if force else list(self.prearm()) or mandatory
        if failures:
            for failure in failures:
                self.say(Severity.CRITICAL, f"Arm: {failure}")
            return MavResult.FAILED
        self.armed = True
        self.throttle_suppressed = self.mode.auto_throttle and not self.is_flying
        self._ground_heading_rad = self.est.yaw_rad
        self.climbout.reset()
        self._events.append(Armed())
        self.say(Severity.INFO, "Throttle armed")
        if not self.home_locked:
            self._put_home_here()
        return MavResult.ACCEPTED

    def disarm(self, *, force: bool = False) -> MavResult:
        """Disarm; in flight only by force."""
        if not self.armed:
            return MavResult.ACCEPTED
        if self.is_flying and not force:
            return MavResult.FAILED
        self._disarm()
        return MavResult.ACCEPTED

    def _disarm(self) -> None:
        self.armed = False
        self.throttle_suppressed = True
        self.climbout.reset()
        self.energy.new_airspeed_m_s = None
        self._events.append(Disarmed())
        self.say(Severity.INFO, "Throttle disarmed")
        if not self.in_auto:
            # As ArduPlane: in AUTO the mission keeps its current item.
            self.mission.reset()

    def set_mode(self, number: int) -> MavResult:
        """Change the mode at the request of a ground station."""
        if number not in self._modes:
            for severity, text in _REFUSED_MODES.get(number, ((Severity.WARNING, f"No such mode {number}"),)):
                self.say(severity, text)
            return MavResult.FAILED
        if self.flight_mode is Mode.INITIALISING:
            # As ArduPlane, which enters its initial mode at the end of the start whatever was requested before.
            return MavResult.ACCEPTED
        return MavResult.ACCEPTED if self.change_mode(Mode(number), _STATION_REASON) else MavResult.FAILED

    def change_mode(self, mode: Mode, reason: str) -> bool:
        """Change the mode; False when the fence refuses that."""
        if self.flight_mode is mode:
            return True
        if self._fence.denies_mode_change(reason):
            self.say(Severity.NOTICE, f"Mode change to {mode.full_name} denied, in fence recovery")
            return False
        self.mode.leave()
        self.mode = self._modes[mode]
        self.flight_mode = mode
        self.previous_mode_reason, self.mode_reason = self.mode_reason, reason
        self.failsafes.mode_changed()
        self.energy.auto_throttle = self.mode.auto_throttle
        self.pilot.fly_level()
        self.energy.new_airspeed_m_s = None
        self.nav.hold_course_rad = None
        if not self.is_flying:
            self.throttle_suppressed = self.mode.auto_throttle or not self.armed
        elif self.armed:
            self.throttle_suppressed = False
        self._events.append(ModeChanged(mode, reason))
        self.mode.enter()
        self._fence.mode_entered()
        if self.mission.in_landing_sequence and not self.is_flying and not self.armed and not self.mode.navigates:
            self.say(Severity.INFO, "In landing sequence: mission reset")
            self.mission.reset()
        return True

    def enter_auto_to_land(self) -> None:
        """Change from RTL to AUTO, whose mission has just been set to a landing sequence."""
        self._enter_auto(RTL_COMPLETE_REASON)

    def _enter_auto(self, reason: str) -> bool:
        self.resume_forced = True
        entered = self.change_mode(Mode.AUTO, reason)
        self.resume_forced = False
        return entered

    def set_mission_current(self, seq: int, *, reset: bool = False) -> MavResult:
        """Make an item the current one; ``reset`` clears the jump counters and restarts a completed mission."""
        if reset:
            self.mission.reset()
        if not self.mission.set_current(seq):
            return MavResult.FAILED
        if reset:
            self.mission.start_or_resume(restart=False)
        return MavResult.ACCEPTED

    def mission_start(self) -> MavResult:
        """Enter AUTO; ACCEPTED even when the mode change is refused, as by ArduPlane."""
        self.set_mode(Mode.AUTO)
        return MavResult.ACCEPTED

    def reposition(self, target: RepositionTarget) -> MavResult:
        """Fly to a point in GUIDED."""
        if not target.change_mode and self.flight_mode is not Mode.GUIDED:
            return MavResult.DENIED
        values = (target.lat_deg, target.lon_deg, target.alt_m, target.radius_m)
        if any(value is not None and not math.isfinite(value) for value in values):
            return MavResult.DENIED
        lat, lon = target.lat_deg, target.lon_deg
        if lat is not None and lon is not None and not (-90.0 <= lat <= 90.0 and -180.0 <= lon <= 180.0):
            return MavResult.DENIED
        if target.frame not in (0, 3, 10):
            return MavResult.DENIED
        # As ArduPlane: when the mode change is refused, the present mode takes the new point.
        self.set_mode(Mode.GUIDED)
        guided = self._guided
        spot = self.here()
        if lat is not None and lon is not None and (lat != 0.0 or lon != 0.0):
            spot.n_m, spot.e_m = self.frame.to_plane(lat, lon)
        if target.alt_m is not None:
            spot.alt_m = target.alt_m if target.frame == 0 else target.alt_m + self.home.alt_m
            spot.follows_ground = target.frame == 10
        if target.radius_m is not None and target.radius_m != 0.0:
            guided.radius_m = abs(target.radius_m)
            guided.clockwise = target.radius_m > 0
            spot.anticlockwise = target.radius_m < 0
        guided.climb_rate_m_s = 0.0
        guided.go_to(spot)
        return MavResult.ACCEPTED

    def set_home(self, lat_deg: float | None, lon_deg: float | None, alt_amsl_m: float | None) -> MavResult:
        """Set home, here when all are None, and lock it until the next boot; RTL turns to it at once."""
        result = super().set_home(lat_deg, lon_deg, alt_amsl_m)
        if result is MavResult.ACCEPTED:
            self.home_locked = True
            if self.flight_mode is Mode.RTL:
                self.mode.enter()
        return result

    def change_speed(self, kind: int, speed_m_s: float, throttle_pct: float) -> MavResult:
        """Set target airspeed (``kind`` 0), minimum ground speed (1) or cruise throttle."""
        return self.energy.change_speed(kind, speed_m_s, throttle_pct)

    def change_altitude(self, alt_m: float, frame: int) -> MavResult:
        """Change the altitude of the point being flown to, whatever the mode: of the landing point too, on a landing.

        As ArduPlane's handle_change_alt_request, which looks at neither mode nor flight stage.
        """
        if not math.isfinite(alt_m) or frame not in (0, 3, 10):
            return MavResult.DENIED
        self.nav.change_altitude(alt_m if frame == 0 else alt_m + self.home.alt_m, follows_ground=frame == 10)
        if isinstance(self.mode, GuidedMode):
            self.mode.climb_rate_m_s = 0.0
        return MavResult.ACCEPTED

    def change_guided_altitude(self, alt_m: float, frame: int, rate_m_s: float) -> MavResult:
        """Change the altitude in GUIDED, at a climb rate or as fast as possible (0)."""
        guided = self.mode
        if not isinstance(guided, GuidedMode):
            return MavResult.FAILED
        result = self.change_altitude(alt_m, frame)
        guided.climb_rate_m_s = abs(rate_m_s) if math.isfinite(rate_m_s) else 0.0
        return result

    def change_heading(self, kind: int, heading_deg: float, accel_m_s2: float) -> MavResult:
        """Fly a course (``kind`` 0) or heading (1) instead of to the point in GUIDED; 2 returns to the point."""
        guided = self.mode
        if not isinstance(guided, GuidedMode) or kind not in (0, 1, 2):
            return MavResult.FAILED
        if kind == 2:
            guided.heading = None
            return MavResult.ACCEPTED
        if not math.isfinite(heading_deg) or not 0.0 <= heading_deg <= 360.0:
            return MavResult.DENIED
        limit = math.atan(accel_m_s2 / 9.80665) if math.isfinite(accel_m_s2) and accel_m_s2 > 0 else math.radians(30.0)
        guided.heading = (kind, wrap_pi(math.radians(heading_deg)), limit)
        return MavResult.ACCEPTED

    def do_mission_command(self, item: StoredItem) -> MavResult:
        """Execute a DO_* command that was sent on its own."""
        command = item.command
        if command == Cmd.DO_LAND_START:
            found = self.mission.jump_to_landing(self.distance_to_item)
            return MavResult.ACCEPTED if found and self._enter_auto(_STATION_REASON) else MavResult.FAILED
        if command == Cmd.DO_RETURN_PATH_START:
            found = self.mission.jump_to_return_path(self.distance_to_item)
            return MavResult.ACCEPTED if found and self._enter_auto(_STATION_REASON) else MavResult.FAILED
        if command == Cmd.DO_JUMP_TAG:
            tags = [i.seq for i in self._plan.mission[1:] if i.command == Cmd.JUMP_TAG and int(i.p1) == int(item.p1)]
            return self.set_mission_current(tags[0]) if tags else MavResult.FAILED
        if command == Cmd.DO_CHANGE_SPEED:
            return self.change_speed(int(item.p1), item.p2, item.p3)
        if command == Cmd.NAV_RETURN_TO_LAUNCH:
            return self.set_mode(Mode.RTL)
        if command == Cmd.NAV_LOITER_UNLIM:
            return self.set_mode(Mode.LOITER)
        if command in AT_ONCE or command in (
            Cmd.DO_SET_HOME,
            Cmd.DO_FENCE_ENABLE,
            Cmd.DO_INVERTED_FLIGHT,
            Cmd.DO_AUTOTUNE_ENABLE,
            Cmd.DO_SET_ROI,
            Cmd.DO_SET_ROI_LOCATION,
            Cmd.DO_SET_ROI_NONE,
            Cmd.DO_MOUNT_CONTROL,
            Cmd.DO_ENGINE_CONTROL,
        ):
            return MavResult.ACCEPTED if self.commands.start(item) else MavResult.FAILED
        return MavResult.UNSUPPORTED

    def abort_landing(self, climb_to_m: float) -> MavResult:
        """Abort the landing that is being flown; ``climb_to_m`` 0 leaves the altitude to the mission."""
        return MavResult.ACCEPTED if self.landing.request_go_around(climb_to_m) else MavResult.FAILED

    # the world outside

    def rc_input(self, channels: Mapping[int, int | None]) -> None:
        """Override radio channels by number, in µs; None returns a channel to the transmitter."""
        self.rc.override(channels)

    def move_by_hand(
        self,
        roll_rad: float,
        pitch_rad: float,
        yaw_rad: float,
        *,
        seconds: float = 0.0,
        offset_ned_m: tuple[float, float, float] = (0.0, 0.0, -CARRY_HEIGHT_M),
    ) -> None:
        """Turn and carry the plane by hand, disarmed and on the ground.

        Parameters
        ----------
        roll_rad, pitch_rad, yaw_rad : float
            Target attitude.
        seconds : float
            Duration; 0 is immediate.
        offset_ned_m : tuple of float
            North, east and down of the point where it was picked up.

        Raises
        ------
        RuntimeError
            The plane is armed, or not on the ground.
        """
        if self.armed:
            raise RuntimeError("the plane is armed: disarm it before it is taken in the hand")
        if self._hand is None:
            if not self.body.on_wheels or self.est.groundspeed_m_s > 1.0:
                raise RuntimeError("the plane is not at rest on the ground: let it land before it is taken in the hand")
            self._hand = Hand(self.body)
        self._hand.move(roll_rad, pitch_rad, yaw_rad, seconds=seconds, offset_ned_m=offset_ned_m)

    def put_down(self) -> None:
        """Put the plane down where it is held, with its heading."""
        if self._hand is not None:
            self._hand = None
            self.body.place(self.body.lat_deg, self.body.lon_deg, self.body.yaw_rad)

    def failsafe_gcs(self, active: bool) -> None:
        """Report that the ground station's heartbeat is lost, or back."""
        self.failsafes.station(is_lost=active)

    def fence_breached(self, kind: FenceBreach | None, return_point: tuple[float, float] | None = None) -> None:
        """Report a fence breach, or that all fences are clear again (None)."""
        self._fence.breached(kind, return_point)

    def reboot(self) -> None:
        """Restart in place, disarmed, with the charge that is left in the battery; time starts from zero."""
        self.battery.restart()
        self.energy.load_saved()
        # Rounded to a centimetre, the resolution of positions on the wire.
        self._boot(round(self.body.lat_deg, 7), round(self.body.lon_deg, 7))

    # camera

    def outlook(self) -> Outlook:
        """The true pose of the plane, for a camera on board."""
        body = self.body
        north, east = self.start.to_plane(body.lat_deg, body.lon_deg)
        revision = self._plan.mission_revision
        if revision != self._landings_revision:
            self._landings_revision = revision
            self._landings = tuple(
                self.start.to_plane(item.lat_deg, item.lon_deg)
                for item in self._plan.mission[1:]
                if item.command == Cmd.NAV_LAND
            )
        return Outlook(
            north_m=north,
            east_m=east,
            up_m=body.alt_amsl_m - self.config.home_alt_amsl_m,
            roll_rad=body.roll_rad,
            pitch_rad=body.pitch_rad,
            yaw_rad=body.yaw_rad,
            home_m=self.start.to_plane(*self._home_lat_lon),
            landings_m=self._landings,
        )

    # telemetry

    def snapshot(self) -> Snapshot:
        """The present state."""
        est, body, sensors, tick = self.est, self.body, self.sensors, self._tick
        aileron, elevator, rudder, throttle = self._surfaces
        gps = sensors.gps(body, math.floor(self.time_s * 5.0) / 5.0)
        lat, lon = self._believed_place()
        alt_m = est.alt_m if self.time_s >= boot.HEIGHT_S else est.alt_m - self.config.home_alt_amsl_m
        yaw = est.yaw_rad if self.time_s >= boot.MEASURED_S else 0.0
        bank, pitch = self.pilot.attitude_demand
        nav_bearing, target_bearing, _, xtrack, _ = self.pilot.track
        nav = self.nav
        navigating = self._navigates()
        airspeed_target = self.pilot.energy_demand[1]
        here = self.here()
        fix = self.time_s >= boot.FIX_S
        fix_type, satellites = (gps.fix_type, gps.satellites) if fix else boot.gps_before_fix(self.time_s)
        wind_n, wind_e = self._wind_estimate
        target = None if self.flight_mode in (Mode.MANUAL, Mode.INITIALISING) else nav.next
        target_lat_lon = (None, None) if target is None else self.frame.to_earth(target.n_m, target.e_m)
        return Snapshot(
            time_s=self.time_s,
            mode=self.flight_mode,
            armed=self.armed,
            system_state=self._system_state(),
            landed_state=self._landed_state(),
            is_flying=self.is_flying,
            gcs_failsafe=self.failsafes.station_is_lost,
            radio_lost=self.failsafes.radio_lost,
            waits_for_radio=self.failsafes.waits_for_radio,
            roll_rad=est.roll_rad,
            pitch_rad=est.pitch_rad,
            yaw_rad=yaw,
            roll_rate_rad_s=est.p_rad_s,
            pitch_rate_rad_s=est.q_rad_s,
            yaw_rate_rad_s=est.r_rad_s,
            lat_deg=lat,
            lon_deg=lon,
            alt_amsl_m=alt_m,
            alt_rel_home_m=self.alt_rel_home_m,
            alt_agl_m=est.alt_m - self.config.home_alt_amsl_m,
            north_m=est.n_m,
            east_m=est.e_m,
            down_m=self.config.home_alt_amsl_m - est.alt_m,
            velocity_n_m_s=est.velocity_n_m_s,
            velocity_e_m_s=est.velocity_e_m_s,
            velocity_d_m_s=est.velocity_d_m_s,
            airspeed_m_s=est.airspeed_m_s,
            groundspeed_m_s=est.groundspeed_m_s,
            heading_deg=math.degrees(yaw) % 360.0,
            climb_m_s=-est.velocity_d_m_s,
            throttle_pct=round(100.0 * throttle),
            home_lat_deg=self._home_lat_lon[0],
            home_lon_deg=self._home_lat_lon[1],
            home_alt_amsl_m=self.home.alt_m,
            accel_m_s2=sensors.accel_m_s2(body, tick, throttle),
            gyro_rad_s=sensors.gyro_rad_s(body, tick),
            mag_mgauss=sensors.mag_mgauss(body, tick),
            static_pressure_pa=sensors.static_pressure_pa(body, tick, self.time_s),
            differential_pressure_pa=sensors.differential_pressure_pa(body, tick),
            temperature_c=sensors.temperature_c(body),
            gps_fix_type=fix_type,
            gps_satellites=satellites,
            gps_hdop=gps.hdop if fix else 100.0,
            gps_vdop=gps.vdop if fix else 100.0,
            gps_lat_deg=gps.lat_deg,
            gps_lon_deg=gps.lon_deg,
            gps_alt_amsl_m=gps.alt_amsl_m,
            gps_alt_ellipsoid_m=gps.alt_amsl_m + self.config.geoid_m,
            gps_speed_m_s=gps.speed_m_s,
            gps_course_deg=gps.course_deg,
            wind_from_deg=math.degrees(math.atan2(-wind_e, -wind_n)) % 360.0,
            wind_speed_m_s=math.hypot(wind_n, wind_e),
            wind_down_m_s=0.0,
            battery_measured=self.time_s >= boot.MEASURED_S,
            battery_voltage_v=self.battery.voltage_v,
            battery_current_a=self.battery.current_a,
            battery_consumed_mah=self.battery.consumed_mah,
            battery_consumed_j=self.battery.consumed_j,
            battery_remaining_pct=round(100.0 * self.battery.remaining),
            battery_failsafe=int(self.failsafes.battery),
            nav_roll_deg=math.degrees(bank),
            nav_pitch_deg=math.degrees(pitch),
            nav_bearing_deg=math.degrees(nav_bearing) if navigating else 0.0,
            target_bearing_deg=math.degrees(target_bearing) if navigating else 0.0,
            wp_distance_m=distance_m(here, nav.next) if navigating else 0.0,
            alt_error_m=nav.target_alt_m - est.alt_m if self.mode.auto_throttle else 0.0,
            airspeed_error_m_s=airspeed_target - est.airspeed_m_s if airspeed_target > 0 else 0.0,
            xtrack_error_m=xtrack if navigating else 0.0,
            target_lat_deg=target_lat_lon[0],
            target_lon_deg=target_lat_lon[1],
            target_alt_amsl_m=None if target is None else target.alt_m,
            servo_pwm_us=(
                round(1500 + 400 * aileron),
                round(1500 + 400 * elevator),
                round(1000 + 1000 * throttle),
                round(1500 + 400 * rudder),
                0,
                0,
                0,
                0,
            ),
            rc_pwm_us=self.rc.pwm()[:8],
            mission_current=self.mission.current_seq,
            mission_total=self.mission.total,
            mission_state=self._mission_state(),
            mission_in_landing=self.mission.in_landing_sequence
            and not self.mission.starts_with_takeoff(restart=self.tune["MIS_RESTART"] == 1),
            origin_set=self._origin_set,
            ekf_flags=boot.ekf_flags(self.time_s),
            ekf_velocity_variance=0.02,
            ekf_pos_horiz_variance=0.03,
            ekf_pos_vert_variance=0.02,
            ekf_compass_variance=0.03,
            vibration_m_s2=sensors.vibration_m_s2(tick, throttle),
        )

    def _believed_place(self) -> tuple[float, float]:
        """Estimated latitude and longitude; before the first fix those of dead reckoning from 0, 0."""
        if self.time_s >= boot.FIX_S:
            return self.where()
        drift_deg = math.degrees(boot.drift_m(self.time_s) / _EARTH_RADIUS_M)
        return drift_deg * math.cos(self.est.yaw_rad), drift_deg * math.sin(self.est.yaw_rad)

    def _system_state(self) -> SystemState:
        if self.flight_mode is Mode.INITIALISING:
            return SystemState.CALIBRATING
        if self.failsafes.is_on:
            return SystemState.CRITICAL
        return SystemState.ACTIVE if self.is_flying else SystemState.STANDBY

    def _landed_state(self) -> LandedState:
        if not self.is_flying:
            return LandedState.ON_GROUND
        if self._climbing_out():
            return LandedState.TAKEOFF
        if self.landing.active:
            return LandedState.LANDING
        return LandedState.IN_AIR

    def _mission_state(self) -> MissionState:
        if self.mission.total == 0:
            return MissionState.NO_MISSION
        if self.mission.state is RunState.COMPLETE:
            return MissionState.COMPLETE
        return MissionState.ACTIVE if self.mission.state is RunState.RUNNING else MissionState.NOT_STARTED
