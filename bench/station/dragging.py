"""Frame rate of the map while a point of a 100-item plan is dragged, with rehearsals and software rendering.

``python bench/station/dragging.py [--seconds 10]``. Frames as in ``frames.py``. The pointer moves all the time; the
rehearsals received meanwhile are counted too, since a page that requests none would be fast, and for the answers about
the lines, the time from the pointer's move until they were painted is measured. A plane's telemetry arrives at 20 Hz at
the same time.
"""

from __future__ import annotations

import argparse
import itertools
import math
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from bench.harness import NotMeasured, cpu_seconds, quantile
from bench.station.frames import COUNT, HZ, LAT_DEG, LON_DEG
from bench.station.stage import chromium, costs_ms, keep, metering, station

if TYPE_CHECKING:
    from playwright.sync_api import Page

ITEMS = 100
LEG_DEG = (0.0016, 0.004)
"""Distance between two parallel lines, and half of their length: degrees of latitude and of longitude."""
DRAGGED = 50
RADIUS_PX = 60.0
WATCH = """() => {
    const bench = (window.bench = { drawn_ms: [], waited_ms: [] });
    let moved = null;
    let asked = null;
    let answered = false;
    addEventListener('pointermove', ({ timeStamp }) => (moved = { at: performance.now(), event: timeStamp }), true);
    const say = WebSocket.prototype.send;
    WebSocket.prototype.send = function (text) {
        if (typeof text === 'string' && text.startsWith('{"type":"plan_way"') && moved !== null) {
            [asked, moved, answered] = [moved, null, false];
        }
        return say.call(this, text);
    };
    const take = Object.getOwnPropertyDescriptor(WebSocket.prototype, 'onmessage');
    Object.defineProperty(WebSocket.prototype, 'onmessage', {
        configurable: true,
        get() { return take.get.call(this); },
        set(listener) {
            take.set.call(this, listener && ((event) => {
                const isWay = typeof event.data === 'string' && event.data.startsWith('{"type":"way"');
                if (isWay) answered = true;
                return listener.call(this, event);
            }));
        },
    });
    // the canvas of the plan lies below that of the planes, which is the last that is painted by hand
    const plan = () => [...document.querySelectorAll('.ol-layers canvas[aria-hidden]')].at(-2);
    const clear = CanvasRenderingContext2D.prototype.clearRect;
    CanvasRenderingContext2D.prototype.clearRect = function (...box) {
        if (answered && asked !== null && this.canvas === plan()) {
            const { at, event } = asked;
            [asked, answered] = [null, false];
            // it is painted in one go
            queueMicrotask(() => {
                bench.drawn_ms.push(performance.now() - at);
                bench.waited_ms.push(at - event);
            });
        }
        return clear.apply(this, box);
    };
}"""
"""Measures the time from each pointer move sent to the core until its answer has been painted, milliseconds;
and how long the move itself waited for the page."""


def waypoint(index: int) -> tuple[float, float]:
    """Return latitude and longitude of an item after the take-off: parallel lines, two points each."""
    line, end = divmod(index, 2)
    east = 1 if (line + end) % 2 else -1
    return LAT_DEG + (line - ITEMS / 4) * LEG_DEG[0], LON_DEG + east * LEG_DEG[1]


def mission() -> str:
    """Return a plan of waypoints, 80 m above home."""
    home = f"0\t1\t0\t16\t0\t0\t0\t0\t{LAT_DEG}\t{LON_DEG}\t690\t1"
    takeoff = f"1\t0\t3\t22\t10\t0\t0\t0\t{LAT_DEG}\t{LON_DEG + 0.003}\t60\t1"
    rest = [
        f"{number}\t0\t3\t16\t0\t0\t0\t0\t{lat_deg}\t{lon_deg}\t80\t1"
        for number, (lat_deg, lon_deg) in enumerate(map(waypoint, range(ITEMS - 2)), 2)
    ]
    return "\n".join(["QGC WPL 110", home, takeoff, *rest, f"{ITEMS}\t0\t3\t20\t0\t0\t0\t0\t0\t0\t0\t1", ""])


def pixel(page: Page, lat_deg: float, lon_deg: float) -> tuple[float, float]:
    """Return a position's pixel in the window, from the coordinates shown for two pointer positions."""
    shown = page.get_by_label("Position of the pointer", exact=True)
    found = []
    for x, y in ((600.0, 250.0), (880.0, 450.0)):
        page.mouse.move(x, y)
        page.wait_for_timeout(300)
        lat, lon = shown.inner_text().split(", ")
        found.append((x, y, float(lat), float(lon)))
    (x0, y0, lat0, lon0), (x1, y1, lat1, lon1) = found
    # Over some kilometres, Mercator's latitudes are practically linear.
    return (
        x0 + (lon_deg - lon0) / (lon1 - lon0) * (x1 - x0),
        y0 + (lat_deg - lat0) / (lat1 - lat0) * (y1 - y0),
    )


def measure(seconds: float) -> dict[str, Any]:
    """Drag one point around, and count."""
    answers: list[float] = []

    def listen(socket: Any) -> None:
        def take(payload: str | bytes) -> None:
            if isinstance(payload, str) and '"track"' in payload:
                answers.append(time.monotonic())

        socket.on("framereceived", take)

    with station(HZ) as served, chromium() as browser, tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "hundred.waypoints"
        file.write_text(mission(), encoding="utf-8")
        page = browser.new_context(viewport={"width": 1440, "height": 900}).new_page()
        page.on("websocket", listen)
        page.add_init_script(f"({WATCH})()")
        page.goto(served.url)
        page.get_by_role("button", name="Plan", exact=True).click()
        with page.expect_file_chooser() as choosing:
            page.get_by_role("button", name="Open a plan file", exact=True).click()
        choosing.value.set_files(file)
        page.wait_for_timeout(5000)
        x, y = pixel(page, *waypoint(DRAGGED))
        page.mouse.move(x, y)
        page.mouse.down()
        answers.clear()
        page.evaluate("[window.bench.drawn_ms, window.bench.waited_ms] = [[], []]")
        session = metering(page)
        server_s, costs = cpu_seconds(served.pid), costs_ms(session)
        page.evaluate(COUNT)
        until, step = time.monotonic() + seconds, 0
        while time.monotonic() < until:
            step += 1
            angle = step / 20
            page.mouse.move(x + RADIUS_PX * math.sin(angle), y + RADIUS_PX * (1 - math.cos(angle)))
        page.mouse.up()
        times: list[float] = page.evaluate("window.benchFrames")
        server_s = cpu_seconds(served.pid) - server_s
        costs = {name: value - costs[name] for name, value in costs_ms(session).items()}
        found: dict[str, list[float]] = page.evaluate("window.bench")
        followed = len(answers)
    if len(found["drawn_ms"]) < seconds:
        raise NotMeasured("the pointer missed the point: the map moved with the plane in that moment; run it again")
    gaps = [later - sooner for sooner, later in itertools.pairwise(times)]
    return {
        "frames_per_s": 1000 * len(gaps) / (times[-1] - times[0]),
        "longest_ms": max(gaps),
        "rehearsals_per_s": followed / seconds,
        "ways_per_s": len(found["drawn_ms"]) / seconds,
        "drawn_ms": statistics.median(found["drawn_ms"]),
        "drawn_p99_ms": quantile(found["drawn_ms"], 0.99),
        "waited_ms": statistics.median(found["waited_ms"]),
        "server_ms": 1000 * server_s / len(times),
        **{name: value / len(times) for name, value in costs.items()},
    }


def main() -> None:
    """Run it from the command line."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seconds", type=float, default=10.0)
    keep("dragging", measure(options.parse_args().seconds))


if __name__ == "__main__":
    main()
