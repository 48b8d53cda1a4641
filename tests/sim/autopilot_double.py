"""An autopilot that does not fly, for tests of the MAVLink half: it settles, arms and changes mode."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from vencejo.sim.autopilot.interface import (
    DT_S,
    Armed,
    Disarmed,
    Event,
    FenceBreach,
    HomeChanged,
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
    StatusText,
    StoredItem,
    SystemState,
)

SETTLED_S = 2.0
"""When it has GPS and an estimator (the real one takes twenty seconds)."""


class DoubleAutopilot:
    """See :class:`vencejo.sim.autopilot.interface.AutopilotPort`."""

    def __init__(self, config: SimConfig, params: Parameters, plan: PlanView, prearm: Callable[[], list[str]]) -> None:
        self.config = config
        self.params = params
        self.plan = plan
        self.prearm = prearm
        self.calls: list[tuple[object, ...]] = []
        self.rebooted = 0
        self._boot()

    def _boot(self) -> None:
        self.time_s = 0.0
        self.mode = Mode.MANUAL
        self.armed = False
        self.flying = False
        self.current = 0
        self.lat_deg, self.lon_deg = self.config.home_lat_deg, self.config.home_lon_deg
        self.alt_rel_home_m = 0.0
        self.landed_state = LandedState.ON_GROUND
        self.settled = False
        self.in_landing = False
        self.radio_lost = False
        self._steps = 0
        self._events: list[Event] = []

    def step(self) -> None:
        self._steps += 1
        self.time_s = self._steps * DT_S
        if not self.settled and self.time_s >= SETTLED_S:
            self.settled = True
            c = self.config
            self._events.append(HomeChanged(c.home_lat_deg, c.home_lon_deg, c.home_alt_amsl_m))

    def events(self) -> list[Event]:
        found, self._events = self._events, []
        return found

    def say(self, text: str, severity: Severity = Severity.INFO) -> None:
        self._events.append(StatusText(severity, text))

    @property
    def flight_mode(self) -> Mode:
        return self.mode

    def snapshot(self) -> Snapshot:
        c = self.config
        total = max(0, len(self.plan.mission) - 1)
        return Snapshot(
            time_s=self.time_s,
            mode=self.mode,
            armed=self.armed,
            system_state=SystemState.ACTIVE if self.flying else SystemState.STANDBY,
            landed_state=self.landed_state,
            is_flying=self.flying,
            gcs_failsafe=False,
            radio_lost=self.radio_lost,
            waits_for_radio=False,
            roll_rad=0.01,
            pitch_rad=0.02,
            yaw_rad=-1.57,
            roll_rate_rad_s=0.0,
            pitch_rate_rad_s=0.0,
            yaw_rate_rad_s=0.0,
            lat_deg=self.lat_deg,
            lon_deg=self.lon_deg,
            alt_amsl_m=c.home_alt_amsl_m + self.alt_rel_home_m,
            alt_rel_home_m=self.alt_rel_home_m,
            alt_agl_m=self.alt_rel_home_m,
            north_m=0.0,
            east_m=0.0,
            down_m=-self.alt_rel_home_m,
            velocity_n_m_s=0.0,
            velocity_e_m_s=0.0,
            velocity_d_m_s=0.0,
            airspeed_m_s=0.3,
            groundspeed_m_s=0.0,
            heading_deg=c.heading_deg,
            climb_m_s=0.0,
            throttle_pct=0,
            home_lat_deg=c.home_lat_deg,
            home_lon_deg=c.home_lon_deg,
            home_alt_amsl_m=c.home_alt_amsl_m,
            accel_m_s2=(0.0, 0.0, -9.80665),
            gyro_rad_s=(0.001, 0.001, 0.001),
            mag_mgauss=(0.0, 258.0, 368.0),
            static_pressure_pa=94322.0,
            differential_pressure_pa=0.5,
            temperature_c=26.3,
            gps_fix_type=6 if self.settled else 1,
            gps_satellites=10 if self.settled else 0,
            gps_hdop=1.21,
            gps_vdop=2.0,
            gps_lat_deg=self.lat_deg,
            gps_lon_deg=self.lon_deg,
            gps_alt_amsl_m=c.home_alt_amsl_m + self.alt_rel_home_m,
            gps_alt_ellipsoid_m=c.home_alt_amsl_m + c.geoid_m + self.alt_rel_home_m,
            gps_speed_m_s=0.0,
            gps_course_deg=90.0,
            wind_from_deg=180.0,
            wind_speed_m_s=0.0,
            wind_down_m_s=0.0,
            battery_measured=True,
            battery_voltage_v=12.6,
            battery_current_a=0.0,
            battery_consumed_mah=0.0,
            battery_consumed_j=0.0,
            battery_remaining_pct=99,
            battery_failsafe=0,
            nav_roll_deg=0.0,
            nav_pitch_deg=0.0,
            nav_bearing_deg=0.0,
            target_bearing_deg=0.0,
            wp_distance_m=0.0,
            alt_error_m=0.0,
            airspeed_error_m_s=0.0,
            xtrack_error_m=0.0,
            target_lat_deg=None,
            target_lon_deg=None,
            target_alt_amsl_m=None,
            servo_pwm_us=(1500, 1500, 1000, 1500, 0, 0, 0, 0),
            rc_pwm_us=(1500, 1500, 1000, 1500, 1800, 1000, 1000, 1800),
            mission_current=self.current,
            mission_total=total,
            mission_state=MissionState.NOT_STARTED if total else MissionState.NO_MISSION,
            mission_in_landing=self.in_landing,
            origin_set=self.settled,
            ekf_flags=831 if self.settled else 1024,
            ekf_velocity_variance=0.006,
            ekf_pos_horiz_variance=0.006,
            ekf_pos_vert_variance=0.005,
            ekf_compass_variance=0.007,
            vibration_m_s2=(0.003, 0.003, 0.003),
        )

    def _called(self, *call: object) -> MavResult:
        self.calls.append(call)
        return MavResult.ACCEPTED

    def arm(self, *, force: bool = False) -> MavResult:
        self._called("arm", force)
        if not force and (reasons := self.prearm()):
            for reason in reasons:
                self.say(f"Arm: {reason}", Severity.CRITICAL)
            return MavResult.FAILED
        self.armed = True
        self._events.append(Armed())
        self.say("Throttle armed")
        return MavResult.ACCEPTED

    def disarm(self, *, force: bool = False) -> MavResult:
        self._called("disarm", force)
        if self.flying and not force:
            return MavResult.FAILED
        self.armed = False
        self._events.append(Disarmed())
        self.say("Throttle disarmed")
        return MavResult.ACCEPTED

    def set_mode(self, number: int) -> MavResult:
        if number not in set(Mode) - {Mode.INITIALISING}:
            self.say(f"No such mode {number}", Severity.WARNING)
            return MavResult.FAILED
        self.mode = Mode(number)
        self._events.append(ModeChanged(self.mode, "test"))
        return self._called("set_mode", self.mode)

    def set_mission_current(self, seq: int, *, reset: bool = False) -> MavResult:
        if not 0 <= seq < len(self.plan.mission):
            return MavResult.FAILED
        self.current = seq
        return self._called("set_mission_current", seq)

    def mission_start(self) -> MavResult:
        return self._called("mission_start")

    def reposition(self, target: RepositionTarget) -> MavResult:
        if target.change_mode:
            self.mode = Mode.GUIDED
        return self._called("reposition", target)

    def change_speed(self, kind: int, speed_m_s: float, throttle_pct: float) -> MavResult:
        return self._called("change_speed", kind, speed_m_s, throttle_pct)

    def change_altitude(self, alt_m: float, frame: int) -> MavResult:
        return self._called("change_altitude", alt_m, frame)

    def change_guided_altitude(self, alt_m: float, frame: int, rate_m_s: float) -> MavResult:
        return self._called("change_guided_altitude", alt_m, frame, rate_m_s)

    def change_guided_speed(self, airspeed_m_s: float, accel_m_s2: float) -> MavResult:
        return self._called("change_guided_speed", airspeed_m_s, accel_m_s2)

    def raise_target(self, metres: float) -> None:
        self._called("raise_target", metres)

    def force_attitude(self, roll_rad: float | None, pitch_rad: float | None, throttle: float | None) -> None:
        self._called("force_attitude", roll_rad, pitch_rad, throttle)

    def change_heading(self, kind: int, heading_deg: float, accel_m_s2: float) -> MavResult:
        return self._called("change_heading", kind, heading_deg, accel_m_s2)

    def set_home(self, lat_deg: float | None, lon_deg: float | None, alt_amsl_m: float | None) -> MavResult:
        if lat_deg is not None and lon_deg is not None and alt_amsl_m is not None:
            self.config = replace(self.config, home_lat_deg=lat_deg, home_lon_deg=lon_deg, home_alt_amsl_m=alt_amsl_m)
        c = self.config
        self._events.append(HomeChanged(c.home_lat_deg, c.home_lon_deg, c.home_alt_amsl_m))
        return self._called("set_home", lat_deg, lon_deg, alt_amsl_m)

    def do_mission_command(self, item: StoredItem) -> MavResult:
        return self._called("do_mission_command", item)

    def abort_landing(self, climb_to_m: float) -> MavResult:
        return self._called("abort_landing", climb_to_m)

    def terminate(self, *, wanted: bool) -> MavResult:
        return self._called("terminate", wanted)

    def rc_input(self, channels: Mapping[int, int | None]) -> None:
        self._called("rc_input", dict(channels))

    def move_by_hand(
        self,
        roll_rad: float,
        pitch_rad: float,
        yaw_rad: float,
        *,
        seconds: float = 0.0,
        offset_ned_m: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        self._called("move_by_hand", roll_rad, pitch_rad, yaw_rad, seconds, offset_ned_m)

    def put_down(self) -> None:
        self._called("put_down")

    def outlook(self) -> Outlook:
        return Outlook(0.0, 0.0, 0.1, 0.0, 0.0, 0.0, (0.0, 0.0), ())

    def failsafe_gcs(self, active: bool) -> None:
        self._called("failsafe_gcs", active)

    def fence_breached(self, kind: FenceBreach | None, return_point: tuple[float, float] | None = None) -> None:
        self._called("fence_breached", kind, return_point)

    def fence_disabled(self) -> None:
        self.fence_is_on = False

    def reboot(self) -> None:
        self.rebooted += 1
        self._boot()
