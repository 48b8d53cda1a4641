"""The sensors of the plane, from its true motion: inertial unit, magnetometer, barometer, airspeed and GPS.

Noise is a function of the seed and the simulated time alone, so that a reading does not depend on how often it is
taken. White noise comes from a fixed table; slow errors (drift of a barometer, wander of a GPS fix) are sums of
sines with periods and phases drawn from the seed. Levels are those of the parts on a small autopilot board:
MEMS inertial unit after the anti-alias filter, a MS5611-class barometer, an M8N-class GPS.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass

from .dynamics import Dynamics

__all__ = ["Errors", "GpsFix", "Sensors"]

_TABLE = 4096
_ACCEL_SIGMA_M_S2 = 0.06
_GYRO_SIGMA_RAD_S = 0.0015
_MAG_SIGMA_MGAUSS = 2.0
_BARO_SIGMA_PA = 1.2
_PITOT_SIGMA_PA = 1.5
_VIBRATION_M_S2 = 0.9
"""Added acceleration noise at full throttle: the motor shakes the foam."""


class _Wander:
    """A slow error: the sum of three sines, of a given standard deviation."""

    __slots__ = ("_terms",)

    def __init__(self, source: random.Random, sigma: float, period_s: float) -> None:
        amplitude = sigma * math.sqrt(2.0 / 3.0)
        self._terms = tuple(
            (amplitude, math.tau / (period_s * source.uniform(0.5, 2.0)), source.uniform(0.0, math.tau))
            for _ in range(3)
        )

    def at(self, time_s: float) -> float:
        (a, b, c), (d, e, f), (g, h, i) = self._terms
        return a * math.sin(b * time_s + c) + d * math.sin(e * time_s + f) + g * math.sin(h * time_s + i)


@dataclass(frozen=True, slots=True)
class Errors:
    """Errors of the estimator: of position, attitude and airspeed."""

    north_m: float
    east_m: float
    up_m: float
    roll_rad: float
    pitch_rad: float
    yaw_rad: float
    airspeed_m_s: float


@dataclass(frozen=True, slots=True)
class GpsFix:
    """One fix of the receiver."""

    fix_type: int
    satellites: int
    hdop: float
    vdop: float
    lat_deg: float
    lon_deg: float
    alt_amsl_m: float
    speed_m_s: float
    course_deg: float


class Sensors:
    """The sensors of one plane.

    Parameters
    ----------
    seed : int
        Seed of all noise.
    lat_deg, lon_deg : float
        Position, for the direction of the magnetic field.
    """

    def __init__(self, *, seed: int, lat_deg: float, lon_deg: float) -> None:
        source = random.Random(f"sensors {seed}")
        self._white = tuple(source.gauss(0.0, 1.0) for _ in range(_TABLE))
        self._field_ned_mgauss = _dipole_field_mgauss(lat_deg, lon_deg)
        self._gps = tuple(_Wander(source, sigma, 45.0) for sigma in (0.35, 0.35, 0.6))
        self._fused = tuple(_Wander(source, sigma, 60.0) for sigma in (0.2, 0.2, 0.12))
        self._attitude = tuple(_Wander(source, math.radians(sigma), 40.0) for sigma in (0.15, 0.15, 0.5))
        self._baro = _Wander(source, 4.0, 200.0)
        self._airspeed = _Wander(source, 0.1, 3.0)
        self._gyro_bias = tuple(source.gauss(0.0, 0.0008) for _ in range(3))

    def noise(self, tick: int, channel: int) -> float:
        """Standard normal noise of a channel at a step."""
        return self._white[(tick * 37 + channel * 911) % _TABLE]

    def errors(self, time_s: float) -> Errors:
        """Errors of the estimator at a time."""
        north, east, up = self._fused
        roll, pitch, yaw = self._attitude
        return Errors(
            north.at(time_s),
            east.at(time_s),
            up.at(time_s),
            roll.at(time_s),
            pitch.at(time_s),
            yaw.at(time_s),
            self._airspeed.at(time_s),
        )

    def accel_m_s2(self, body: Dynamics, tick: int, throttle: float) -> tuple[float, float, float]:
        """Accelerometer."""
        sigma = _ACCEL_SIGMA_M_S2 + _VIBRATION_M_S2 * throttle * throttle * 0.4
        return (
            body.accel_x_m_s2 + sigma * self.noise(tick, 0),
            body.accel_y_m_s2 + sigma * self.noise(tick, 1),
            body.accel_z_m_s2 + sigma * self.noise(tick, 2),
        )

    def vibration_m_s2(self, tick: int, throttle: float) -> tuple[float, float, float]:
        """Vibration levels as the autopilot reports them."""
        level = 0.02 + _VIBRATION_M_S2 * throttle * throttle
        return tuple(level * (1.0 + 0.1 * self.noise(tick, 20 + axis)) for axis in range(3))  # type: ignore[return-value]

    def gyro_rad_s(self, body: Dynamics, tick: int) -> tuple[float, float, float]:
        """Rate gyroscope."""
        sigma = _GYRO_SIGMA_RAD_S
        bias_p, bias_q, bias_r = self._gyro_bias
        return (
            body.p_rad_s + bias_p + sigma * self.noise(tick, 3),
            body.q_rad_s + bias_q + sigma * self.noise(tick, 4),
            body.r_rad_s + bias_r + sigma * self.noise(tick, 5),
        )

    def mag_mgauss(self, body: Dynamics, tick: int) -> tuple[float, float, float]:
        """Magnetometer in body axes."""
        north, east, down = self._field_ned_mgauss
        sin_r, cos_r = math.sin(body.roll_rad), math.cos(body.roll_rad)
        sin_p, cos_p = math.sin(body.pitch_rad), math.cos(body.pitch_rad)
        sin_y, cos_y = math.sin(body.yaw_rad), math.cos(body.yaw_rad)
        ahead = north * cos_y + east * sin_y
        right = -north * sin_y + east * cos_y
        x = ahead * cos_p - down * sin_p
        lower = ahead * sin_p + down * cos_p
        sigma = _MAG_SIGMA_MGAUSS
        return (
            x + sigma * self.noise(tick, 6),
            right * cos_r + lower * sin_r + sigma * self.noise(tick, 7),
            -right * sin_r + lower * cos_r + sigma * self.noise(tick, 8),
        )

    def static_pressure_pa(self, body: Dynamics, tick: int, time_s: float) -> float:
        """Barometer."""
        return float(body.pressure_pa) + self._baro.at(time_s) + _BARO_SIGMA_PA * self.noise(tick, 9)

    def differential_pressure_pa(self, body: Dynamics, tick: int) -> float:
        """Pitot tube: ½ ρ₀ V² of the equivalent airspeed."""
        return 0.5 * 1.225 * body.airspeed_m_s**2 + _PITOT_SIGMA_PA * self.noise(tick, 10)

    def temperature_c(self, body: Dynamics) -> float:
        """Board temperature: 12 K above the air, as of an enclosed board."""
        return float(body.temperature_k) - 273.15 + 12.0

    def gps(self, body: Dynamics, time_s: float) -> GpsFix:
        """Receiver at 5 Hz resolution of its slow error."""
        north, east, up = (wander.at(time_s) for wander in self._gps)
        speed = math.hypot(body.velocity_n_m_s, body.velocity_e_m_s)
        course = math.degrees(math.atan2(body.velocity_e_m_s, body.velocity_n_m_s)) % 360.0
        return GpsFix(
            fix_type=6,
            satellites=10,
            hdop=1.21,
            vdop=2.0,
            lat_deg=body.lat_deg + north / 111_132.0,
            lon_deg=body.lon_deg + east / (111_320.0 * max(0.01, math.cos(math.radians(body.lat_deg)))),
            alt_amsl_m=body.alt_amsl_m + up,
            speed_m_s=speed,
            course_deg=course,
        )


def _dipole_field_mgauss(lat_deg: float, lon_deg: float) -> tuple[float, float, float]:
    """Earth's field, north-east-down, from the dipole terms of the IGRF (13th generation, 2025).

    Within a few degrees and 15 % of the full model: enough for a compass that only has to be consistent.
    """
    g10, g11, h11 = -29_351.0, -1_410.0, 4_545.0
    colatitude, lon = math.radians(90.0 - lat_deg), math.radians(lon_deg)
    equatorial = g11 * math.cos(lon) + h11 * math.sin(lon)
    radial = 2.0 * (g10 * math.cos(colatitude) + equatorial * math.sin(colatitude))
    southward = g10 * math.sin(colatitude) - equatorial * math.cos(colatitude)
    eastward = g11 * math.sin(lon) - h11 * math.cos(lon)
    # nanotesla to milligauss
    return -southward / 100.0, eastward / 100.0, -radial / 100.0
