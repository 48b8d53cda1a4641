"""The contract between the flying half of the simulated plane and its MAVLink half.

It has the types of that interface and no behaviour: the autopilot's inputs (:class:`SimConfig`, :class:`Parameters`,
:class:`PlanView`), its state (:class:`Snapshot`), its events (:class:`Event`) and the commands it accepts
(:class:`AutopilotPort`). All quantities are SI with the unit in the name; latitudes and longitudes are degrees WGS-84;
``amsl`` is height above mean sea level; ``rel_home`` is height above home; NED is north, east, down; body axes are
forward, right, down.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Literal, NamedTuple, Protocol, TypeAlias

__all__ = [
    "BY_STICK",
    "DT_S",
    "Armed",
    "AutopilotPort",
    "CameraTriggered",
    "Disarmed",
    "EkfFlag",
    "Event",
    "FenceBreach",
    "HomeChanged",
    "LandedState",
    "MavResult",
    "MissionItemReached",
    "MissionState",
    "Mode",
    "ModeChanged",
    "Parameters",
    "PlanView",
    "RallyPoint",
    "RepositionTarget",
    "Severity",
    "SimConfig",
    "Snapshot",
    "StatusText",
    "StoredItem",
    "SystemState",
]

DT_S = 0.01
"""Simulated time of one :meth:`AutopilotPort.step`, in seconds."""


class MavResult(IntEnum):
    """MAV_RESULT, the result of a command."""

    ACCEPTED = 0
    TEMPORARILY_REJECTED = 1
    DENIED = 2
    UNSUPPORTED = 3
    FAILED = 4


class Severity(IntEnum):
    """MAV_SEVERITY of a status text."""

    EMERGENCY = 0
    ALERT = 1
    CRITICAL = 2
    ERROR = 3
    WARNING = 4
    NOTICE = 5
    INFO = 6
    DEBUG = 7


class Mode(IntEnum):
    """ArduPlane mode numbers (``HEARTBEAT.custom_mode``): the simulated modes, and INITIALISING."""

    MANUAL = 0
    CIRCLE = 1
    STABILIZE = 2
    TRAINING = 3
    ACRO = 4
    FBWA = 5
    FBWB = 6
    CRUISE = 7
    AUTOTUNE = 8
    AUTO = 10
    RTL = 11
    LOITER = 12
    TAKEOFF = 13
    AVOID_ADSB = 14
    GUIDED = 15
    INITIALISING = 16
    LOITER_ALT_QLAND = 25
    AUTOLAND = 26

    @property
    def full_name(self) -> str:
        """ArduPlane's name of the mode in texts (``Mode::name`` in mode.h, 4.8)."""
        if self in (Mode.FBWA, Mode.FBWB, Mode.RTL):
            return self.name
        return {"AVOID_ADSB": "Avoid ADSB", "LOITER_ALT_QLAND": "Loiter to QLand"}.get(
            self.name, self.name.capitalize()
        )

    @property
    def failing_checks(self) -> list[str]:
        """The failing pre-arm check of this mode (``Mode::pre_arm_checks``); empty when it may be armed in."""
        return [f"{self.full_name} mode not armable"] if self in (Mode.RTL, Mode.INITIALISING) else []


BY_STICK = frozenset(
    {Mode.MANUAL, Mode.STABILIZE, Mode.TRAINING, Mode.ACRO, Mode.FBWA, Mode.FBWB, Mode.CRUISE, Mode.AUTOTUNE}
)
"""The modes that are flown by stick."""


class LandedState(IntEnum):
    """MAV_LANDED_STATE of EXTENDED_SYS_STATE."""

    UNDEFINED = 0
    ON_GROUND = 1
    IN_AIR = 2
    TAKEOFF = 3
    LANDING = 4


class MissionState(IntEnum):
    """MISSION_STATE of MISSION_CURRENT."""

    UNKNOWN = 0
    NO_MISSION = 1
    NOT_STARTED = 2
    ACTIVE = 3
    PAUSED = 4
    COMPLETE = 5


class SystemState(IntEnum):
    """MAV_STATE of HEARTBEAT as ArduPlane sets it.

    CALIBRATING during the start, STANDBY on the ground, ACTIVE in flight, CRITICAL during a failsafe.
    """

    CALIBRATING = 2
    STANDBY = 3
    ACTIVE = 4
    CRITICAL = 5


class EkfFlag(IntEnum):
    """Bits of EKF_STATUS_REPORT.flags."""

    ATTITUDE = 1
    VELOCITY_HORIZ = 2
    VELOCITY_VERT = 4
    POS_HORIZ_REL = 8
    POS_HORIZ_ABS = 16
    POS_VERT_ABS = 32
    POS_VERT_AGL = 64
    CONST_POS_MODE = 128
    PRED_POS_HORIZ_REL = 256
    PRED_POS_HORIZ_ABS = 512
    UNINITIALIZED = 1024


class FenceBreach(Enum):
    """The breached fence (FENCE_BREACH: MINALT 1, MAXALT 2, BOUNDARY 3)."""

    MIN_ALT = "Min Alt"
    MAX_ALT = "Max Alt"
    CIRCLE = "Circle"
    POLYGON = "Polygon"


@dataclass(frozen=True, slots=True)
class SimConfig:
    """Configuration of one simulated plane.

    Parameters
    ----------
    home_lat_deg, home_lon_deg : float
        Start position, degrees WGS-84.
    home_alt_amsl_m : float
        Ground elevation there (flat earth around it), metres.
    heading_deg : float
        Start heading, degrees true, 0 to 360.
    wind_m_s, wind_from_deg : float
        Steady wind speed and the direction it comes from (degrees true).
    gust_m_s : float
        Wind speed at 6 m that scales the Dryden turbulence; 0 is smooth air.
    seed : int
        Seed of gusts and sensor noise; the same seed gives the same flight.
    system_id : int
        MAVLink system id, 1 to 255.
    geoid_m : float
        Height of the geoid above the WGS-84 ellipsoid there, metres.
    launch : {"runway", "hand"}
        Take-off along a runway on its belly skid, or launch by hand.
    """

    home_lat_deg: float = 40.3332
    home_lon_deg: float = -3.7978
    home_alt_amsl_m: float = 600.0
    heading_deg: float = 270.0
    wind_m_s: float = 0.0
    wind_from_deg: float = 180.0
    gust_m_s: float = 0.0
    seed: int = 0
    system_id: int = 1
    geoid_m: float = 51.0
    launch: Literal["runway", "hand"] = "runway"


@dataclass(frozen=True, slots=True)
class StoredItem:
    """A mission item as stored by the autopilot (already normalised by the plan store).

    ``seq`` 0 is home. ``frame`` is MAV_FRAME 0 (AMSL), 3 (relative to home) or 10 (above the terrain below the
    plane, or above home where that is unknown). ``lat_deg`` and ``lon_deg`` are 0 when the item has no position.
    ``p1`` to ``p4`` are as read back.
    """

    seq: int
    command: int
    frame: int
    p1: float
    p2: float
    p3: float
    p4: float
    lat_deg: float
    lon_deg: float
    alt_m: float
    x: int = 0
    """Raw x on the wire, for commands without a position."""
    y: int = 0
    """Raw y on the wire."""


@dataclass(frozen=True, slots=True)
class RallyPoint:
    """A rally point; ``alt_m`` is above home when ``relative`` (ArduPlane's default), else AMSL."""

    lat_deg: float
    lon_deg: float
    alt_m: float
    relative: bool = True


class Parameters(Protocol):
    """The parameter store, by ArduPlane's names."""

    def get(self, name: str) -> float:
        """Value of a parameter.

        Raises
        ------
        KeyError
            There is no such parameter.
        """
        ...

    def set_unsaved(self, name: str, value: float) -> None:
        """Set a value without saving it, until :meth:`load`."""
        ...

    def load(self, name: str) -> None:
        """Restore the saved value."""
        ...

    @property
    def revision(self) -> int:
        """Increases with every change of any value; the autopilot then reads its parameters again."""
        ...


class GroundView(Protocol):
    """The autopilot's terrain data, metres above mean sea level; None where it has none."""

    def height_m(self, lat_deg: float, lon_deg: float) -> float | None:
        """Terrain altitude at a position."""
        ...

    def below_m(self, lat_deg: float, lon_deg: float) -> float | None:
        """Terrain altitude below the plane, or the last known one."""
        ...


class PlanView(Protocol):
    """The stored plan as the autopilot reads it. Never kept, because an upload may replace it."""

    @property
    def mission(self) -> Sequence[StoredItem]:
        """Stored items by ``seq``; ``mission[0]`` is home, whose content is ignored: the autopilot owns home."""
        ...

    @property
    def mission_revision(self) -> int:
        """Increases with every change of the mission."""
        ...

    @property
    def mission_clears(self) -> int:
        """Number of removals of the whole mission: by MISSION_CLEAR_ALL, or before an upload as a file."""
        ...

    @property
    def rally(self) -> Sequence[RallyPoint]:
        """Stored rally points."""
        ...


@dataclass(frozen=True, slots=True)
class StatusText:
    """A STATUSTEXT message, before it is split into chunks."""

    severity: int
    text: str


@dataclass(frozen=True, slots=True)
class MissionItemReached:
    """MISSION_ITEM_REACHED is due."""

    seq: int


@dataclass(frozen=True, slots=True)
class HomeChanged:
    """Home moved: HOME_POSITION (and GPS_GLOBAL_ORIGIN) are due."""

    lat_deg: float
    lon_deg: float
    alt_amsl_m: float


@dataclass(frozen=True, slots=True)
class ModeChanged:
    """The mode changed; ``reason`` is free text."""

    mode: Mode
    reason: str


@dataclass(frozen=True, slots=True)
class Armed:
    """The plane was armed."""


@dataclass(frozen=True, slots=True)
class Disarmed:
    """The plane was disarmed."""


@dataclass(frozen=True, slots=True)
class CameraTriggered:
    """The camera took picture ``index`` at this position: CAMERA_FEEDBACK is due."""

    index: int
    lat_deg: float
    lon_deg: float
    alt_amsl_m: float
    alt_rel_home_m: float
    roll_deg: float
    pitch_deg: float
    yaw_deg: float


Event: TypeAlias = StatusText | MissionItemReached | HomeChanged | ModeChanged | Armed | Disarmed | CameraTriggered


@dataclass(frozen=True, slots=True)
class Snapshot:
    """The state shown by telemetry, at one instant."""

    time_s: float
    """Simulated time since boot."""

    # mode and state
    mode: Mode
    armed: bool
    system_state: SystemState
    landed_state: LandedState
    is_flying: bool
    gcs_failsafe: bool
    radio_lost: bool
    """Whether the remote control counts as lost."""
    waits_for_radio: bool
    """Arming, forced arming included, is refused until a first RC frame arrives."""

    # attitude estimate
    roll_rad: float
    pitch_rad: float
    yaw_rad: float
    """Heading of the nose, −π to π, 0 north."""
    roll_rate_rad_s: float
    pitch_rate_rad_s: float
    yaw_rate_rad_s: float

    # position and velocity estimate; before the first fix near latitude and longitude 0, with barometric height
    lat_deg: float
    lon_deg: float
    alt_amsl_m: float
    alt_rel_home_m: float
    alt_agl_m: float
    north_m: float
    """From the EKF origin (the boot position), for LOCAL_POSITION_NED."""
    east_m: float
    down_m: float
    velocity_n_m_s: float
    velocity_e_m_s: float
    velocity_d_m_s: float
    airspeed_m_s: float
    groundspeed_m_s: float
    heading_deg: float
    """0 to 360."""
    climb_m_s: float
    throttle_pct: int

    # home
    home_lat_deg: float
    home_lon_deg: float
    home_alt_amsl_m: float

    # raw sensors, noisy
    accel_m_s2: tuple[float, float, float]
    """Specific force in body axes; (0, 0, −9.81) at rest and level."""
    gyro_rad_s: tuple[float, float, float]
    mag_mgauss: tuple[float, float, float]
    static_pressure_pa: float
    differential_pressure_pa: float
    temperature_c: float

    # GPS
    gps_fix_type: int
    """GPS_FIX_TYPE: 0 no receiver, 1 no fix, 3 three-dimensional, 6 RTK fixed (as ArduPilot's simulator reports)."""
    gps_satellites: int
    gps_hdop: float
    gps_vdop: float
    gps_lat_deg: float
    gps_lon_deg: float
    gps_alt_amsl_m: float
    gps_alt_ellipsoid_m: float
    gps_speed_m_s: float
    gps_course_deg: float

    # wind estimate
    wind_from_deg: float
    wind_speed_m_s: float
    wind_down_m_s: float

    # battery
    battery_measured: bool
    """False until the first reading of the battery monitor."""
    battery_voltage_v: float
    battery_current_a: float
    battery_consumed_mah: float
    battery_consumed_j: float
    battery_remaining_pct: int
    battery_failsafe: int
    """Threshold crossed in flight: 0 none, 1 low, 2 critical."""

    # navigation controller
    nav_roll_deg: float
    nav_pitch_deg: float
    nav_bearing_deg: float
    """−180 to 180, as NAV_CONTROLLER_OUTPUT."""
    target_bearing_deg: float
    wp_distance_m: float
    alt_error_m: float
    airspeed_error_m_s: float
    xtrack_error_m: float

    # the point being flown to (POSITION_TARGET_GLOBAL_INT): in every mode but MANUAL, whose is None
    target_lat_deg: float | None
    target_lon_deg: float | None
    target_alt_amsl_m: float | None

    # servos and radio
    servo_pwm_us: tuple[int, ...]
    """Outputs 1 to 8: aileron, elevator, throttle, rudder; 0 for unused ones."""
    rc_pwm_us: tuple[int, ...]
    """Radio channels 1 to 8 in effect (override or the simulated transmitter)."""

    # mission
    mission_current: int
    mission_total: int
    """Number of items, home excluded, as MISSION_CURRENT.total."""
    mission_state: MissionState
    mission_in_landing: bool
    """In a landing sequence, and the next command is not a take-off: arming is refused."""

    # estimator health
    origin_set: bool
    """The estimator has set its origin (GPS_GLOBAL_ORIGIN)."""
    ekf_flags: int
    ekf_velocity_variance: float
    ekf_pos_horiz_variance: float
    ekf_pos_vert_variance: float
    ekf_compass_variance: float
    vibration_m_s2: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class RepositionTarget:
    """Target of DO_REPOSITION. None keeps the present value."""

    lat_deg: float | None
    lon_deg: float | None
    alt_m: float | None
    frame: int = 3
    """MAV_FRAME 0, 3 or 10 (integer variants folded by the caller)."""
    radius_m: float | None = None
    """Loiter radius; negative turns anticlockwise."""
    change_mode: bool = True
    """MAV_DO_REPOSITION_FLAGS_CHANGE_MODE; without it the target is refused outside GUIDED."""


class Outlook(NamedTuple):
    """Input of a camera on board: the true pose, and the marks on the ground. Metres from the start position."""

    north_m: float
    east_m: float
    up_m: float
    """Height of the centre of gravity above the ground."""
    roll_rad: float
    pitch_rad: float
    yaw_rad: float
    home_m: tuple[float, float]
    """North and east of home."""
    landings_m: tuple[tuple[float, float], ...]
    """North and east of the mission's landing points."""


class AutopilotPort(Protocol):
    """The interface of :class:`vencejo.sim.autopilot.Autopilot` to the MAVLink half. Single-threaded."""

    time_s: float
    prearm: Callable[[], list[str]]
    """Returns the failing checks without the prefix "Arm: ", for :meth:`arm`. May be replaced."""

    def step(self) -> None:
        """Advance the simulation by :data:`DT_S`."""
        ...

    def snapshot(self) -> Snapshot:
        """The present state. It costs twice as much as a step, so it is not built in each."""
        ...

    @property
    def flight_mode(self) -> Mode:
        """The snapshot's ``mode``, without the cost of a snapshot."""
        ...

    def events(self) -> list[Event]:
        """Events since the last call, oldest first; beyond 1,024 the oldest are dropped."""
        ...

    # commands: each returns a MAV_RESULT; ArduPlane's texts are in events()

    def arm(self, *, force: bool = False) -> MavResult:
        """COMPONENT_ARM_DISARM 1; ``force`` is parameter 2 of 2989 or 21196."""
        ...

    def disarm(self, *, force: bool = False) -> MavResult:
        """COMPONENT_ARM_DISARM 0; refused in flight unless ``force`` (21196)."""
        ...

    def set_mode(self, number: int) -> MavResult:
        """DO_SET_MODE or SET_MODE with ArduPlane's number; an unknown one fails with "No such mode 99"."""
        ...

    def set_mission_current(self, seq: int, *, reset: bool = False) -> MavResult:
        """MISSION_SET_CURRENT or DO_SET_MISSION_CURRENT, whose parameter 2 is ``reset``."""
        ...

    def mission_start(self) -> MavResult:
        """MISSION_START: enters AUTO; ACCEPTED even when the mode change is refused."""
        ...

    def reposition(self, target: RepositionTarget) -> MavResult:
        """DO_REPOSITION: enter GUIDED and fly to a point."""
        ...

    def change_speed(self, kind: int, speed_m_s: float, throttle_pct: float) -> MavResult:
        """DO_CHANGE_SPEED: ``kind`` 0 airspeed, 1 ground speed; −1 keeps speed or throttle, −2 restores the default."""
        ...

    def change_altitude(self, alt_m: float, frame: int) -> MavResult:
        """DO_CHANGE_ALTITUDE (186): the altitude of the point being flown to, in any mode."""
        ...

    def change_guided_altitude(self, alt_m: float, frame: int, rate_m_s: float) -> MavResult:
        """GUIDED_CHANGE_ALTITUDE (43001): fails in other modes; ``rate_m_s`` 0 is as fast as possible."""
        ...

    def change_guided_speed(self, airspeed_m_s: float, accel_m_s2: float) -> MavResult:
        """GUIDED_CHANGE_SPEED (43000): wins over DO_CHANGE_SPEED until GUIDED is left; ``accel_m_s2`` 0 is at once."""
        ...

    def raise_target(self, metres: float) -> None:
        """SET_POSITION_TARGET_LOCAL_NED: change the altitude of the point being flown to, in GUIDED."""
        ...

    def force_attitude(self, roll_rad: float | None, pitch_rad: float | None, throttle: float | None) -> None:
        """SET_ATTITUDE_TARGET: fly these for GUIDED_TIMEOUT, in GUIDED; None is left to the autopilot."""
        ...

    def change_heading(self, kind: int, heading_deg: float, accel_m_s2: float) -> MavResult:
        """GUIDED_CHANGE_HEADING (43002): ``kind`` 0 course over ground, 1 heading, 2 return to the point."""
        ...

    def set_home(self, lat_deg: float | None, lon_deg: float | None, alt_amsl_m: float | None) -> MavResult:
        """DO_SET_HOME; to the present position when all are None."""
        ...

    def do_mission_command(self, item: StoredItem) -> MavResult:
        """A DO_* command sent as COMMAND_LONG or COMMAND_INT (jump tags, payload, land start …)."""
        ...

    def abort_landing(self, climb_to_m: float) -> MavResult:
        """DO_GO_AROUND: fly the mission's abort pattern, else climb to a height above home (0: the landing's own)."""
        ...

    def terminate(self, *, wanted: bool) -> MavResult:
        """DO_FLIGHTTERMINATION: terminate the flight, or abort that."""
        ...

    # inputs from outside

    def rc_input(self, channels: Mapping[int, int | None]) -> None:
        """Override radio channels by number (1 to 16), in µs; None returns a channel to the simulated transmitter."""
        ...

    def move_by_hand(
        self,
        roll_rad: float,
        pitch_rad: float,
        yaw_rad: float,
        *,
        seconds: float = ...,
        offset_ned_m: tuple[float, float, float] = ...,
    ) -> None:
        """Hold the plane by hand on the ground: attitude and sensors follow in all three axes.

        Raises RuntimeError while it is armed or not at rest on the ground.
        """
        ...

    def put_down(self) -> None:
        """End :meth:`move_by_hand`: put the plane on its skid, with its heading."""
        ...

    def outlook(self) -> Outlook:
        """The true pose of the plane, for a camera on board."""
        ...

    def failsafe_gcs(self, active: bool) -> None:
        """Report that the ground station's heartbeat is lost (True) or back; acts by FS_LONG_ACTN."""
        ...

    def fence_breached(self, kind: FenceBreach | None, return_point: tuple[float, float] | None = None) -> None:
        """Report a fence breach, or that all fences are clear again (None); acts by FENCE_ACTION.

        ``return_point`` is the fence's return point (latitude and longitude, degrees), home when None.
        """
        ...

    def fence_disabled(self) -> None:
        """Report that no fence is enabled, which ends the return from a breach."""
        ...

    def reboot(self) -> None:
        """PREFLIGHT_REBOOT_SHUTDOWN: restart in place, disarmed, with the charge left; time from zero."""
        ...
