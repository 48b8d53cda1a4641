"""The state of the plane as telemetry shows it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from . import boot
from .auto.mission import RunState
from .geo import EARTH_RADIUS_M, distance_m
from .interface import LandedState, MissionState, Mode, Snapshot, SystemState

if TYPE_CHECKING:
    from .loop import FlightLoop

__all__ = ["take"]


def take(plane: FlightLoop) -> Snapshot:
    """The present state of a plane."""
    est, body, sensors, tick = plane.est, plane.body, plane.sensors, plane._tick
    surfaces, demanded = plane._surfaces, plane.pilot.output
    gps = sensors.gps(body, math.floor(plane.time_s * 5.0) / 5.0)
    lat, lon = _believed_place(plane)
    alt_m = est.alt_m if plane.time_s >= boot.HEIGHT_S else est.alt_m - plane.config.home_alt_amsl_m
    yaw = est.yaw_rad if plane.time_s >= boot.MEASURED_S else 0.0
    nav = plane.nav
    airspeed_target = demanded.airspeed_demand_m_s
    here = plane.here()
    fix = plane.time_s >= boot.FIX_S
    fix_type, satellites = (gps.fix_type, gps.satellites) if fix else boot.gps_before_fix(plane.time_s)
    wind_n, wind_e = plane._wind_estimate
    target = None if plane.flight_mode in (Mode.MANUAL, Mode.INITIALISING) else nav.next
    target_lat_lon = (None, None) if target is None else plane.frame.to_earth(target.n_m, target.e_m)
    return Snapshot(
        time_s=plane.time_s,
        mode=plane.flight_mode,
        armed=plane.armed,
        system_state=_system_state(plane),
        landed_state=_landed_state(plane),
        is_flying=plane.is_flying,
        gcs_failsafe=plane.failsafes.station_is_lost,
        radio_lost=plane.failsafes.radio_lost,
        waits_for_radio=plane.failsafes.waits_for_radio,
        roll_rad=est.roll_rad,
        pitch_rad=est.pitch_rad,
        yaw_rad=yaw,
        roll_rate_rad_s=est.p_rad_s,
        pitch_rate_rad_s=est.q_rad_s,
        yaw_rate_rad_s=est.r_rad_s,
        lat_deg=lat,
        lon_deg=lon,
        alt_amsl_m=alt_m,
        alt_rel_home_m=plane.alt_rel_home_m,
        alt_agl_m=est.alt_m - plane.config.home_alt_amsl_m,
        north_m=est.n_m,
        east_m=est.e_m,
        down_m=plane.config.home_alt_amsl_m - est.alt_m,
        velocity_n_m_s=est.velocity_n_m_s,
        velocity_e_m_s=est.velocity_e_m_s,
        velocity_d_m_s=est.velocity_d_m_s,
        airspeed_m_s=est.airspeed_m_s,
        groundspeed_m_s=est.groundspeed_m_s,
        heading_deg=math.degrees(yaw) % 360.0,
        climb_m_s=-est.velocity_d_m_s,
        throttle_pct=round(100.0 * surfaces.throttle),
        home_lat_deg=plane._home_lat_lon[0],
        home_lon_deg=plane._home_lat_lon[1],
        home_alt_amsl_m=plane.home.alt_m,
        accel_m_s2=sensors.accel_m_s2(body, tick, surfaces.throttle),
        gyro_rad_s=sensors.gyro_rad_s(body, tick),
        mag_mgauss=sensors.mag_mgauss(body, tick),
        static_pressure_pa=sensors.static_pressure_pa(body, tick, plane.time_s),
        differential_pressure_pa=sensors.differential_pressure_pa(body, tick),
        temperature_c=sensors.temperature_c(body),
        gps_fix_type=fix_type,
        gps_satellites=satellites,
        gps_hdop=gps.hdop if fix else 100.0,
        gps_vdop=gps.vdop if fix else 100.0,
        gps_lat_deg=gps.lat_deg,
        gps_lon_deg=gps.lon_deg,
        gps_alt_amsl_m=gps.alt_amsl_m,
        gps_alt_ellipsoid_m=gps.alt_amsl_m + plane.config.geoid_m,
        gps_speed_m_s=gps.speed_m_s,
        gps_course_deg=gps.course_deg,
        wind_from_deg=math.degrees(math.atan2(-wind_e, -wind_n)) % 360.0,
        wind_speed_m_s=math.hypot(wind_n, wind_e),
        wind_down_m_s=0.0,
        battery_measured=plane.time_s >= boot.MEASURED_S,
        battery_voltage_v=plane.battery.voltage_v,
        battery_current_a=plane.battery.current_a,
        battery_consumed_mah=plane.battery.consumed_mah,
        battery_consumed_j=plane.battery.consumed_j,
        battery_remaining_pct=round(100.0 * plane.battery.remaining),
        battery_failsafe=int(plane.failsafes.battery),
        nav_roll_deg=math.degrees(demanded.bank_rad),
        nav_pitch_deg=math.degrees(demanded.pitch_rad),
        nav_bearing_deg=math.degrees(demanded.nav_bearing_rad),
        target_bearing_deg=math.degrees(demanded.target_bearing_rad),
        wp_distance_m=distance_m(here, nav.next),
        alt_error_m=nav.target_alt_m - est.alt_m if plane.mode.auto_throttle else 0.0,
        airspeed_error_m_s=airspeed_target - est.airspeed_m_s if airspeed_target > 0 else 0.0,
        xtrack_error_m=demanded.xtrack_error_m,
        target_lat_deg=target_lat_lon[0],
        target_lon_deg=target_lat_lon[1],
        target_alt_amsl_m=None if target is None else target.alt_m,
        servo_pwm_us=(
            round(1500 + 400 * surfaces.aileron),
            round(1500 + 400 * surfaces.elevator),
            round(1000 + 1000 * surfaces.throttle),
            round(1500 + 400 * surfaces.rudder),
            0,
            0,
            0,
            0,
        ),
        rc_pwm_us=plane.rc.pwm()[:8],
        mission_current=plane.mission.current_seq,
        mission_total=plane.mission.total,
        mission_state=_mission_state(plane),
        mission_in_landing=plane.mission.in_landing_sequence
        and not plane.mission.starts_with_takeoff(restart=plane.tune["MIS_RESTART"] == 1),
        origin_set=plane._origin_set,
        ekf_flags=boot.ekf_flags(plane.time_s),
        ekf_velocity_variance=0.02,
        ekf_pos_horiz_variance=0.03,
        ekf_pos_vert_variance=0.02,
        ekf_compass_variance=0.03,
        vibration_m_s2=sensors.vibration_m_s2(tick, surfaces.throttle),
    )


def _believed_place(plane: FlightLoop) -> tuple[float, float]:
    """Estimated latitude and longitude; before the first fix those of dead reckoning from 0, 0."""
    if plane.time_s >= boot.FIX_S:
        return plane.where()
    drift_deg = math.degrees(boot.drift_m(plane.time_s) / EARTH_RADIUS_M)
    return drift_deg * math.cos(plane.est.yaw_rad), drift_deg * math.sin(plane.est.yaw_rad)


def _system_state(plane: FlightLoop) -> SystemState:
    if plane.flight_mode is Mode.INITIALISING:
        return SystemState.CALIBRATING
    if plane.failsafes.is_on:
        return SystemState.CRITICAL
    return SystemState.ACTIVE if plane.is_flying else SystemState.STANDBY


def _landed_state(plane: FlightLoop) -> LandedState:
    if not plane.is_flying:
        return LandedState.ON_GROUND
    if plane._climbing_out():
        return LandedState.TAKEOFF
    if plane.landing.active:
        return LandedState.LANDING
    return LandedState.IN_AIR


def _mission_state(plane: FlightLoop) -> MissionState:
    if plane.mission.total == 0:
        return MissionState.NO_MISSION
    if plane.mission.state is RunState.COMPLETE:
        return MissionState.COMPLETE
    return MissionState.ACTIVE if plane.mission.state is RunState.RUNNING else MissionState.NOT_STARTED
