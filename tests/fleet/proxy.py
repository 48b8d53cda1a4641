"""A way that can be cut: what goes between two programs over TCP goes through here."""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Iterator

__all__ = ["Way", "open_way"]


class Way:
    """Passes bytes on in both directions until it is cut; then they vanish, and neither end hears of it."""

    def __init__(self, to_port: int) -> None:
        self._to_port = to_port
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
                    threading.Thread(target=self._pass_on, args=(one, other), daemon=True).start()

    def _pass_on(self, one: socket.socket, other: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := one.recv(65536):
                if self._is_open.is_set():
                    other.sendall(data)
        for each in (one, other):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)


@contextlib.contextmanager
def open_way(to_port: int) -> Iterator[Way]:
    """A way to this port of this machine."""
    way = Way(to_port)
    try:
        yield way
    finally:
        way.close()
