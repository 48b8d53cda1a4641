"""20 browsers' WebSockets at 10 Hz with a plane of 1,000 messages/s: duration of commands, and the server's memory.

``python bench/station/browsers.py [--minutes 10]``. A command is an HTTP request answered by the vehicle (a speed
change, which the plane accepts at once), ten a second over one persistent connection.
"""

from __future__ import annotations

import argparse
import http.client
import json
import sys
import threading
import time
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from bench.harness import cpu_seconds, quantile, rss_mb
from bench.station.stage import keep, station
from tests.server.client import Client, WebSocket

BROWSERS = 20
BROWSER_HZ = 10
STREAM_HZ = 50
"""Rate of each of the recorded streams: 1,000 messages a second in total."""
COMMAND_HZ = 10.0
WARM_UP_S = 20.0


def measure(minutes: float) -> dict[str, float]:
    """Command and measure for a time."""
    counts = [0] * BROWSERS
    stop = threading.Event()

    def follow(place: int, client: Client) -> None:
        with WebSocket(client) as socket:
            socket.say(type="subscribe", vehicle=1, rate_hz=BROWSER_HZ)
            while not stop.is_set() and (message := socket.take()) is not None:
                counts[place] += message["type"] == "telemetry"

    def browser(name: str, url: str) -> Client:
        client = Client(url)
        client.open_session(name=name)
        return client

    with station(STREAM_HZ) as served:
        # The first one commands, and keeps control through its WebSocket, as a page does.
        clients = [browser(f"browser {place}", served.url) for place in range(BROWSERS)]
        pilot = clients[0]
        connection = http.client.HTTPConnection(pilot.authority, timeout=30)
        threads = [threading.Thread(target=follow, args=entry) for entry in enumerate(clients)]
        for thread in threads:
            thread.start()
        body = json.dumps({"kind": "airspeed", "speed_m_s": 20})
        headers = {"Cookie": pilot.cookie or "", "Content-Type": "application/json"}

        def command() -> float:
            began = time.perf_counter()
            connection.request("POST", "/api/v1/vehicles/1/speed", body, headers)
            response = connection.getresponse()
            said = response.read()
            if response.status != 200:
                raise RuntimeError(said.decode())
            return (time.perf_counter() - began) * 1000

        try:
            time.sleep(WARM_UP_S)
            first_mb, cpu_s, seen, began = rss_mb(served.pid), cpu_seconds(served.pid), sum(counts), time.monotonic()
            took_ms = []
            while (now := time.monotonic()) - began < minutes * 60:
                took_ms.append(command())
                time.sleep(max(0.0, now + 1 / COMMAND_HZ - time.monotonic()))
            lasted_s = time.monotonic() - began
            last_mb, cpu_s, seen = rss_mb(served.pid), cpu_seconds(served.pid) - cpu_s, sum(counts) - seen
        finally:
            stop.set()
            for thread in threads:
                thread.join(30)
    return {
        "commands": len(took_ms),
        "median_ms": median(took_ms),
        "p99_ms": quantile(took_ms, 0.99),
        "minutes": lasted_s / 60,
        "first_mb": first_mb,
        "last_mb": last_mb,
        "cpu_percent": 100 * cpu_s / lasted_s,
        "telemetry_hz": seen / BROWSERS / lasted_s,
    }


def main() -> None:
    """Run it from the command line."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--minutes", type=float, default=10.0)
    keep("browsers", measure(options.parse_args().minutes))


if __name__ == "__main__":
    main()
