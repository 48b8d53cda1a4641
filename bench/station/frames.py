"""Frame rate of the map with a trail of 50,000 points, 20 Hz telemetry and software rendering.

``python bench/station/frames.py [--seconds 10]``. A frame is a callback of requestAnimationFrame, of which a page that
is fast enough gets 60 a second. First with an empty trail, then with a full one at rest, then while the map is dragged.
"""

from __future__ import annotations

import argparse
import base64
import itertools
import math
import struct
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from bench.station.stage import chromium, keep, station

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

HZ = 20
POINTS = 50_000
LAT_DEG, LON_DEG = 40.3332, -3.7978
COUNT = """() => {
    const frames = (window.benchFrames = []);
    const count = (at) => {
        frames.push(at);
        // A later count has a list of its own, and ends this one.
        if (window.benchFrames === frames) requestAnimationFrame(count);
    };
    requestAnimationFrame(count);
}"""


def trail() -> str:
    """Return a spiral trail, 4 m between points, in the format in which the page stores it between two loads."""
    out = bytearray()
    angle = 0.0
    for index in range(POINTS):
        radius_m = 300.0 + index * 0.05
        angle += 4.0 / radius_m
        lat_deg = LAT_DEG + radius_m * math.sin(angle) / 111_195
        lon_deg = LON_DEG + radius_m * math.cos(angle) / 111_195 / math.cos(math.radians(LAT_DEG))
        height_m = 60 + 40 * math.sin(angle / 7)
        out += struct.pack("<iih", round(lon_deg * 1e7), round(lat_deg * 1e7), round(height_m * 10))
    return base64.b64encode(bytes(out)).decode()


def frames(page: Page, seconds: float, *, dragged: bool) -> tuple[float, float]:
    """Return the frame rate over a time, and the longest time between two frames, ms."""
    page.evaluate(COUNT)
    until = time.monotonic() + seconds
    if dragged:
        page.mouse.move(720, 450)
        page.mouse.down()
        step = 0
        while time.monotonic() < until:
            step += 1
            page.mouse.move(720 + 200 * math.sin(step / 15), 450 + 100 * math.cos(step / 15))
        page.mouse.up()
    else:
        page.wait_for_timeout(seconds * 1000)
    times: list[float] = page.evaluate("window.benchFrames")
    gaps = [later - sooner for sooner, later in itertools.pairwise(times)]
    return 1000 * len(gaps) / (times[-1] - times[0]), max(gaps)


def opened(browser: Browser, url: str, kept: str | None) -> Page:
    """Open the page with running telemetry, optionally with a stored trail."""
    page = browser.new_context(viewport={"width": 1440, "height": 900}).new_page()
    if kept is not None:
        page.add_init_script(f"sessionStorage.setItem('vencejo.trail.1', '{kept}')")
    page.goto(url)
    page.wait_for_function("document.querySelector('canvas') !== null")
    page.wait_for_timeout(5000)
    return page


def measure(seconds: float) -> dict[str, Any]:
    """Measure the three situations."""
    with station(HZ) as served, chromium() as browser:
        page = opened(browser, served.url, None)
        empty, _ = frames(page, seconds, dragged=False)
        page.context.close()
        page = opened(browser, served.url, trail())
        full, longest_ms = frames(page, seconds, dragged=False)
        dragged, _ = frames(page, seconds, dragged=True)
    return {"empty_per_s": empty, "frames_per_s": full, "dragged_per_s": dragged, "longest_ms": longest_ms}


def main() -> None:
    """Run it from the command line."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seconds", type=float, default=10.0)
    keep("frames", measure(options.parse_args().seconds))


if __name__ == "__main__":
    main()
