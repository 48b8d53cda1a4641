"""COMMAND_LONG and COMMAND_INT: the commands that ArduPlane implements, its checks, and its answers.

Each command becomes one call of the autopilot. Commands that ArduPlane does not implement are UNSUPPORTED. As in
ArduPlane, COMMAND_LONG is converted to COMMAND_INT.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from vencejo.sim.autopilot.interface import (
    AutopilotPort,
    MavResult,
    Mode,
    RepositionTarget,
    Severity,
)
from vencejo.sim.fence import FenceMonitor, FenceType
from vencejo.sim.mavlink.codec import MavMessage, dialect
from vencejo.sim.mavlink.guided import frame_of
from vencejo.sim.mavlink.link import Peer
from vencejo.sim.mavlink.payload import refusal
from vencejo.sim.mavlink.streams import StreamSchedule
from vencejo.sim.mavlink.telemetry import BUILDERS
from vencejo.sim.params import ParamStore, float32
from vencejo.sim.plan_store import MissionResult, PlanStore, WireItem, normalise, stored_item
from vencejo.sim.terrain import Terrain

__all__ = ["Command", "CommandHandler", "Vehicle"]

IN_PROGRESS = 5
_FORCE = (2989.0, 21196.0)
_LOCAL_OFFSET_NED = 7
_FASTEST_SHARE = 0.8
"""Highest message rate, as a share of the main loop's rate."""
_CALIBRATION_S = 1.7
"""Duration of an airspeed calibration, as recorded after boot."""

_AS_MISSION_ITEM = frozenset(
    {181, 182, 183, 184, 195, 197, 201, 202, 203, 205, 206, 208, 211, 212, 216, 218, 223,
     531, 532, 534, 601, 1000, 2000, 2001, 2500, 2501}
)  # fmt: skip
"""Commands that act immediately as the mission item of the same number does."""
_FLIGHT_ITEMS = frozenset({188, 189})
"""Return path start and landing start."""


@dataclass(frozen=True, slots=True)
class Command:
    """The content of COMMAND_INT; COMMAND_LONG is converted to it."""

    number: int
    frame: int
    p1: float
    p2: float
    p3: float
    p4: float
    x: int
    y: int
    z: float

    @classmethod
    def from_int(cls, message: MavMessage) -> Command:
        """From COMMAND_INT."""
        return cls(
            message.command,
            message.frame,
            message.param1,
            message.param2,
            message.param3,
            message.param4,
            message.x,
            message.y,
            message.z,
        )

    @classmethod
    def from_long(cls, message: MavMessage) -> Command | None:
        """From COMMAND_LONG; None for commands that ArduPlane accepts as COMMAND_INT only."""
        frame, scale = 3, 1.0
        if message.command in (179, 195, 201):  # set home, regions of interest: degrees
            frame, scale = (0 if message.command == 179 else 3), 1e7
        elif message.command == 22:  # NAV_TAKEOFF
            frame = _LOCAL_OFFSET_NED
        elif message.command == 192:  # DO_REPOSITION
            return None
        # In 32-bit floats, as in the autopilot: 40.3340 arrives as 40.333999… and becomes 403340000.
        x, y = float32(message.param5 * scale), float32(message.param6 * scale)
        return cls(
            message.command,
            frame,
            message.param1,
            message.param2,
            message.param3,
            message.param4,
            _whole(x),
            _whole(y),
            message.param7,
        )


def _whole(value: float) -> int:
    """The integer part; −1 for values without one."""
    return int(value) if math.isfinite(value) and abs(value) < 2**31 else -1


class Vehicle(Protocol):
    """The part of :class:`vencejo.sim.mavlink.component.PlaneComponent` that commands use."""

    autopilot: AutopilotPort
    params: ParamStore
    plans: PlanStore
    fence: FenceMonitor
    terrain: Terrain

    @property
    def home_set(self) -> bool:
        """Whether home is set."""

    def schedule_of(self, peer: Peer) -> StreamSchedule:
        """Stream schedule of a peer's link."""

    def say(self, severity: Severity, text: str) -> None:
        """Send a text to every link."""

    def reply(self, peer: Peer, message: MavMessage) -> None:
        """Send to one peer's link."""

    def send_telemetry(self, peer: Peer, message_id: int) -> None:
        """Send one telemetry message now, if it is available."""

    def default_interval_us(self, message_id: int) -> int | None:
        """Interval of a message by the stream parameters, None when it is off."""

    def send_banner(self, peer: Peer) -> None:
        """Send the banner texts."""

    def now_us(self) -> int:
        """Simulated time since boot in microseconds."""

    def later(self, delay_s: float, action: Callable[[], None]) -> None:
        """Run an action after some simulated time."""

    def request_reboot(self) -> None:
        """Reboot at the next tick."""


class CommandHandler:
    """Answers the commands to one plane."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle = vehicle
        self._after: list[Callable[[], None]] = []
        self._table: dict[int, Callable[[Peer, Command], int]] = {
            20: lambda _peer, _c: self._mode(Mode.RTL),
            17: lambda _peer, _c: self._mode(Mode.LOITER),
            # NAV_TAKEOFF as a command needs vertical lift, and as COMMAND_INT a frame of its own.
            22: lambda _peer, c: MavResult.FAILED if c.frame == _LOCAL_OFFSET_NED else MavResult.DENIED,
            32: lambda _peer, c: MavResult.ACCEPTED if 0 < c.p1 <= 255 else MavResult.DENIED,  # DO_FOLLOW
            176: self._set_mode,
            178: self._change_speed,
            179: self._set_home,
            185: lambda _peer, c: self._vehicle.autopilot.terminate(wanted=c.p1 > 0.5),
            186: self._change_altitude,
            191: self._go_around,
            192: self._reposition,
            207: self._fence_enable,
            224: self._set_mission_current,
            241: self._calibrate,
            245: self._storage,
            246: self._reboot,
            300: self._mission_start,
            400: self._arm,
            401: self._run_prearm,
            410: self._get_home,
            510: self._get_message_interval,
            511: self._set_message_interval,
            512: self._request_message,
            520: lambda peer, c: self._request(peer, 148, c) if c.p1 == 1 else MavResult.FAILED,
            42428: self._banner,
            43000: self._guided_speed,
            43001: self._guided_altitude,
            43002: self._guided_heading,
        }

    def on_command_long(self, peer: Peer, message: MavMessage) -> None:
        """Handle COMMAND_LONG and acknowledge it."""
        command = Command.from_long(message)
        if command is None:
            self._acknowledge(peer, message.command, MavResult.UNSUPPORTED)
        else:
            self._handle(peer, command)

    def on_command_int(self, peer: Peer, message: MavMessage) -> None:
        """Handle COMMAND_INT and acknowledge it."""
        self._handle(peer, Command.from_int(message))

    def _handle(self, peer: Peer, command: Command) -> None:
        self._after = []
        self._acknowledge(peer, command.number, self._run(peer, command))
        for action in self._after:
            action()

    def _run(self, peer: Peer, command: Command) -> int:
        refused = refusal(command.number, command.p1, self._vehicle.params)
        if refused is not None:
            if refused.text:
                self._vehicle.say(refused.severity, refused.text)
            return refused.result
        handler = self._table.get(command.number)
        if handler is not None:
            return handler(peer, command)
        if command.number in _AS_MISSION_ITEM or command.number in _FLIGHT_ITEMS:
            return self._mission_command(command)
        return MavResult.UNSUPPORTED

    def _acknowledge(self, peer: Peer, number: int, result: int) -> None:
        self._vehicle.reply(
            peer,
            dialect.MAVLink_command_ack_message(number, int(result), 0, 0, peer.system, peer.component),
        )

    # arming, modes, flight

    def _arm(self, _peer: Peer, command: Command) -> int:
        autopilot = self._vehicle.autopilot
        force = command.p2 in _FORCE
        if command.p1 == 1:
            return autopilot.arm(force=force)
        if command.p1 == 0:
            return autopilot.disarm(force=command.p2 == _FORCE[1])
        return MavResult.UNSUPPORTED

    def _mode(self, mode: Mode) -> int:
        self._vehicle.autopilot.set_mode(mode)
        return MavResult.ACCEPTED

    def _set_mode(self, _peer: Peer, command: Command) -> int:
        if not _whole(command.p1) & 1:  # MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
            return MavResult.DENIED
        return self._vehicle.autopilot.set_mode(_whole(command.p2))

    def _mission_start(self, _peer: Peer, command: Command) -> int:
        if command.p1 != 0 or command.p2 != 0:
            return MavResult.DENIED
        return self._vehicle.autopilot.mission_start()

    def _set_mission_current(self, peer: Peer, command: Command) -> int:
        seq = _whole(command.p1)
        if not 0 <= seq < len(self._vehicle.plans.mission_store):
            return MavResult.DENIED
        result = self._vehicle.autopilot.set_mission_current(seq, reset=command.p2 == 1.0)
        if result is MavResult.ACCEPTED:
            self._after.append(lambda: self._vehicle.send_telemetry(peer, 42))
        return result

    def _reposition(self, _peer: Peer, command: Command) -> int:
        if abs(command.x) > 900_000_000 or abs(command.y) > 1_800_000_000:
            return MavResult.DENIED
        frame = frame_of(command.frame, self._vehicle.say)
        if frame is None or not math.isfinite(command.z) or abs(command.z) > 80_000:
            return MavResult.DENIED
        if (command.x == 0 and command.y == 0) or (frame != 0 and int(command.z * 100.0) == 0):
            # Location::sanitize replaces these by the present position or altitude, and a changed location is denied.
            return MavResult.DENIED
        lat_deg, lon_deg = command.x * 1e-7, command.y * 1e-7
        now = self._vehicle.autopilot.snapshot()
        alt_rel_home_m = {0: command.z - now.home_alt_amsl_m, 3: command.z}.get(frame)
        if not self._vehicle.fence.contains(lat_deg, lon_deg, alt_rel_home_m, now):
            return MavResult.DENIED
        change_mode = math.isfinite(command.p2) and bool(_whole(command.p2) & 1)
        if not change_mode and not self._guided():
            return MavResult.FAILED
        radius_m = None
        if math.isfinite(command.p3) and command.p3 > 0:
            anticlockwise = not (math.isnan(command.p4) or command.p4 == 0)
            radius_m = -command.p3 if anticlockwise else command.p3
        return self._vehicle.autopilot.reposition(
            RepositionTarget(
                lat_deg=lat_deg,
                lon_deg=lon_deg,
                alt_m=command.z,
                frame=frame,
                radius_m=radius_m,
                change_mode=change_mode,
            )
        )

    def _change_speed(self, _peer: Peer, command: Command) -> int:
        if not (math.isfinite(command.p1) and math.isfinite(command.p2) and math.isfinite(command.p3)):
            return MavResult.DENIED
        if self._vehicle.autopilot.snapshot().mode not in (Mode.GUIDED, Mode.AUTO):
            return MavResult.FAILED
        return self._vehicle.autopilot.change_speed(_whole(command.p1), command.p2, command.p3)

    def _change_altitude(self, _peer: Peer, command: Command) -> int:
        frame = frame_of(_whole(command.p2), self._vehicle.say)
        if frame is None or not math.isfinite(command.p1):
            return MavResult.DENIED
        return self._vehicle.autopilot.change_altitude(command.p1, frame)

    def _go_around(self, _peer: Peer, command: Command) -> int:
        return self._vehicle.autopilot.abort_landing(command.p1 if math.isfinite(command.p1) else 0.0)

    def _guided(self) -> bool:
        return self._vehicle.autopilot.snapshot().mode is Mode.GUIDED

    def _guided_speed(self, _peer: Peer, command: Command) -> int:
        if not self._guided():
            return MavResult.FAILED
        params = self._vehicle.params
        if _whole(command.p1) != 0:
            return MavResult.DENIED
        if not params.get("AIRSPEED_MIN") <= command.p2 <= params.get("AIRSPEED_MAX"):
            return MavResult.FAILED
        accel_m_s2 = abs(command.p3) if math.isfinite(command.p3) else 0.0
        return self._vehicle.autopilot.change_guided_speed(command.p2, accel_m_s2)

    def _guided_altitude(self, _peer: Peer, command: Command) -> int:
        if not self._guided():
            return MavResult.FAILED
        if command.z in (-1.0, 0.0):
            return MavResult.DENIED
        frame = frame_of(command.frame, self._vehicle.say)
        if frame is None or not math.isfinite(command.z):
            return MavResult.DENIED
        rate_m_s = abs(command.p3) if math.isfinite(command.p3) else 0.0
        return self._vehicle.autopilot.change_guided_altitude(command.z, frame, rate_m_s)

    def _guided_heading(self, _peer: Peer, command: Command) -> int:
        if not self._guided():
            return MavResult.FAILED
        if not 0.0 <= command.p2 < 360.0 or _whole(command.p1) not in (0, 1, 2):
            return MavResult.DENIED
        accel = max(command.p3, 0.05) if math.isfinite(command.p3) else 0.05
        return self._vehicle.autopilot.change_heading(_whole(command.p1), command.p2, accel)

    def _mission_command(self, command: Command) -> int:
        item = normalise(
            WireItem(
                seq=0,
                frame=command.frame,
                command=command.number,
                p1=command.p1,
                p2=command.p2,
                p3=command.p3,
                p4=command.p4,
                x=command.x,
                y=command.y,
                z=command.z if math.isfinite(command.z) else 0.0,
            )
        )
        if isinstance(item, MissionResult):
            return MavResult.UNSUPPORTED if item is MissionResult.UNSUPPORTED else MavResult.DENIED
        return self._vehicle.autopilot.do_mission_command(stored_item(item))

    # home and fence

    def _set_home(self, _peer: Peer, command: Command) -> int:
        if command.p1 == 1 or (command.x == 0 and command.y == 0):
            return self._vehicle.autopilot.set_home(None, None, None)
        if command.p1 != 0:
            return MavResult.FAILED
        frame = frame_of(command.frame, self._vehicle.say)
        if frame is None or not math.isfinite(command.z) or abs(command.z) > 80_000:
            return MavResult.DENIED
        if abs(command.x) > 900_000_000 or abs(command.y) > 1_800_000_000:
            return MavResult.FAILED
        now = self._vehicle.autopilot.snapshot()
        lat_deg, lon_deg = command.x * 1e-7, command.y * 1e-7
        base_m = {0: 0.0, 3: now.home_alt_amsl_m, 10: self._vehicle.terrain.height_m(lat_deg, lon_deg)}[frame]
        if base_m is None:
            return MavResult.FAILED
        return self._vehicle.autopilot.set_home(lat_deg, lon_deg, base_m + command.z)

    def _get_home(self, peer: Peer, _command: Command) -> int:
        if not self._vehicle.home_set:
            return MavResult.FAILED
        self._vehicle.send_telemetry(peer, 242)
        self._vehicle.send_telemetry(peer, 49)
        return MavResult.ACCEPTED

    def _fence_enable(self, _peer: Peer, command: Command) -> int:
        fence = self._vehicle.fence
        chosen = FenceType(_whole(command.p2) & 15) if math.isfinite(command.p2) and command.p2 > 0 else FenceType(15)
        match _whole(command.p1):
            case 0:
                fence.enable(False, chosen)
            case 1:
                if not fence.present & chosen:
                    return MavResult.FAILED
                fence.enable(True, chosen)
            case 2:
                fence.enable(False, FenceType.ALT_MIN)
            case _:
                return MavResult.FAILED
        return MavResult.ACCEPTED

    # messages

    def _set_message_interval(self, peer: Peer, command: Command) -> int:
        message_id = _whole(command.p1)
        if command.p3 != 0:
            return MavResult.DENIED
        if message_id not in BUILDERS:
            self._after.append(lambda: self._vehicle.say(Severity.INFO, f"No ap_message for mavlink id ({message_id})"))
            return MavResult.DENIED
        schedule = self._vehicle.schedule_of(peer)
        asked_us = _whole(command.p2)
        if asked_us == -1:
            schedule.set_interval(message_id, None, now_us=self._vehicle.now_us())
            return MavResult.ACCEPTED
        if asked_us < 0:
            return MavResult.DENIED
        # ArduPlane stores milliseconds, 1 to 60,000.
        interval_us = (
            min(max(asked_us // 1000, 1), 60_000) * 1000 if asked_us else self._vehicle.default_interval_us(message_id)
        )
        if interval_us is not None and interval_us < self.fastest_us(self._vehicle.params):
            self._after.append(
                lambda: self._vehicle.say(
                    Severity.INFO,
                    f"Requested rate for message ID {message_id} too fast. Increase SCHED_LOOP_RATE",
                )
            )
            return MavResult.DENIED
        schedule.set_interval(message_id, interval_us, now_us=self._vehicle.now_us())
        return MavResult.ACCEPTED

    @staticmethod
    def fastest_us(params: ParamStore) -> int:
        """Shortest message interval that the main loop's rate allows, in microseconds."""
        return round(1e6 / (_FASTEST_SHARE * max(1.0, params.get("SCHED_LOOP_RATE"))))

    def _get_message_interval(self, peer: Peer, command: Command) -> int:
        message_id = _whole(command.p1)
        known = message_id in BUILDERS
        interval_us = self._vehicle.schedule_of(peer).interval(message_id)
        reported_us = 0 if not known else -1 if interval_us is None else interval_us
        self._vehicle.reply(peer, dialect.MAVLink_message_interval_message(max(message_id, 0) & 0xFFFF, reported_us))
        return MavResult.ACCEPTED if known else MavResult.FAILED

    def _request_message(self, peer: Peer, command: Command) -> int:
        return self._request(peer, _whole(command.p1), command)

    def _request(self, peer: Peer, message_id: int, _command: Command) -> int:
        if message_id not in BUILDERS:
            return MavResult.FAILED
        self._after.append(lambda: self._vehicle.send_telemetry(peer, message_id))
        return MavResult.ACCEPTED

    def _banner(self, peer: Peer, _command: Command) -> int:
        self._after.append(lambda: self._vehicle.send_banner(peer))
        return MavResult.ACCEPTED

    # preflight

    def _run_prearm(self, _peer: Peer, _command: Command) -> int:
        autopilot = self._vehicle.autopilot
        if autopilot.snapshot().armed:
            return MavResult.TEMPORARILY_REJECTED
        for reason in autopilot.prearm():
            self._vehicle.say(Severity.CRITICAL, f"PreArm: {reason}")
        return MavResult.ACCEPTED

    def _calibrate(self, peer: Peer, command: Command) -> int:
        if self._vehicle.autopilot.snapshot().armed:
            self._vehicle.say(Severity.NOTICE, "Disarm to allow calibration")
            return MavResult.FAILED
        if command.p1 == 1 or command.x in (1, 2, 4, 76) or command.p2 == 76:
            return MavResult.ACCEPTED
        if command.p3 != 1:
            return MavResult.UNSUPPORTED
        self._vehicle.say(Severity.INFO, "Updating barometer calibration")
        self._vehicle.say(Severity.INFO, "Barometer calibration complete")
        self._vehicle.say(Severity.INFO, "Airspeed 1 calibration started")

        self._vehicle.later(1.0, lambda: self._acknowledge(peer, command.number, IN_PROGRESS))

        def done() -> None:
            self._vehicle.say(Severity.INFO, "Airspeed 1 calibrated")
            self._acknowledge(peer, command.number, MavResult.ACCEPTED)

        self._vehicle.later(_CALIBRATION_S, done)
        return IN_PROGRESS

    def _storage(self, _peer: Peer, command: Command) -> int:
        if command.p1 != 2:
            return MavResult.DENIED
        self._vehicle.params.reset()
        self._after.append(lambda: self._vehicle.say(Severity.WARNING, "All parameters reset, reboot board"))
        return MavResult.ACCEPTED

    def _reboot(self, _peer: Peer, command: Command) -> int:
        if self._vehicle.autopilot.snapshot().armed:
            return MavResult.FAILED
        if command.p1 not in (1.0, 3.0):
            return MavResult.UNSUPPORTED
        self._vehicle.request_reboot()
        return MavResult.ACCEPTED
