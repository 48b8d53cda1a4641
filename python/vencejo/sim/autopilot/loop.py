"""The loop of the autopilot: estimate, navigate at 10 Hz, set-points, control laws, motion.

It owns the mode and what the plane does without being asked: following home, judging whether it flies, suppressing the
throttle, disarming after a landing. Guidance is in :mod:`.navigator`, the modes in :mod:`.modes`, AUTO in :mod:`.auto`.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from vencejo.sim.hand import Hand

from . import boot
from .auto.commands import Commands
from .auto.mission import MissionRunner
from .auto.names import Cmd
from .energy import Energy
from .failsafe import Failsafes
from .fence_response import RTL_COMPLETE_REASON, FenceResponse
from .geo import wrap_pi
from .interface import (
    DT_S,
    Disarmed,
    Mode,
    ModeChanged,
    Parameters,
    PlanView,
    Severity,
    SimConfig,
    StoredItem,
)
from .landing import Landing
from .modes.base import Controls, FlightMode
from .modes.guided import GuidedMode
from .modes.table import make_modes
from .modes.takeoff import TakeoffMode
from .navigator import Navigator
from .plane import Plane
from .takeoff import Takeoff

__all__ = ["STATION_REASON", "FlightLoop"]

STATION_REASON = "ground station"
_BLOCKABLE = (
    Mode.MANUAL, Mode.CIRCLE, Mode.STABILIZE, Mode.TRAINING, Mode.ACRO, Mode.FBWA, Mode.FBWB, Mode.CRUISE,
    Mode.AUTOTUNE, Mode.AUTO, Mode.LOITER, Mode.TAKEOFF, Mode.AVOID_ADSB, Mode.GUIDED, None, None, None, None, None,
    None, Mode.LOITER_ALT_QLAND, Mode.AUTOLAND,
)  # fmt: skip
"""The modes by their bits of FLTMODE_GCSBLOCK (Plane::gcs_mode_enabled); None for modes that do not exist here."""
_COURSE_SPEED_M_S = 5.0
"""Ground speed above which a course over ground counts (GPS_GND_CRS_MIN_SPD)."""
_NAVIGATE_TICKS = 10
_STICK_TICKS = 2
_FLYING_TICKS = 20
_LANDED_M_S = 3.0
_HOME_AGAIN_S = 6.0
"""Period at which home follows a disarmed plane, as recorded (Plane::one_second_loop, after more than 5 s)."""


class FlightLoop(Plane):
    """The loop of one plane, and the changes of mode and arming that it makes by itself.

    :class:`vencejo.sim.autopilot.Autopilot` adds what a ground station may ask for.
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
            surfaces.aileron,
            surfaces.elevator,
            surfaces.rudder,
            surfaces.throttle,
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
        if self.mode.navigates and self.flight_mode is not Mode.CIRCLE:
            nav.count_turns()
        self._capture_direction()
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
        if self.config.launch == "hand" and self._climbing_out():
            self.climbout.throw()

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
        if self._climbing_out():
            return self.climbout.bank_limit_deg(limit)
        if self.landing.flaring:
            return min(limit, self.tune["LEVEL_ROLL_LIMIT"])
        return self.mode.bank_max_deg(limit)

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

    # mode and arming

    def change_mode(self, mode: Mode, reason: str) -> bool:
        """Change the mode; False when the fence, FLTMODE_GCSBLOCK or the mode itself refuses that."""
        if self.flight_mode is mode:
            return True
        if self._fence.denies_mode_change(reason):
            self.say(Severity.NOTICE, f"Mode change to {mode.full_name} denied, in fence recovery")
            return False
        if reason == STATION_REASON and self._is_blocked(mode):
            why = "GCS entry disabled (FLTMODE_GCSBLOCK)"
            self.say(Severity.NOTICE, f"Mode change to {mode.full_name} denied, {why}")
            return False
        # As Mode::enter, which resets these before the mode can refuse.
        self.energy.new_airspeed_m_s = None
        self._guided.forget()
        self.failsafes.mode_changed()
        refusal = self._modes[mode].refusal()
        if refusal is not None:
            self.say(Severity.WARNING, refusal)
            self.say(Severity.WARNING, "Flight mode change failed")
            return False
        self.mode.leave()
        self.autotune(on=False)
        self.mode = self._modes[mode]
        self.previous_mode, self.flight_mode = self.flight_mode, mode
        self.previous_mode_reason, self.mode_reason = self.mode_reason, reason
        self.energy.auto_throttle = self.mode.auto_throttle
        self.pilot.fly_level()
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

    def _is_blocked(self, mode: Mode) -> bool:
        return mode in _BLOCKABLE and bool(int(self.tune["FLTMODE_GCSBLOCK"]) >> _BLOCKABLE.index(mode) & 1)

    def enter_auto_to_land(self) -> None:
        """Change from RTL to AUTO, whose mission has just been set to a landing sequence."""
        self._enter_auto(RTL_COMPLETE_REASON)

    def _enter_auto(self, reason: str) -> bool:
        self.resume_forced = True
        entered = self.change_mode(Mode.AUTO, reason)
        self.resume_forced = False
        return entered

    def _capture_direction(self) -> None:
        """Take AUTOLAND's direction once the plane flies (ModeAutoLand::check_takeoff_direction)."""
        est = self.est
        is_wanted = self.takeoff_course_rad is None and self.mode.captures_direction
        if is_wanted and self.armed and self.is_flying and est.groundspeed_m_s > _COURSE_SPEED_M_S:
            course_rad = math.atan2(est.velocity_e_m_s, est.velocity_n_m_s)
            self._set_direction(course_rad + math.radians(self.tune["AUTOLAND_DIR_OFF"]))

    def _set_direction(self, course_rad: float) -> None:
        self.takeoff_course_rad = wrap_pi(course_rad)
        self.say(Severity.INFO, f"Autoland direction= {int(math.degrees(course_rad) % 360.0)}")

    def _disarm(self) -> None:
        self.armed = False
        self.takeoff_course_rad = None
        self.throttle_suppressed = True
        self.climbout.reset()
        self.energy.new_airspeed_m_s = None
        self._events.append(Disarmed())
        self.say(Severity.INFO, "Throttle disarmed")
        if not self.in_auto:
            # As ArduPlane: in AUTO the mission keeps its current item.
            self.mission.reset()
