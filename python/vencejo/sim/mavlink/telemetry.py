"""Builds telemetry messages from the autopilot's snapshot, field by field as in recordings of ArduPlane.

There is one builder per message; it returns None while ArduPlane would not send that message (no navigation in MANUAL,
no position before the estimator has one). The model is tests/fixtures/captures/arduplane-50hz-20s.mavlink and the
recorded flights in that folder. Units are those of the message definitions, https://mavlink.io/en/messages/common.html
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from vencejo.sim.autopilot.interface import BY_STICK, EkfFlag, Mode, Snapshot
from vencejo.sim.fence import FenceStatus
from vencejo.sim.mavlink.codec import MavMessage, dialect

__all__ = ["BANNER", "BUILDERS", "TelemetryContext", "build"]

BANNER = ("ArduPlane V4.8.0-dev (vencejo-sim)", "Vencejo simulated plane")
"""The banner: an ArduPlane to a station, recognisable as a simulation to a reader."""

_G_M_S2 = 9.80665
_EARTH_RADIUS_M = 6_378_100.0
"""Radius of ArduPilot's sphere."""
_U16_MAX = 65535
_GPS_INTERVAL_MS = 200
_FLIGHT_VERSION = 4 << 24 | 8 << 16
_CAPABILITIES = 62319
"""Mission float and int, parameters float, COMMAND_INT, MAVFTP, fence, rally, terrain, set position… as recorded."""

_SENSOR = {
    "gyro": 1 << 0,
    "accel": 1 << 1,
    "mag": 1 << 2,
    "pressure": 1 << 3,
    "airspeed": 1 << 4,
    "gps": 1 << 5,
    "rate_control": 1 << 10,
    "attitude_control": 1 << 11,
    "yaw_control": 1 << 12,
    "z_control": 1 << 13,
    "xy_control": 1 << 14,
    "motors": 1 << 15,
    "radio": 1 << 16,
    "geofence": 1 << 20,
    "ahrs": 1 << 21,
    "terrain": 1 << 22,
    "logging": 1 << 24,
    "battery": 1 << 25,
    "prearm": 1 << 28,
}
"""Bits of MAV_SYS_STATUS_SENSOR in use."""


def _bits(*names: str) -> int:
    return sum(_SENSOR[name] for name in names)


_BASE = _bits("gyro", "accel", "mag", "pressure", "airspeed", "motors", "radio", "battery")
_CONTROL = _bits("rate_control", "attitude_control", "yaw_control", "z_control", "xy_control")
_PRESENT = _BASE | _CONTROL | _bits("gps", "ahrs", "terrain", "logging", "prearm")


@dataclass(slots=True)
class TelemetryContext:
    """Telemetry data that is not in the autopilot's snapshot."""

    unix_us_at_boot: int
    stick_mixing: bool
    rc_rssi: int
    fence_enabled: bool
    fence_present: bool
    fence: FenceStatus
    prearm_ok: bool
    home_set: bool
    system_id: int = 1
    """Distinguishes the planes of one simulator by their hardware id (AUTOPILOT_VERSION ``uid2``)."""
    terrain: Callable[[float, float], MavMessage] | None = None
    """Builds TERRAIN_REPORT for a position; None without terrain data."""


def _clamp(value: float, low: int, high: int) -> int:
    if value != value:  # A NaN of a failed simulation must not stop telemetry.
        return 0
    return int(min(max(value, low), high))


def _finite(value: float) -> float:
    """The value, or 0 when it is not finite."""
    return value if math.isfinite(value) else 0.0


def _round(value: float) -> float:
    """Nearest integer; non-finite values are left to :func:`_clamp`."""
    return round(value) if math.isfinite(value) else value


def _i16(value: float) -> int:
    return _clamp(value, -32768, 32767)


def _u16(value: float) -> int:
    return _clamp(value, 0, _U16_MAX)


def _i32(value: float) -> int:
    return _clamp(value, -2147483648, 2147483647)


def _deg_e7(degrees: float) -> int:
    return _i32(_round(degrees * 1e7))


def _ms(s: Snapshot) -> int:
    return round(s.time_s * 1000.0)


def _us(s: Snapshot) -> int:
    return round(s.time_s * 1e6)


def base_mode(s: Snapshot, *, stick_mixing: bool) -> int:
    """HEARTBEAT.base_mode: bits of MAV_MODE_FLAG."""
    bits = 1  # custom mode
    if s.mode is Mode.INITIALISING:
        return bits | 16  # as recorded
    if s.mode is Mode.MANUAL:
        bits |= 64
    else:
        bits |= 16
        if s.mode not in BY_STICK:
            bits |= 8
    if s.mode is Mode.MANUAL:
        bits |= 16  # as recorded
    if stick_mixing:
        bits |= 64
    if s.armed:
        bits |= 128
    return bits


def _heartbeat(s: Snapshot, c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_heartbeat_message(
        dialect.MAV_TYPE_FIXED_WING,
        dialect.MAV_AUTOPILOT_ARDUPILOTMEGA,
        base_mode(s, stick_mixing=c.stick_mixing),
        int(s.mode),
        int(s.system_state),
        3,
    )


def _sys_status(s: Snapshot, c: TelemetryContext) -> MavMessage:
    gps = s.gps_fix_type >= 3
    present = _PRESENT | (_SENSOR["geofence"] if c.fence_present else 0)
    enabled = _BASE | _bits("ahrs", "terrain", "prearm") | (_SENSOR["gps"] if gps else 0)
    health = _BASE | _bits("geofence", "ahrs", "logging") | (_SENSOR["gps"] if gps else 0)
    if not s.battery_measured or s.battery_failsafe:
        health &= ~_SENSOR["battery"]
    if s.radio_lost:
        health &= ~_SENSOR["radio"]
    if s.armed:
        enabled |= _CONTROL | _SENSOR["logging"]
        health |= _CONTROL
    if c.fence_enabled:
        enabled |= _SENSOR["geofence"]
        if c.fence.breached:
            health &= ~_SENSOR["geofence"]
    if c.prearm_ok or s.armed:
        health |= _SENSOR["prearm"]
    return dialect.MAVLink_sys_status_message(
        present,
        enabled,
        health,
        0,
        *_battery(s),
        0,
        0,
        0,
        0,
        0,
        0,
    )


def _battery(s: Snapshot) -> tuple[int, int, int]:
    """Millivolts, centiamperes and percent; 0, −1 and −1 before the first reading, as in ArduPlane."""
    if not s.battery_measured:
        return 0, -1, -1
    return (
        _u16(s.battery_voltage_v * 1000.0),
        _i16(s.battery_current_a * 100.0),
        _clamp(s.battery_remaining_pct, 0, 100),
    )


def _system_time(s: Snapshot, c: TelemetryContext) -> MavMessage:
    unix_us = c.unix_us_at_boot + _us(s) if s.gps_fix_type >= 3 else 0
    return dialect.MAVLink_system_time_message(unix_us, _ms(s))


def _gps_raw_int(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    if s.gps_fix_type < 2:
        return dialect.MAVLink_gps_raw_int_message(
            0, s.gps_fix_type, 0, 0, 0, _U16_MAX, _U16_MAX, 0, 0, s.gps_satellites
        )
    sampled_ms = _ms(s) // _GPS_INTERVAL_MS * _GPS_INTERVAL_MS
    return dialect.MAVLink_gps_raw_int_message(
        sampled_ms * 1000,
        s.gps_fix_type,
        _deg_e7(s.gps_lat_deg),
        _deg_e7(s.gps_lon_deg),
        _i32(s.gps_alt_amsl_m * 1000.0),
        _u16(s.gps_hdop * 100.0),
        _u16(s.gps_vdop * 100.0),
        _u16(s.gps_speed_m_s * 100.0),
        _u16(_finite(s.gps_course_deg) % 360.0 * 100.0),
        _clamp(s.gps_satellites, 0, 254),
        _i32(s.gps_alt_ellipsoid_m * 1000.0),
        300,
        300,
        0,
        0,
    )


def _imu(s: Snapshot) -> tuple[int, ...]:
    accel = (_i16(value / _G_M_S2 * 1000.0) for value in s.accel_m_s2)
    gyro = (_i16(value * 1000.0) for value in s.gyro_rad_s)
    return (*accel, *gyro, *(_i16(value) for value in s.mag_mgauss))


def _raw_imu(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_raw_imu_message(_us(s), *_imu(s), 0, _i16(s.temperature_c * 100.0))


def _scaled_imu2(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_scaled_imu2_message(_ms(s), *_imu(s), _i16(s.temperature_c * 100.0))


def _scaled_imu3(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    mag = (_i16(value) for value in s.mag_mgauss)
    return dialect.MAVLink_scaled_imu3_message(_ms(s), 0, 0, 0, 0, 0, 0, *mag, 0)


def _scaled_pressure(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_scaled_pressure_message(
        _ms(s), s.static_pressure_pa / 100.0, s.differential_pressure_pa / 100.0, _i16(s.temperature_c * 100.0), 0
    )


def _scaled_pressure2(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_scaled_pressure2_message(
        _ms(s), s.static_pressure_pa / 100.0, 0.0, _i16(s.temperature_c * 100.0), 0
    )


def _attitude(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_attitude_message(
        _ms(s), s.roll_rad, s.pitch_rad, s.yaw_rad, s.roll_rate_rad_s, s.pitch_rate_rad_s, s.yaw_rate_rad_s
    )


def _attitude_quaternion(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    # Z-Y-X Euler angles to a quaternion, e.g. Diebel 2006, eq. 290.
    roll, pitch, yaw = (_finite(angle) / 2 for angle in (s.roll_rad, s.pitch_rad, s.yaw_rad))
    cr, sr = math.cos(roll), math.sin(roll)
    cp, sp = math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    return dialect.MAVLink_attitude_quaternion_message(
        _ms(s),
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        s.roll_rate_rad_s,
        s.pitch_rate_rad_s,
        s.yaw_rate_rad_s,
    )


def _global_position_int(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_global_position_int_message(
        _ms(s),
        _deg_e7(s.lat_deg),
        _deg_e7(s.lon_deg),
        _i32(_round(s.alt_amsl_m * 100.0) * 10),
        _i32(s.alt_rel_home_m * 1000.0),
        _i16(s.velocity_n_m_s * 100.0),
        _i16(s.velocity_e_m_s * 100.0),
        _i16(s.velocity_d_m_s * 100.0),
        _u16(_round(_finite(s.heading_deg) * 100.0) % 36000),
    )


def _local_position_ned(s: Snapshot, _c: TelemetryContext) -> MavMessage | None:
    if not s.ekf_flags & (EkfFlag.POS_HORIZ_ABS | EkfFlag.POS_HORIZ_REL):
        return None
    return dialect.MAVLink_local_position_ned_message(
        _ms(s), s.north_m, s.east_m, s.down_m, s.velocity_n_m_s, s.velocity_e_m_s, s.velocity_d_m_s
    )


def _servo_output_raw(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    pwm = [_u16(value) for value in s.servo_pwm_us[:16]]
    pwm += [0] * (16 - len(pwm))
    return dialect.MAVLink_servo_output_raw_message(_us(s) & 0xFFFFFFFF, 0, *pwm)


def _rc_channels(s: Snapshot, c: TelemetryContext) -> MavMessage:
    pwm = [_u16(value) for value in s.rc_pwm_us[:18]]
    count = len(pwm)
    pwm += [0] * (18 - count)
    return dialect.MAVLink_rc_channels_message(_ms(s), count, *pwm, c.rc_rssi)


def _vfr_hud(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_vfr_hud_message(
        s.airspeed_m_s,
        s.groundspeed_m_s,
        _i16(_finite(s.heading_deg) % 360.0),
        _u16(abs(s.throttle_pct)),
        s.alt_amsl_m,
        s.climb_m_s,
    )


def _mission_current(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_mission_current_message(
        _u16(s.mission_current), _u16(s.mission_total), int(s.mission_state), 1 if s.mode is Mode.AUTO else 0
    )


def _nav_controller_output(s: Snapshot, _c: TelemetryContext) -> MavMessage | None:
    if s.mode is Mode.MANUAL:
        return None
    return dialect.MAVLink_nav_controller_output_message(
        s.nav_roll_deg,
        s.nav_pitch_deg,
        _i16(s.nav_bearing_deg),
        _i16(s.target_bearing_deg),
        _u16(s.wp_distance_m),
        s.alt_error_m,
        s.airspeed_error_m_s * 100.0,  # ArduPlane sends cm/s here
        s.xtrack_error_m,
    )


def _position_target_global_int(s: Snapshot, _c: TelemetryContext) -> MavMessage | None:
    if s.target_lat_deg is None or s.target_lon_deg is None:
        return None
    return dialect.MAVLink_position_target_global_int_message(
        _ms(s),
        dialect.MAV_FRAME_GLOBAL,
        65016,  # only the position counts
        _deg_e7(s.target_lat_deg),
        _deg_e7(s.target_lon_deg),
        s.target_alt_amsl_m or 0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    )


def _power_status(_s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_power_status_message(5000, 0, 0)


def _meminfo(_s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_meminfo_message(0, 65535, 524288)


_CHARGE_STATES = (
    dialect.MAV_BATTERY_CHARGE_STATE_OK,
    dialect.MAV_BATTERY_CHARGE_STATE_LOW,
    dialect.MAV_BATTERY_CHARGE_STATE_CRITICAL,
)
"""MAV_BATTERY_CHARGE_STATE, by the threshold crossed."""


def _battery_status(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    millivolts, centiamperes, percent = _battery(s)
    return dialect.MAVLink_battery_status_message(
        0,
        0,
        0,
        32767,
        [millivolts if s.battery_measured else _U16_MAX] + [_U16_MAX] * 9,
        max(0, centiamperes),
        _i32(s.battery_consumed_mah),
        _i32(s.battery_consumed_j / 100.0),
        percent,
        0,
        _CHARGE_STATES[s.battery_failsafe] if s.battery_measured else dialect.MAV_BATTERY_CHARGE_STATE_UNHEALTHY,
    )


def _home_ned(s: Snapshot) -> tuple[float, float, float]:
    """Home relative to the estimator's origin; NaN without one."""
    if not s.ekf_flags & EkfFlag.POS_HORIZ_ABS:
        return math.nan, math.nan, math.nan
    north_m = s.north_m + math.radians(s.home_lat_deg - s.lat_deg) * _EARTH_RADIUS_M
    circle_m = _EARTH_RADIUS_M * math.cos(math.radians(_finite(s.home_lat_deg)))
    east_m = s.east_m + math.radians(s.home_lon_deg - s.lon_deg) * circle_m
    return north_m, east_m, s.alt_amsl_m - s.home_alt_amsl_m + s.down_m


def _home_position(s: Snapshot, c: TelemetryContext) -> MavMessage | None:
    if not c.home_set:
        return None
    nan = math.nan
    return dialect.MAVLink_home_position_message(
        _deg_e7(s.home_lat_deg),
        _deg_e7(s.home_lon_deg),
        _i32(_round(s.home_alt_amsl_m * 100.0) * 10),
        *_home_ned(s),
        [nan, nan, nan, nan],
        0.0,
        0.0,
        0.0,
        _us(s),
    )


def _gps_global_origin(s: Snapshot, _c: TelemetryContext) -> MavMessage | None:
    if not s.origin_set:
        return None
    lat_deg = s.lat_deg - math.degrees(s.north_m / _EARTH_RADIUS_M)
    circle_m = _EARTH_RADIUS_M * math.cos(math.radians(_finite(s.lat_deg)))
    return dialect.MAVLink_gps_global_origin_message(
        _deg_e7(lat_deg),
        _deg_e7(s.lon_deg - math.degrees(s.east_m / circle_m)),
        _i32((s.alt_amsl_m + s.down_m) * 1000.0),
        _us(s),
    )


def _extended_sys_state(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_extended_sys_state_message(0, int(s.landed_state))


def _ekf_status_report(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_ekf_status_report_message(
        _u16(s.ekf_flags),
        s.ekf_velocity_variance,
        s.ekf_pos_horiz_variance,
        s.ekf_pos_vert_variance,
        s.ekf_compass_variance,
        0.0,
        0.0,
    )


def _vibration(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_vibration_message(_us(s), *s.vibration_m_s2, 0, 0, 0)


def _wind(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    direction = (s.wind_from_deg + 180.0) % 360.0 - 180.0
    return dialect.MAVLink_wind_message(direction, s.wind_speed_m_s, s.wind_down_m_s)


def _ahrs(_s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_ahrs_message(0.0, 0.0, 0.0, 0.0, 0.0, 0.002, 0.001)


def _ahrs2(s: Snapshot, _c: TelemetryContext) -> MavMessage | None:
    if s.ekf_flags & EkfFlag.UNINITIALIZED:
        return None
    return dialect.MAVLink_ahrs2_message(
        s.roll_rad, s.pitch_rad, s.yaw_rad, s.alt_amsl_m, _deg_e7(s.lat_deg), _deg_e7(s.lon_deg)
    )


def _simstate(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_simstate_message(
        s.roll_rad,
        s.pitch_rad,
        s.yaw_rad,
        *s.accel_m_s2,
        *s.gyro_rad_s,
        _deg_e7(s.gps_lat_deg),  # the true position, with or without a fix
        _deg_e7(s.gps_lon_deg),
    )


def _aoa_ssa(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_aoa_ssa_message(_us(s), 0.0, 0.0)


def _airspeed(s: Snapshot, _c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_airspeed_message(0, s.airspeed_m_s, 32767, s.differential_pressure_pa, 2)


def _terrain_report(s: Snapshot, c: TelemetryContext) -> MavMessage:
    if c.terrain is not None:
        return c.terrain(s.lat_deg, s.lon_deg)
    return dialect.MAVLink_terrain_report_message(_deg_e7(s.lat_deg), _deg_e7(s.lon_deg), 0, 0.0, s.alt_amsl_m, 0, 0)


def _fence_status(_s: Snapshot, c: TelemetryContext) -> MavMessage | None:
    if not c.fence_enabled:
        return None
    return dialect.MAVLink_fence_status_message(
        int(c.fence.breached), _u16(c.fence.count), c.fence.kind, round(c.fence.time_s * 1000.0), 0
    )


def _autopilot_version(_s: Snapshot, c: TelemetryContext) -> MavMessage:
    return dialect.MAVLink_autopilot_version_message(
        _CAPABILITIES,
        _FLIGHT_VERSION,
        0,
        0,
        0,
        list(b"vencejo\0"),
        [0] * 8,
        [0] * 8,
        0,
        0,
        0,
        list(f"vencejo-sim-{c.system_id}".encode().ljust(18, b"\0")),
    )


Builder = Callable[[Snapshot, TelemetryContext], "MavMessage | None"]

BUILDERS: dict[int, Builder] = {
    0: _heartbeat,
    1: _sys_status,
    2: _system_time,
    24: _gps_raw_int,
    27: _raw_imu,
    29: _scaled_pressure,
    30: _attitude,
    31: _attitude_quaternion,
    32: _local_position_ned,
    33: _global_position_int,
    36: _servo_output_raw,
    42: _mission_current,
    49: _gps_global_origin,
    62: _nav_controller_output,
    65: _rc_channels,
    74: _vfr_hud,
    87: _position_target_global_int,
    116: _scaled_imu2,
    125: _power_status,
    129: _scaled_imu3,
    136: _terrain_report,
    137: _scaled_pressure2,
    147: _battery_status,
    148: _autopilot_version,
    152: _meminfo,
    162: _fence_status,
    163: _ahrs,
    164: _simstate,
    168: _wind,
    178: _ahrs2,
    193: _ekf_status_report,
    241: _vibration,
    242: _home_position,
    245: _extended_sys_state,
    295: _airspeed,
    11020: _aoa_ssa,
}
"""Every message that can be streamed or requested."""


def build(message_id: int, snapshot: Snapshot, context: TelemetryContext) -> MavMessage | None:
    """Build a message from a snapshot; None when ArduPlane would not send it now."""
    builder = BUILDERS.get(message_id)
    return None if builder is None else builder(snapshot, context)
