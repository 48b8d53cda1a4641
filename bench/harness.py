"""Starts contestants and measures their time, CPU and memory from outside. Linux only (/proc)."""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import IO, Any

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "bench/out"
CONTESTANTS = ROOT / "bench/contestants"
LOAD = ROOT / "target/release/vencejo-bench-load"
FRAMES = OUT / "frames.bin"
FLEET_FRAMES = OUT / "fleet.bin"
#: The stream for contestants that wait for their first message.
EAGER_FRAMES = OUT / "eager.bin"


#: Independent of this program's own environment: compiling pymavlink takes a second and 100 MB, which would be
#: measured.
BYTECODE_KEPT = {"PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": str(OUT / "bytecode")}
BYTECODE_UNKEPT = {"PYTHONDONTWRITEBYTECODE": "1", "PYTHONPYCACHEPREFIX": str(OUT / "no-bytecode")}
#: Load average (1 min) per core above which nothing is recorded, since other processes would be measured.
MOST_LOAD = 0.5


def load() -> float:
    """Return the load average of the last minute, per core."""
    return os.getloadavg()[0] / (os.cpu_count() or 1)


class NotMeasured(Exception):
    """A contestant could not take part; the text gives the reason for the table."""


@dataclass(frozen=True)
class Usage:
    """Resources used by a process over a window: CPU (1 = one core) and resident memory."""

    cpu: float
    rss_mb: float


def free_port() -> int:
    """Return an unused UDP port of the loopback interface."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def contestant(name: str, task: str, **options: object) -> list[str]:
    """Return the command line for one task of a program in bench/contestants."""
    return [
        sys.executable,
        str(CONTESTANTS / f"{name}.py"),
        task,
        *(f"{key}={value}" for key, value in options.items()),
    ]


@contextlib.contextmanager
def running(command: Sequence[str], environment: Mapping[str, str] | None = None) -> Iterator[subprocess.Popen[str]]:
    """Run a program for the duration of a block; afterwards it and its children are ended."""
    environment = {**os.environ, **BYTECODE_KEPT, "VENCEJO_DATA": str(OUT / "data"), **(environment or {})}
    errors = (OUT / "last-errors.txt").open("w")
    process = subprocess.Popen(
        command,
        stdin=subprocess.PIPE,  # kept open: some contestants end with their input
        stdout=subprocess.PIPE,
        stderr=errors,
        text=True,
        start_new_session=True,
        cwd=OUT,
        env=environment,
    )
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGTERM)
        try:
            process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                stream.close()
        errors.close()


def wait_line(process: subprocess.Popen[str], start: str, timeout_s: float) -> str:
    """Return the next line of output that starts with ``start``."""
    assert process.stdout is not None
    until = time.monotonic() + timeout_s
    while (left_s := until - time.monotonic()) > 0:
        if not _readable(process.stdout, left_s):
            break
        line = process.stdout.readline()
        if not line:
            errors = (OUT / "last-errors.txt").read_text().strip().splitlines()
            raise NotMeasured(errors[-1].replace(f"{ROOT}/", "")[:100] if errors else f"ended with {process.wait()}")
        if line.startswith(start):
            return line
    raise NotMeasured(f"no answer within {timeout_s:.0f} s")


def result_of(process: subprocess.Popen[str], timeout_s: float) -> dict[str, Any]:
    """Return the line of JSON with which a contestant ends."""
    parsed: dict[str, Any] = json.loads(wait_line(process, "{", timeout_s))
    return parsed


def _readable(stream: IO[str], timeout_s: float) -> bool:
    # Contestants print at most two lines, so nothing hides in the text buffer between two calls unless both came at
    # once; then the next readline returns at once anyway.
    return bool(select.select([stream], [], [], timeout_s)[0])


def cpu_seconds(pid: int) -> float:
    """Return the CPU time used by a process, including ended threads.

    Its CPU clock (clock_getcpuclockid(3)) has a resolution of nanoseconds; /proc counts ticks of 10 ms, of which a
    process with 1 % CPU uses eight in eight seconds.
    """
    try:
        return time.clock_gettime((~pid << 3) | 2)
    except OSError as error:
        raise NotMeasured("it ended too early") from error


def rss_mb(pid: int) -> float:
    """Return the resident memory of a process in MB."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1000
    raise NotMeasured("it ended too early")


def usage_over(pid: int, seconds: float) -> Usage:
    """Measure a process over a time."""
    before, began = cpu_seconds(pid), time.monotonic()
    time.sleep(seconds)
    used, lasted = cpu_seconds(pid) - before, time.monotonic() - began
    return Usage(cpu=used / lasted, rss_mb=rss_mb(pid))


def play(port: int, *, rate: float, seconds: float, systems: int = 1, frames: Path | None = None) -> list[str]:
    """Return the command that plays the recorded stream, or other frames, to a UDP port."""
    frames = frames or (FRAMES if systems == 1 else FLEET_FRAMES)
    return [
        str(LOAD), "send", "--frames", str(frames), "--to", f"127.0.0.1:{port}",
        "--rate", str(rate), "--seconds", str(seconds), "--systems", str(systems),
    ]  # fmt: skip


def quantile(values: Sequence[float], share: float) -> float:
    """Return the value below which ``share`` of the samples lie."""
    if not values:
        raise NotMeasured("no samples")
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(len(ordered) * share))]


def repeat(runs: int, who: dict[str, Callable[[], dict[str, float]]]) -> dict[str, dict[str, float] | str]:
    """Run every contestant ``runs`` times, in turn, and return the median of each figure.

    In turn, so that a temporary slowdown of the machine affects all contestants. For a contestant that cannot take
    part, the reason is returned instead of figures. Of figures whose names begin with ``worst``, the largest value is
    returned.
    """
    collected: dict[str, list[dict[str, float]]] = {name: [] for name in who}
    refused: dict[str, str] = {}
    for run in range(runs):
        for name, measure in who.items():
            if name in refused:
                continue
            print(f"    {name} ({run + 1}/{runs})", flush=True)
            try:
                collected[name].append(measure())
            except NotMeasured as reason:
                refused[name] = str(reason)
                print(f"      not measured: {reason}", flush=True)
    return {
        name: refused[name]
        if name in refused
        else {
            figure: (max if figure.startswith("worst") else median)(run[figure] for run in runs_of)
            for figure in runs_of[0]
        }
        for name, runs_of in collected.items()
    }
