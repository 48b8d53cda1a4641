"""Telemetry: the newest value of every group, frozen at one moment, each with its age.

A group is ``None`` until the vehicle has sent it; a field is ``None`` when the vehicle marks it as unknown or when its
value cannot be. Nothing is ever NaN. Units and datum stand in the names.

Examples
--------
>>> from vencejo.telemetry import Hud
>>> hud = Hud(
...     airspeed_m_s=22.1,
...     groundspeed_m_s=25.0,
...     heading_deg=90.0,
...     throttle_pct=45.0,
...     alt_amsl_m=690.0,
...     climb_m_s=0.1,
...     age_s=4.0,
...     has_invalid=False,
... )
>>> hud.freshness
'stale'
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, Literal, TypeVar

from vencejo import _native

if TYPE_CHECKING:
    from vencejo.items import GeoPoint

STALE_AFTER_S: Final = 3.5
"""A group older than this is stale: shown, but marked."""
LOST_AFTER_S: Final = 5.0
"""A group older than this says nothing about the vehicle any more."""

Freshness = Literal["fresh", "stale", "lost"]


@dataclass(frozen=True, kw_only=True)
class Group:
    """What all groups have in common.

    Attributes
    ----------
    age_s : float
        How long ago the message had arrived when the snapshot was taken, in seconds.
    has_invalid : bool
        Whether the message held a value that cannot be; such fields are ``None``.
    """

    age_s: float
    has_invalid: bool

    @property
    def freshness(self) -> Freshness:
        """``"fresh"``, ``"stale"`` after 3.5 s or ``"lost"`` after 5 s."""
        if self.age_s <= STALE_AFTER_S:
            return "fresh"
        return "stale" if self.age_s <= LOST_AFTER_S else "lost"


_G = TypeVar("_G", bound=Group)


def _point(lat_deg: float, lon_deg: float) -> GeoPoint:
    from vencejo.items import GeoPoint

    return GeoPoint(lat_deg, lon_deg)


# Written by scripts/telemetry_classes.py: do not edit.


@dataclass(frozen=True, kw_only=True)
class Heartbeat(Group):
    """HEARTBEAT of the autopilot: type, mode and state of the vehicle.

    Attributes
    ----------
    mode : str
        Flight mode by name, such as ``"AUTO"``; ``"mode 42"`` when the number is not known.
    mode_number : int
        The mode's number on the wire, in the autopilot's own numbering.
    is_armed : bool
        Whether the motors can run.
    system_status : str
        ``MAV_STATE`` in words, such as ``"standby"`` or ``"active"``.
    mav_type : int
        ``MAV_TYPE``: 1 fixed wing, 2 quadrotor, 19 to 25 VTOL.
    autopilot : int
        ``MAV_AUTOPILOT``: 3 ArduPilot, 12 PX4.
    """

    mode: str
    mode_number: int
    is_armed: bool
    system_status: str
    mav_type: int
    autopilot: int


@dataclass(frozen=True, kw_only=True)
class Attitude(Group):
    """ATTITUDE: body (forward, right, down) in the local frame (north, east, down), Tait-Bryan ZYX.

    Attributes
    ----------
    roll_rad : float or None
        Right wing down positive, -pi to pi.
    pitch_rad : float or None
        Nose up positive, -pi/2 to pi/2.
    yaw_rad : float or None
        Clockwise from true north, -pi to pi.
    roll_rate_rad_s : float or None
        Body rate about the forward axis.
    pitch_rate_rad_s : float or None
        Body rate about the right axis.
    yaw_rate_rad_s : float or None
        Body rate about the down axis.
    """

    roll_rad: float | None
    pitch_rad: float | None
    yaw_rad: float | None
    roll_rate_rad_s: float | None
    pitch_rate_rad_s: float | None
    yaw_rate_rad_s: float | None


@dataclass(frozen=True, kw_only=True)
class Position(Group):
    """GLOBAL_POSITION_INT: the autopilot's filtered position estimate.

    Attributes
    ----------
    lat_deg : float or None
        WGS-84 latitude; ``None`` without a position.
    lon_deg : float or None
        WGS-84 longitude; ``None`` without a position.
    alt_amsl_m : float or None
        Altitude above mean sea level.
    alt_rel_home_m : float or None
        Altitude above home.
    velocity_north_m_s : float or None
        Ground speed northward.
    velocity_east_m_s : float or None
        Ground speed eastward.
    velocity_down_m_s : float or None
        Speed downward.
    heading_deg : float or None
        Heading, 0 to 360 from true north.
    """

    lat_deg: float | None
    lon_deg: float | None
    alt_amsl_m: float | None
    alt_rel_home_m: float | None
    velocity_north_m_s: float | None
    velocity_east_m_s: float | None
    velocity_down_m_s: float | None
    heading_deg: float | None

    @property
    def point(self) -> GeoPoint | None:
        """The position as functions of `vencejo.geodesy` take it; ``None`` without one."""
        return None if self.lat_deg is None or self.lon_deg is None else _point(self.lat_deg, self.lon_deg)


@dataclass(frozen=True, kw_only=True)
class Hud(Group):
    """VFR_HUD: speeds, heading and altitude for a head-up display.

    Attributes
    ----------
    airspeed_m_s : float or None
        Airspeed (indicated or equivalent, depending on the autopilot).
    groundspeed_m_s : float or None
        Speed over ground.
    heading_deg : float or None
        Heading, 0 to 360.
    throttle_pct : float or None
        Throttle, 0 to 100 %.
    alt_amsl_m : float or None
        Altitude above mean sea level.
    climb_m_s : float or None
        Climb rate, up positive.
    """

    airspeed_m_s: float | None
    groundspeed_m_s: float | None
    heading_deg: float | None
    throttle_pct: float | None
    alt_amsl_m: float | None
    climb_m_s: float | None


@dataclass(frozen=True, kw_only=True)
class Gps(Group):
    """GPS_RAW_INT: the GPS receiver's data, unfiltered.

    Attributes
    ----------
    fix : int
        ``GPS_FIX_TYPE``; 3 and more is a position in three dimensions.
    fix_name : str
        The fix in words.
    satellites : int or None
        Satellites in view.
    hdop : float or None
        Horizontal dilution of precision.
    vdop : float or None
        Vertical dilution of precision.
    lat_deg : float or None
        WGS-84 latitude.
    lon_deg : float or None
        WGS-84 longitude.
    alt_amsl_m : float or None
        Altitude above mean sea level.
    alt_ellipsoid_m : float or None
        Altitude above the WGS-84 ellipsoid, if the receiver reports it.
    groundspeed_m_s : float or None
        Speed over ground.
    course_deg : float or None
        Course over ground, 0 to 360.
    horizontal_accuracy_m : float or None
        Horizontal uncertainty, one sigma as the receiver estimates it.
    vertical_accuracy_m : float or None
        Vertical uncertainty, one sigma as the receiver estimates it.
    """

    fix: int
    fix_name: str
    satellites: int | None
    hdop: float | None
    vdop: float | None
    lat_deg: float | None
    lon_deg: float | None
    alt_amsl_m: float | None
    alt_ellipsoid_m: float | None
    groundspeed_m_s: float | None
    course_deg: float | None
    horizontal_accuracy_m: float | None
    vertical_accuracy_m: float | None

    @property
    def point(self) -> GeoPoint | None:
        """The position as functions of `vencejo.geodesy` take it; ``None`` without one."""
        return None if self.lat_deg is None or self.lon_deg is None else _point(self.lat_deg, self.lon_deg)


@dataclass(frozen=True, kw_only=True)
class SysStatus(Group):
    """SYS_STATUS: sensors and power at a glance.

    Attributes
    ----------
    is_ready_to_arm : bool or None
        Whether the vehicle's pre-arm checks pass; ``None`` when not reported.
    unhealthy_sensors : tuple[str, ...]
        Sensors in use that are unhealthy.
    load_pct : float or None
        Processor load, 0 to 100 %.
    voltage_v : float or None
        Battery voltage.
    current_a : float or None
        Battery current, discharge positive.
    battery_remaining_pct : float or None
        Charge left, 0 to 100 %.
    drop_rate_pct : float or None
        Messages lost on their way to the vehicle, 0 to 100 %.
    """

    is_ready_to_arm: bool | None
    unhealthy_sensors: tuple[str, ...]
    load_pct: float | None
    voltage_v: float | None
    current_a: float | None
    battery_remaining_pct: float | None
    drop_rate_pct: float | None


@dataclass(frozen=True, kw_only=True)
class Battery(Group):
    """BATTERY_STATUS of one battery.

    Attributes
    ----------
    id : int
        Battery id, from 0.
    voltage_v : float or None
        Voltage of the pack: the sum of the reported voltages.
    current_a : float or None
        Current, discharge positive.
    consumed_mah : float or None
        Charge used.
    consumed_j : float or None
        Energy used.
    remaining_pct : float or None
        Charge left, 0 to 100 %.
    temperature_c : float or None
        Temperature.
    time_remaining_s : float or None
        Time left at this rate.
    """

    id: int
    voltage_v: float | None
    current_a: float | None
    consumed_mah: float | None
    consumed_j: float | None
    remaining_pct: float | None
    temperature_c: float | None
    time_remaining_s: float | None


@dataclass(frozen=True, kw_only=True)
class Imu(Group):
    """SCALED_IMU to SCALED_IMU3, or an ArduPilot's RAW_IMU: one inertial sensor, body forward, right, down.

    Attributes
    ----------
    acc_g : tuple[float, float, float] or None
        Specific force in g (9.80665 m/s²).
    gyro_rad_s : tuple[float, float, float] or None
        Angular rate.
    mag_gauss : tuple[float, float, float] or None
        Magnetic field; ``None`` when all three are 0, which no place on Earth has.
    temperature_c : float or None
        Temperature of the sensor.
    """

    acc_g: tuple[float, float, float] | None
    gyro_rad_s: tuple[float, float, float] | None
    mag_gauss: tuple[float, float, float] | None
    temperature_c: float | None


@dataclass(frozen=True, kw_only=True)
class Pressure(Group):
    """SCALED_PRESSURE: barometer and airspeed sensor.

    Attributes
    ----------
    absolute_pa : float or None
        Static pressure.
    differential_pa : float or None
        Differential pressure of the airspeed sensor.
    temperature_c : float or None
        Temperature at the barometer.
    """

    absolute_pa: float | None
    differential_pa: float | None
    temperature_c: float | None


@dataclass(frozen=True, kw_only=True)
class Wind(Group):
    """WIND (ArduPilot) or WIND_COV: the autopilot's estimate.

    Attributes
    ----------
    from_deg : float or None
        Direction that the wind comes from, 0 to 360.
    speed_m_s : float or None
        Horizontal speed.
    speed_down_m_s : float or None
        Vertical speed, down positive.
    """

    from_deg: float | None
    speed_m_s: float | None
    speed_down_m_s: float | None


@dataclass(frozen=True, kw_only=True)
class HomePosition(Group):
    """Where heights relative to home are counted from.

    Attributes
    ----------
    lat_deg : float
        WGS-84 latitude.
    lon_deg : float
        WGS-84 longitude.
    alt_amsl_m : float
        Height above mean sea level, metres.
    """

    lat_deg: float
    lon_deg: float
    alt_amsl_m: float

    @property
    def point(self) -> GeoPoint:
        """The position as functions of `vencejo.geodesy` take it."""
        return _point(self.lat_deg, self.lon_deg)


@dataclass(frozen=True, kw_only=True)
class MissionCurrent(Group):
    """MISSION_CURRENT, with the numbers of the wire: on ArduPilot item 0 is home.

    Attributes
    ----------
    seq : int
        Number of the item in execution on the wire.
    total : int or None
        Items on board, home not counted, 0 where there is no mission; ``None`` when not reported.
    state : str or None
        ``"no mission"``, ``"not started"``, ``"active"``, ``"paused"`` or ``"complete"``; ``None`` when the vehicle
        does not say.
    """

    seq: int
    total: int | None
    state: str | None


@dataclass(frozen=True, kw_only=True)
class NavController(Group):
    """NAV_CONTROLLER_OUTPUT: targets and errors of the navigation controller.

    Attributes
    ----------
    nav_roll_deg : float or None
        Desired roll.
    nav_pitch_deg : float or None
        Desired pitch.
    nav_bearing_deg : float or None
        Desired heading, -180 to 180.
    target_bearing_deg : float or None
        Bearing to the target, -180 to 180.
    wp_distance_m : float or None
        Distance to the target.
    alt_error_m : float or None
        Altitude error, target above positive.
    airspeed_error_m_s : float or None
        Airspeed error, target faster positive.
    cross_track_error_m : float or None
        Distance off the track, right of it positive.
    """

    nav_roll_deg: float | None
    nav_pitch_deg: float | None
    nav_bearing_deg: float | None
    target_bearing_deg: float | None
    wp_distance_m: float | None
    alt_error_m: float | None
    airspeed_error_m_s: float | None
    cross_track_error_m: float | None


@dataclass(frozen=True, kw_only=True)
class ExtendedState(Group):
    """EXTENDED_SYS_STATE: on the ground or in the air.

    Attributes
    ----------
    landed : str
        ``"undefined"``, ``"on ground"``, ``"in air"``, ``"taking off"`` or ``"landing"``.
    vtol : int or None
        ``MAV_VTOL_STATE`` (3 multicopter, 4 fixed wing, 1 and 2 transitions); ``None`` for a plane without VTOL.
    """

    landed: str
    vtol: int | None


@dataclass(frozen=True, kw_only=True)
class Ekf(Group):
    """EKF_STATUS_REPORT: agreement of the estimator with its sensors; a test ratio of 1 is the limit.

    Attributes
    ----------
    flags : int
        ``EKF_STATUS_FLAGS`` bits.
    velocity_variance : float or None
        Test ratio of velocity.
    pos_horiz_variance : float or None
        Test ratio of horizontal position.
    pos_vert_variance : float or None
        Test ratio of altitude.
    compass_variance : float or None
        Test ratio of the compass.
    terrain_alt_variance : float or None
        Test ratio of terrain altitude.
    """

    flags: int
    velocity_variance: float | None
    pos_horiz_variance: float | None
    pos_vert_variance: float | None
    compass_variance: float | None
    terrain_alt_variance: float | None


@dataclass(frozen=True, kw_only=True)
class Vibration(Group):
    """VIBRATION of the airframe, measured by the accelerometers.

    Attributes
    ----------
    vibration_m_s2 : tuple[float or None, float or None, float or None]
        Levels along body x, y, z.
    clipping : tuple[int, int, int]
        Clipping events of each accelerometer since boot.
    """

    vibration_m_s2: tuple[float | None, float | None, float | None]
    clipping: tuple[int, int, int]


@dataclass(frozen=True, kw_only=True)
class AutopilotVersion(Group):
    """AUTOPILOT_VERSION.

    Attributes
    ----------
    flight_sw : str
        Version of the flight software, such as ``"4.6.3"``.
    git_hash : str
        First eight characters of the git hash of the flight software.
    capabilities : int
        ``MAV_PROTOCOL_CAPABILITY`` bits.
    uid : int or None
        Unique id of the hardware, 64 bits; in JSON a string of decimal digits, which a JSON number could not hold
        exactly.
    """

    flight_sw: str
    git_hash: str
    capabilities: int
    uid: int | None


@dataclass(frozen=True, kw_only=True)
class Radio(Group):
    """RADIO_STATUS or RADIO of the telemetry radio.

    Attributes
    ----------
    rssi : int or None
        Received signal on our side, raw 0 to 254.
    remote_rssi : int or None
        Received signal on the vehicle's side, raw 0 to 254.
    noise : int or None
        Noise on our side, raw.
    remote_noise : int or None
        Noise on the vehicle's side, raw.
    tx_buffer_pct : int or None
        Free transmit buffer, 0 to 100 %.
    rx_errors : int
        Packets lost to radio errors.
    fixed : int
        Packets restored by error correction.
    """

    rssi: int | None
    remote_rssi: int | None
    noise: int | None
    remote_noise: int | None
    tx_buffer_pct: int | None
    rx_errors: int
    fixed: int


@dataclass(frozen=True, kw_only=True)
class AirspeedSensor(Group):
    """AIRSPEED of the sensor heard last.

    Attributes
    ----------
    id : int
        Sensor id.
    airspeed_m_s : float or None
        Calibrated airspeed.
    differential_pa : float or None
        Differential pressure.
    temperature_c : float or None
        Temperature.
    is_unhealthy : bool
        Whether the sensor reports that it is unhealthy.
    is_used : bool
        Whether the autopilot uses it.
    """

    id: int
    airspeed_m_s: float | None
    differential_pa: float | None
    temperature_c: float | None
    is_unhealthy: bool
    is_used: bool


@dataclass(frozen=True, kw_only=True)
class ServoOutputs(Group):
    """SERVO_OUTPUT_RAW of outputs 1 to 16: the signals to the actuators.

    Attributes
    ----------
    pulse_us : tuple[int or None, ...]
        Pulse lengths of outputs 1 to 16; ``None`` for an output that is off.
    """

    pulse_us: tuple[int | None, ...]


@dataclass(frozen=True, kw_only=True)
class RcChannels(Group):
    """RC_CHANNELS: the pilot's radio.

    Attributes
    ----------
    count : int
        Number of channels.
    pulse_us : tuple[int or None, ...]
        Pulse lengths of channels 1 to 18; ``None`` for a missing channel.
    rssi : int or None
        Received signal, raw 0 to 254.
    """

    count: int
    pulse_us: tuple[int | None, ...]
    rssi: int | None


@dataclass(frozen=True, kw_only=True)
class SystemTime(Group):
    """SYSTEM_TIME: the vehicle's clocks.

    Attributes
    ----------
    utc_us : int or None
        UTC of the vehicle when the message was sent, microseconds since 1970; ``None`` before it knows the date.
    boot_ms : int
        Time since the vehicle booted.
    """

    utc_us: int | None
    boot_ms: int


@dataclass(frozen=True, kw_only=True)
class FenceStatus(Group):
    """FENCE_STATUS.

    Attributes
    ----------
    is_breached : bool
        Whether the vehicle is outside now.
    breach_count : int
        Breaches so far.
    breach_type : int
        Kind of the last breach (``FENCE_BREACH``: 1 too low, 2 too high, 3 over the boundary).
    """

    is_breached: bool
    breach_count: int
    breach_type: int


@dataclass(frozen=True, kw_only=True)
class TerrainReport(Group):
    """TERRAIN_REPORT: the vehicle's terrain data.

    Attributes
    ----------
    ground_amsl_m : float or None
        Ground above mean sea level under the vehicle (or where TERRAIN_CHECK asked); ``None`` as long as it does not
        know it.
    alt_terrain_m : float or None
        Altitude of the vehicle above that terrain.
    pending : int
        Blocks of 4 × 4 altitudes that it waits for.
    loaded : int
        Blocks that it holds in memory.
    """

    ground_amsl_m: float | None
    alt_terrain_m: float | None
    pending: int
    loaded: int


@dataclass(frozen=True, kw_only=True)
class Engine(Group):
    """EFI_STATUS: an engine with fuel injection. Values that are not measured may be reported as 0.

    Attributes
    ----------
    health : int
        Health as sent: 1 healthy and 0 not on ArduPilot; 0 stopped, 1 starting, 2 running and 3 at fault on PX4.
    ecu_index : float or None
        Number of the engine control unit.
    rpm : float or None
        Revolutions per minute.
    fuel_consumed_cm3 : float or None
        Fuel used.
    fuel_flow_cm3_min : float or None
        Fuel flow, cubic centimetres per minute.
    load_pct : float or None
        Load, 0 to 200 %.
    throttle_position_pct : float or None
        Throttle position, 0 to 100 %.
    throttle_output_pct : float or None
        Commanded throttle, 0 to 100 %.
    spark_dwell_ms : float or None
        Charging time of the ignition coil.
    ignition_timing_deg : float or None
        Ignition timing, crank angle.
    injection_ms : float or None
        Injection time.
    barometric_pa : float or None
        Atmospheric pressure.
    intake_manifold_pa : float or None
        Pressure in the intake manifold.
    intake_manifold_temperature_c : float or None
        Temperature in the intake manifold.
    cylinder_head_temperature_c : float or None
        Temperature of the cylinder head.
    exhaust_gas_temperature_c : float or None
        Temperature of the exhaust gas.
    pressure_temperature_compensation : float or None
        Correction factor of the fuel for pressure and temperature.
    ignition_v : float or None
        Ignition voltage.
    fuel_pressure_pa : float or None
        Fuel pressure.
    """

    health: int
    ecu_index: float | None
    rpm: float | None
    fuel_consumed_cm3: float | None
    fuel_flow_cm3_min: float | None
    load_pct: float | None
    throttle_position_pct: float | None
    throttle_output_pct: float | None
    spark_dwell_ms: float | None
    ignition_timing_deg: float | None
    injection_ms: float | None
    barometric_pa: float | None
    intake_manifold_pa: float | None
    intake_manifold_temperature_c: float | None
    cylinder_head_temperature_c: float | None
    exhaust_gas_temperature_c: float | None
    pressure_temperature_compensation: float | None
    ignition_v: float | None
    fuel_pressure_pa: float | None


GROUPS: Final[dict[str, type[Group]]] = {
    "heartbeat": Heartbeat,
    "attitude": Attitude,
    "position": Position,
    "hud": Hud,
    "gps": Gps,
    "sys_status": SysStatus,
    "imu": Imu,
    "pressure": Pressure,
    "wind": Wind,
    "home": HomePosition,
    "mission": MissionCurrent,
    "nav": NavController,
    "extended": ExtendedState,
    "ekf": Ekf,
    "vibration": Vibration,
    "version": AutopilotVersion,
    "radio": Radio,
    "airspeed": AirspeedSensor,
    "servos": ServoOutputs,
    "rc": RcChannels,
    "system_time": SystemTime,
    "fence": FenceStatus,
    "terrain": TerrainReport,
    "battery": Battery,
    "engine": Engine,
}
"""The class of each group by its name in a snapshot."""
# (end of what is written by a script)


class Telemetry:
    """Everything known of a vehicle at one moment. Immutable; groups are made when they are looked at."""

    def __init__(self, native: _native.TelemetrySnapshot) -> None:
        self._native = native

    @property
    def time_s(self) -> float:
        """When the snapshot was taken, in seconds on a monotonic clock of this process."""
        return self._native.time_s

    @property
    def mode(self) -> str | None:
        """Flight mode by name, ``None`` before the first heartbeat."""
        return None if self.heartbeat is None else self.heartbeat.mode

    @property
    def is_armed(self) -> bool | None:
        """Whether the motors can run, ``None`` before the first heartbeat."""
        return None if self.heartbeat is None else self.heartbeat.is_armed

    @property
    def is_on_ground(self) -> bool | None:
        """Whether the vehicle says that it is on the ground, ``None`` when it does not say."""
        if self.extended is None or self.extended.landed == "undefined":
            return None
        return self.extended.landed == "on ground"

    @property
    def messages(self) -> int:
        """Messages so far that a group here is of."""
        return self._native.messages

    @property
    def invalid_values(self) -> int:
        """Values so far that could not be and were not used."""
        return self._native.invalid_values

    # Written by scripts/telemetry_classes.py: do not edit.

    @cached_property
    def heartbeat(self) -> Heartbeat | None:
        """See `Heartbeat`."""
        return self._group("heartbeat", Heartbeat)

    @cached_property
    def attitude(self) -> Attitude | None:
        """See `Attitude`."""
        return self._group("attitude", Attitude)

    @cached_property
    def position(self) -> Position | None:
        """See `Position`."""
        return self._group("position", Position)

    @cached_property
    def hud(self) -> Hud | None:
        """See `Hud`."""
        return self._group("hud", Hud)

    @cached_property
    def gps(self) -> Gps | None:
        """See `Gps`."""
        return self._group("gps", Gps)

    @cached_property
    def sys_status(self) -> SysStatus | None:
        """See `SysStatus`."""
        return self._group("sys_status", SysStatus)

    @cached_property
    def imu(self) -> Imu | None:
        """See `Imu`."""
        return self._group("imu", Imu)

    @cached_property
    def pressure(self) -> Pressure | None:
        """See `Pressure`."""
        return self._group("pressure", Pressure)

    @cached_property
    def wind(self) -> Wind | None:
        """See `Wind`."""
        return self._group("wind", Wind)

    @cached_property
    def home(self) -> HomePosition | None:
        """See `HomePosition`."""
        return self._group("home", HomePosition)

    @cached_property
    def mission(self) -> MissionCurrent | None:
        """See `MissionCurrent`."""
        return self._group("mission", MissionCurrent)

    @cached_property
    def nav(self) -> NavController | None:
        """See `NavController`."""
        return self._group("nav", NavController)

    @cached_property
    def extended(self) -> ExtendedState | None:
        """See `ExtendedState`."""
        return self._group("extended", ExtendedState)

    @cached_property
    def ekf(self) -> Ekf | None:
        """See `Ekf`."""
        return self._group("ekf", Ekf)

    @cached_property
    def vibration(self) -> Vibration | None:
        """See `Vibration`."""
        return self._group("vibration", Vibration)

    @cached_property
    def version(self) -> AutopilotVersion | None:
        """See `AutopilotVersion`."""
        return self._group("version", AutopilotVersion)

    @cached_property
    def radio(self) -> Radio | None:
        """See `Radio`."""
        return self._group("radio", Radio)

    @cached_property
    def airspeed(self) -> AirspeedSensor | None:
        """See `AirspeedSensor`."""
        return self._group("airspeed", AirspeedSensor)

    @cached_property
    def servos(self) -> ServoOutputs | None:
        """See `ServoOutputs`."""
        return self._group("servos", ServoOutputs)

    @cached_property
    def rc(self) -> RcChannels | None:
        """See `RcChannels`."""
        return self._group("rc", RcChannels)

    @cached_property
    def system_time(self) -> SystemTime | None:
        """See `SystemTime`."""
        return self._group("system_time", SystemTime)

    @cached_property
    def fence(self) -> FenceStatus | None:
        """See `FenceStatus`."""
        return self._group("fence", FenceStatus)

    @cached_property
    def terrain(self) -> TerrainReport | None:
        """See `TerrainReport`."""
        return self._group("terrain", TerrainReport)

    @cached_property
    def engine(self) -> Engine | None:
        """See `Engine`."""
        return self._group("engine", Engine)

    # (end of what is written by a script)

    @cached_property
    def batteries(self) -> tuple[Battery, ...]:
        """The batteries heard so far, by id."""
        return tuple(Battery(**values) for values in self._native.group("batteries"))

    @cached_property
    def imus(self) -> tuple[Imu | None, Imu | None, Imu | None]:
        """Inertial sensors 1 to 3; `imu` is the first."""
        imus = self._native.group("imus")
        first, second, third = (None if values is None else Imu(**values) for values in imus)
        return (first, second, third)

    def groups(self) -> Iterator[tuple[str, Group]]:
        """The groups heard so far, by name."""
        for name in GROUPS:
            group = getattr(self, name, None)
            if isinstance(group, Group):
                yield name, group

    def to_dict(self) -> dict[str, Any]:
        """Plain dictionaries of everything heard so far, ready for JSON; 64-bit ids as their decimal digits."""
        values: dict[str, Any] = {name: asdict(group) for name, group in self.groups()}
        if (version := values.get("version")) is not None and version["uid"] is not None:
            version["uid"] = str(version["uid"])
        values["batteries"] = [asdict(battery) for battery in self.batteries]
        values["imus"] = [None if imu is None else asdict(imu) for imu in self.imus]
        return values

    def _group(self, name: str, kind: type[_G]) -> _G | None:
        values = self._native.group(name)
        if values is None:
            return None
        # All fields at once: a frozen class's own constructor sets one after another.
        group = object.__new__(kind)
        object.__setattr__(group, "__dict__", values)
        return group

    def __repr__(self) -> str:
        heard = ", ".join(name for name, _ in self.groups())
        return f"<Telemetry at {self.time_s:.3f} s: {heard or 'nothing heard yet'}>"
