"""A way that is long, narrow, lossy, or cut: what goes between two programs over TCP goes through here.

A stream loses nothing: what a packet lost does to it is that all behind it waits until that has been sent again. So loss is a stall here, and so
is a cut, after which what was sent in it arrives.
"""

from __future__ import annotations

import contextlib
import queue
import random
import socket
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass

__all__ = ["HEADERS", "PLAIN", "Line", "Passed", "Way", "open_way"]

HEADERS = 40
"""Bytes of IPv4 and TCP headers (RFC 791, RFC 9293) that each segment takes on the line beside its own."""
SEGMENT = 1400
"""Bytes of a segment at most, on a line that is shaped."""
LEAST_RTO_S = 0.2
"""After this and a round trip TCP sends again what was lost; Linux's least (``TCP_RTO_MIN``)."""
QUEUE_S = 1.0
"""What waits before a narrow line, as in a modem; what is more waits in the sender's own buffers."""


@dataclass(frozen=True)
class Line:
    """What one direction does to what goes over it."""

    delay_s: float = 0.0
    """How much later each segment arrives, in order."""
    jitter_s: float = 0.0
    """Up to how much later still, evenly."""
    loss: float = 0.0
    """Share of segments that are lost, and sent again."""
    kbit_s: float | None = None
    """What it carries, headers included; as much as there is when ``None``."""

    @property
    def is_shaped(self) -> bool:
        """Whether it does anything."""
        return self != PLAIN


PLAIN = Line()
"""As fast as this machine."""


class _Direction:
    """One direction of a way, for all connections over it."""

    def __init__(self, line: Line, seed: int) -> None:
        self.line = line
        self.open = threading.Event()
        self.open.set()
        self.bytes = 0
        self.segments = 0
        self._free_at = 0.0
        self._random = random.Random(seed)
        self._lock = threading.Lock()

    def pass_on(self, size: int) -> tuple[float, float]:
        """When a segment of this size arrives, and how long whoever sends has to wait before the next."""
        line, now = self.line, time.monotonic()
        with self._lock:
            self.bytes += size
            self.segments += 1
            if line.kbit_s is not None:
                self._free_at = max(now, self._free_at) + (size + HEADERS) * 8 / 1000 / line.kbit_s
            late_s = line.delay_s + line.jitter_s * self._random.random()
            while line.loss and self._random.random() < line.loss:
                late_s += 2 * line.delay_s + LEAST_RTO_S
            sent_at = max(now, self._free_at)
        return sent_at + late_s, sent_at - now - QUEUE_S


@dataclass(frozen=True)
class Passed:
    """What has gone over one direction: bytes of the streams, and segments."""

    bytes: int
    segments: int

    @property
    def on_the_line(self) -> int:
        """Bytes with the headers of TCP and IP, without what acknowledges them."""
        return self.bytes + self.segments * HEADERS


class Way:
    """Passes on what comes from those who dial (``up``) and from whom they reach (``down``), until it is cut."""

    def __init__(self, to_port: int, up: Line = PLAIN, down: Line = PLAIN, seed: int = 0) -> None:
        self._to_port = to_port
        self._up, self._down = _Direction(up, seed), _Direction(down, seed + 1)
        self._sockets: list[socket.socket] = []
        self._server = socket.create_server(("127.0.0.1", 0))
        if up.kbit_s is not None:
            # Small, so that whoever sends more than goes through notices.
            self._server.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 8192)
        self.port = int(self._server.getsockname()[1])
        threading.Thread(target=self._accept, daemon=True).start()

    @property
    def up(self) -> Passed:
        """What was sent by those who dial."""
        return Passed(self._up.bytes, self._up.segments)

    @property
    def down(self) -> Passed:
        """What was sent to them."""
        return Passed(self._down.bytes, self._down.segments)

    def cut(self, *, up: bool = True, down: bool = True) -> None:
        """Let nothing through any more, old or new; or nothing in one direction."""
        for direction, is_cut in ((self._up, up), (self._down, down)):
            if is_cut:
                direction.open.clear()

    def heal(self) -> None:
        """Let everything through again."""
        for direction in (self._up, self._down):
            direction.open.set()

    def close(self) -> None:
        """End it."""
        self.heal()
        for each in [self._server, *self._sockets]:
            each.close()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):  # closed
            while True:
                near, _ = self._server.accept()
                threading.Thread(target=self._join, args=(near,), daemon=True).start()

    def _join(self, near: socket.socket) -> None:
        """Reach the other end, as soon as the way is open in both directions."""
        self._up.open.wait()
        self._down.open.wait()
        self._sockets.append(near)
        try:
            far = socket.create_connection(("127.0.0.1", self._to_port))
        except OSError:  # nobody is there
            near.close()
            return
        self._sockets.append(far)
        for one, other, direction in ((near, far, self._up), (far, near, self._down)):
            for each in (one, other):
                each.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            on_its_way: queue.SimpleQueue[tuple[float, bytes]] = queue.SimpleQueue()
            threading.Thread(target=self._take, args=(one, direction, on_its_way), daemon=True).start()
            threading.Thread(target=self._give, args=(other, direction, on_its_way), daemon=True).start()

    @staticmethod
    def _take(one: socket.socket, direction: _Direction, on_its_way: queue.SimpleQueue[tuple[float, bytes]]) -> None:
        most = SEGMENT if direction.line.is_shaped else 65536
        data = b"begun"
        while data:
            try:
                data = one.recv(most)
            except OSError:
                data = b""
            direction.open.wait()
            due, wait_s = direction.pass_on(len(data))
            on_its_way.put((due, data))
            if wait_s > 0:
                time.sleep(wait_s)

    @staticmethod
    def _give(other: socket.socket, direction: _Direction, on_its_way: queue.SimpleQueue[tuple[float, bytes]]) -> None:
        with contextlib.suppress(OSError):
            while True:
                due, data = on_its_way.get()
                time.sleep(max(0.0, due - time.monotonic()))
                direction.open.wait()
                if not data:
                    break
                other.sendall(data)
        with contextlib.suppress(OSError):
            other.shutdown(socket.SHUT_RDWR)


@contextlib.contextmanager
def open_way(to_port: int, *, up: Line = PLAIN, down: Line = PLAIN, seed: int = 0) -> Iterator[Way]:
    """A way to this port of this machine."""
    way = Way(to_port, up, down, seed)
    try:
        yield way
    finally:
        way.close()
