"""Planes flown remotely: simulator, onboard stations, network paths, routers and ground stations, each a process."""

from __future__ import annotations

import contextlib
import json
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bench.far.rig import free_tcp_port
from bench.harness import contestant
from tests.fleet.programs import Program, command
from tests.fleet.proxy import PLAIN, Line, Way, open_way
from tests.server.client import Client

ORG = "acme"
#: Starting fifty planes takes long on a busy machine.
PATIENCE_S = 120.0


class StockRouter:
    """A plain Zenoh router, which can be killed and restarted on the same port."""

    def __init__(self, port: int, others: Sequence[int]) -> None:
        self.port = port
        self._others = others
        self._process: subprocess.Popen[str] | None = None

    def start(self) -> None:
        """Start it, and wait until it listens."""
        router = contestant("zenoh_peer", "serve", port=self.port, others=",".join(map(str, self._others)))
        self._process = subprocess.Popen(router, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert self._process.stdout is not None
        assert self._process.stdout.readline(), "the router did not start"

    def kill(self) -> None:
        """Kill it."""
        if self._process is not None:
            self._process.kill()
            with self._process:
                self._process = None


@dataclass
class Ground:
    """A ground station and its operator."""

    program: Program
    startup: dict[str, Any]
    client: Client

    def vehicles(self) -> dict[str, dict[str, Any]]:
        """Return the planes in its list, by name."""
        return {each["remote_name"]: each for each in self.client.done("GET", "vehicles") if each["remote_name"]}

    def at(self, name: str) -> str:
        """Return a plane's path in the API."""
        return f"vehicles/{self.vehicles()[name]['system_id']}"

    def telemetry(self, at: str) -> dict[str, Any]:
        """Return a plane's telemetry."""
        found: dict[str, Any] = self.client.done("GET", at)["telemetry"]
        return found

    def age_s(self, at: str) -> float:
        """Return the age of a plane's heartbeat."""
        return float(self.telemetry(at)["heartbeat"]["age_s"])


@dataclass
class Board:
    """An onboard station and its network paths, one to each router; several planes may share them."""

    program: Program
    ways: list[Way]
    planes: list[str]
    data: Path

    def cut(self, *, up: bool = True, down: bool = True) -> None:
        """Cut all its paths, or one direction of them."""
        for way in self.ways:
            way.cut(up=up, down=down)

    def heal(self) -> None:
        """Restore all paths."""
        for way in self.ways:
            way.heal()

    def freeze(self) -> None:
        """Suspend the program, like a computer that hangs (SIGSTOP)."""
        self.program.process.send_signal(signal.SIGSTOP)

    def thaw(self) -> None:
        """Resume the program."""
        self.program.process.send_signal(signal.SIGCONT)


@dataclass
class Field:
    """All programs of a field test."""

    grounds: list[Ground]
    boards: list[Board]
    routers: list[StockRouter] = field(default_factory=list)

    @property
    def planes(self) -> list[str]:
        """Return the names of all planes."""
        return [name for board in self.boards for name in board.planes]


def until(condition: Callable[[], bool], timeout_s: float = PATIENCE_S) -> float:
    """Wait for a condition; return the time taken, seconds."""
    began = time.monotonic()
    while not condition():
        assert time.monotonic() - began < timeout_s, f"not within {timeout_s:.0f} s"
        time.sleep(0.01)
    return time.monotonic() - began


@contextlib.contextmanager
def planes_on(count: int) -> Iterator[list[str]]:
    """Run `vencejo sim --planes` with one port per plane; yield the link of each."""
    simulator = [
        sys.executable, "-m", "vencejo.cli", "sim", "--planes", str(count), "--ports", "consecutive", "--link", "tcp:127.0.0.1:0",
    ]  # fmt: skip
    with subprocess.Popen(simulator, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            yield [str(json.loads(process.stdout.readline())["listening"]) for _ in range(count)]
        finally:
            process.terminate()


@contextlib.contextmanager
def field_of(
    *,
    planes: int = 1,
    boards: int = 1,
    grounds: int = 1,
    routers: int = 0,
    up: Line = PLAIN,
    down: Line = PLAIN,
    seed: int = 0,
    on_board: Sequence[str] = (),
) -> Iterator[Field]:
    """Run planes, shared by onboard stations, until all are in the lists of all ground stations.

    Without ``routers``, the first ground station is the router. ``up`` and ``down`` are the properties of each path,
    and ``on_board`` are options of the onboard stations.
    """
    with contextlib.ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(ignore_cleanup_errors=True)))
        links = stack.enter_context(planes_on(planes))
        ports = [free_tcp_port() for _ in range(routers)]
        stock = [StockRouter(port, ports[:number]) for number, port in enumerate(ports)]
        for router in stock:
            stack.callback(router.kill)
            router.start()
        stations: list[Ground] = []
        for number in range(grounds):
            # Each has another preferred router.
            dialled = [*ports[number % max(1, routers) :], *ports[: number % max(1, routers)]]
            options = [f"--fleet-router=tcp/127.0.0.1:{port}" for port in dialled]
            if not routers and not number:
                ports = [free_tcp_port()]
                options = [f"--fleet-listen=tcp/127.0.0.1:{ports[0]}"]
            stations.append(_ground(stack, folder / f"ground{number}", f"Ana{number}", options))
        keys = [option for each in stations for option in ("--trust", each.startup["fleet"]["key"])]
        found = []
        for number in range(boards):
            ways = [
                stack.enter_context(open_way(port, up=up, down=down, seed=seed + 100 * number + 10 * at))
                for at, port in enumerate(ports)
            ]
            shared = [(index + 1, link) for index, link in enumerate(links) if index % boards == number]
            data = folder / f"board{number}"
            program = stack.enter_context(
                command(
                    data, "onboard", "--fleet", ORG, *keys, *on_board,
                    *(f"--dial=tcp/127.0.0.1:{way.port}" for way in ways),
                    *(f"--plane=plane{system}@{system}={link}" for system, link in shared),
                )
            )  # fmt: skip
            board = Board(program, ways, [f"plane{system}" for system, _ in shared], data)
            stack.callback(board.thaw)
            found.append(board)
        whole = Field(stations, found, stock)
        names = set(whole.planes)
        for station in stations:
            until(lambda station=station: names <= {name for name, each in station.vehicles().items() if each["mode"]})  # type: ignore[misc]
        yield whole


def _ground(stack: contextlib.ExitStack, data: Path, operator: str, options: Sequence[str]) -> Ground:
    sources = data / "maps" / "sources.toml"
    sources.parent.mkdir(parents=True)
    # Otherwise a new installation begins with maps from the network.
    sources.write_text("# none\n", encoding="utf-8")
    program = stack.enter_context(
        command(data, "serve", "--fleet", ORG, "--port", "0", "--link", "udpin:127.0.0.1:0", *options)
    )
    startup = program.line()
    client = Client(startup["url"])
    client.open_session(name=operator)
    return Ground(program, startup, client)
