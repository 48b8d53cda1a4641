"""The flight dynamics: JSBSim flies the airframe; this file converts its feet and slugs to metres and kilograms.

It owns the true state, which sensors and the estimator read. It does not know the autopilot.
"""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import jsbsim

__all__ = ["AIRFRAME", "G_M_S2", "Dynamics"]

AIRFRAME = Path(__file__).parent / "airframe"
"""Folder of the aircraft and engine definitions."""

_FT = 0.3048
G_M_S2 = 9.80665
"""Standard gravity, ISO 80000-3."""
_RHO0 = 1.225
_SLUG_FT3 = 515.378819
_PSF = 47.880259
_GEAR_HEIGHT_M = 0.112
"""Height of the centre of gravity above flat ground while the plane stands on its wheels."""
_MOTOR_FULL_V = 16.8
_RATE_LIMIT_RAD_S = 100.0
"""A body rate that no flight reaches; beyond it the integration of an impact diverges."""


class Dynamics:
    """The true motion of one plane.

    Parameters
    ----------
    lat_deg, lon_deg : float
        Start position, degrees WGS-84.
    ground_amsl_m : float
        Elevation of the ground, the same everywhere, metres above mean sea level.
    heading_deg : float
        Start heading, degrees true.
    dt_s : float
        Step, seconds.

    Attributes
    ----------
    lat_deg, lon_deg, alt_amsl_m, height_m : float
        Position of the centre of gravity; ``height_m`` is 0 while the plane stands on its wheels.
    velocity_n_m_s, velocity_e_m_s, velocity_d_m_s : float
        Velocity over ground.
    roll_rad, pitch_rad, yaw_rad : float
        Attitude; yaw −π to π.
    p_rad_s, q_rad_s, r_rad_s : float
        Body rates.
    accel_x_m_s2, accel_y_m_s2, accel_z_m_s2 : float
        Specific force in body axes, as measured by an accelerometer.
    airspeed_m_s : float
        Equivalent airspeed along the pitot tube (0 from behind).
    tas_m_s : float
        True airspeed.
    density_kg_m3, pressure_pa, temperature_k : float
        Air around the plane.
    motor_a : float
        Current of the motor, amperes.
    on_wheels : bool
        True while a main wheel touches.
    """

    __slots__ = (
        "_exec",
        "_get",
        "_ground_amsl_m",
        "_held",
        "_run",
        "_set",
        "accel_x_m_s2",
        "accel_y_m_s2",
        "accel_z_m_s2",
        "airspeed_m_s",
        "alt_amsl_m",
        "density_kg_m3",
        "height_m",
        "lat_deg",
        "lon_deg",
        "motor_a",
        "on_wheels",
        "p_rad_s",
        "pitch_rad",
        "pressure_pa",
        "q_rad_s",
        "r_rad_s",
        "roll_rad",
        "tas_m_s",
        "temperature_k",
        "velocity_d_m_s",
        "velocity_e_m_s",
        "velocity_n_m_s",
        "yaw_rad",
    )

    def __init__(
        self, *, lat_deg: float, lon_deg: float, ground_amsl_m: float, heading_deg: float, dt_s: float
    ) -> None:
        self._exec = _quiet_exec()
        loaded = self._exec.load_model_with_paths(
            "bixler3", str(AIRFRAME / "aircraft"), str(AIRFRAME / "engine"), str(AIRFRAME / "systems")
        )
        if not loaded:
            raise RuntimeError(f"JSBSim could not read the airframe in {AIRFRAME}: is the package complete?")
        self._exec.set_dt(dt_s)
        self._ground_amsl_m = ground_amsl_m
        self._held = False
        # Access by property node costs a third of one by name.
        manager = self._exec.get_property_manager()

        def node(name: str) -> Any:
            return manager.get_node(name)

        self._get = tuple(
            node(name).get_double_value
            for name in (
                "position/lat-geod-deg",
                "position/long-gc-deg",
                "position/h-sl-ft",
                "velocities/v-north-fps",
                "velocities/v-east-fps",
                "velocities/v-down-fps",
                "attitude/phi-rad",
                "attitude/theta-rad",
                "attitude/psi-rad",
                "velocities/p-rad_sec",
                "velocities/q-rad_sec",
                "velocities/r-rad_sec",
                "accelerations/a-pilot-x-ft_sec2",
                "accelerations/a-pilot-y-ft_sec2",
                "accelerations/a-pilot-z-ft_sec2",
                "velocities/u-aero-fps",
                "velocities/vt-fps",
                "atmosphere/rho-slugs_ft3",
                "atmosphere/P-psf",
                "atmosphere/T-R",
                "propulsion/engine/current-amperes",
                "gear/unit[1]/WOW",
                "gear/unit[2]/WOW",
            )
        )
        self._set = tuple(
            node(name).set_double_value
            for name in (
                "fcs/aileron-cmd-norm",
                "fcs/elevator-cmd-norm",
                "fcs/rudder-cmd-norm",
                "fcs/steer-cmd-norm",
                "fcs/throttle-cmd-norm",
                "atmosphere/wind-north-fps",
                "atmosphere/wind-east-fps",
                "atmosphere/wind-down-fps",
            )
        )
        self._run = self._exec.run
        self.place(lat_deg, lon_deg, math.radians(heading_deg))

    def place(
        self,
        lat_deg: float,
        lon_deg: float,
        yaw_rad: float,
        *,
        height_m: float = 0.0,
        pitch_rad: float = 0.0,
        speed_m_s: float = 0.0,
        wind_ne_m_s: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Place the plane: on its wheels, or ``height_m`` above that, moving forward with ``speed_m_s``."""
        put = self._exec.set_property_value
        for value in self._set:
            value(0.0)
        put("atmosphere/wind-north-fps", wind_ne_m_s[0] / _FT)
        put("atmosphere/wind-east-fps", wind_ne_m_s[1] / _FT)
        put("ic/terrain-elevation-ft", self._ground_amsl_m / _FT)
        put("ic/lat-geod-deg", lat_deg)
        put("ic/long-gc-deg", lon_deg)
        put("ic/h-agl-ft", (_GEAR_HEIGHT_M + height_m) / _FT)
        put("ic/phi-rad", 0.0)
        put("ic/theta-rad", pitch_rad)
        put("ic/psi-true-rad", yaw_rad % math.tau)
        put("ic/vn-fps", speed_m_s * math.cos(pitch_rad) * math.cos(yaw_rad) / _FT)
        put("ic/ve-fps", speed_m_s * math.cos(pitch_rad) * math.sin(yaw_rad) / _FT)
        put("ic/vd-fps", -speed_m_s * math.sin(pitch_rad) / _FT)
        put("ic/p-rad_sec", 0.0)
        put("ic/q-rad_sec", 0.0)
        put("ic/r-rad_sec", 0.0)
        if not self._exec.run_ic():
            raise RuntimeError("JSBSim refused its initial conditions")
        self._exec.get_propulsion().init_running(-1)
        self._held = False
        self._read()

    def step(
        self,
        aileron: float,
        elevator: float,
        rudder: float,
        throttle: float,
        *,
        battery_v: float,
        wind_m_s: tuple[float, float, float],
    ) -> None:
        """Advance by one step with surfaces −1 to 1 (right, up, right), throttle 0 to 1 and the local wind.

        After an impact that the model cannot integrate, the plane stands on its wheels where it hit the ground.
        """
        if self._held:
            return
        set_aileron, set_elevator, set_rudder, set_steer, set_throttle, set_north, set_east, set_down = self._set
        set_aileron(aileron)
        set_elevator(elevator)
        set_rudder(rudder)
        set_steer(rudder)
        set_throttle(throttle * battery_v / _MOTOR_FULL_V)
        set_north(wind_m_s[0] / _FT)
        set_east(wind_m_s[1] / _FT)
        set_down(wind_m_s[2] / _FT)
        lat_deg, lon_deg, yaw_rad = self.lat_deg, self.lon_deg, self.yaw_rad
        self._run()
        self._read()
        if not math.hypot(self.p_rad_s, self.q_rad_s, self.r_rad_s) < _RATE_LIMIT_RAD_S:  # NaN included
            self.place(lat_deg, lon_deg, yaw_rad)

    def hold(
        self,
        attitude_rad: tuple[float, float, float],
        *,
        rates_rad_s: tuple[float, float, float],
        force_m_s2: tuple[float, float, float],
        lat_deg: float,
        lon_deg: float,
        height_m: float,
        velocity_ned_m_s: tuple[float, float, float],
        pressure_pa: float,
    ) -> None:
        """Hold the plane by hand: :mod:`vencejo.sim.hand` sets its state until it is placed."""
        self._held = True
        self.roll_rad, self.pitch_rad, self.yaw_rad = attitude_rad
        self.p_rad_s, self.q_rad_s, self.r_rad_s = rates_rad_s
        self.accel_x_m_s2, self.accel_y_m_s2, self.accel_z_m_s2 = force_m_s2
        self.lat_deg, self.lon_deg = lat_deg, lon_deg
        self.height_m = height_m
        self.alt_amsl_m = height_m + self._ground_amsl_m + _GEAR_HEIGHT_M
        self.velocity_n_m_s, self.velocity_e_m_s, self.velocity_d_m_s = velocity_ned_m_s
        self.pressure_pa = pressure_pa
        self.airspeed_m_s = self.tas_m_s = 0.0
        self.motor_a = 0.0
        self.on_wheels = False

    @property
    def held(self) -> bool:
        """True while the plane is held by hand."""
        return self._held

    @property
    def eas_to_tas(self) -> float:
        """True over equivalent airspeed, √(ρ₀/ρ)."""
        return math.sqrt(_RHO0 / self.density_kg_m3)

    def _read(self) -> None:
        get = self._get
        self.lat_deg = get[0]()
        self.lon_deg = get[1]()
        self.alt_amsl_m = get[2]() * _FT
        self.height_m = self.alt_amsl_m - self._ground_amsl_m - _GEAR_HEIGHT_M
        self.velocity_n_m_s = get[3]() * _FT
        self.velocity_e_m_s = get[4]() * _FT
        self.velocity_d_m_s = get[5]() * _FT
        self.roll_rad = get[6]()
        self.pitch_rad = get[7]()
        self.yaw_rad = _wrap(get[8]())
        self.p_rad_s = get[9]()
        self.q_rad_s = get[10]()
        self.r_rad_s = get[11]()
        self.accel_x_m_s2 = get[12]() * _FT
        self.accel_y_m_s2 = get[13]() * _FT
        self.accel_z_m_s2 = get[14]() * _FT
        forward = get[15]() * _FT
        self.tas_m_s = get[16]() * _FT
        density = get[17]() * _SLUG_FT3
        self.density_kg_m3 = density
        self.airspeed_m_s = max(0.0, forward) * math.sqrt(density / _RHO0)
        self.pressure_pa = get[18]() * _PSF
        self.temperature_k = get[19]() / 1.8
        self.motor_a = max(0.0, get[20]())
        self.on_wheels = get[21]() > 0.5 or get[22]() > 0.5


def _wrap(angle_rad: float) -> float:
    return (angle_rad + math.pi) % math.tau - math.pi


def _quiet_exec() -> Any:
    """An executive that does not write its banner to the terminal."""
    previous = os.environ.get("JSBSIM_DEBUG")
    os.environ["JSBSIM_DEBUG"] = "0"
    try:
        executive = jsbsim.FGFDMExec(None)
    finally:
        if previous is None:
            del os.environ["JSBSIM_DEBUG"]
        else:
            os.environ["JSBSIM_DEBUG"] = previous
    executive.set_debug_level(0)
    return executive
