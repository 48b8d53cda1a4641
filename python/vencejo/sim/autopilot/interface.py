"""The contract between the flying half of the simulated plane and its MAVLink half.

This file owns the types that cross that line, and nothing that moves: what the autopilot is given
(:class:`SimConfig`, :class:`Parameters`, :class:`PlanView`), what it shows (:class:`Snapshot`), what it says
(:class:`Event`) and what it can be told (:class:`AutopilotPort`). All quantities are SI with the unit in the
name; latitudes and longitudes are degrees WGS-84; ``amsl`` is height above mean sea level; ``rel_home`` is
height above home; NED is north, east, down; body axes are forward, right, down.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Literal, NamedTuple, Protocol, TypeAlias

__all__ = [
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
    """MAV_RESULT as commands answer it."""

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
    """ArduPlane mode numbers (``HEARTBEAT.custom_mode``) that the simulated plane flies, and the one of its start."""

    MANUAL = 0
    CIRCLE = 1
    STABILIZE = 2
    FBWA = 5
    FBWB = 6
    CRUISE = 7
    AUTO = 10
    RTL = 11
    LOITER = 12
    TAKEOFF = 13
    GUIDED = 15
    INITIALISING = 16

    @property
    def full_name(self) -> str:
        """As ArduPlane says it in a text."""
        return {"FBWA": "FLY_BY_WIRE_A", "FBWB": "FLY_BY_WIRE_B"}.get(self.name, self.name)

    @property
    def failing_checks(self) -> list[str]:
        """Why this mode does not arm (``Mode::pre_arm_checks``); empty where it does."""
        return [f"{self.full_name} mode not armable"] if self in (Mode.RTL, Mode.INITIALISING) else []


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
    """MAV_STATE of HEARTBEAT as ArduPlane sets it: CALIBRATING while it starts, STANDBY on the ground, ACTIVE flying, CRITICAL in failsafe."""

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
    """Which fence was crossed (FENCE_BREACH: MINALT 1, MAXALT 2, BOUNDARY 3)."""

    MIN_ALT = "Min Alt"
    MAX_ALT = "Max Alt"
    CIRCLE = "Circle"
    POLYGON = "Polygon"


@dataclass(frozen=True, slots=True)
class SimConfig:
    """What one simulated plane is started with.

    Parameters
    ----------
    home_lat_deg, home_lon_deg : float
        Where it stands, degrees WGS-84.
    home_alt_amsl_m : float
        Ground elevation there (flat earth around it), metres.
    heading_deg : float
        Where it looks, degrees true, 0 to 360.
    wind_m_s, wind_from_deg : float
        Steady wind speed and the direction it comes from (degrees true).
    gust_m_s : float
        Wind speed at 6 m that scales the Dryden turbulence; 0 is smooth air.
    seed : int
        Seed of gusts and sensor noise; the same seed gives the same flight.
    system_id : int
        MAVLink system id, 1 to 255.
    geoid_m : float
        Height of the sea's level there above the WGS-84 ellipsoid, metres.
    launch : {"runway", "hand"}
        Take-off by rolling on its belly skid along a strip, or thrown by hand.
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
    """A mission item as the autopilot keeps it (already normalised by the plan store).

    ``seq`` 0 is home. ``frame`` is MAV_FRAME 0 (AMSL), 3 (relative to home) or 10 (above the
    ground below the plane, as far as that is known; else above home). ``lat_deg`` and ``lon_deg`` are 0 when the item has no position. ``p1`` to ``p4`` are as read back.
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
    """Raw x of the wire, for commands that carry no position there."""
    y: int = 0
    """Raw y of the wire."""


@dataclass(frozen=True, slots=True)
class RallyPoint:
    """A rally point; ``alt_m`` is above home when ``relative`` (ArduPlane's default), else AMSL."""

    lat_deg: float
    lon_deg: float
    alt_m: float
    relative: bool = True


class Parameters(Protocol):
    """The parameter store, ArduPlane's names."""

    def get(self, name: str) -> float:
        """Value of a parameter.

        Raises
        ------
        KeyError
            The plane has no such parameter.
        """
        ...

    def set_unsaved(self, name: str, value: float) -> None:
        """Change a value until it is loaded again."""
        ...

    def load(self, name: str) -> None:
        """Return to the saved value."""
        ...

    @property
    def revision(self) -> int:
        """Grows by at least one with every change of any value (the autopilot re-reads its parameters then)."""
        ...


class GroundView(Protocol):
    """What the autopilot knows of the ground, metres above mean sea level; None where it does not."""

    def height_m(self, lat_deg: float, lon_deg: float) -> float | None:
        """Height of the ground at a place."""
        ...

    def below_m(self, lat_deg: float, lon_deg: float) -> float | None:
        """Height of the ground below the plane, or the last that was known there."""
        ...


class PlanView(Protocol):
    """What the autopilot reads of the stored plan. Read at once, never kept: an upload may replace it."""

    @property
    def mission(self) -> Sequence[StoredItem]:
        """Stored items by ``seq``; ``mission[0]`` is home (its content is ignored, the autopilot owns home)."""
        ...

    @property
    def mission_revision(self) -> int:
        """Grows with every change of the mission."""
        ...

    @property
    def mission_clears(self) -> int:
        """How often the whole mission was removed: by MISSION_CLEAR_ALL, or before one that came as a file."""
        ...

    @property
    def rally(self) -> Sequence[RallyPoint]:
        """Stored rally points."""
        ...


@dataclass(frozen=True, slots=True)
class StatusText:
    """A text for STATUSTEXT, unchunked."""

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
    """The mode changed; ``reason`` is free text for the log."""

    mode: Mode
    reason: str


@dataclass(frozen=True, slots=True)
class Armed:
    """The motor is armed."""


@dataclass(frozen=True, slots=True)
class Disarmed:
    """The motor is disarmed."""


@dataclass(frozen=True, slots=True)
class CameraTriggered:
    """The camera took picture ``index`` here: CAMERA_FEEDBACK is due."""

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
    """Everything that telemetry shows of one instant."""

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
    """The failsafe of the remote control counts it as lost."""
    waits_for_radio: bool
    """It does not arm, not even by force, before a receiver was heard."""

    # attitude estimate
    roll_rad: float
    pitch_rad: float
    yaw_rad: float
    """Heading of the nose, −π to π, 0 north."""
    roll_rate_rad_s: float
    pitch_rate_rad_s: float
    yaw_rate_rad_s: float

    # position and velocity estimate; before the first fix near latitude and longitude 0, and the height is the barometer's
    lat_deg: float
    lon_deg: float
    alt_amsl_m: float
    alt_rel_home_m: float
    alt_agl_m: float
    north_m: float
    """From the EKF origin (where the plane booted), for LOCAL_POSITION_NED."""
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

    # wind estimate: the direction it comes from
    wind_from_deg: float
    wind_speed_m_s: float
    wind_down_m_s: float

    # battery
    battery_measured: bool
    """False until the monitor has read it for the first time."""
    battery_voltage_v: float
    battery_current_a: float
    battery_consumed_mah: float
    battery_consumed_j: float
    battery_remaining_pct: int
    battery_failsafe: int
    """Which mark was reached in flight: 0 none, 1 low, 2 critical."""

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
    """Outputs 1 to 8: aileron, elevator, throttle, rudder, then 0 for unused."""
    rc_pwm_us: tuple[int, ...]
    """Radio channels 1 to 8 as in use (override or the simulated radio)."""

    # mission
    mission_current: int
    mission_total: int
    """Items without home, as MISSION_CURRENT.total."""
    mission_state: MissionState
    mission_in_landing: bool
    """In a landing sequence, and the next command is no take-off: nothing to arm for."""

    # estimator health
    origin_set: bool
    """The estimator has its origin: GPS_GLOBAL_ORIGIN is known."""
    ekf_flags: int
    ekf_velocity_variance: float
    ekf_pos_horiz_variance: float
    ekf_pos_vert_variance: float
    ekf_compass_variance: float
    vibration_m_s2: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class RepositionTarget:
    """Where DO_REPOSITION sends the plane. None: keep as it is."""

    lat_deg: float | None
    lon_deg: float | None
    alt_m: float | None
    frame: int = 3
    """MAV_FRAME 0, 3 or 10 (integer variants folded by the caller)."""
    radius_m: float | None = None
    """Loiter radius; negative turns anticlockwise."""
    change_mode: bool = True
    """MAV_DO_REPOSITION_FLAGS_CHANGE_MODE; without it, refused unless already in GUIDED."""


class Outlook(NamedTuple):
    """What a camera on board needs: the true pose, and what lies marked on the ground. Metres from the start place."""

    north_m: float
    east_m: float
    up_m: float
    """Height of the centre of gravity over the ground."""
    roll_rad: float
    pitch_rad: float
    yaw_rad: float
    home_m: tuple[float, float]
    """North and east of home."""
    landings_m: tuple[tuple[float, float], ...]
    """North and east of the mission's landing points."""


class AutopilotPort(Protocol):
    """What :class:`vencejo.sim.autopilot.Autopilot` offers to the MAVLink half. Single-threaded."""

    time_s: float
    prearm: Callable[[], list[str]]
    """Called by :meth:`arm`; returns the failing checks without the "Arm: " prefix. May be replaced after construction."""

    def step(self) -> None:
        """Advance the simulation by :data:`DT_S`."""
        ...

    def snapshot(self) -> Snapshot:
        """The present instant, all of it: costs twice what a step does, so not to be asked for in each."""
        ...

    @property
    def flight_mode(self) -> Mode:
        """The snapshot's ``mode`` alone."""
        ...

    def events(self) -> list[Event]:
        """Events since the last call, oldest first; at most 1,024 are kept (oldest dropped)."""
        ...

    # commands: each answers a MAV_RESULT, and the texts that ArduPlane would send appear in events()

    def arm(self, *, force: bool = False) -> MavResult:
        """COMPONENT_ARM_DISARM 1; ``force`` is the magic 2989 or 21196."""
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
        """MISSION_START: enters AUTO; accepted even when that is refused."""
        ...

    def reposition(self, target: RepositionTarget) -> MavResult:
        """DO_REPOSITION: GUIDED towards a point."""
        ...

    def change_speed(self, kind: int, speed_m_s: float, throttle_pct: float) -> MavResult:
        """DO_CHANGE_SPEED: ``kind`` 0 airspeed, 1 ground speed; speed −1 or throttle −1 keep, −2 default."""
        ...

    def change_altitude(self, alt_m: float, frame: int) -> MavResult:
        """DO_CHANGE_ALTITUDE (186): the altitude of the point being flown to, in any mode."""
        ...

    def change_guided_altitude(self, alt_m: float, frame: int, rate_m_s: float) -> MavResult:
        """GUIDED_CHANGE_ALTITUDE (43001): fails in other modes; ``rate_m_s`` 0 is as fast as possible."""
        ...

    def change_heading(self, kind: int, heading_deg: float, accel_m_s2: float) -> MavResult:
        """GUIDED_CHANGE_HEADING (43002): ``kind`` 0 course over ground, 1 heading, 2 back to the point."""
        ...

    def set_home(self, lat_deg: float | None, lon_deg: float | None, alt_amsl_m: float | None) -> MavResult:
        """DO_SET_HOME; all None is where the plane is."""
        ...

    def do_mission_command(self, item: StoredItem) -> MavResult:
        """A DO_* command sent as COMMAND_LONG or COMMAND_INT (jump tags, payload, land start …)."""
        ...

    def abort_landing(self, climb_to_m: float) -> MavResult:
        """DO_GO_AROUND: by the mission's pattern, else a climb to a height above home (0: the landing's own)."""
        ...

    # the world outside

    def rc_input(self, channels: Mapping[int, int | None]) -> None:
        """Radio channels by number (1 to 16) in µs; None gives a channel back to the simulated radio."""
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
        """A plane held in the hand on the ground: attitude and sensors follow in all three axes.

        RuntimeError while it is armed or not at rest on the ground.
        """
        ...

    def put_down(self) -> None:
        """End of :meth:`move_by_hand`: back on its skid, keeping its heading."""
        ...

    def outlook(self) -> Outlook:
        """Where the plane truly is, for a camera on board."""
        ...

    def failsafe_gcs(self, active: bool) -> None:
        """The ground station's heartbeat is lost (True) or back; acts as FS_LONG_ACTN says."""
        ...

    def fence_breached(self, kind: FenceBreach | None, return_point: tuple[float, float] | None = None) -> None:
        """A fence was crossed (None: all clear again); acts as FENCE_ACTION says.

        ``return_point`` is the fence's: latitude and longitude, degrees; home without one.
        """
        ...

    def reboot(self) -> None:
        """PREFLIGHT_REBOOT_SHUTDOWN: where it stands, with what is left in its battery, disarmed, time from zero."""
        ...
