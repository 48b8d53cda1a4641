"""Load time of the page from localhost, and its transferred size: ``python bench/station/paint.py [--runs 7]``.

Each run uses a fresh browser profile, so nothing is cached. First paint is Chromium's first-contentful-paint; the map
is loaded when its canvas has been drawn on. The size is what was transferred by then, compressed and with headers.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from bench.station.stage import chromium, keep, station

HZ = 20
MAP_DRAWN = """() => {
    const canvas = document.querySelector('.ol-viewport canvas') ?? document.querySelector('canvas');
    return canvas !== null && canvas.width > 0 ? performance.now() : false;
}"""
PAINTED = "performance.getEntriesByName('first-contentful-paint')[0]?.startTime"
TRANSFERRED = """[...performance.getEntriesByType('navigation'), ...performance.getEntriesByType('resource')]
    .filter((entry) => !entry.name.includes('/api/'))
    .reduce((sum, entry) => sum + entry.transferSize, 0)"""


def measure(runs: int) -> dict[str, float]:
    """Load the page a number of times."""
    painted, drawn, transferred = [], [], []
    with station(HZ) as served, chromium() as browser:
        for _ in range(runs):
            with browser.new_context(viewport={"width": 1440, "height": 900}) as context:
                page = context.new_page()
                page.goto(served.url)
                drawn.append(page.wait_for_function(MAP_DRAWN).json_value() / 1000)
                painted.append(page.wait_for_function(PAINTED).json_value() / 1000)
                transferred.append(page.evaluate(TRANSFERRED) / 1000)
    return {
        "runs": runs,
        "paint_s": median(painted),
        "map_s": median(drawn),
        "transferred_kb": median(transferred),
    }


def main() -> None:
    """Run it from the command line."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--runs", type=int, default=7)
    keep("paint", measure(options.parse_args().runs))


if __name__ == "__main__":
    main()
