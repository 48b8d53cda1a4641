"""The wind: a steady wind with a boundary layer near the ground, and seeded Dryden turbulence.

Gusts follow the low-altitude model of MIL-F-8785C (MIL-HDBK-1797): first- and second-order filters over white noise,
with lengths and intensities that depend on height. They are discretised as in R. W. Beard and T. W. McLain, *Small
Unmanned Aircraft*, 2012, section 4.4.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field

__all__ = ["Wind"]

_FT = 0.3048
_REFERENCE_M = 10.0
_BOUNDARY_EXPONENT = 1.0 / 7.0


@dataclass(slots=True)
class Wind:
    """Wind at the plane.

    Parameters
    ----------
    speed_m_s : float
        Steady speed at 10 m and above, m/s. Below 10 m it follows the 1/7 power law of a boundary layer over open
        ground.
    from_deg : float
        Direction it comes from, degrees true.
    gust_m_s : float
        Wind speed at 6 m that scales the turbulence (W20 of the standard), m/s; 0 is smooth air.
    seed : int
        Seed of the turbulence.
    """

    speed_m_s: float = 0.0
    from_deg: float = 0.0
    gust_m_s: float = 0.0
    seed: int = 0
    north_m_s: float = 0.0
    east_m_s: float = 0.0
    down_m_s: float = 0.0
    _random: random.Random = field(default_factory=random.Random)
    _u: float = 0.0
    _v: tuple[float, float] = (0.0, 0.0)
    _w: tuple[float, float] = (0.0, 0.0)
    _to_north: float = 0.0
    _to_east: float = 0.0

    def __post_init__(self) -> None:
        self._random = random.Random(f"wind {self.seed}")
        self._to_north = -self.speed_m_s * math.cos(math.radians(self.from_deg))
        self._to_east = -self.speed_m_s * math.sin(math.radians(self.from_deg))

    def blow(self, height_m: float, airspeed_m_s: float, heading_rad: float, dt_s: float) -> None:
        """Advance the wind at the plane, as velocities ``north_m_s``, ``east_m_s`` and ``down_m_s``."""
        factor = min(1.0, (max(height_m, 0.1) / _REFERENCE_M) ** _BOUNDARY_EXPONENT)
        self.north_m_s = self._to_north * factor
        self.east_m_s = self._to_east * factor
        self.down_m_s = 0.0
        if self.gust_m_s > 0.0:
            self._turbulence(height_m, airspeed_m_s, heading_rad, dt_s)

    def _turbulence(self, height_m: float, airspeed_m_s: float, heading_rad: float, dt_s: float) -> None:
        height_ft = min(max(height_m / _FT, 10.0), 1000.0)
        shape = 0.177 + 0.000823 * height_ft
        length_u = height_ft / shape**1.2 * _FT
        length_w = height_ft * _FT
        sigma_w = 0.1 * self.gust_m_s
        sigma_u = sigma_w / shape**0.4
        speed = max(airspeed_m_s, 3.0)
        gauss = self._random.gauss

        # u: first order, a = V / L.
        a = speed / length_u
        decay = math.exp(-a * dt_s)
        self._u = decay * self._u + sigma_u * math.sqrt(1.0 - decay * decay) * gauss(0.0, 1.0)
        self._v = _second_order(self._v, speed / length_u, dt_s, gauss(0.0, 1.0))
        self._w = _second_order(self._w, speed / length_w, dt_s, gauss(0.0, 1.0))
        along = self._u
        across = sigma_u * _shaped(self._v)
        cos, sin = math.cos(heading_rad), math.sin(heading_rad)
        self.north_m_s += along * cos - across * sin
        self.east_m_s += along * sin + across * cos
        self.down_m_s += sigma_w * _shaped(self._w)


def _second_order(state: tuple[float, float], a: float, dt_s: float, noise: float) -> tuple[float, float]:
    """Two equal lags in series over white noise, each of unit variance in the first stage."""
    decay = math.exp(-a * dt_s)
    first = decay * state[0] + math.sqrt(1.0 - decay * decay) * noise
    second = state[1] + (first - state[1]) * (1.0 - decay)
    return first, second


def _shaped(state: tuple[float, float]) -> float:
    """Output of sqrt(3) (s + a/sqrt(3)) / (s + a)² written with the two lags, scaled to unit variance.

    (√3 s + a)/(s + a)² = √3/(s + a) + a (1 − √3)/(s + a)²; with first = 1/(s+a) at unit variance the sum below
    has variance 3 + (1−√3)²/2 + √3 (1−√3) = 2, hence the √2.
    """
    first, second = state
    root = math.sqrt(3.0)
    return (root * first + (1.0 - root) * second) / math.sqrt(2.0)
