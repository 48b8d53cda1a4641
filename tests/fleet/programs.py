"""`vencejo` commands as programs of their own, which tell of themselves in lines of JSON."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.clock import Clock
from tests.fleet.proxy import Way, open_way
from tests.server.client import Client
from tests.support import simulated_plane, wait_for

__all__ = ["FarPlane", "Program", "command", "far_plane", "ground_station"]


class Program:
    """A `vencejo` command that tells of itself in lines of JSON."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self.process = process

    def line(self) -> dict[str, Any]:
        """The next line."""
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert line, f"it ended with {self.process.wait(10)}"
        told: dict[str, Any] = json.loads(line)
        return told

    def until(self, **wanted: object) -> dict[str, Any]:
        """The next line with these values."""
        while True:
            told = self.line()
            if all(told.get(name) == value for name, value in wanted.items()):
                return told


@contextlib.contextmanager
def command(data: Path, *args: str, clock: Clock | None = None) -> Iterator[Program]:
    """A running command with a data folder, and maybe a clock, of its own."""
    env = {**os.environ, "VENCEJO_DATA": str(data), **(clock.env if clock else {})}
    with subprocess.Popen(
        [sys.executable, "-m", "vencejo.cli", *args, "--json", "--no-record"],
        stdout=subprocess.PIPE,
        text=True,
        env=env,
    ) as process:
        try:
            yield Program(process)
        finally:
            process.terminate()


@contextlib.contextmanager
def ground_station(data: Path, listen: int = 0, router: int | None = None) -> Iterator[tuple[Program, dict[str, Any]]]:
    """A ground station that is a router at a port of this machine, linked with another one's, and what it told of itself at its start."""
    linked = [] if router is None else ["--fleet-router", f"tcp/127.0.0.1:{router}"]
    with command(
        data, "serve", "--fleet", "acme", "--fleet-listen", f"tcp/127.0.0.1:{listen}", *linked, "--port", "0",
        "--link", "udpin:127.0.0.1:0",
    ) as program:  # fmt: skip
        yield program, program.line()


@dataclass
class FarPlane:
    """A simulated plane, the station on board and the ground station as programs of their own, with a way between them that can be cut."""

    ground: Program
    board: Program
    way: Way
    told: dict[str, Any]
    """What the ground station told of itself at its start."""
    ana: Client
    """An operator at the ground station, who has not asked for control yet."""

    @property
    def summary(self) -> dict[str, Any]:
        """The plane in the ground station's list."""
        (found,) = self._found()
        return found

    @property
    def at(self) -> str:
        """Where the plane is in the API."""
        return f"vehicles/{self.summary['system_id']}"

    def is_listed(self) -> bool:
        """Whether the ground station has the plane in its list."""
        return bool(self._found())

    def _found(self) -> list[dict[str, Any]]:
        return [each for each in self.ana.done("GET", "vehicles") if each["remote_name"] == "plane7"]


@contextlib.contextmanager
def far_plane(folder: Path, *on_board: str, listen: int = 0, router: int | None = None) -> Iterator[FarPlane]:
    """A plane far away that is in the ground station's list; `on_board` are options of the station on board, the others of the ground station."""
    with simulated_plane() as link, ground_station(folder / "ground", listen, router) as (ground, told):
        endpoint, key = told["fleet"]["endpoint"], told["fleet"]["key"]
        with (
            open_way(int(endpoint.rpartition(":")[2])) as way,
            command(
                folder / "board", "onboard", "--fleet", "acme", "--name", "plane7", "--link", link,
                "--dial", f"tcp/127.0.0.1:{way.port}", "--trust", key, *on_board,
            ) as board,
        ):  # fmt: skip
            board.until(is_connected=True, holder=None)
            ana = Client(told["url"])
            ana.open_session(name="Ana")
            plane = FarPlane(ground, board, way, told, ana)
            wait_for(plane.is_listed, "the plane in the list")
            yield plane
