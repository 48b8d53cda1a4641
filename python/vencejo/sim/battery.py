"""The flight battery: its voltage by charge and current, and the consumption counted by its monitor.

A four-cell lithium-polymer pack. The open-circuit curve is the usual one of the chemistry at rest; the internal
resistance is that of a 25 C pack of this size in good order.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass

__all__ = ["AVIONICS_A", "CELLS", "Battery"]

CELLS = 4
AVIONICS_A = 0.45
"""Autopilot, radio, receiver and idle servos, amperes."""

_SOC = (0.0, 0.05, 0.10, 0.20, 0.30, 0.40, 0.50, 0.60, 0.70, 0.80, 0.90, 1.0)
_CELL_V = (3.20, 3.50, 3.62, 3.70, 3.74, 3.77, 3.81, 3.87, 3.94, 4.02, 4.10, 4.20)
_CELL_OHM = 0.006


@dataclass(slots=True)
class Battery:
    """State of the pack.

    Parameters
    ----------
    capacity_mah : float
        Charge when full, mAh, above 0.
    consumed_mah, consumed_j : float
        Consumption counted by the monitor since it was switched on.
    missing_mah : float
        Charge drawn before that.
    """

    capacity_mah: float = 3300.0
    consumed_mah: float = 0.0
    consumed_j: float = 0.0
    missing_mah: float = 0.0
    current_a: float = AVIONICS_A
    voltage_v: float = CELLS * _CELL_V[-1]

    @property
    def remaining(self) -> float:
        """Remaining charge by the monitor, 0 to 1; the monitor assumes a full pack when it is switched on."""
        return self._left(self.consumed_mah)

    @property
    def resting_v(self) -> float:
        """Voltage without the sag of the present current."""
        return self.voltage_v + self.current_a * CELLS * _CELL_OHM

    def _left(self, drawn_mah: float) -> float:
        return min(1.0, max(0.0, 1.0 - drawn_mah / max(1.0, self.capacity_mah)))

    def restart(self) -> None:
        """Restart the monitor, which counts from 0."""
        self.missing_mah += self.consumed_mah
        self.consumed_mah = self.consumed_j = 0.0

    def draw(self, motor_a: float, dt_s: float) -> None:
        """Draw the motor's current and the avionics' for ``dt_s`` seconds."""
        current = max(0.0, motor_a) + AVIONICS_A
        soc = self._left(self.missing_mah + self.consumed_mah)
        upper = min(len(_SOC) - 1, max(1, bisect_right(_SOC, soc)))
        low, high = _SOC[upper - 1], _SOC[upper]
        part = (soc - low) / (high - low)
        open_v = CELLS * (_CELL_V[upper - 1] + part * (_CELL_V[upper] - _CELL_V[upper - 1]))
        self.current_a = current
        # The voltage settles within a second of a step in current: surface charge, and the filter of a power module.
        target = max(6.0, open_v - current * CELLS * _CELL_OHM)
        self.voltage_v += (target - self.voltage_v) * min(1.0, dt_s / 0.3)
        self.consumed_mah += current * dt_s / 3.6
        self.consumed_j += current * self.voltage_v * dt_s
