"""Load generators for a station that others use meanwhile, in a process separate from the measurement.

``python -m tests.faults.load KIND TARGET CLIENTS`` prints "ready" when its load is prepared, applies it until its
standard input ends, and then prints its counts as one line of JSON. TARGET is the station's URL, or for ``ice`` its
proxies as JSON.
"""

from __future__ import annotations

import contextlib
import json
import math
import select
import socket
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

from tests.jderobot.support import EMPTY, MALFORMED, address_of, client_of, many_files, raw
from tests.server.client import Client, WebSocket, frame

SOCKETS_OF_A_SESSION = 16
"""Largest number of WebSockets of a session."""
MESSAGES_HZ = 10_000
FRAMES_HZ = 50
BAD_CALLS_HZ = 200
PAGE_HZ = 20
"""Default rate at which a page subscribes to its vehicle."""
PONG = frame(0xA, b"")

Done = Counter[str]
Step = Callable[[], None]


def is_over() -> bool:
    """Return whether standard input has ended."""
    ready, _, _ = select.select([sys.stdin], [], [], 0.0)
    return bool(ready) and not sys.stdin.read(1)


class Crowd:
    """WebSockets that are reopened when they end."""

    def __init__(self, url: str, size: int, done: Done, *, receive_buffer: int | None = None) -> None:
        self._sessions = [Client(url) for _ in range(-(-size // SOCKETS_OF_A_SESSION))]
        for number, session in enumerate(self._sessions):
            session.open_session(name=f"crowd {number}")
        self._open: list[WebSocket | None] = [None] * size
        self._done = done
        self._receive_buffer = receive_buffer
        self.says: list[dict[str, Any]] = []
        """First messages of each."""

    def __len__(self) -> int:
        return len(self._open)

    def at(self, place: int) -> WebSocket | None:
        """Return a WebSocket; ``None`` when the station does not accept it now."""
        found = self._open[place]
        if found is not None:
            return found
        self._done["connections"] += 1
        try:
            found = WebSocket(self._sessions[place // SOCKETS_OF_A_SESSION], receive_buffer=self._receive_buffer)
            if found.status == 101:
                for message in self.says:
                    found.say(**message)
        except (OSError, AssertionError):  # disconnected by the station
            self._done["turned away"] += 1
            return None
        self._done[f"answered {found.status}"] += 1
        self._open[place] = found
        return found

    def end(self, place: int) -> None:
        """Record the end of a WebSocket."""
        found, self._open[place] = self._open[place], None
        if found is not None:
            self._done["ended"] += 1
            found.close()

    def put(self, place: int, data: bytes) -> bool:
        """Send bytes on a WebSocket; return whether they were sent."""
        found = self.at(place)
        if found is None or found.status != 101:
            self.end(place)
            return False
        try:
            found.put(data)
        except OSError:
            self.end(place)
            return False
        return True


@contextlib.contextmanager
def messages(url: str, clients: int, done: Done) -> Iterator[Step]:
    """Send 10,000 messages of a page per second, on new connections as the old ones are closed."""
    crowd, batch = Crowd(url, clients, done), 10
    text = frame(0x1, b'{"type":"unsubscribe","vehicle":9}') * batch
    due = time.monotonic()

    def step() -> None:
        nonlocal due
        for place in range(len(crowd)):
            done["messages"] += batch * crowd.put(place, text)
            due += batch / MESSAGES_HZ
            time.sleep(max(0.0, due - time.monotonic()))

    yield step


@contextlib.contextmanager
def frames(url: str, clients: int, done: Done) -> Iterator[Step]:
    """Send messages of 1 MiB, 50 a second."""
    crowd, big = Crowd(url, clients, done), frame(0x1, bytes(1 << 20))
    due = time.monotonic()

    def step() -> None:
        nonlocal due
        for place in range(len(crowd)):
            done["frames begun"] += 1
            done["frames sent"] += crowd.put(place, big)
            due += 1.0 / FRAMES_HZ
            time.sleep(max(0.0, due - time.monotonic()))

    yield step


@contextlib.contextmanager
def reading(url: str, clients: int, done: Done, rate_hz: float, most: int | None) -> Iterator[Step]:
    """Subscribe to vehicle 1, and read a limited number of bytes per turn, or all; send a pong once a second."""
    crowd = Crowd(url, clients, done, receive_buffer=4096 if most else None)
    crowd.says = [{"type": "subscribe", "vehicle": 1, "rate_hz": rate_hz}]
    if most:
        crowd.says.append({"type": "subscribe_messages", "vehicle": 1, "rate_hz": 50})
    turns_hz = 1.0 if most else 10.0
    due, turn = time.monotonic(), 0

    def step() -> None:
        nonlocal due, turn
        turn += 1
        for place in range(len(crowd)):
            found = crowd.at(place)
            if found is None:
                continue
            try:
                done["bytes read"] += found.skim(most or 1 << 20)
            except (OSError, EOFError):
                crowd.end(place)
                continue
            if found.status == 101 and turn % turns_hz == 0:
                crowd.put(place, PONG)
        due = max(due + 1.0 / turns_hz, time.monotonic())
        time.sleep(due - time.monotonic() if due > time.monotonic() else 0.01)

    step()
    yield step


@contextlib.contextmanager
def bad_calls(proxies: str, clients: int, done: Done) -> Iterator[Step]:
    """Open idle connections, and send 200 malformed calls a second: wrong data, NaN, unknown operation."""
    named = json.loads(proxies)
    addresses = [address_of(text) for text in named.values()]
    due = time.monotonic()
    with many_files(clients + 256), contextlib.ExitStack() as idle, client_of(named) as client:
        for number in range(clients):
            idle.enter_context(raw(addresses[number % len(addresses)]))
        pose, mission, velocity = client.pose, client.mission, client.velocity

        def malformed(name: str) -> None:
            with raw(addresses[done[name] % len(addresses)]) as connection, contextlib.suppress(OSError):
                connection.sendall(MALFORMED[name])
                connection.shutdown(socket.SHUT_WR)
                while connection.recv(4096):
                    pass

        def refused(call: Callable[..., Any], *given: Any) -> None:
            with contextlib.suppress(client.ice.Exception):
                call(*given)

        nothing = client.jderobot.Pose3DData(x=math.nan)
        bad: dict[str, Callable[[], None]] = {name: lambda name=name: malformed(name) for name in MALFORMED}  # type: ignore[misc]
        bad["operation"] = lambda: refused(mission.ice_invoke, "fly", client.ice.OperationMode.Normal, EMPTY)
        bad["no number"] = lambda: refused(pose.setPose3DData, nothing)
        bad["no speed"] = lambda: refused(velocity.setCMDVelData, client.jderobot.CMDVelData(math.nan, 0, 0, 0, 0, 0))
        bad["reference"] = lambda: refused(
            mission.ice_invoke,
            "setMissionData",
            client.ice.OperationMode.Normal,
            b"\x07\x00\x00\x00\x01\x01\x02",
        )

        def step() -> None:
            nonlocal due
            for name, send in bad.items():
                send()
                done[name] += 1
                due = max(due + 1.0 / BAD_CALLS_HZ, time.monotonic() - 1.0)
                time.sleep(max(0.0, due - time.monotonic()))

        yield step


KINDS: dict[str, Callable[[str, int, Done], contextlib.AbstractContextManager[Step]]] = {
    "frames": frames,
    "messages": messages,
    "slow readers": lambda url, clients, done: reading(url, clients, done, 50.0, 256),
    "sockets": lambda url, clients, done: reading(url, clients, done, 1.0, None),
    "browsers": lambda url, clients, done: reading(url, clients, done, PAGE_HZ, None),
    "ice": bad_calls,
}


def main(kind: str, target: str, clients: str) -> None:
    """Apply a load."""
    done: Done = Counter()
    with KINDS[kind](target, int(clients), done) as step:
        sys.stdout.write("ready\n")
        sys.stdout.flush()
        began = time.monotonic()
        while not is_over():
            step()
        sys.stdout.write(json.dumps({"seconds": time.monotonic() - began, **done}) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
