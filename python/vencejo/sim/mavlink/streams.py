"""Stream schedule of one link: ArduPlane's stream groups and message intervals."""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["GROUPS", "GROUP_PARAMS", "STREAM_ORDER", "StreamSchedule"]

GROUPS: dict[int, tuple[int, ...]] = {
    1: (27, 116, 129, 29, 137, 295),  # RAW_SENSORS
    2: (1, 125, 152, 42, 24, 62, 162, 87),  # EXTENDED_STATUS
    3: (36, 65),  # RC_CHANNELS
    4: (),  # RAW_CONTROLLER: SERVO_OUT, which ArduPlane no longer sends
    6: (33, 32),  # POSITION
    10: (30, 164, 178, 11020),  # EXTRA1
    11: (74,),  # EXTRA2
    12: (163, 168, 2, 136, 133, 147, 193, 241),  # EXTRA3
}
"""Messages of each MAV_DATA_STREAM, as ArduPlane groups them."""

GROUP_PARAMS: dict[int, str] = {
    1: "RAW_SENS",
    2: "EXT_STAT",
    3: "RC_CHAN",
    4: "RAW_CTRL",
    6: "POSITION",
    10: "EXTRA1",
    11: "EXTRA2",
    12: "EXTRA3",
}
"""The parameter (``MAV1_…``) with the rate of each group, in Hz."""

STREAM_ORDER: tuple[int, ...] = (
    163, 30, 33, 178, 74, 1, 125, 152, 62, 42, 36, 65, 27, 116, 129, 29, 137, 24, 2, 164, 168, 136, 133, 193, 32, 241,
    87, 147, 11020, 295, 162,
)  # fmt: skip
"""The order of messages that are due at the same time, as recorded."""

_RANK = {message: rank for rank, message in enumerate(STREAM_ORDER)}


class StreamSchedule:
    """Schedule of the messages on one link. Times are simulated microseconds.

    Parameters
    ----------
    rates_hz : mapping
        Rate of each group of :data:`GROUPS`; 0 is off.
    """

    def __init__(self, rates_hz: Mapping[int, float]) -> None:
        self._interval_us: dict[int, int] = {}
        self._due_us: dict[int, int] = {}
        self._next_us = 0
        for group, rate in rates_hz.items():
            self.set_group(group, rate, now_us=0)

    def set_group(self, group: int, rate_hz: float, *, now_us: int) -> None:
        """Stream all messages of a group at one rate; 0 stops them."""
        for message in GROUPS[group]:
            self.set_interval(message, round(1e6 / rate_hz) if rate_hz > 0 else None, now_us=now_us)

    def set_interval(self, message: int, interval_us: int | None, *, now_us: int) -> None:
        """Stream one message; None stops it."""
        if interval_us is None:
            self._interval_us.pop(message, None)
            self._due_us.pop(message, None)
            return
        self._interval_us[message] = interval_us
        self._due_us[message] = now_us
        self._next_us = min(self._next_us, now_us)

    def interval(self, message: int) -> int | None:
        """Present interval of a message, None when it is not streamed."""
        return self._interval_us.get(message)

    def restart(self, now_us: int) -> None:
        """Restart after a jump in time (reboot): everything is due now."""
        self._due_us = dict.fromkeys(self._interval_us, now_us)
        self._next_us = now_us

    def due(self, now_us: int) -> list[int]:
        """Messages due now, in order. A late message is sent once, whatever number of intervals was missed."""
        if now_us < self._next_us:
            return []
        found = []
        earliest = now_us + 1_000_000
        for message, due in self._due_us.items():
            if due <= now_us:
                found.append(message)
                interval = self._interval_us[message]
                due += interval
                if due <= now_us:
                    due = now_us + interval
                self._due_us[message] = due
            earliest = min(earliest, due)
        self._next_us = earliest
        found.sort(key=lambda message: _RANK.get(message, len(_RANK)))
        return found
