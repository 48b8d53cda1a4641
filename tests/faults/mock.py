"""A scripted plane: an ArduPlane as seen by a ground station, which does exactly what a test tells it to.

One thread serves the connections of one TCP port and owns all state; a test changes it through the hooks, or between
two operations. Nothing happens by itself: the only telemetry is the heartbeat, the only clock is `MockPlane.boot_ms`.
"""

from __future__ import annotations

import selectors
import socket
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

HEARTBEAT_S = 0.2
ACTS = {"SET_MODE", "MISSION_SET_CURRENT", "MANUAL_CONTROL", "RC_CHANNELS_OVERRIDE", "SET_ATTITUDE_TARGET"}
"""Messages, and below commands, that move a plane; they must never be sent without a request."""
ACT_COMMANDS = {
    mavlink.MAV_CMD_COMPONENT_ARM_DISARM,
    mavlink.MAV_CMD_DO_SET_MODE,
    mavlink.MAV_CMD_MISSION_START,
    mavlink.MAV_CMD_DO_PAUSE_CONTINUE,
    mavlink.MAV_CMD_NAV_TAKEOFF,
    mavlink.MAV_CMD_NAV_LAND,
    mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH,
    mavlink.MAV_CMD_NAV_LOITER_UNLIM,
    mavlink.MAV_CMD_DO_SET_MISSION_CURRENT,
    mavlink.MAV_CMD_DO_LAND_START,
    mavlink.MAV_CMD_DO_GO_AROUND,
    mavlink.MAV_CMD_DO_REPOSITION,
    mavlink.MAV_CMD_DO_CHANGE_SPEED,
    mavlink.MAV_CMD_DO_CHANGE_ALTITUDE,
    mavlink.MAV_CMD_DO_FLIGHTTERMINATION,
    mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN,
}


class _Out:
    """Output stream for pymavlink."""

    def __init__(self) -> None:
        self.data = bytearray()

    def write(self, data: bytes) -> None:
        self.data += data


class _Peer:
    def __init__(self, sock: socket.socket) -> None:
        self.sock = sock
        self.reader = mavlink.MAVLink(None)
        self.reader.robust_parsing = True


class MockPlane:
    """An ArduPlane on ``tcp:127.0.0.1``; see the module.

    Attributes
    ----------
    on_message : function of a message, or None
        Called before anything else; its result is sent instead of the plane's own answer, unless it is ``None``.
    received : list of (name, message)
        Everything that stations have sent, in order.
    """

    def __init__(self, system_id: int = 1) -> None:
        self.system_id = system_id
        self.received: list[tuple[str, Any]] = []
        self.on_message: Callable[[Any], list[Any] | None] | None = None
        self.heartbeats = True
        self.custom_mode, self.is_armed = 0, False
        self.items: dict[int, list[Any]] = {0: [], 1: [], 2: []}
        self.params: dict[str, float] = {"WP_RADIUS": 50.0, "AIRSPEED_CRUISE": 22.0, "SYSID_THISMAV": 1.0}
        self.boot_ms = 600_000
        self.connections = 0
        self._incoming: tuple[int, int, list[Any], Any] | None = None
        self._out = _Out()
        self._writer = mavlink.MAVLink(self._out, srcSystem=system_id, srcComponent=1)
        self._jobs: list[Callable[[], None]] = []
        self._lock = threading.Lock()
        self._selector = selectors.DefaultSelector()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._wake_in, self._wake_out = socket.socketpair()
        for each in (self._listener, self._wake_in):
            each.setblocking(False)
            self._selector.register(each, selectors.EVENT_READ)
        self._peers: dict[socket.socket, _Peer] = {}
        self._is_closed = False
        self._thread = threading.Thread(target=self._serve, name="mock plane", daemon=True)
        self._thread.start()

    @property
    def link(self) -> str:
        """Link string of the plane."""
        return f"tcp:127.0.0.1:{self._listener.getsockname()[1]}"

    def __enter__(self) -> MockPlane:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._is_closed = True
        self._wake_out.send(b"!")
        self._thread.join(10)
        for sock in (*self._peers, self._listener, self._wake_in, self._wake_out):
            sock.close()
        self._selector.close()

    def do(self, job: Callable[[], None]) -> None:
        """Run a function in the plane's own thread, between two messages."""
        with self._lock:
            self._jobs.append(job)
        self._wake_out.send(b"!")

    def say(self, *messages: Any) -> None:
        """Send messages to all stations. In the plane's own thread only."""
        self._out.data.clear()
        for message in messages:
            if isinstance(message, bytes):
                self._out.data += message
            else:
                message.pack(self._writer)
                self._writer.send(message)
        data = bytes(self._out.data)
        for sock in list(self._peers):
            try:
                sock.sendall(data)
            except OSError:
                self._drop(sock)

    def cut(self, *, reset: bool = True) -> None:
        """Close all connections, by a TCP reset or regularly. In the plane's own thread only."""
        for sock in list(self._peers):
            if reset:
                sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
            self._drop(sock)

    def reboot(self) -> None:
        """Reboot like ArduPlane: transfers forgotten, clock from zero. In the plane's own thread only."""
        self._incoming, self.boot_ms = None, 0
        self.custom_mode, self.is_armed = 0, False
        self.say(*self._beat())

    def acts(self) -> list[str]:
        """Return the received messages that move a plane."""
        found = []
        for name, message in list(self.received):
            if name in ACTS or (name in ("COMMAND_LONG", "COMMAND_INT") and message.command in ACT_COMMANDS):
                found.append(f"{name} {getattr(message, 'command', '')}")
        return found

    # The plane's own thread ------------------------------------------------------------------------------------------

    def _serve(self) -> None:
        beat_due = time.monotonic()
        while not self._is_closed:
            for key, _ in self._selector.select(max(0.0, beat_due - time.monotonic())):
                if key.fileobj is self._listener:
                    self._accept()
                elif key.fileobj is self._wake_in:
                    self._wake_in.recv(4096)
                else:
                    self._read(key.fileobj)  # type: ignore[arg-type]
            with self._lock:
                jobs, self._jobs = self._jobs, []
            for job in jobs:
                job()
            if time.monotonic() >= beat_due:
                beat_due = time.monotonic() + HEARTBEAT_S
                self.boot_ms += int(HEARTBEAT_S * 1e3)
                self.say(*self._beat())

    def _beat(self) -> list[Any]:
        if not self.heartbeats:
            return []
        armed = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if self.is_armed else 0
        return [
            mavlink.MAVLink_heartbeat_message(1, 3, armed | 1, self.custom_mode, 4, 3),
            mavlink.MAVLink_system_time_message(0, self.boot_ms),
        ]

    def _accept(self) -> None:
        sock, _ = self._listener.accept()
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._peers[sock] = _Peer(sock)
        self._selector.register(sock, selectors.EVENT_READ)
        self.connections += 1
        self.say(*self._beat())

    def _drop(self, sock: socket.socket) -> None:
        if self._peers.pop(sock, None) is not None:
            self._selector.unregister(sock)
            sock.close()

    def _read(self, sock: socket.socket) -> None:
        peer = self._peers.get(sock)
        if peer is None:
            return
        try:
            data = sock.recv(65536)
        except OSError:
            data = b""
        if not data:
            self._drop(sock)
            return
        for message in peer.reader.parse_buffer(data) or ():
            self.received.append((message.get_type(), message))
            own = self.on_message(message) if self.on_message is not None else None
            self.say(*(self._answer(message) if own is None else own))

    def _answer(self, message: Any) -> list[Any]:
        name = message.get_type()
        if getattr(message, "target_system", self.system_id) not in (0, self.system_id):
            return []
        answer = getattr(self, f"_on_{name.lower()}", None)
        return [] if answer is None else answer(message)

    def ack(self, message: Any, result: int = 0, *, progress: int = 0) -> Any:
        """Return a COMMAND_ACK to the sender of a command."""
        target = (message.get_srcSystem(), message.get_srcComponent())
        return mavlink.MAVLink_command_ack_message(message.command, result, progress, 0, *target)

    def _on_command_long(self, message: Any) -> list[Any]:
        if message.command == mavlink.MAV_CMD_DO_SET_MODE:
            self.custom_mode = int(message.param2)
        elif message.command == mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
            self.is_armed = message.param1 == 1
        elif message.command == mavlink.MAV_CMD_REQUEST_MESSAGE:
            return [self.ack(message, mavlink.MAV_RESULT_UNSUPPORTED)]
        return [self.ack(message), *self._beat()]

    def _on_command_int(self, message: Any) -> list[Any]:
        return self._on_command_long(message) if message.command not in ACT_COMMANDS else [self.ack(message)]

    def _on_file_transfer_protocol(self, message: Any) -> list[Any]:
        request = bytes(message.payload)
        answer = bytearray(251)
        answer[0:2] = (int.from_bytes(request[0:2], "little") + 1 & 0xFFFF).to_bytes(2, "little")
        answer[2:6] = bytes([request[2], 129, 1, request[3]])
        answer[12] = 7  # unknown command: this plane has no MAVFTP
        return [
            mavlink.MAVLink_file_transfer_protocol_message(
                0, message.get_srcSystem(), message.get_srcComponent(), answer
            )
        ]

    def _on_mission_count(self, message: Any) -> list[Any]:
        sender = (message.get_srcSystem(), message.get_srcComponent())
        if self._incoming is not None and self._incoming[0:2] != sender:
            return [mavlink.MAVLink_mission_ack_message(*sender, mavlink.MAV_MISSION_DENIED, message.mission_type)]
        self._incoming = (*sender, [], message)
        return self._next_request()

    def _next_request(self) -> list[Any]:
        assert self._incoming is not None
        system, component, items, count = self._incoming
        if len(items) < count.count:
            return [mavlink.MAVLink_mission_request_int_message(system, component, len(items), count.mission_type)]
        self.items[count.mission_type] = items
        self._incoming = None
        return [mavlink.MAVLink_mission_ack_message(system, component, 0, count.mission_type)]

    def _on_mission_item_int(self, message: Any) -> list[Any]:
        sender = (message.get_srcSystem(), message.get_srcComponent())
        if self._incoming is None or self._incoming[0:2] != sender:
            return [mavlink.MAVLink_mission_ack_message(*sender, mavlink.MAV_MISSION_DENIED, message.mission_type)]
        if message.seq != len(self._incoming[2]):
            return [
                mavlink.MAVLink_mission_ack_message(*sender, mavlink.MAV_MISSION_INVALID_SEQUENCE, message.mission_type)
            ]
        self._incoming[2].append(message)
        return self._next_request()

    def _on_mission_ack(self, message: Any) -> list[Any]:
        if message.type != 0 and self._incoming is not None:
            self._incoming = None
        return []

    def _on_mission_request_list(self, message: Any) -> list[Any]:
        sender = (message.get_srcSystem(), message.get_srcComponent())
        kind = message.mission_type
        return [mavlink.MAVLink_mission_count_message(*sender, len(self.items[kind]), kind)]

    def _on_mission_request_int(self, message: Any) -> list[Any]:
        sender = (message.get_srcSystem(), message.get_srcComponent())
        stored = self.items[message.mission_type]
        if message.seq >= len(stored):
            return [
                mavlink.MAVLink_mission_ack_message(*sender, mavlink.MAV_MISSION_INVALID_SEQUENCE, message.mission_type)
            ]
        item = stored[message.seq]
        fields = [getattr(item, name) for name in item.fieldnames[2:]]
        return [mavlink.MAVLink_mission_item_int_message(*sender, *fields)]

    def _on_mission_clear_all(self, message: Any) -> list[Any]:
        self.items[message.mission_type] = []
        sender = (message.get_srcSystem(), message.get_srcComponent())
        return [mavlink.MAVLink_mission_ack_message(*sender, 0, message.mission_type)]

    def _param(self, name: str) -> Any:
        names = sorted(self.params)
        return mavlink.MAVLink_param_value_message(
            name.encode(), self.params[name], mavlink.MAV_PARAM_TYPE_REAL32, len(names), names.index(name)
        )

    def _on_param_request_read(self, message: Any) -> list[Any]:
        names = sorted(self.params)
        name = names[message.param_index] if 0 <= message.param_index < len(names) else message.param_id
        return [self._param(name)] if name in self.params else []

    def _on_param_request_list(self, message: Any) -> list[Any]:
        return [self._param(name) for name in sorted(self.params)]

    def _on_param_set(self, message: Any) -> list[Any]:
        if message.param_id not in self.params:
            return []
        self.params[message.param_id] = message.param_value
        return [self._param(message.param_id)]
