"""Video from a file through the server to a browser's page: age of the displayed images, and cost.

`python -m bench.camera` prints a section for bench/RESULTS.md; `--write` puts it there. A file of 640 × 480 at 30
images a second, each of which shows its number, is played by `vencejo serve --camera`. Chromium shows the station's
camera window; a script in the page reads the number from the canvas in each painted frame. The time of capture is known
from a second viewer, which receives the same data and recognises each image byte for byte.
"""

from __future__ import annotations

import argparse
import asyncio
import bisect
import contextlib
import json
import os
import statistics
import struct
import threading
import time
from datetime import date
from pathlib import Path
from typing import Any

from tests.browser.chromium import running
from tests.camera.test_bytes import coded
from tests.camera.test_serving import Viewer
from tests.server.client import Client, serving

ROOT = Path(__file__).resolve().parent.parent
VIDEO = ROOT / "tests" / "fixtures" / "camera" / "counter-640x480-30.mp4"
RESULTS = ROOT / "bench" / "RESULTS.md"
TITLE = "## Camera: a file of 640 × 480 at 30/s to the browser's canvas"
AIM = (
    "≤ 150 ms from the picture's time to the canvas on localhost; ≤ 25 % of a core for the server with its Python side"
)
WARM_UP_S = 3.0

READER = """
() => {
  const canvas = document.querySelector('section.window canvas');
  const small = new OffscreenCanvas(8, 1).getContext('2d', { willReadFrequently: true });
  window.seen = [];
  let last = -1;
  const look = () => {
    if (canvas.width === 640) {
      for (let bit = 0; bit < 8; bit += 1) small.drawImage(canvas, 16 + 76 * bit + 20, 20, 20, 20, bit, 0, 1, 1);
      const pixels = small.getImageData(0, 0, 8, 1).data;
      let number = 0;
      for (let bit = 0; bit < 8; bit += 1) number = 2 * number + (pixels[4 * bit] > 127 ? 1 : 0);
      if (number !== last) window.seen.push([number, performance.timeOrigin + performance.now()]);
      last = number;
    }
    requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
}
"""


def cpu_s(pids: list[int]) -> float:
    """Return the CPU time used by processes, seconds (proc(5), fields 14 and 15)."""
    ticks = 0
    for pid in pids:
        with contextlib.suppress(OSError):
            fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
            ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def descendants(pid: int) -> list[int]:
    """Return a process and all of its descendants."""
    found = [pid]
    with contextlib.suppress(OSError):
        for thread in Path(f"/proc/{pid}/task").iterdir():
            for child in (thread / "children").read_text(encoding="ascii").split():
                found += descendants(int(child))
    return found


class Times(threading.Thread):
    """Records the capture time of each image, as another viewer."""

    def __init__(self, client: Client, count: int) -> None:
        super().__init__(daemon=True)
        self._numbers = {frame.data: number for number, frame in enumerate(coded(VIDEO))}
        assert len(self._numbers) == count
        self._viewer = Viewer(client, "nose", "h264,jpeg")
        self.taken: dict[int, list[float]] = {number: [] for number in range(count)}
        self.start()

    def run(self) -> None:
        """Listen until the end."""
        with contextlib.suppress(OSError, AssertionError, struct.error):
            for seen in self._viewer.pictures():
                self.taken[self._numbers[seen.data]].append(seen.captured_unix_s)

    def close(self) -> None:
        """Stop listening."""
        self._viewer.close()


async def measure(seconds: float, data: Path) -> dict[str, Any]:
    """Play the video and measure."""
    with serving("--link", "udpin:127.0.0.1:0", "--camera", f"nose={VIDEO}", data=data) as served:
        client = served.client(name="bench")
        server = [served.process.pid]
        await asyncio.sleep(WARM_UP_S)
        alone_s, began = cpu_s(server), time.monotonic()
        await asyncio.sleep(seconds / 2)
        idle_percent = 100 * (cpu_s(server) - alone_s) / (time.monotonic() - began)
        async with running() as browser:
            page = await (await browser.new_context(viewport={"width": 1440, "height": 900})).new_page()
            await page.goto(served.url)
            await page.get_by_role("button", name="Show the camera").click()
            await page.locator("section.window canvas").wait_for()
            await page.evaluate(READER)
            await asyncio.sleep(WARM_UP_S)
            browsers = [pid for pid in descendants(os.getpid()) if pid not in (os.getpid(), *server)]
            used_s, looked_s, began = cpu_s(server), cpu_s(browsers), time.monotonic()
            await asyncio.sleep(seconds / 2)
            spent_s = time.monotonic() - began
            one_percent = 100 * (cpu_s(server) - used_s) / spent_s
            browser_percent = 100 * (cpu_s(browsers) - looked_s) / spent_s
            times = Times(client, 120)
            await asyncio.sleep(1.0)
            await page.evaluate("() => { window.seen.length = 0; }")
            await asyncio.sleep(seconds)
            seen: list[tuple[int, float]] = await page.evaluate("() => window.seen")
            await asyncio.sleep(0.5)
            times.close()
    ages_ms = []
    for number, at_ms in seen:
        taken = times.taken.get(number, [])
        index = bisect.bisect_right(taken, at_ms / 1000) - 1
        if index >= 0 and at_ms / 1000 - taken[index] < 3.0:
            ages_ms.append(at_ms - 1000 * taken[index])
    assert len(ages_ms) > 10, f"only {len(ages_ms)} pictures were recognised"
    ages_ms.sort()
    return {
        "median_ms": statistics.median(ages_ms),
        "p99_ms": ages_ms[int(len(ages_ms) * 0.99)],
        "shown_per_s": len(seen) / seconds,
        "idle_percent": idle_percent,
        "one_percent": one_percent,
        "browser_percent": browser_percent,
        "load": os.getloadavg()[0],
    }


def section(figures: dict[str, Any]) -> str:
    """Return the section of RESULTS.md."""
    return (
        f"{TITLE}\n\nAim: {AIM}. Written by `python -m bench.camera --write`, {date.today()}"  # noqa: DTZ011
        f" (load of the machine: {figures['load']:.1f} on 2 cores).\n\n"
        "| from capture to canvas, median | 99 % | pictures shown /s | server and Python, no viewer | one viewer | "
        "the browser's own (software rendering) |\n|---|---|---|---|---|---|\n"
        f"| {figures['median_ms']:.0f} ms | {figures['p99_ms']:.0f} ms | {figures['shown_per_s']:.1f} | "
        f"{figures['idle_percent']:.1f} % of a core | {figures['one_percent']:.1f} % | "
        f"{figures['browser_percent']:.0f} % |\n"
    )


def main() -> None:
    """Measure, and print or write the section."""
    import tempfile

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        figures = asyncio.run(measure(arguments.seconds, Path(folder)))
    print(json.dumps(figures))
    text = section(figures)
    if arguments.write:
        before = RESULTS.read_text(encoding="utf-8").partition(f"\n{TITLE}")[0].rstrip("\n")
        RESULTS.write_text(f"{before}\n\n{text}", encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()
