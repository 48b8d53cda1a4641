"""MAVProxy, as a program driven by a pilot's input, works with the simulated plane."""

from __future__ import annotations

import queue
import re
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from vencejo.sim import SimulatedPlane

from tests.peers.support import ITEMS, PATIENCE_S, eventually, running_plane

pytestmark = pytest.mark.peer


class MavProxy:
    """A MAVProxy process: type a line, wait for its output."""

    def __init__(self, sim: SimulatedPlane, folder: Path) -> None:
        self.sim = sim
        program = Path(sys.executable).with_name("mavproxy.py")
        if not program.exists():
            pytest.skip("MAVProxy is not installed")
        self._process = subprocess.Popen(
            [
                sys.executable, "-W", "ignore", str(program), f"--master={sim.link}",
                "--default-modules=mode,wp,param,ftp,cmdlong,misc,arm,link,output,signing",
                f"--state-basedir={folder}", "--source-system=255", "--streamrate=4",
            ],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=folder, text=True, bufsize=1,
            env={"HOME": str(folder), "PATH": "/usr/bin:/bin", "PYTHONUNBUFFERED": "1"},
        )  # fmt: skip
        self._lines: queue.SimpleQueue[str] = queue.SimpleQueue()
        self.said: list[str] = []
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._lines.put(line.rstrip())

    def type(self, line: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()

    def wait(self, pattern: str) -> re.Match[str]:
        end = time.monotonic() + PATIENCE_S
        while True:
            try:
                line = self._lines.get(timeout=max(0.0, end - time.monotonic()))
            except queue.Empty:
                raise AssertionError(f"MAVProxy never said {pattern!r}, but:\n" + "\n".join(self.said)) from None
            self.said.append(line)
            if found := re.search(pattern, line):
                return found

    def close(self) -> None:
        self._process.kill()
        self._process.wait()


@pytest.fixture
def mavproxy(tmp_path: Path) -> Iterator[MavProxy]:
    with running_plane() as sim:
        program = MavProxy(sim, tmp_path)
        try:
            program.wait(r"Detected vehicle 1:1")
            yield program
        finally:
            program.close()


def waypoints(path: Path) -> None:
    lines = ["QGC WPL 110"]
    for seq, frame, command, _current, auto, *rest in ITEMS:
        lines.append("\t".join(str(field) for field in (seq, int(seq == 0), frame, command, *rest, auto)))
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def test_telemetry_and_modes(mavproxy: MavProxy) -> None:
    mavproxy.type("mode FBWA")
    mavproxy.wait(r"Mode FBWA")
    mavproxy.type("status GLOBAL_POSITION_INT")
    assert float(mavproxy.wait(r"lat : (\d+)").group(1)) * 1e-7 == pytest.approx(40.3332, abs=1e-3)


def test_parameters(mavproxy: MavProxy) -> None:
    mavproxy.wait(r"Received 1399 parameters")
    mavproxy.type("param show WP_RADIUS")
    mavproxy.wait(r"WP_RADIUS\s+50")
    mavproxy.type("param set WP_RADIUS 35")
    eventually(lambda: mavproxy.sim.call(lambda world: world.planes[0].params.get("WP_RADIUS")) == 35)
    mavproxy.type("param fetch WP_RADIUS")
    mavproxy.wait(r"WP_RADIUS = 35\.0")


def test_mission_both_ways(mavproxy: MavProxy, tmp_path: Path) -> None:
    mavproxy.wait(r"Received 1399 parameters")
    waypoints(tmp_path / "up.txt")
    mavproxy.type("wp load up.txt")
    mavproxy.wait(r"Flight plan received")
    mavproxy.type("wp save down.txt")
    mavproxy.wait(r"Saved 6 waypoints")
    rows = [line.split("\t") for line in (tmp_path / "down.txt").read_text(encoding="ascii").splitlines()[1:]]
    assert [int(row[3]) for row in rows] == [item[2] for item in ITEMS]
    for row, item in list(zip(rows, ITEMS, strict=True))[1:]:
        assert [float(field) for field in row[8:11]] == pytest.approx(item[9:12], abs=1e-5)
