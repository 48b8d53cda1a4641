"""The simulator's loop: sockets, pace and shutdown.

One thread does everything. It never waits for a client: sockets do not block, each connection has bounded queues,
and a client that misbehaves or does not read affects no other.
"""

from __future__ import annotations

import contextlib
import errno
import importlib.util
import math
import selectors
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from vencejo.sim.autopilot.interface import DT_S
from vencejo.sim.config import LinkSpec, SimOptions, parse_link
from vencejo.sim.hand import CARRY_HEIGHT_M
from vencejo.sim.mavlink.component import AutopilotFactory, PlaneComponent
from vencejo.sim.mavlink.link import Link
from vencejo.sim.world import World

if TYPE_CHECKING:
    from vencejo.sim.camera.http import CameraServer
    from vencejo.sim.camera.nose import NoseCamera

__all__ = ["Listening", "SimServer", "SimulatedPlane", "run"]

_T = TypeVar("_T")

_RECEIVE_BYTES = 65536
_SEND_BYTES = 65536
_LOOP_TICKS = 2
"""Period of ArduPlane's main loop, which handles received messages: 20 ms (SCHED_LOOP_RATE 50)."""
_INBOX_BYTES = 1 << 20
"""Most bytes that wait for the main loop; beyond it they are handled at once, which bounds the memory."""
_MAX_CLIENTS = 64
"""Most connections of one server; further ones are closed at once."""
_BACKLOG = 128
"""Most connections waiting to be accepted."""
_MAX_BACKLOG_S = 0.25
"""Real time that the simulation may fall behind before its clock is reset."""
_MAX_BURST_S = 0.02
"""Longest real time of simulation between two polls of the sockets."""
_TICKS_PER_FLUSH = 10
_LEAST_SPEEDUP = 0.01
"""Lowest speed-up; below it time would appear to stand still."""
_IDLE_S = 0.05
_TURN_S = 0.02
"""Real time between two bursts while no messages arrive: waking up for a tick costs more than the tick."""


class Listening(NamedTuple):
    """A link that is open."""

    link: str
    """Link string for a station, with the bound port."""
    system_ids: tuple[int, ...]
    """System ids of its planes."""


class _Pace:
    """Schedules ticks for a speed-up. With ``inf`` one is always due."""

    def __init__(self, speedup: float, now_s: float) -> None:
        self._tick_s = DT_S / speedup
        self._next_s = now_s

    def change(self, speedup: float, now_s: float) -> None:
        """Change the speed-up from now on."""
        self._tick_s = DT_S / speedup
        self._next_s = now_s

    def due(self, now_s: float) -> bool:
        if self._tick_s == 0:
            return True
        if now_s - self._next_s > max(_MAX_BACKLOG_S, self._tick_s):
            self._next_s = now_s
        return now_s >= self._next_s

    def ticked(self) -> None:
        self._next_s += self._tick_s

    def wait_s(self, now_s: float, least_s: float) -> float:
        """Time until the next tick, at least ``least_s`` and at most the idle limit."""
        return 0.0 if self._tick_s == 0 else min(max(least_s, self._next_s - now_s), _IDLE_S)


class _Connection:
    """A socket with its link. With ``datagrams`` each has one frame, and errors are ignored."""

    def __init__(self, sock: socket.socket, name: str, *, datagrams: bool, is_usb: bool) -> None:
        sock.setblocking(False)
        self.socket = sock
        self.link = Link(name, is_usb=is_usb)
        self._datagrams = datagrams
        self._unsent = b""

    @property
    def wants_write(self) -> bool:
        return bool(self._unsent)

    def flush(self) -> bool:
        """Send queued frames; False when the connection is broken."""
        if self.link.failed:
            return False
        try:
            if self._datagrams:
                self._flush_datagrams()
            else:
                self._flush_stream()
        except BlockingIOError:
            pass
        except OSError:
            return self._datagrams
        return True

    def _flush_stream(self) -> None:
        while True:
            if not self._unsent:
                self._unsent = b"".join(self.link.take(_SEND_BYTES))
                if not self._unsent:
                    return
            sent = self.socket.send(self._unsent)
            self._unsent = self._unsent[sent:]

    def _flush_datagrams(self) -> None:
        for frame in self.link.take(1 << 20):
            # No receiver yet, or a full buffer: the datagram is lost.
            with contextlib.suppress(ConnectionRefusedError):
                self.socket.send(frame)

    def read(self) -> bytes | None:
        """Received bytes; empty when there are none, None when the connection has ended."""
        try:
            data = self.socket.recv(_RECEIVE_BYTES)
        except BlockingIOError:
            return b""
        except OSError:
            return b"" if self._datagrams else None
        return data if data or self._datagrams else None


class _Listener(NamedTuple):
    socket: socket.socket
    planes: list[PlaneComponent]
    is_usb: bool


class SimServer:
    """Simulated planes on real links.

    Parameters
    ----------
    options : SimOptions
    autopilot : callable, optional
        Factory of the flying half of each plane; tests pass a double.

    Raises
    ------
    OSError
        A link cannot be opened; the message names it.
    """

    def __init__(self, options: SimOptions, *, autopilot: AutopilotFactory | None = None) -> None:
        self.options = options
        self.world = World(options, autopilot=autopilot)
        self.listening: list[Listening] = []
        self._selector = selectors.DefaultSelector()
        self._listeners: list[_Listener] = []
        self._connections: list[_Connection] = []
        self.cameras: CameraServer | None = None
        self._noses: dict[PlaneComponent, NoseCamera] = {}
        self._ticks = 0
        self._inbox: list[tuple[Link, bytes]] = []
        """Bytes received since the last main loop."""
        self._inbox_bytes = 0
        self._calls: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._wake_receive, self._wake_send = socket.socketpair()
        self._wake_receive.setblocking(False)
        self._wake_send.setblocking(False)
        for plane in self.world.planes:
            # Rehearsals recognise this simulation by its step: ArduPilot's simulator has the same parameters.
            plane.params.set("SIM_RATE_HZ", 1.0 / DT_S)
            if math.isfinite(options.speedup):
                plane.params.set("SIM_SPEEDUP", options.speedup)
        self._selector.register(self._wake_receive, selectors.EVENT_READ, None)
        try:
            for number, text in enumerate(options.links):
                for spec, planes in self._shares(parse_link(text)):
                    # As on ArduPilot the first link is the USB port.
                    self._open(spec, planes, is_usb=number == 0)
            if options.camera is not None:
                self._open_cameras(options.camera)
        except BaseException:
            self.close()
            raise

    @property
    def clients(self) -> int:
        """Number of connections."""
        return len(self._connections)

    def serve(self, stop: threading.Event) -> None:
        """Simulate and serve until ``stop`` is set (call :meth:`wake` after it)."""
        pace = _Pace(self.options.speedup, time.monotonic())
        speedups = [self._speedup(plane) for plane in self.world.planes]
        was_asked = False
        while not stop.is_set():
            self._burst(pace)
            for number, plane in enumerate(self.world.planes):
                if (speedup := self._speedup(plane)) != speedups[number]:
                    # One clock for all planes: the last change decides.
                    speedups[number] = speedup
                    pace.change(speedup, time.monotonic())
            self._flush()
            self._show()
            # After a message, the next tick is not delayed: it may have the answer.
            was_asked = self._poll(pace.wait_s(time.monotonic(), 0.0 if was_asked else _TURN_S))

    @staticmethod
    def _speedup(plane: PlaneComponent) -> float:
        """SIM_SPEEDUP, which changes the speed-up at run time as in ArduPilot's simulator."""
        return max(_LEAST_SPEEDUP, plane.params.get("SIM_SPEEDUP"))

    def wake(self) -> None:
        """Wake the loop for its stop event and calls. May be called from any thread."""
        with contextlib.suppress(OSError):
            self._wake_send.send(b"\0")

    def submit(self, call: Callable[[], None]) -> None:
        """Run a call in the loop. May be called from any thread."""
        self._calls.put(call)
        self.wake()

    def close(self) -> None:
        """Close every socket."""
        if self.cameras is not None:
            self.cameras.close()
        for connection in list(self._connections):
            self._drop(connection)
        for listener in self._listeners:
            listener.socket.close()
        self._listeners.clear()
        self._selector.close()
        self._wake_receive.close()
        self._wake_send.close()

    def _shares(self, spec: LinkSpec) -> Iterator[tuple[LinkSpec, list[PlaneComponent]]]:
        if self.options.ports == "shared":
            yield spec, self.world.planes
            return
        for number, plane in enumerate(self.world.planes):
            yield spec.shifted(number), [plane]

    def _open(self, spec: LinkSpec, planes: list[PlaneComponent], *, is_usb: bool) -> None:
        try:
            family, _, _, _, address = socket.getaddrinfo(
                spec.host, spec.port, type=socket.SOCK_STREAM if spec.kind == "tcp" else socket.SOCK_DGRAM
            )[0]
            if spec.kind == "tcp":
                sock = socket.create_server(address[:2], family=family, backlog=_BACKLOG)
            else:
                sock = socket.socket(family, socket.SOCK_DGRAM)
                sock.connect(address)
        except OSError as error:
            raise OSError(error.errno, f"link {spec}: {error.strerror or error}") from error
        if spec.kind == "tcp":
            sock.setblocking(False)
            listener = _Listener(sock, planes, is_usb)
            self._listeners.append(listener)
            self._selector.register(sock, selectors.EVENT_READ, listener)
            spec = LinkSpec("tcp", spec.host, sock.getsockname()[1])
        else:
            self._connect(_Connection(sock, str(spec), datagrams=True, is_usb=is_usb), planes)
        self.listening.append(Listening(str(spec), tuple(plane.system_id for plane in planes)))

    def _open_cameras(self, address: str) -> None:
        from vencejo.sim.camera.http import CameraServer, parse_address
        from vencejo.sim.camera.nose import NoseCamera

        if importlib.util.find_spec("cv2") is None:
            raise ValueError("camera: OpenCV is not installed: pip install 'vencejo[camera]'")
        place = parse_address(address)
        self._noses = {plane: NoseCamera(plane.heading_deg, self.options.camera_rate_hz) for plane in self.world.planes}
        self.cameras = CameraServer(place, {plane.system_id: nose for plane, nose in self._noses.items()})

    def _show(self) -> None:
        """Pass the poses of the planes to the cameras with viewers."""
        for plane, nose in self._noses.items():
            if nose.watched:
                nose.see(time.time(), plane.autopilot.outlook())

    def _connect(self, connection: _Connection, planes: list[PlaneComponent]) -> None:
        self._connections.append(connection)
        self._selector.register(connection.socket, selectors.EVENT_READ, connection)
        self.world.attach(connection.link, planes)

    def _drop(self, connection: _Connection) -> None:
        self._handle_inbox()
        self._connections.remove(connection)
        self.world.detach(connection.link)
        self._selector.unregister(connection.socket)
        connection.socket.close()

    def _burst(self, pace: _Pace) -> None:
        """Run the ticks that are due, with a pause for the sockets when they are many."""
        started = now = time.monotonic()
        ticks = 0
        while pace.due(now):
            self.world.tick()
            pace.ticked()
            self._ticks += 1
            if self._ticks % _LOOP_TICKS == 0:
                self._handle_inbox()
            ticks += 1
            if ticks % _TICKS_PER_FLUSH == 0:
                self._flush()
            now = time.monotonic()
            if now - started > _MAX_BURST_S:
                return

    def _flush(self) -> None:
        for connection in list(self._connections):
            if not connection.link.pending and not connection.wants_write:
                continue
            if not connection.flush():
                self._drop(connection)
                continue
            events = selectors.EVENT_READ | (selectors.EVENT_WRITE if connection.wants_write else 0)
            if self._selector.get_key(connection.socket).events != events:
                self._selector.modify(connection.socket, events, connection)

    def _poll(self, timeout_s: float) -> bool:
        """Handle the sockets until the time-out; True when anything arrived."""
        heard = self._selector.select(timeout_s)
        for key, events in heard:
            owner: Any = key.data
            if owner is None:
                self._woken()
            elif isinstance(owner, _Listener):
                self._accept(owner)
            elif events & selectors.EVENT_READ and owner in self._connections:
                self._read(owner)
        self._flush()
        return bool(heard)

    def _read(self, connection: _Connection) -> None:
        data = connection.read()
        if data is None:
            self._drop(connection)
        elif data:
            self._inbox.append((connection.link, data))
            self._inbox_bytes += len(data)
            if self._inbox_bytes > _INBOX_BYTES:
                self._handle_inbox()

    def _handle_inbox(self) -> None:
        inbox, self._inbox, self._inbox_bytes = self._inbox, [], 0
        for link, data in inbox:
            self.world.receive(link, data)

    def _accept(self, listener: _Listener) -> None:
        for _ in range(_BACKLOG):
            try:
                sock, address = listener.socket.accept()
            except BlockingIOError:
                return
            except OSError as error:
                if error.errno in (errno.EMFILE, errno.ENFILE):
                    time.sleep(_IDLE_S)  # no descriptor left: do not spin on the waiting client
                return
            if len(self._connections) >= _MAX_CLIENTS:
                sock.close()
                continue
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            name = f"tcp client {address[0]}:{address[1]}"
            self._connect(_Connection(sock, name, datagrams=False, is_usb=listener.is_usb), listener.planes)

    def _woken(self) -> None:
        with contextlib.suppress(BlockingIOError):
            while self._wake_receive.recv(4096):
                pass
        while True:
            try:
                call = self._calls.get_nowait()
            except Empty:
                return
            call()


def run(
    options: SimOptions,
    *,
    on_listening: Callable[[Listening], None] | None = None,
    on_camera: Callable[[int, str, str], None] | None = None,
    until: Callable[[], object] | None = None,
) -> None:
    """Simulate until SIGINT or SIGTERM (signals only when called from the main thread).

    Parameters
    ----------
    options : SimOptions
    on_listening : callable, optional
        Called with each link once it is open.
    on_camera : callable, optional
        Called with each camera: system id, URL of the stream, URL of single pictures.
    until : callable, optional
        Called in a thread of its own; the simulation ends when it returns.

    Raises
    ------
    OSError
        A link or the camera's port cannot be opened.
    ValueError
        The camera's address is wrong, or OpenCV is missing.
    """
    server = SimServer(options)
    stop = threading.Event()

    def end() -> None:
        stop.set()
        server.wake()

    def ask_to_stop(_number: int, _frame: object) -> None:
        end()

    def wait(returns: Callable[[], object]) -> None:
        returns()
        end()

    before: dict[signal.Signals, Any] = {}
    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGINT, signal.SIGTERM):
            before[number] = signal.signal(number, ask_to_stop)
    try:
        for link in server.listening:
            if on_listening is not None:
                on_listening(link)
        if server.cameras is not None and on_camera is not None:
            for plane in server.world.planes:
                system = plane.system_id
                on_camera(system, server.cameras.stream_url(system), server.cameras.snapshot_url(system))
        if until is not None:
            threading.Thread(target=wait, args=(until,), name="vencejo-sim-until", daemon=True).start()
        server.serve(stop)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        server.close()


class SimulatedPlane:
    """Simulated planes in a thread of this process, for tests and examples.

    Parameters
    ----------
    options : SimOptions, optional
        A plane at the default home on a free TCP port when omitted.
    autopilot : callable, optional
        Factory of the flying half of each plane; the real one when omitted.

    Examples
    --------
    >>> with SimulatedPlane(SimOptions(links=("tcp:127.0.0.1:0",), speedup=10.0)) as sim:  # doctest: +SKIP
    ...     print(sim.link)
    tcp:127.0.0.1:41327
    """

    def __init__(self, options: SimOptions | None = None, *, autopilot: AutopilotFactory | None = None) -> None:
        self.options = options if options is not None else SimOptions(links=("tcp:127.0.0.1:0",))
        self._server = SimServer(self.options, autopilot=autopilot)
        self._stop = threading.Event()
        self._failure: BaseException | None = None
        self._thread = threading.Thread(target=self._serve, name="vencejo-sim", daemon=True)
        self._thread.start()

    @property
    def link(self) -> str:
        """Link string of the first link, with its port."""
        return self._server.listening[0].link

    @property
    def links(self) -> tuple[str, ...]:
        """Link strings of all links."""
        return tuple(listening.link for listening in self._server.listening)

    @property
    def port(self) -> int:
        """Port of the first link."""
        return parse_link(self.link).port

    @property
    def clients(self) -> int:
        """Number of connections."""
        return self._server.clients

    @property
    def camera(self) -> str | None:
        """Address of the first plane's video stream; None without ``camera`` in the options."""
        cameras = self._server.cameras
        return None if cameras is None else cameras.stream_url(self.options.first_system_id)

    @property
    def snapshot(self) -> str | None:
        """Address of the first plane's single pictures; None without ``camera`` in the options."""
        cameras = self._server.cameras
        return None if cameras is None else cameras.snapshot_url(self.options.first_system_id)

    def call(self, function: Callable[[World], _T], *, timeout_s: float = 30.0) -> _T:
        """Run a function between two ticks in the simulator's thread and return its result.

        Raises
        ------
        RuntimeError
            The simulator has stopped.
        TimeoutError
            The simulator did not run it in time.
        """
        future: Future[_T] = Future()

        def work() -> None:
            try:
                future.set_result(function(self._server.world))
            except BaseException as error:  # noqa: BLE001  (handed to the caller)
                future.set_exception(error)

        if not self._thread.is_alive():
            raise RuntimeError("the simulator has stopped") from self._failure
        self._server.submit(work)
        return future.result(timeout_s)

    def hold(
        self,
        roll_deg: float,
        pitch_deg: float,
        yaw_deg: float,
        *,
        seconds: float = 0.0,
        north_m: float = 0.0,
        east_m: float = 0.0,
        up_m: float = CARRY_HEIGHT_M,
        plane: int = 0,
    ) -> None:
        """Hold a plane by hand, disarmed and on the ground: sets its true attitude, which its sensors show.

        Returns immediately; telemetry shows it from the next message on.

        Parameters
        ----------
        roll_deg, pitch_deg, yaw_deg : float
            Attitude: right wing down, nose up, degrees true.
        seconds : float
            Simulated duration of the turn, which the gyroscopes measure; 0 is immediate.
        north_m, east_m, up_m : float
            Offset from the point where it was picked up.
        plane : int
            Number of the plane, from 0.

        Raises
        ------
        RuntimeError
            The plane is armed, or not at rest on the ground.
        ValueError
            A number is not finite.

        Examples
        --------
        >>> with SimulatedPlane() as sim:  # doctest: +SKIP
        ...     sim.hold(30.0, -10.0, 120.0)
        ...     sim.release()
        """
        self.call(
            lambda world: world.hold(
                roll_deg,
                pitch_deg,
                yaw_deg,
                seconds=seconds,
                north_m=north_m,
                east_m=east_m,
                up_m=up_m,
                plane=plane,
            )
        )

    def release(self, *, plane: int = 0) -> None:
        """Put a held plane down, in place and with its heading; no effect on one that is not held."""
        self.call(lambda world: world.release(plane=plane))

    def close(self) -> None:
        """Stop and close every socket; may be called again.

        Raises
        ------
        RuntimeError
            The simulator had failed.
        """
        self._stop.set()
        self._server.wake()
        self._thread.join()
        if self._failure is not None:
            failure, self._failure = self._failure, None
            raise RuntimeError(f"the simulator failed: {failure}") from failure

    def __enter__(self) -> SimulatedPlane:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _serve(self) -> None:
        try:
            self._server.serve(self._stop)
        except BaseException as error:  # noqa: BLE001  (raised by close())
            self._failure = error
        finally:
            self._server.close()
