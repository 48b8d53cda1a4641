"""Guidance by messages instead of commands: guided mission items, position targets and attitude targets."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

from vencejo.sim.autopilot.interface import AutopilotPort, Mode, RepositionTarget, Severity
from vencejo.sim.mavlink.codec import MavMessage, dialect
from vencejo.sim.mavlink.link import Peer
from vencejo.sim.mavlink.mission import item_from_message
from vencejo.sim.plan_store import FRAMES, MissionResult, normalise, stored_item

__all__ = ["GuidedMessages", "frame_of"]

_NO_ALTITUDE = 4
"""POSITION_TARGET_TYPEMASK_Z_IGNORE."""
_NO_ROLL_RATE, _NO_PITCH_RATE, _NO_THROTTLE, _NO_ATTITUDE = 1, 2, 64, 128
"""Bits of ATTITUDE_TARGET_TYPEMASK."""


def frame_of(number: int, say: Callable[[Severity, str], None]) -> int | None:
    """A frame with an altitude, its integer variant folded; other frames are announced."""
    frame = FRAMES.get(number)
    if frame is None:
        say(Severity.INFO, f"Unknown mavlink coordinate frame {number}")
    return frame


class Vehicle(Protocol):
    """The part of :class:`vencejo.sim.mavlink.component.PlaneComponent` that these messages use."""

    autopilot: AutopilotPort

    def reply(self, peer: Peer, message: MavMessage) -> None:
        """Send to one peer's link."""

    def say(self, severity: Severity, text: str) -> None:
        """Send a text to every link."""


class GuidedMessages:
    """Handles the guidance messages of one plane; those but the item are ignored outside GUIDED, without an answer."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle = vehicle

    def on_item(self, peer: Peer, message: MavMessage) -> None:
        """The legacy guided commands: a mission item with ``current`` 2 (a point) or 3 (an altitude)."""
        item = item_from_message(message)
        stored = item if isinstance(item, MissionResult) else normalise(item)
        if isinstance(stored, MissionResult):
            result = stored
        else:
            point = stored_item(stored)
            if message.current == 3:
                self._vehicle.autopilot.change_altitude(point.alt_m, point.frame)
                result = MissionResult.ACCEPTED
            else:
                target = RepositionTarget(
                    point.lat_deg, point.lon_deg, point.alt_m, frame=point.frame, change_mode=False
                )
                accepted = self._vehicle.autopilot.reposition(target) == 0
                result = MissionResult.ACCEPTED if accepted else MissionResult.ERROR
        self._vehicle.reply(peer, dialect.MAVLink_mission_ack_message(peer.system, peer.component, int(result), 0))

    @property
    def _is_guided(self) -> bool:
        return self._vehicle.autopilot.flight_mode is Mode.GUIDED

    def on_position_target_global(self, _peer: Peer, message: MavMessage) -> None:
        """SET_POSITION_TARGET_GLOBAL_INT: ArduPlane uses its altitude alone."""
        if not self._is_guided:
            return
        frame = frame_of(message.coordinate_frame, self._vehicle.say)
        if frame is None:
            self._vehicle.say(Severity.WARNING, "Invalid coord frame in SET_POSITION_TARGET_GLOBAL_INT")
        elif not message.type_mask & _NO_ALTITUDE and math.isfinite(message.alt):
            self._vehicle.autopilot.change_altitude(message.alt, frame)

    def on_position_target_local(self, _peer: Peer, message: MavMessage) -> None:
        """SET_POSITION_TARGET_LOCAL_NED: ArduPlane uses its z, as an offset, in MAV_FRAME_LOCAL_OFFSET_NED alone."""
        if self._is_guided and message.coordinate_frame == dialect.MAV_FRAME_LOCAL_OFFSET_NED:
            self._vehicle.autopilot.raise_target(-message.z)

    def on_attitude_target(self, _peer: Peer, message: MavMessage) -> None:
        """SET_ATTITUDE_TARGET: roll, pitch and thrust; an axis counts when its attitude or its rate is not ignored."""
        mask = message.type_mask
        w, x, y, z = message.q
        if not self._is_guided or not all(map(math.isfinite, (w, x, y, z, message.thrust))):
            return
        # Euler angles of a quaternion, e.g. Diebel 2006, eq. 290.
        roll_rad = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
        pitch_rad = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
        has_attitude = not mask & _NO_ATTITUDE
        self._vehicle.autopilot.force_attitude(
            roll_rad if has_attitude or not mask & _NO_ROLL_RATE else None,
            pitch_rad if has_attitude or not mask & _NO_PITCH_RATE else None,
            max(0.0, min(1.0, message.thrust)) if not mask & _NO_THROTTLE else None,
        )
