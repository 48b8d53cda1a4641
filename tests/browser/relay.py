"""Networks that fail: a TCP relay that can be cut, and a UDP relay that loses frames. Both pass bytes on untouched."""

from __future__ import annotations

import contextlib
import random
import selectors
import socket
import threading
from types import TracebackType
from typing import TypeVar

_Relay = TypeVar("_Relay", bound="_Loop")
_BYTES = 65536


class _Loop:
    """A thread with a selector; what the tests tell it is done between two events."""

    def __init__(self) -> None:
        self._selector = selectors.DefaultSelector()
        self._wake_out, self._wake_in = socket.socketpair()
        self._selector.register(self._wake_out, selectors.EVENT_READ)
        self._is_over = False
        self._lock = threading.RLock()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self: _Relay) -> _Relay:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._is_over = True
        self._wake_in.send(b"\0")
        self._thread.join(10)
        with self._lock:
            self._close_all()
        self._selector.close()
        self._wake_in.close()
        self._wake_out.close()

    def _run(self) -> None:
        while not self._is_over:
            events = self._selector.select()
            with self._lock:
                for key, _ in events:
                    if key.fileobj is not self._wake_out and key.fd >= 0:
                        self._on_readable(key.fileobj)  # type: ignore[arg-type]

    def _on_readable(self, sock: socket.socket) -> None:
        raise NotImplementedError

    def _close_all(self) -> None:
        raise NotImplementedError


class TcpRelay(_Loop):
    """Passes TCP connections on to a port of this machine.

    `silence` is a network that swallows everything without a word, for connections old and new; those made before
    `restore` never work again, as after a change of network. `hang_up` ends every connection, and ends new ones at once.
    """

    def __init__(self, port: int) -> None:
        super().__init__()
        self._far_port = port
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._other: dict[socket.socket, socket.socket] = {}
        self._dead: set[socket.socket] = set()
        self._state = "open"

    @property
    def port(self) -> int:
        """Where to connect to."""
        return int(self._listener.getsockname()[1])

    def silence(self) -> None:
        """Drop all packets silently from now on."""
        with self._lock:
            self._state = "silent"
            self._dead |= self._other.keys()
            self._other.clear()

    def hang_up(self) -> None:
        """All connections end, and new ones end at once."""
        with self._lock:
            self._state = "closed"
            self._close_connections()

    def restore(self) -> None:
        """New connections pass again."""
        with self._lock:
            self._state = "open"

    def _on_readable(self, sock: socket.socket) -> None:
        if sock is self._listener:
            self._accept()
        elif sock in self._dead:
            try:
                data = sock.recv(_BYTES)
            except OSError:
                data = b""
            if not data:
                self._drop(sock)
        elif sock in self._other:
            try:
                data = sock.recv(_BYTES)
                if data:
                    self._other[sock].sendall(data)
            except OSError:
                data = b""
            if not data:
                self._drop(sock)

    def _accept(self) -> None:
        near, _ = self._listener.accept()
        if self._state == "closed":
            near.close()
        elif self._state == "silent":
            self._dead.add(near)
            self._selector.register(near, selectors.EVENT_READ)
        else:
            try:
                far = socket.create_connection(("127.0.0.1", self._far_port))
            except OSError:
                near.close()
                return
            for one, other in ((near, far), (far, near)):
                one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._other[one] = other
                self._selector.register(one, selectors.EVENT_READ)

    def _drop(self, sock: socket.socket) -> None:
        """Ends a connection; of a dead one only this end, because the other is not to hear of it."""
        ends = [sock]
        if sock not in self._dead and (other := self._other.pop(sock, None)) is not None:
            self._other.pop(other, None)
            ends.append(other)
        self._dead.discard(sock)
        for end in ends:
            with contextlib.suppress(KeyError, ValueError):
                self._selector.unregister(end)
            end.close()

    def _close_connections(self) -> None:
        for sock in {*self._other, *self._dead}:
            with contextlib.suppress(KeyError, ValueError):
                self._selector.unregister(sock)
            sock.close()
        self._other.clear()
        self._dead.clear()

    def _close_all(self) -> None:
        self._close_connections()
        self._listener.close()


class LossyRelay(_Loop):
    """Passes datagrams, each of them one frame, between a plane and a driver, and loses a share of them both ways."""

    def __init__(self, *, seed: int) -> None:
        super().__init__()
        self.loss = 0.0
        """Share of the frames that are lost, 0 to 1."""
        self._random = random.Random(seed)
        self._ends = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2)]
        self._peers: list[tuple[str, int] | None] = [None, None]
        for end in self._ends:
            end.bind(("127.0.0.1", 0))
            self._selector.register(end, selectors.EVENT_READ)

    @property
    def plane_link(self) -> str:
        """Link string for the plane."""
        return f"udpout:127.0.0.1:{self._ends[0].getsockname()[1]}"

    @property
    def driver_link(self) -> str:
        """Link string for the driver."""
        return f"udpout:127.0.0.1:{self._ends[1].getsockname()[1]}"

    def _on_readable(self, sock: socket.socket) -> None:
        side = self._ends.index(sock)
        try:
            data, self._peers[side] = sock.recvfrom(_BYTES)
        except OSError:
            return
        peer = self._peers[1 - side]
        if peer is not None and self._random.random() >= self.loss:
            with contextlib.suppress(OSError):
                self._ends[1 - side].sendto(data, peer)

    def _close_all(self) -> None:
        for end in self._ends:
            end.close()
