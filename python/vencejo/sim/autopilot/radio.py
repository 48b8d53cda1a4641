"""The radio: the channels of the pilot's transmitter, and overrides by a ground station."""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["Radio"]

_IDLE_US = (1500, 1500, 1000, 1500, 1800, 1000, 1000, 1800, 0, 0, 0, 0, 0, 0, 0, 0)
"""Sticks centred, throttle down."""
_FAILED_THROTTLE_US = 950
"""Throttle output of a receiver without signal, configured as ArduPlane recommends."""
_DEAD_ZONE_US = 30
_LOW_US, _HIGH_US = 800, 2200
_THROTTLE = 3


class Radio:
    """Sixteen channels, microseconds."""

    __slots__ = ("_overrides", "failure", "is_believed")

    def __init__(self) -> None:
        self._overrides: dict[int, int] = {}
        self.failure = 0
        """As SIM_RC_FAIL: 0 none, 1 no frames arrive, 2 the throttle drops to 950 µs."""
        self.is_believed = True
        """False while the autopilot assumes centred sticks and closed throttle, whatever arrives."""

    def override(self, channels: Mapping[int, int | None]) -> None:
        """Set channels by number (1 to 16), 800 to 2200 µs, others are ignored; None returns one to the transmitter."""
        for number, value in channels.items():
            if not 1 <= number <= len(_IDLE_US):
                continue
            if value is None:
                self._overrides.pop(number, None)
            elif _LOW_US <= value <= _HIGH_US:
                self._overrides[number] = value

    def clear(self) -> None:
        """Remove all overrides."""
        self._overrides.clear()

    @property
    def is_heard(self) -> bool:
        """Whether channels arrive, from the transmitter or from a ground station."""
        return self.failure != 1 or bool(self._overrides)

    def _us(self, number: int) -> int:
        value = self._overrides.get(number)
        if value is not None:
            return value
        return _FAILED_THROTTLE_US if self.failure == 2 and number == _THROTTLE else _IDLE_US[number - 1]

    @property
    def throttle_us(self) -> int:
        """The throttle channel."""
        return self._us(_THROTTLE)

    def stick(self, number: int) -> float:
        """Deflection of a centred stick, −1 to 1, zero within its dead zone."""
        offset = self._us(number) - 1500
        if not self.is_believed or abs(offset) <= _DEAD_ZONE_US:
            return 0.0
        offset -= _DEAD_ZONE_US if offset > 0 else -_DEAD_ZONE_US
        return max(-1.0, min(1.0, offset / (500.0 - _DEAD_ZONE_US)))

    def throttle(self) -> float:
        """The throttle stick, 0 to 1."""
        if not self.is_believed:
            return 0.0
        return max(0.0, min(1.0, (self.throttle_us - 1000 - _DEAD_ZONE_US) / (1000.0 - _DEAD_ZONE_US)))

    def pwm(self) -> tuple[int, ...]:
        """All channels."""
        return tuple(self._us(number) for number in range(1, len(_IDLE_US) + 1))
