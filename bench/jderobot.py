"""Response times of the Ice interfaces: ten clients poll at 50 Hz, alone and beside a thousand idle connections.

`python -m bench.jderobot` prints a section for bench/RESULTS.md; `--write` puts it there. The driver is `vencejo serve
--ice` with the simulated plane at 50 Hz. Each client is a process that uses only the Slice files: fifty times a second
it calls Pose3D and Navdata (the tenth client, as a station would, also the precise Telemetry) and measures each call.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from datetime import date
from pathlib import Path
from typing import Any

from bench.harness import cpu_seconds
from tests.jderobot.support import address_of, client_of, driver, load_slices
from tests.support import simulated_plane

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "bench" / "RESULTS.md"
TITLE = "## JdeRobot: calls over ZeroC Ice while ten clients poll at 50 Hz"
AIM = "99 % of calls under 20 ms"
CLIENTS, RATE_HZ, IDLE = 10, 50.0, 1000
POLLER = "--poll"


def poll(proxies: dict[str, str], seconds: float) -> list[float]:
    """Run one client; return the duration of each call, milliseconds."""
    ice, jderobot, precise = load_slices("pose3d", "navdata")
    with ice.initialize() as communicator:
        pose = jderobot.Pose3DPrx.checkedCast(communicator.stringToProxy(proxies["Pose3D"]))
        navdata = jderobot.NavdataPrx.checkedCast(communicator.stringToProxy(proxies["Navdata"]))
        telemetry = precise.TelemetryPrx.checkedCast(communicator.stringToProxy(proxies["Precise"]))
        calls = [
            pose.getPose3DData,
            navdata.getNavdata,
            lambda: telemetry.getPose(0),
            lambda: telemetry.getNavigation(0),
        ]
        took: list[float] = []
        due = time.perf_counter()
        end = due + seconds
        while due < end:
            for call in calls:
                begun = time.perf_counter()
                call()
                took.append((time.perf_counter() - begun) * 1e3)
            due = max(due + 1.0 / RATE_HZ, time.perf_counter() - 1.0 / RATE_HZ)
            time.sleep(max(0.0, due - time.perf_counter()))
        return took


@contextlib.contextmanager
def idle(addresses: list[tuple[str, int]], count: int) -> Iterator[None]:
    """Open connections that send nothing."""
    with contextlib.ExitStack() as stack:
        for number in range(count):
            stack.enter_context(socket.create_connection(addresses[number % len(addresses)]))
        yield


def measure(proxies: dict[str, str], pid: int, seconds: float, clients: int = CLIENTS) -> dict[str, float]:
    """Let the clients poll; return the durations of their calls, and the driver's CPU time."""
    command = [sys.executable, "-m", "bench.jderobot", POLLER, json.dumps(proxies), "--seconds", str(seconds)]
    before, begun = cpu_seconds(pid), time.monotonic()
    pollers = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT) for _ in range(clients)]
    took: list[float] = []
    for client in pollers:
        out, _ = client.communicate()
        took += json.loads(out)
    cpu = (cpu_seconds(pid) - before) / (time.monotonic() - begun)
    cuts = statistics.quantiles(took, n=1000)
    return {
        "calls": len(took),
        "median_ms": statistics.median(took),
        "p99_ms": cuts[989],
        "worst_ms": max(took),
        "under_20_pct": 100.0 * sum(one < 20.0 for one in took) / len(took),
        "cpu_pct": 100.0 * cpu,
    }


def section(rows: dict[str, dict[str, float]], seconds: float, load: float) -> str:
    """Return the section of RESULTS.md."""
    lines = [
        TITLE,
        "",
        f"Aim: {AIM}. {CLIENTS} processes, four calls each at {RATE_HZ:.0f} Hz for {seconds:.0f} s, {date.today().isoformat()}.",  # noqa: DTZ011
        f"Written by `python -m bench.jderobot --write`; load average before: {load:.1f}, own priority: nice {os.nice(0)}.",
        "",
        "| | calls | median | 99 % | worst | under 20 ms | driver's CPU |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, row in rows.items():
        lines.append(
            f"| {name} | {row['calls']:,.0f} | {row['median_ms']:.2f} ms | {row['p99_ms']:.1f} ms | {row['worst_ms']:.0f} ms "
            f"| {row['under_20_pct']:.2f} % | {row['cpu_pct']:.0f} % |"
        )
    return "\n".join(lines) + "\n"


def put(page: str, part: str) -> str:
    """Return the page with our section replaced, or appended."""
    begin = page.find(TITLE)
    if begin < 0:
        return page.rstrip("\n") + "\n\n" + part
    end = page.find("\n## ", begin + 1)
    return page[:begin] + part + ("" if end < 0 else page[end:])


def main() -> int:
    """Measure, print and optionally write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=15.0)
    parser.add_argument("--write", action="store_true", help="put the section into bench/RESULTS.md")
    parser.add_argument(POLLER, default="", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.poll:
        print(json.dumps(poll(json.loads(options.poll), options.seconds)))
        return 0
    rows: dict[str, dict[str, float]] = {}
    load = os.getloadavg()[0]
    with (
        simulated_plane() as link,
        tempfile.TemporaryDirectory() as data,
        driver(link, "--rate", "50", data=Path(data)) as served,
    ):
        proxies: dict[str, Any] = served.said["ice"]
        with client_of(proxies) as client:
            client.wait_ready()
        rows["ten clients"] = measure(proxies, served.process.pid, options.seconds)
        addresses = [address_of(proxies[name]) for name in ("Pose3D", "Navdata", "Mission", "Precise")]
        with idle(addresses, IDLE):
            rows[f"ten clients beside {IDLE:,} idle connections"] = measure(
                proxies, served.process.pid, options.seconds
            )
    part = section(rows, options.seconds, load)
    print(part)
    if options.write:
        RESULTS.write_text(put(RESULTS.read_text(encoding="utf-8"), part), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
