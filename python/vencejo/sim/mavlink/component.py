"""The MAVLink component of one plane: routes messages to the protocols, ticks them, and turns events into messages."""

from __future__ import annotations

import heapq
import itertools
import time
from collections.abc import Callable

from vencejo.sim.autopilot.interface import (
    DT_S,
    Armed,
    AutopilotPort,
    CameraTriggered,
    Event,
    HomeChanged,
    LandedState,
    MissionItemReached,
    Mode,
    ModeChanged,
    Severity,
    SimConfig,
    Snapshot,
    StatusText,
)
from vencejo.sim.fence import FenceMonitor, FenceType
from vencejo.sim.mavlink.codec import MavMessage, Payload, dialect, payload_of
from vencejo.sim.mavlink.commands import CommandHandler
from vencejo.sim.mavlink.files import VirtualFiles
from vencejo.sim.mavlink.ftp import FtpServer
from vencejo.sim.mavlink.guided import GuidedMessages
from vencejo.sim.mavlink.link import Link, Peer, Source
from vencejo.sim.mavlink.parameters import ParameterProtocol
from vencejo.sim.mavlink.plans import PlanMessages
from vencejo.sim.mavlink.signing import Signing
from vencejo.sim.mavlink.station import StationWatch
from vencejo.sim.mavlink.statistics import Statistics
from vencejo.sim.mavlink.sticks import StickMessages
from vencejo.sim.mavlink.streams import GROUP_PARAMS, GROUPS, StreamSchedule
from vencejo.sim.mavlink.telemetry import BANNER, TelemetryContext, build
from vencejo.sim.mavlink.terrain import TerrainMessages
from vencejo.sim.params import Parameter, ParamStore
from vencejo.sim.plan_store import PlanStore
from vencejo.sim.prearm import PrearmChecks, PrearmTexts
from vencejo.sim.terrain import Terrain

__all__ = ["AutopilotFactory", "PlaneComponent"]

AutopilotFactory = Callable[[SimConfig, ParamStore, PlanStore, Callable[[], list[str]]], AutopilotPort]

COMPONENT_AUTOPILOT = 1
_TEXT_BYTES = 50
_SLOW_TICKS = 10
"""Ticks of 10 ms between the checks that run ten times a second."""
_OFF_TICKS = 200
"""Silence of a reboot, in ticks: 2 s, as of an autopilot's boot loader and start."""
_HEARTBEAT_US = 1_000_000
_TIMESYNC_US = 10_000_000
_TERRAIN_REQUEST = 133


def _default_autopilot(
    config: SimConfig, params: ParamStore, plans: PlanStore, prearm: Callable[[], list[str]]
) -> AutopilotPort:
    from vencejo.sim.autopilot import Autopilot

    return Autopilot(config=config, params=params, plan=plans, prearm=prearm)


class PlaneComponent:
    """The MAVLink half of one plane. Single-threaded: the owner calls it from one loop.

    Parameters
    ----------
    config : SimConfig
        The plane; ``config.system_id`` is its MAVLink system id.
    params : ParamStore, optional
        ArduPlane's defaults when omitted.
    autopilot : callable, optional
        Factory of the flying half; tests pass a double.
    unix_s_at_boot : float, optional
        Unix time of the boot in SYSTEM_TIME; the real time when omitted.
    """

    def __init__(
        self,
        config: SimConfig,
        *,
        params: ParamStore | None = None,
        autopilot: AutopilotFactory | None = None,
        unix_s_at_boot: float | None = None,
    ) -> None:
        self.source = Source(config.system_id, COMPONENT_AUTOPILOT)
        self.heading_deg = config.heading_deg
        self.params = params if params is not None else ParamStore.arduplane()
        self.params.set("MAV_SYSID", config.system_id)
        self.plans = PlanStore()
        self.fence = FenceMonitor(self.params, self.plans.fence_store)
        self._snapshot: Snapshot | None = None
        self.autopilot = (autopilot or _default_autopilot)(config, self.params, self.plans, lambda: self._prearm())
        self.terrain = Terrain(self.params)
        if hasattr(self.autopilot, "ground"):
            self.autopilot.ground = self.terrain
        self._prearm = PrearmChecks(self.params, self.plans, self.fence, self.terrain, self.snapshot)
        self._unix_us_at_boot = round((time.time() if unix_s_at_boot is None else unix_s_at_boot) * 1e6)

        self._links: dict[Link, StreamSchedule] = {}
        self._later: list[tuple[float, int, Callable[[], None]]] = []
        self._later_number = itertools.count()
        self._off_ticks = 0
        """Ticks until a reboot is complete; 0 when the plane is on."""
        self._held_texts: list[tuple[Severity, str]] | None = None
        self._text_id = 0
        self.station = StationWatch(self.params, self.autopilot)
        self._start_clocks()

        self._parameters = ParameterProtocol(
            self.params, reply=self.reply, announce=self.broadcast, changed=self._parameter_changed, say=self.say
        )
        self._statistics = Statistics(self.params, lambda parameter: self.broadcast(self._parameters.value(parameter)))
        self._guided = GuidedMessages(self)
        self._plans = PlanMessages(self, self._guided, self._parameters.value)
        files = VirtualFiles(self.params, self._plans.by_file, say=self.say, param_set=self._parameter_uploaded)
        self._ftp = FtpServer(files, reply=self.reply, banner=self.send_banner, say=self.say, now_s=self._now_s)
        self._commands = CommandHandler(self)
        self._sticks = StickMessages(self)
        self._terrain_messages = TerrainMessages(self)
        self.signing = Signing(config.system_id, self.say)
        self._handlers: dict[str, Callable[[Peer, MavMessage], None]] = {
            "HEARTBEAT": self.station.on_heartbeat,
            "COMMAND_LONG": self._commands.on_command_long,
            "COMMAND_INT": self._commands.on_command_int,
            "SET_MODE": self._on_set_mode,
            "PARAM_REQUEST_LIST": self._on_param_request_list,
            "PARAM_REQUEST_READ": self._parameters.on_request_read,
            "PARAM_SET": self._parameters.on_set,
            "FILE_TRANSFER_PROTOCOL": self._ftp.on_message,
            "REQUEST_DATA_STREAM": self._on_request_data_stream,
            "TIMESYNC": self._on_timesync,
            "PING": self._on_ping,
            **self._plans.handlers,
            "SETUP_SIGNING": lambda _, m: self.signing.set_up(m, armed=self.snapshot().armed),
            "RC_CHANNELS_OVERRIDE": self._sticks.on_rc_channels_override,
            "MANUAL_CONTROL": self._sticks.on_manual_control,
            "TERRAIN_DATA": self._terrain_messages.on_data,
            "TERRAIN_CHECK": self._terrain_messages.on_check,
            "SET_POSITION_TARGET_GLOBAL_INT": self._guided.on_position_target_global,
            "SET_POSITION_TARGET_LOCAL_NED": self._guided.on_position_target_local,
            "SET_ATTITUDE_TARGET": self._guided.on_attitude_target,
        }
        if hasattr(self.autopilot, "on_fence_enable"):
            self.autopilot.on_fence_enable = self._mission_fence_enable
        if hasattr(self.autopilot, "utc_s"):
            self.autopilot.utc_s = self._utc_s
        self._drain_events()

    def _mission_fence_enable(self, action: int) -> None:
        """DO_FENCE_ENABLE as a mission item: 0 off, 1 on, 2 without the floor."""
        fences = FenceType.ALT_MIN if action == 2 else FenceType(15)
        self.fence.enable(action == 1, fences)

    def _utc_s(self) -> float | None:
        """Seconds since 1970, from the first GPS fix on."""
        if self.snapshot().gps_fix_type < 3:
            return None
        return (self._unix_us_at_boot + self.now_us()) * 1e-6

    def _start_clocks(self) -> None:
        self._ticks = 0
        self._heartbeat_due_us = 0
        self._mode_sent: Mode | None = None
        self._timesync_due_us = _TIMESYNC_US
        self._prearm_texts = PrearmTexts(self.say)

    # used by the protocols

    @property
    def system_id(self) -> int:
        """MAVLink system id."""
        return self.source.system

    @property
    def home_set(self) -> bool:
        """Whether home is set."""
        return self.plans.mission_store.home is not None

    def snapshot(self) -> Snapshot:
        """The present state, built once a tick."""
        if self._snapshot is None:
            self._snapshot = self.autopilot.snapshot()
        return self._snapshot

    def now_us(self) -> int:
        """Simulated time since boot in microseconds."""
        return round(self.autopilot.time_s * 1e6)

    def _now_s(self) -> float:
        return self.autopilot.time_s

    def schedule_of(self, peer: Peer) -> StreamSchedule:
        """Stream schedule of a peer's link."""
        return self._links[peer.link]

    def reply(self, peer: Peer, message: MavMessage) -> None:
        """Send to one peer's link."""
        peer.link.send(message, self.source)

    def say(self, severity: Severity, text: str) -> None:
        """Send a text to every link, in chunks of fifty bytes when it is longer.

        Texts of a message being handled are sent after the answers to it, as by ArduPlane.
        """
        if self._held_texts is not None:
            self._held_texts.append((severity, text))
            return
        data = text.encode("utf-8", "replace")
        number = 0
        if len(data) > _TEXT_BYTES:
            self._text_id = self._text_id % 0xFFFF + 1
            number = self._text_id
        for chunk, start in enumerate(range(0, max(1, len(data)), _TEXT_BYTES)):
            part = data[start : start + _TEXT_BYTES]
            self.broadcast(dialect.MAVLink_statustext_message(int(severity), part, number, chunk))

    def send_telemetry(self, peer: Peer, message_id: int) -> None:
        """Send one telemetry message now, if it is available."""
        message = build(message_id, self.snapshot(), self.context())
        if message is not None:
            self.reply(peer, message)

    def default_interval_us(self, message_id: int) -> int | None:
        """Interval of a message by the stream parameters, None when it is off."""
        for group, messages in GROUPS.items():
            if message_id in messages:
                rate_hz = self.params.get(f"MAV1_{GROUP_PARAMS[group]}")
                return round(1e6 / rate_hz) if rate_hz > 0 else None
        return None

    def send_banner(self, peer: Peer) -> None:
        """Send the banner texts."""
        for line in BANNER:
            self.reply(peer, dialect.MAVLink_statustext_message(int(Severity.INFO), line.encode("ascii")))

    def later(self, delay_s: float, action: Callable[[], None]) -> None:
        """Run an action after some simulated time, unless the vehicle reboots before."""
        heapq.heappush(self._later, (self.autopilot.time_s + delay_s, next(self._later_number), action))

    def request_reboot(self) -> None:
        """Reboot at the next tick."""
        self._off_ticks = _OFF_TICKS

    # links

    def attach(self, link: Link) -> None:
        """Add a link: it receives telemetry from now on."""
        schedule = StreamSchedule({g: self.params.get(f"MAV1_{name}") for g, name in GROUP_PARAMS.items()})
        schedule.restart(self.now_us())
        self._links[link] = schedule
        self.signing.attach(link)

    def detach(self, link: Link) -> None:
        """Remove a link."""
        self._links.pop(link, None)
        self.signing.detach(link)
        self._parameters.forget(link)
        self.terrain.forget(link)
        # Its queued file requests are still served: the queue belongs to the server, as on the vehicle.
        self._plans.forget(link)

    def on_message(self, link: Link, message: MavMessage) -> None:
        """Handle a message from a station; those for other vehicles are ignored."""
        if link not in self._links or self._off_ticks:
            return
        system, component = message.get_srcSystem(), message.get_srcComponent()
        if getattr(message, "target_system", getattr(message, "target", 0)) not in (0, self.system_id):
            return
        if getattr(message, "target_component", 0) not in (0, COMPONENT_AUTOPILOT):
            return
        handler = self._handlers.get(message.get_type())
        if handler is not None and self.signing.accepts(link, message):
            self._snapshot = None
            self._held_texts = []
            try:
                handler(Peer(link, system, component), message)
                self._snapshot = None
                self._drain_events()
            finally:
                texts, self._held_texts = self._held_texts, None
            for severity, text in texts:
                self.say(severity, text)

    # time

    def tick(self) -> None:
        """Advance the plane by 10 ms of simulated time and send what is due."""
        if self._off_ticks:
            # The plane stands on the ground or is held by hand, and does not move meanwhile.
            self._off_ticks -= 1
            if self._off_ticks:
                return
            self._restart()
        self.autopilot.step()
        self._snapshot = None
        self._ticks += 1
        self._drain_events()
        while self._later and self._later[0][0] <= self.autopilot.time_s:
            heapq.heappop(self._later)[2]()
        self._ftp.tick()
        if self._links:
            self._parameters.tick()
        if self._ticks % _SLOW_TICKS == 0:
            self._slow_tick()
        self._plans.announce_totals()
        if self._links:
            self._stream()

    def _slow_tick(self) -> None:
        self._plans.tick()
        now = self.snapshot()
        self.signing.tick(now.time_s)
        new, cleared = self.fence.check(now, landing=now.landed_state is LandedState.LANDING)
        if new:
            self.autopilot.fence_breached(self.fence.kind(new), self.fence.return_point)
        elif cleared:
            self.autopilot.fence_breached(None)
        if not self.fence.enabled:
            self.autopilot.fence_disabled()
        self.station.check(now)
        self._statistics.update(now)
        self._terrain_messages.look(now)
        self._sticks.expire(now.time_s)
        self._prearm_texts.tick(now, [] if now.armed else self._prearm())
        self._drain_events()

    def _stream(self) -> None:
        now_us = self.now_us()
        is_due = now_us >= self._heartbeat_due_us
        if is_due:
            self._heartbeat_due_us = now_us + _HEARTBEAT_US
        # A mode change sends a heartbeat immediately (ArduPlane's set_mode()), in addition to the periodic ones.
        mode = self.autopilot.flight_mode
        if is_due or mode is not self._mode_sent:
            self._mode_sent = mode
            self.broadcast(build(0, self.snapshot(), self.context()))
        if mode is Mode.INITIALISING:
            return
        if now_us >= self._timesync_due_us:
            self._timesync_due_us += _TIMESYNC_US
            self.broadcast(dialect.MAVLink_timesync_message(0, now_us * 1000 + self.system_id))
        packed: dict[int, Payload | None] = {}
        context: TelemetryContext | None = None
        for link, schedule in self._links.items():
            for message_id in schedule.due(now_us):
                if message_id == _TERRAIN_REQUEST:
                    self._terrain_messages.ask(link)
                    continue
                if message_id not in packed:
                    if context is None:
                        context = self.context()
                    message = build(message_id, self.snapshot(), context)
                    packed[message_id] = None if message is None else payload_of(message)
                payload = packed[message_id]
                if payload is not None:
                    link.stream(payload, self.source)

    def context(self) -> TelemetryContext:
        """Telemetry data that is not in the snapshot."""
        return TelemetryContext(
            unix_us_at_boot=self._unix_us_at_boot,
            stick_mixing=self.params.integer("STICK_MIXING") != 0,
            rc_rssi=255,
            fence_enabled=self.fence.enabled,
            fence_present=bool(self.plans.fence_store.shapes),
            fence=self.fence.status,
            prearm_ok=self._prearm_texts.passed,
            home_set=self.home_set,
            system_id=self.source.system,
            terrain=self._terrain_messages.report,
        )

    def _restart(self) -> None:
        self._unix_us_at_boot += self.now_us() + round(_OFF_TICKS * DT_S * 1e6)
        self.autopilot.reboot()
        self._statistics.restart()
        self.terrain.restart()
        self.plans.mission_store.home = None
        self.fence.reset()
        self._ftp.reset()
        self._plans.reset()
        self._later.clear()
        self._sticks.restart()
        self.station.restart()
        self._start_clocks()
        self.signing.restart()
        for link in self._links:
            link.restart(self.source)
            self.attach(link)

    # events and announcements

    def _drain_events(self) -> None:
        events = self.autopilot.events()
        if not events:
            return
        texts: list[StatusText] = []
        reached: int | None = None
        for event in events:
            if isinstance(event, StatusText):
                texts.append(event)
            elif isinstance(event, MissionItemReached):
                # ArduPlane keeps one pending index per link: of simultaneous items only the last is announced.
                reached = event.seq
            else:
                self._on_event(event)
        if reached is not None:
            self.broadcast(dialect.MAVLink_mission_item_reached_message(reached))
        for severity, text in ((Severity(said.severity), said.text) for said in texts):
            self.say(severity, text)  # after the other messages of the same instant, as from ArduPlane's queue

    def _on_event(self, event: Event) -> None:
        match event:
            case HomeChanged(lat_deg, lon_deg, alt_amsl_m):
                self.plans.mission_store.set_home(lat_deg, lon_deg, alt_amsl_m)
                self._send_home()
            case Armed():
                now = self.autopilot.snapshot()
                self.terrain.armed(now.lat_deg, now.lon_deg, now.alt_amsl_m)
            case ModeChanged():
                self.broadcast(build(0, self.snapshot(), self.context()))
            case CameraTriggered():
                self.broadcast(
                    dialect.MAVLink_camera_feedback_message(
                        self._unix_us_at_boot + self.now_us(),
                        0,
                        0,
                        event.index & 0xFFFF,
                        round(event.lat_deg * 1e7),
                        round(event.lon_deg * 1e7),
                        event.alt_amsl_m,
                        event.alt_rel_home_m,
                        event.roll_deg,
                        event.pitch_deg,
                        event.yaw_deg,
                        0.0,
                        0,
                        event.index & 0xFFFF,
                    )
                )

    def _send_home(self) -> None:
        if self._links:
            for message_id in (49, 242):
                self.broadcast(build(message_id, self.snapshot(), self.context()))

    def broadcast(self, message: MavMessage | None) -> None:
        """Send a message to every link."""
        if message is None or not self._links:
            return
        payload = payload_of(message)
        for link in self._links:
            link.send_payload(payload, self.source)

    # messages

    def _on_set_mode(self, _peer: Peer, message: MavMessage) -> None:
        if message.base_mode & 1:  # MAV_MODE_FLAG_CUSTOM_MODE_ENABLED; ArduPlane does not acknowledge this message
            self.autopilot.set_mode(message.custom_mode)

    def _on_param_request_list(self, peer: Peer, message: MavMessage) -> None:
        self.send_banner(peer)
        self._parameters.on_request_list(peer, message)

    def _on_request_data_stream(self, peer: Peer, message: MavMessage) -> None:
        """Set the rates of the stream groups of this link; changed rate parameters are announced, as recorded."""
        groups = GROUPS if message.req_stream_id == 0 else {message.req_stream_id: ()}
        rate_hz = float(message.req_message_rate) if message.start_stop else 0.0
        fastest_hz = 1e6 / self._commands.fastest_us(self.params)
        for group in groups:
            if group not in GROUP_PARAMS:
                continue
            self._links[peer.link].set_group(group, min(rate_hz, fastest_hz), now_us=self.now_us())
            name = f"MAV1_{GROUP_PARAMS[group]}"
            if self.params.get(name) != rate_hz:
                self.broadcast(self._parameters.value(self.params.set(name, rate_hz)))

    def _on_timesync(self, peer: Peer, message: MavMessage) -> None:
        if message.tc1 == 0:
            self.reply(peer, dialect.MAVLink_timesync_message(self.now_us() * 1000, message.ts1))

    def _on_ping(self, peer: Peer, message: MavMessage) -> None:
        if message.target_system == 0 and message.target_component == 0:
            self.reply(peer, dialect.MAVLink_ping_message(message.time_usec, message.seq, peer.system, peer.component))

    def _parameter_uploaded(self, parameter: Parameter) -> None:
        self.broadcast(self._parameters.value(parameter))
        self._parameter_changed(parameter)

    def _parameter_changed(self, parameter: Parameter) -> None:
        if parameter.name.startswith("MAV1_"):
            for group, name in GROUP_PARAMS.items():
                if parameter.name == f"MAV1_{name}":
                    for schedule in self._links.values():
                        schedule.set_group(group, parameter.value, now_us=self.now_us())
