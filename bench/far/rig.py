"""Programs of these benchmarks: ground station and router, a bare router, a thousand aircraft, and listeners."""

from __future__ import annotations

import contextlib
import json
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.harness import ROOT, NotMeasured, result_of, running, wait_line
from tests.server.client import Client

ORG = "acme"
AIRCRAFT = 1000
RATE_HZ = 10
EXAMPLES = ROOT / "target/release/examples"
#: Opening a thousand sessions and registering as many aircraft takes seconds, more on a busy machine.
PATIENCE_S = 60.0


def example(name: str) -> str:
    """Return the path of a program of crates/fleet/examples, or raise when it was not built."""
    path = EXAMPLES / name
    if not path.exists():
        raise NotMeasured(f"{path.relative_to(ROOT)} is not built")
    return str(path)


def free_tcp_port() -> int:
    """Return an unused TCP port of the loopback interface."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


#: A session that closes blocks a thread until its router has been informed. A process has fifty threads for that, so a
#: thousand sessions of a killed router would wait for each other for ten seconds; real aircraft are separate processes.
MANY_SESSIONS = (
    "(rx: (max_blocking_threads: 2000), net: (max_blocking_threads: 2000), app: (max_blocking_threads: 2000))"
)


@dataclass(frozen=True)
class Router:
    """A running router: its process, its address, and its startup message."""

    process: subprocess.Popen[str]
    endpoint: str
    startup: dict[str, Any]

    @property
    def pid(self) -> int:
        """Return its process id."""
        return self.process.pid

    def operator(self) -> Client:
        """Return an operator's client of the ground station."""
        client = Client(self.startup["url"])
        client.open_session(name="Ana")
        return client


@contextlib.contextmanager
def ground_station(*options: str, port: int = 0) -> Iterator[Router]:
    """Run `vencejo serve --fleet` with a data folder of its own."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as data:
        sources = Path(data) / "maps" / "sources.toml"
        sources.parent.mkdir(parents=True, exist_ok=True)
        # Otherwise a new installation begins with maps from the network.
        sources.write_text("# none\n", encoding="utf-8")
        command = [
            sys.executable, "-m", "vencejo.cli", "serve", "--port", "0", "--json", "--no-record", "--link", "udpin:127.0.0.1:0",
            "--fleet", ORG, *(options or ("--fleet-listen", f"tcp/127.0.0.1:{port}")),
        ]  # fmt: skip
        with running(command, {"VENCEJO_DATA": data}) as process:
            startup = json.loads(wait_line(process, "{", PATIENCE_S))
            yield Router(process, startup["fleet"]["endpoint"], startup)


@contextlib.contextmanager
def bare_router(*options: str, port: int = 0) -> Iterator[Router]:
    """Run a plain Zenoh router; with ``ORG`` it subscribes as well."""
    endpoint = f"tcp/127.0.0.1:{port or free_tcp_port()}"
    with running([example("bare_router"), endpoint, *options]) as process:
        yield Router(process, endpoint, json.loads(wait_line(process, "{", PATIENCE_S)))


@contextlib.contextmanager
def crowd(endpoint: str, *, aircraft: int = AIRCRAFT, rate_hz: int = RATE_HZ) -> Iterator[subprocess.Popen[str]]:
    """Run a thousand aircraft, and wait until all are connected."""
    arguments = [example("crowd"), endpoint, ORG, str(aircraft), str(rate_hz), "stamped"]
    with running(arguments, {"ZENOH_RUNTIME": MANY_SESSIONS}) as process:
        wait_line(process, "{", PATIENCE_S)
        yield process


@contextlib.contextmanager
def listeners(endpoint: str, count: int, seconds: float, *options: str) -> Iterator[subprocess.Popen[str]]:
    """Run subscribers to all aircraft, which begin to count now."""
    with running([example("listen"), endpoint, ORG, str(count), str(seconds), *options]) as process:
        wait_line(process, "READY", PATIENCE_S)
        yield process


def heard(endpoint: str, count: int, seconds: float, options: Sequence[str] = ()) -> dict[str, Any]:
    """Listen for a time and return the counts."""
    with listeners(endpoint, count, seconds, *options) as process:
        return result_of(process, seconds + PATIENCE_S)
