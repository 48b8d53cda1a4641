"""Growth of the page's heap in an hour of 20 Hz telemetry: ``python bench/station/heap.py [--minutes 60]``.

The page is open with its map, instruments and sensors, and follows the endless plane. Once a minute, garbage is
collected and the heap size recorded (Chrome DevTools Protocol: HeapProfiler.collectGarbage, Runtime.getHeapUsage). The
growth is counted from the first minute, when everything has been shown once, to the last.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from bench.harness import OUT, rss_mb
from bench.station.stage import chromium, keep, station

HZ = 20
MINUTE_S = 60.0


def measure(minutes: int) -> dict[str, float]:
    """Watch for a time; return megabytes (10⁶ bytes)."""
    series: list[tuple[float, float, float]] = []
    with station(HZ) as served, chromium() as browser:
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        heard = [0]
        page.on("websocket", lambda socket: socket.on("framereceived", lambda _: heard.__setitem__(0, heard[0] + 1)))
        page.goto(served.url)
        page.wait_for_function("document.querySelector('canvas') !== null")
        page.keyboard.press("s")
        session = page.context.new_cdp_session(page)
        began = time.monotonic()
        with (OUT / "heap.csv").open("w", buffering=1) as log:
            log.write("minute,heap_mb,dom_nodes,server_rss_mb,messages_per_s\n")
            seen = 0
            for minute in range(minutes + 1):
                page.wait_for_timeout(max(0.0, began + (minute + 1) * MINUTE_S - time.monotonic()) * 1000)
                session.send("HeapProfiler.collectGarbage")
                session.send("HeapProfiler.collectGarbage")
                used_mb = session.send("Runtime.getHeapUsage")["usedSize"] / 1e6
                nodes = session.send("Memory.getDOMCounters")["nodes"]
                series.append((used_mb, nodes, rss_mb(served.pid)))
                rate_hz, seen = (heard[0] - seen) / MINUTE_S, heard[0]
                log.write(f"{minute},{used_mb:.2f},{nodes},{series[-1][2]:.1f},{rate_hz:.1f}\n")
                print(f"minute {minute}: {used_mb:.2f} MB, {nodes} nodes, {rate_hz:.1f} messages/s", flush=True)
        page.screenshot(path=OUT / "heap.png")
    first, last = series[0], series[-1]
    return {
        "minutes": minutes,
        "first_mb": first[0],
        "last_mb": last[0],
        "most_mb": max(entry[0] for entry in series),
        "growth_mb": last[0] - first[0],
        "server_growth_mb": last[2] - first[2],
        "messages_per_s": seen / (MINUTE_S * (minutes + 1)),
    }


def main() -> None:
    """Run it from the command line."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--minutes", type=int, default=60)
    minutes = options.parse_args().minutes
    figures = measure(minutes)
    keep("heap", figures)


if __name__ == "__main__":
    main()
