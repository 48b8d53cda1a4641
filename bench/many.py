#!/usr/bin/env python3
"""Many aircraft far away at one ground station: its processor time and memory, what its list costs a client, and how long a command takes.

    cargo build --workspace --features vencejo-py/fleet --example crowd
    .venv/bin/python bench/many.py [--aircraft 1000] [--rate 10] [--seconds 20] [--commands 200]

`crates/fleet/examples/crowd.rs` is the aircraft, in a process of its own: with the payloads that a station on board sends, and its authority
over orders. The ground station and router is `vencejo serve --fleet`, one process. The client follows the roster over a WebSocket and commands
aircraft over HTTP, one after another. Prints one line of JSON.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.server.client import Client, Served, WebSocket, serving

CROWD = Path(__file__).resolve().parents[1] / "target" / "debug" / "examples" / "crowd"


@contextlib.contextmanager
def crowd(router: str, aircraft: int, rate_hz: int, *options: str) -> Iterator[subprocess.Popen[str]]:
    """The aircraft, all of them there."""
    command = [str(CROWD), router, "acme", str(aircraft), str(rate_hz), *options]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            assert process.stdout.readline(), "the crowd did not start"
            yield process
        finally:
            process.stdin.close()
            process.wait(30)


def used(pid: int) -> tuple[float, float]:
    """Processor time in seconds, and resident memory in MB."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    ticks = int(fields[11]) + int(fields[12])
    pages = int(Path(f"/proc/{pid}/statm").read_text(encoding="utf-8").split()[1])
    return ticks / os.sysconf("SC_CLK_TCK"), pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def watch(client: Client, over: threading.Event, told: dict[str, int]) -> None:
    """Follow the roster and count what it costs."""
    with WebSocket(client) as socket:
        socket.say(type="subscribe_roster")
        while not over.is_set():
            message = socket.take()
            if message is None:
                told["ended"] = 1
                return
            if message["type"] == "roster":
                told["rosters"] = told.get("rosters", 0) + 1
                told["rows"] = told.get("rows", 0) + len(message["rows"])
                told["bytes"] = told.get("bytes", 0) + len(json.dumps(message, separators=(",", ":")))


def measure(served: Served, aircraft: int, seconds: float, commands: int) -> dict[str, Any]:
    """Wait for all to be there, then look."""
    client = served.client(name="Ana")
    deadline = time.monotonic() + 60
    while len(found := client.done("GET", "vehicles")) < aircraft and time.monotonic() < deadline:
        time.sleep(0.5)
    pid, over, told = served.process.pid, threading.Event(), dict[str, int]()
    result: dict[str, Any] = {"aircraft": len(found)}
    idle = used(pid)
    time.sleep(seconds)
    cpu_s, rss_mb = used(pid)
    result |= {"cpu_pct": round(100 * (cpu_s - idle[0]) / seconds, 1), "rss_mb": round(rss_mb, 1)}
    watcher = threading.Thread(target=watch, args=(client, over, told))
    watcher.start()
    before = used(pid)[0]
    time.sleep(seconds)
    result["cpu_with_list_pct"] = round(100 * (used(pid)[0] - before) / seconds, 1)
    client.done("POST", "control/take")
    took_ms = []
    for number in range(commands):
        at = found[number * 7 % len(found)]["system_id"]
        # The first asks for control of the aircraft too.
        for act in ("loiter", "mission/resume"):
            began = time.monotonic()
            client.done("POST", f"vehicles/{at}/{act}")
            took_ms.append((time.monotonic() - began) * 1e3)
    took_ms.sort()
    over.set()
    watcher.join(10)
    if took_ms:
        result |= {"command_p50_ms": round(took_ms[len(took_ms) // 2], 1)}
        result |= {"command_p99_ms": round(took_ms[int(len(took_ms) * 0.99)], 1)}
    return result | told


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--aircraft", type=int, default=1000)
    parser.add_argument("--rate", type=int, default=10)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--commands", type=int, default=200)
    asked = parser.parse_args()
    with (
        tempfile.TemporaryDirectory() as data,
        serving("--fleet", "acme", "--fleet-listen", "tcp/127.0.0.1:0", "--link", "udpin:127.0.0.1:0", data=Path(data)) as served,
        crowd(served.said["fleet"]["endpoint"], asked.aircraft, asked.rate) as process,
    ):  # fmt: skip
        before = used(process.pid)[0]
        began = time.monotonic()
        result = measure(served, asked.aircraft, asked.seconds, asked.commands)
        crowd_pct = round(100 * (used(process.pid)[0] - before) / (time.monotonic() - began), 1)
        load = os.getloadavg()[0]
        print(json.dumps({**result, "rate_hz": asked.rate, "crowd_cpu_pct": crowd_pct, "load": round(load, 1)}))


if __name__ == "__main__":
    main()
