"""Service quality for others while a station is abused or heavily used, and the cost of each abuser.

`make soak` runs it.

The only tests that gate on time: each on a real `vencejo serve`, alone, for minutes, with the machine's load recorded beside its figures.
"""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from bench.harness import free_port, quantile
from bench.jderobot import measure
from tests.faults.load import PAGE_HZ
from tests.faults.test_links import resident_bytes
from tests.jderobot.support import client_of, driver
from tests.server.client import Client, Served, WebSocket, serving
from tests.support import ROOT, simulated_plane, wait_for

pytestmark = [pytest.mark.soak, pytest.mark.timeout(0)]

SECONDS = min(60.0, float(os.environ.get("VENCEJO_SOAK_S", "60")))
ASK_HZ = 50.0
MIB = 1 << 20


@contextlib.contextmanager
def played(port: int, hz: int) -> Iterator[None]:
    """Run the benchmarks' plane: twenty endless streams at `hz`; it accepts every command."""
    plane = [sys.executable, str(ROOT / "bench/station/plane.py"), str(port), f"--hz={hz}"]
    with subprocess.Popen(plane, stdin=subprocess.PIPE) as process:
        try:
            yield
        finally:
            process.kill()


@contextlib.contextmanager
def followed(hz: int, data: Path) -> Iterator[Served]:
    """Run a station that follows that plane."""
    port = free_port()
    with serving("--link", f"udpin:127.0.0.1:{port}", data=data) as served, played(port, hz):
        wait_for(lambda: Client(served.url).done("GET", "vehicles") != [], "a vehicle")
        yield served


@contextlib.contextmanager
def under(kind: str, target: str, clients: int) -> Iterator[dict[str, float]]:
    """Apply a load for the length of a block; its counts are available afterwards."""
    command = [sys.executable, "-m", "tests.faults.load", kind, target, str(clients)]
    done: dict[str, float] = {}
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT) as load:
        try:
            assert load.stdout is not None
            assert load.stdout.readline() == "ready\n"
            yield done
            out, _ = load.communicate(timeout=60)
            done.update(json.loads(out))
        finally:
            load.kill()


@dataclass
class Heard:
    """A client's observations of a station under load."""

    took_s: dict[str, list[float]] = field(default_factory=dict)
    peak_bytes: int = 0
    telemetry_hz: float = 0.0

    def timed(self, what: str, act: Callable[[], object]) -> None:
        """Call a function and record its duration."""
        began = time.perf_counter()
        act()
        self.took_s.setdefault(what, []).append(time.perf_counter() - began)

    def told(self, name: str, **more: object) -> str:
        """Return the figures as a line of text."""
        parts = [
            f"{what} {1e3 * quantile(took, 0.5):.1f} / {1e3 * quantile(took, 0.99):.1f} / {1e3 * max(took):.0f} ms of {len(took):,}"
            for what, took in self.took_s.items()
        ]
        return f"{name}: median / 99 % / worst: {', '.join(parts)}; telemetry {self.telemetry_hz:.1f} Hz; load {os.getloadavg()[0]:.1f}; {more}\n"


@dataclass
class Pilot:
    """A client that follows the plane over a WebSocket, and records every delay."""

    served: Served
    client: Client
    socket: WebSocket
    telemetry: int = 0

    def request(self) -> None:
        """Send a request over a new connection."""
        self.client.done("GET", "vehicles/1")

    def question(self) -> None:
        """Send a request over the WebSocket, whose answer arrives between telemetry."""
        self.socket.say(type="subscribe", vehicle=1, rate_hz=0)
        while (message := self.socket.take()) is not None and message["type"] != "error":
            self.telemetry += message["type"] == "telemetry"
        assert message is not None, self.socket.closed

    def command(self) -> None:
        """Send a command, which the plane accepts."""
        self.client.done("POST", "vehicles/1/mission/current", {"item": 2})

    def use(self, seconds: float, *acts: Callable[[], None]) -> Heard:
        """Repeat each of these."""
        heard = Heard()
        telemetry, due = self.telemetry, time.monotonic()
        end = due + seconds
        while due < end:
            for act in acts:
                heard.timed(act.__name__, act)
            heard.peak_bytes = max(heard.peak_bytes, resident_bytes(self.served.process.pid))
            due = max(due + 1.0 / ASK_HZ, time.monotonic() - 1.0 / ASK_HZ)
            time.sleep(max(0.0, due - time.monotonic()))
        assert self.served.process.poll() is None, "it lives"
        heard.telemetry_hz = (self.telemetry - telemetry) / seconds
        return heard


@contextlib.contextmanager
def pilot_of(served: Served) -> Iterator[Pilot]:
    """A client of a station that follows a plane, at the page's default rate."""
    client = served.client(name="pilot")
    with WebSocket(client) as socket:
        socket.say(type="subscribe", vehicle=1, rate_hz=PAGE_HZ)
        yield Pilot(served, client, socket)


ABUSES = {"frames": 16, "messages": 64, "slow readers": 96, "sockets": 500}
"""Number of concurrent clients."""


@pytest.mark.fault(
    47,
    figure="1 MiB frames, 10,000 messages a second, 96 slow readers, 500 sockets: 99 % of others' requests ≤ 100 ms; ≤ 4 MiB each",
)
@pytest.mark.parametrize("abuse", ABUSES)
def test_others_are_served_while_websockets_are_abused(abuse: str, tmp_path: Path) -> None:
    clients = ABUSES[abuse]
    with followed(50, tmp_path) as served, pilot_of(served) as pilot:
        quiet = pilot.use(5.0, pilot.request, pilot.question)
        with under(abuse, served.url, clients) as done:
            heard = pilot.use(SECONDS, pilot.request, pilot.question)
    each = (heard.peak_bytes - quiet.peak_bytes) / clients
    sys.stdout.write(quiet.told("quiet") + heard.told(abuse, each_kib=round(each / 1024), **done))
    for what, took in heard.took_s.items():
        assert quantile(took, 0.99) <= 0.1, what
    assert heard.telemetry_hz >= 0.9 * PAGE_HZ
    assert each <= 4 * MIB


@pytest.mark.fault(63, figure="2,000 messages a second, 20 browsers at 20 Hz: 99 % of commands ≤ 250 ms")
def test_commands_go_through_while_twenty_browsers_follow_a_busy_plane(tmp_path: Path) -> None:
    with followed(100, tmp_path) as served, pilot_of(served) as pilot, under("browsers", served.url, 20) as done:
        heard = pilot.use(SECONDS, pilot.request, pilot.question, pilot.command)
        (link,) = pilot.client.done("GET", "links")
    sys.stdout.write(heard.told("busy", received_hz=round(link["frames_per_s"]), **done))
    assert link["frames_per_s"] >= 1900
    assert quantile(heard.took_s["command"], 0.99) <= 0.25


@pytest.mark.fault(52, figure="200 bad calls a second and 1,000 idle connections: it lives, 99 % of calls ≤ 50 ms")
def test_ice_serves_others_while_it_is_abused(tmp_path: Path) -> None:
    with simulated_plane() as link, driver(link, "--rate", "50", data=tmp_path) as served:
        proxies: dict[str, Any] = served.said["ice"]
        with client_of(proxies) as client:
            client.wait_ready()
            with under("ice", json.dumps(proxies), 1000) as done:
                row = measure(proxies, served.process.pid, SECONDS, clients=2)
            sys.stdout.write(f"ice: {row}; load {os.getloadavg()[0]:.1f}; {done}\n")
            assert client.pose.getPose3DData().x != 0, "it lives"
        assert row["p99_ms"] <= 50.0
