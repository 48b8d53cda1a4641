"""Authorisation of requests to the Ice interfaces, and the limit of connections."""

from __future__ import annotations

import contextlib
import hmac
import ipaddress
import os
import socket
import threading
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Any, Final, NamedTuple
from urllib.parse import urlsplit

from vencejo.control import Operator
from vencejo.jderobot.runtime import tolerant
from vencejo.jderobot.settings import Network, is_loopback
from vencejo.jderobot.subject import LOG
from vencejo.serve import Tokens

__all__ = [
    "ConnectionLimit",
    "Gate",
    "Peer",
    "Presence",
    "below_home",
    "despite_mixed_plan",
    "peer_of",
    "raise_file_limit",
    "remote_address",
    "web_origin",
]

_DESCRIPTORS: Final = Path("/proc/self/fd")
_LOOK_S: Final = 0.5
_RECHECK_S: Final = 1.0
"""How often the tokens of connections that have acted are checked."""
_SPARE_FILES: Final = 512
"""Descriptors for everything but Ice's connections."""
READS: Final = frozenset(
    {
        "getPose3DData", "getNavdata", "getMissionData", "getImageData", "getImageFormat", "getImageDescription",
        "getCameraDescription", "startCameraStreaming", "stopCameraStreaming",
        "vehicles", "getPose", "getNavigation", "subscribe", "subscribeHere", "unsubscribe",
        "check", "download", "getPlanState", "getProgress", "modes",
        "ice_ping", "ice_isA", "ice_id", "ice_ids",
    }
)  # fmt: skip
"""Operations that a viewer may call."""


class Gate:
    """Decides whether a request is let through.

    Parameters
    ----------
    tokens : function that gives Tokens, or None
        Called at each request, whose context has one of them under ``token``, so new ones hold at once. ``None``: no
        token is needed.
    allow : collection of networks
        Networks that need no token: existing programs cannot send one.
    takes_pages : bool, optional
        Whether pages in a browser reach what it guards.
    """

    def __init__(
        self,
        tokens: Callable[[], Tokens | None] | None,
        allow: Collection[Network] = (),
        *,
        takes_pages: bool = False,
    ) -> None:
        self._tokens = tokens
        self._allow = allow
        self._takes_pages = takes_pages

    def standing(self, connection: Any, operation: str, token: str) -> Callable[[], str | None]:
        """A function that returns, at any later time, why a request of this connection would be refused: tokens may be replaced."""
        origin = web_origin(connection) if self._takes_pages else None
        if origin is None and self._tokens is None:
            return lambda: None
        remote = remote_address(connection)
        return lambda: self.refusal(remote, token, operation, origin)

    def refusal(self, remote: str | None, token: str, operation: str, origin: str | None = None) -> str | None:
        """Why a request is refused, ``None`` when it is not.

        Parameters
        ----------
        remote : str or None
            Address that it comes from; ``None`` when it is none of IP.
        token : str
            What it brought, or nothing.
        operation : str
        origin : str or None, optional
            Of the page that it comes from, when a browser sent it. A page speaks with its visitor's address, so its own
            has to be let in too.
        """
        is_known_page = origin is None or self._is_let_in_page(origin)
        if self._tokens is None:
            return None if is_known_page else f"pages of {origin} are not let in: serve the page from this machine"
        if is_known_page and self._is_let_in((remote or "").removeprefix("::ffff:")):
            return None
        given, tokens = token.encode(), self._tokens()
        # Both are compared, whole.
        is_operator = tokens is not None and hmac.compare_digest(given, tokens.operator.encode())
        is_viewer = tokens is not None and hmac.compare_digest(given, tokens.viewer.encode())
        if is_operator or (is_viewer and operation in READS):
            return None
        if is_viewer:
            return f"{operation} needs the operator's token; this is the viewer's"
        return (
            "this driver demands a token: put it into the request's context as 'token', "
            "or let your network in with --ice-allow"
        )

    def _is_let_in(self, remote: str) -> bool:
        try:
            address = ipaddress.ip_address(remote)
        except ValueError:
            return False
        return any(address in network for network in self._allow)

    def _is_let_in_page(self, origin: str) -> bool:
        try:
            host = urlsplit(origin).hostname or ""
        except ValueError:
            return False
        return is_loopback(host) or self._is_let_in(host)


class Presence:
    """Keeps the Ice operator present in the station while a connection that has acted is open and still authorised.

    Control ends within 5 s of the last such connection's end, or of its token's replacement, as sessions over HTTP do.
    """

    def __init__(self, operator: Operator) -> None:
        self._operator = operator
        self._lock = threading.Lock()
        self._known: dict[Any, Callable[[], str | None]] = {}
        """Connection → why its newest request that acted would be refused by now."""
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name="vencejo-ice-presence", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop checking tokens."""
        self._closed.set()
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        while not self._closed.wait(_RECHECK_S):
            self.recheck()

    def recheck(self) -> None:
        """Detach connections whose token has been replaced. Each attaches again when it acts with a new one."""
        with self._lock:
            known = list(self._known.items())
        for connection, refusal in known:
            if refusal() is not None:
                self._gone(connection, refusal)

    def acts(self, connection: Any, refusal: Callable[[], str | None]) -> None:
        """A request that is not a mere read was let through; `refusal` tells why it would no longer be."""
        with self._lock:
            if connection is None:
                return
            is_known = connection in self._known
            self._known[connection] = refusal
        if is_known:
            return
        self._operator.attach()
        # Ice takes a function, which a bound method is not, and calls it at once for a connection that is closed
        # already.
        connection.setCloseCallback(lambda gone: self._gone(gone))

    def _gone(self, connection: Any, refusal: Callable[[], str | None] | None = None) -> None:
        """Detach a connection; if `refusal` is given, only while that is still its newest."""
        with self._lock:
            newest = self._known.get(connection)
            if newest is None or refusal not in (None, newest):
                return
            del self._known[connection]
        self._operator.detach()


class Peer(NamedTuple):
    """The far end of a connection."""

    address: str
    port: int


def peer_of(connection: Any) -> Peer | None:
    """Where a connection comes from; ``None`` for one within the process."""
    info = None if connection is None else connection.getInfo()
    while info is not None:
        remote = getattr(info, "remoteAddress", None)
        if remote:
            return Peer(str(remote), int(info.remotePort))
        info = info.underlying
    return None


def remote_address(connection: Any) -> str | None:
    """The address that a connection comes from; ``None`` for one within the process."""
    peer = peer_of(connection)
    return None if peer is None else peer.address


def web_origin(connection: Any) -> str | None:
    """Origin of the page in a browser that a connection comes from; ``None`` for one of a program."""
    info = None if connection is None else connection.getInfo()
    while info is not None:
        headers = getattr(info, "headers", None)
        if headers is not None:
            return next((value for name, value in headers.items() if name.lower() == "origin"), None)
        info = info.underlying
    return None


def despite_mixed_plan(current: Any) -> bool:
    """Whether the request's context has ``despite_mixed_plan``: then it is done although the mission on board may be mixed."""
    return _is_set(current, "despite_mixed_plan")


def below_home(current: Any) -> bool:
    """Whether the request's context has ``below_home``: then an altitude far below home is meant."""
    return _is_set(current, "below_home")


def _is_set(current: Any, name: str) -> bool:
    if current is None:
        return False
    with tolerant():
        return bool(current.ctx.get(name) == "true")


def raise_file_limit(connections: int) -> None:
    """Raise the limit of open files to this many connections and the other files, as far as the system allows."""
    try:
        import resource
    except ImportError:
        return  # Windows has no such limit
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = connections + _SPARE_FILES
    if soft != resource.RLIM_INFINITY and soft < wanted:
        most = wanted if hard == resource.RLIM_INFINITY else min(wanted, hard)
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))


class ConnectionLimit:
    """Closes connections beyond a limit. Ice 3.7 has none, and a connection that sends nothing never reaches a servant.

    Twice a second it counts this process's sockets on our ports (Linux) and shuts down the newest excess ones; Ice
    handles their end like any other. Elsewhere Ice's own closing of idle connections (60 s) has to suffice.
    """

    def __init__(self, ports: Collection[int], most: int) -> None:
        self._ports = frozenset(ports)
        self._most = most
        self._closed = threading.Event()
        self._known: dict[int, int] = {}
        """Inode of a socket → when it was first seen, by number."""
        self._count = 0
        self._thread: threading.Thread | None = None
        if _DESCRIPTORS.is_dir():
            self._thread = threading.Thread(target=self._run, name="vencejo-ice-limit", daemon=True)
            self._thread.start()

    def close(self) -> None:
        """End the watch."""
        self._closed.set()
        if self._thread is not None:
            self._thread.join(timeout=5.0)

    def _run(self) -> None:
        while not self._closed.wait(_LOOK_S):
            with contextlib.suppress(OSError):  # no descriptor left to look with
                self.look()

    def look(self) -> int:
        """Count the connections, shut down the excess, and return its number."""
        present: list[tuple[int, int]] = []
        for inode, descriptor in self._connections():
            if inode not in self._known:
                self._count += 1
                self._known[inode] = self._count
            present.append((self._known[inode], descriptor))
        present.sort()
        ages = {age for age, _ in present}
        self._known = {inode: age for inode, age in self._known.items() if age in ages}
        excess = present[self._most :]
        for _, descriptor in excess:
            self._shut(descriptor)
        if excess:
            LOG.warning("%d connections beyond %d were closed", len(excess), self._most)
        return len(excess)

    def _connections(self) -> Iterator[tuple[int, int]]:
        for descriptor in _DESCRIPTORS.iterdir():
            try:
                target = str(descriptor.readlink())
            except OSError:
                continue
            if target.startswith("socket:[") and self._is_ours(int(descriptor.name)):
                yield int(target[8:-1]), int(descriptor.name)

    def _is_ours(self, descriptor: int) -> bool:
        """Whether it is a connection to one of our ports. Examined through a duplicate: the descriptor may be reused by now."""
        try:
            with socket.socket(fileno=os.dup(descriptor)) as copy:
                if copy.family not in (socket.AF_INET, socket.AF_INET6) or copy.type != socket.SOCK_STREAM:
                    return False
                copy.getpeername()  # a listening socket has none
                return copy.getsockname()[1] in self._ports
        except OSError:
            return False

    def _shut(self, descriptor: int) -> None:
        with contextlib.suppress(OSError), socket.socket(fileno=os.dup(descriptor)) as copy:
            if copy.getsockname()[1] in self._ports:
                copy.shutdown(socket.SHUT_RDWR)
