"""The radio: channels as a transmitter in the pilot's hand gives them, and overrides from a ground station."""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["Radio"]

_IDLE_US = (1500, 1500, 1000, 1500, 1800, 1000, 1000, 1800, 0, 0, 0, 0, 0, 0, 0, 0)
"""Sticks centred, throttle down."""
_DEAD_ZONE_US = 30
_LOW_US, _HIGH_US = 800, 2200


class Radio:
    """Sixteen channels, microseconds."""

    __slots__ = ("_channels",)

    def __init__(self) -> None:
        self._channels = list(_IDLE_US)

    def override(self, channels: Mapping[int, int | None]) -> None:
        """Set channels by number (1 to 16); None gives one back to the transmitter. Values no servo knows are ignored."""
        for number, value in channels.items():
            if not 1 <= number <= len(_IDLE_US):
                continue
            if value is None:
                self._channels[number - 1] = _IDLE_US[number - 1]
            elif _LOW_US <= value <= _HIGH_US:
                self._channels[number - 1] = value

    def clear(self) -> None:
        """Everything back to the transmitter."""
        self._channels[:] = _IDLE_US

    def stick(self, number: int) -> float:
        """Deflection of a centred stick, −1 to 1, with its dead zone."""
        offset = self._channels[number - 1] - 1500
        if abs(offset) <= _DEAD_ZONE_US:
            return 0.0
        offset -= _DEAD_ZONE_US if offset > 0 else -_DEAD_ZONE_US
        return max(-1.0, min(1.0, offset / (500.0 - _DEAD_ZONE_US)))

    def throttle(self) -> float:
        """The throttle stick, 0 to 1."""
        return max(0.0, min(1.0, (self._channels[2] - 1000 - _DEAD_ZONE_US) / (1000.0 - _DEAD_ZONE_US)))

    def pwm(self) -> tuple[int, ...]:
        """All channels."""
        return tuple(self._channels)
