"""A way that can be cut: what goes between two programs over TCP goes through here."""

from __future__ import annotations

import contextlib
import queue
import socket
import threading
import time
from collections.abc import Iterator

__all__ = ["Way", "open_way"]


class Way:
    """Passes bytes on in both directions until it is cut; then they vanish, and neither end hears of it.

    Each arrives ``delay_s`` after it was sent, in order.
    """

    def __init__(self, to_port: int, delay_s: float = 0.0) -> None:
        self._to_port = to_port
        self._delay_s = delay_s
        self._is_open = threading.Event()
        self._is_open.set()
        self._sockets: list[socket.socket] = []
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port = int(self._server.getsockname()[1])
        threading.Thread(target=self._accept, daemon=True).start()

    def cut(self) -> None:
        """Let nothing through any more, old or new."""
        self._is_open.clear()

    def heal(self) -> None:
        """Let everything through that comes from now on."""
        self._is_open.set()

    def close(self) -> None:
        """End it."""
        for each in [self._server, *self._sockets]:
            each.close()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):  # closed
            while True:
                near, _ = self._server.accept()
                far = socket.create_connection(("127.0.0.1", self._to_port))
                self._sockets += [near, far]
                for one, other in ((near, far), (far, near)):
                    on_its_way: queue.SimpleQueue[tuple[float, bytes]] = queue.SimpleQueue()
                    threading.Thread(target=self._take, args=(one, on_its_way), daemon=True).start()
                    threading.Thread(target=self._give, args=(other, on_its_way), daemon=True).start()

    def _take(self, one: socket.socket, on_its_way: queue.SimpleQueue[tuple[float, bytes]]) -> None:
        data = b"begun"
        while data:
            try:
                data = one.recv(65536)
            except OSError:
                data = b""
            if self._is_open.is_set() or not data:
                on_its_way.put((time.monotonic() + self._delay_s, data))

    @staticmethod
    def _give(other: socket.socket, on_its_way: queue.SimpleQueue[tuple[float, bytes]]) -> None:
        with contextlib.suppress(OSError):
            while True:
                due, data = on_its_way.get()
                time.sleep(max(0.0, due - time.monotonic()))
                if not data:
                    break
                other.sendall(data)
        with contextlib.suppress(OSError):
            other.shutdown(socket.SHUT_RDWR)


@contextlib.contextmanager
def open_way(to_port: int, delay_s: float = 0.0) -> Iterator[Way]:
    """A way to this port of this machine."""
    way = Way(to_port, delay_s)
    try:
        yield way
    finally:
        way.close()
