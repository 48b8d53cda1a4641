"""RC_CHANNELS_OVERRIDE and MANUAL_CONTROL: sticks moved by a ground station, until they expire."""

from __future__ import annotations

from typing import Protocol

from vencejo.sim.autopilot.interface import AutopilotPort
from vencejo.sim.mavlink.codec import MavMessage
from vencejo.sim.mavlink.link import Peer
from vencejo.sim.mavlink.station import StationWatch
from vencejo.sim.params import ParamStore

__all__ = ["StickMessages"]

_IGNORED_CHANNEL = 65535
_IGNORED_AXIS = 32767
_CHANNELS = 16


class Vehicle(Protocol):
    """The part of :class:`vencejo.sim.mavlink.component.PlaneComponent` that this protocol uses."""

    autopilot: AutopilotPort
    params: ParamStore
    station: StationWatch


class StickMessages:
    """The overridden channels of one plane."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle = vehicle
        self._since_s: dict[int, float] = {}

    def restart(self) -> None:
        """Forget all overrides, at a reboot."""
        self._since_s.clear()

    def on_rc_channels_override(self, peer: Peer, message: MavMessage) -> None:
        """Override channels by their pulse widths; 0 returns one to the transmitter."""
        if not self._vehicle.station.is_station(peer.system):
            return
        channels: dict[int, int | None] = {}
        for number in range(1, _CHANNELS + 1):
            value = getattr(message, f"chan{number}_raw")
            if value == _IGNORED_CHANNEL or (number > 8 and value == 0):
                continue
            channels[number] = None if value in (0, _IGNORED_CHANNEL - 1) else value
        self._override(channels)

    def on_manual_control(self, peer: Peer, message: MavMessage) -> None:
        """Override roll, pitch, throttle and rudder by stick deflections."""
        if not self._vehicle.station.is_station(peer.system):
            return
        channels: dict[int, int | None] = {}
        for axis, raw, low, reverse in (
            ("ROLL", message.y, -1000, False),
            ("PITCH", message.x, -1000, True),
            ("THROTTLE", message.z, 0, False),
            ("YAW", message.r, -1000, False),
        ):
            if raw == _IGNORED_AXIS or not low <= raw <= 1000:
                continue
            number = self._vehicle.params.integer(f"RCMAP_{axis}")
            if not 1 <= number <= _CHANNELS:
                continue
            least, most = self._vehicle.params.get(f"RC{number}_MIN"), self._vehicle.params.get(f"RC{number}_MAX")
            share = (raw - low) / (1000 - low)
            channels[number] = round(least + (most - least) * (1 - share if reverse else share))
        self._override(channels)

    def _override(self, channels: dict[int, int | None]) -> None:
        self._vehicle.station.heard()
        for number, value in channels.items():
            if value is None:
                self._since_s.pop(number, None)
            else:
                self._since_s[number] = self._vehicle.autopilot.time_s
        self._vehicle.autopilot.rc_input(channels)

    def expire(self, now_s: float) -> None:
        """Return the channels to the transmitter that were not repeated for RC_OVERRIDE_TIME."""
        keep_s = self._vehicle.params.get("RC_OVERRIDE_TIME")
        if keep_s < 0:
            return
        expired = [number for number, set_s in self._since_s.items() if now_s - set_s > keep_s]
        if expired:
            for number in expired:
                del self._since_s[number]
            self._vehicle.autopilot.rc_input(dict.fromkeys(expired))
