"""Map coverage while dragging over an offline area: ``python bench/station/panning.py [--seconds 20]``.

The server shows an MBTiles file of photographs; the page drags its map over it, in software rendering, always into
areas that it has not shown yet. In each frame, twenty points of the window are examined: one without an image begins a
gap, which lasts until the frame in which it has one. Results are the longest time between two frames, and the longest
gap.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import sqlite3
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from bench.harness import result_of, running
from bench.station.stage import chromium, keep

LAT_DEG, LON_DEG = 40.3332, -3.7978
COARSEST, FINEST = 8, 16
AROUND_TILES = 24
"""Tiles of the finest level on each side of the centre."""
PICTURES = 16
DRAG_PX = 40
"""Distance per mouse move, of which the browser receives some twenty a second: a brisk drag."""
MOVES = 8
"""Moves from pressing the button to releasing it."""

WATCH = """() => {
    const marks = [];
    for (let x = 1; x <= 5; x += 1) for (let y = 1; y <= 4; y += 1) marks.push([x / 6, y / 5]);
    const blankSince = marks.map(() => null);
    const seen = (window.panned = { frames: 0, longest_frame_ms: 0, longest_gap_ms: 0, gaps: 0, looks: 0 });
    const end = (index, now) => {
        if (blankSince[index] !== null) seen.longest_gap_ms = Math.max(seen.longest_gap_ms, now - blankSince[index]);
        blankSince[index] = null;
    };
    let before = null;
    const look = (now) => {
        if (before !== null) seen.longest_frame_ms = Math.max(seen.longest_frame_ms, now - before);
        before = now;
        seen.frames += 1;
        const layers = [...document.querySelectorAll('.ol-layer canvas')].map((canvas) => canvas.getContext('2d'));
        marks.forEach(([x, y], index) => {
            const isCovered = layers.some((layer) => {
                const { width, height } = layer.canvas;
                return layer.getImageData(Math.round(x * width), Math.round(y * height), 1, 1).data[3] > 0;
            });
            seen.looks += isCovered;
            if (isCovered) end(index, now);
            else if (blankSince[index] === null) {
                blankSince[index] = now;
                seen.gaps += 1;
            }
        });
        if (!window.panningEnds) requestAnimationFrame(look);
        else {
            marks.forEach((_, index) => end(index, now));
            window.panningEnded = true;
        }
    };
    requestAnimationFrame(look);
}"""


def photograph(seed: int) -> bytes:
    """Return a tile that is as expensive to decode as a photograph: smooth colours with noise, as JPEG."""
    rng = np.random.default_rng(seed)
    coarse = rng.integers(40, 200, (17, 17, 3)).astype(np.uint8)
    smooth = cv2.resize(coarse, (256, 256), interpolation=cv2.INTER_CUBIC).astype(np.float64)
    picture = np.clip(smooth + rng.normal(0, 8, smooth.shape), 0, 255).astype(np.uint8)
    _, encoded = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 85])
    return encoded.tobytes()


def write_mbtiles(path: Path) -> int:
    """Write the area's tiles, coarse to fine; return their number."""
    pictures = [photograph(seed) for seed in range(PICTURES)]
    count = 0
    with contextlib.closing(sqlite3.connect(path)) as file, file:
        file.execute("CREATE TABLE metadata (name TEXT, value TEXT)")
        file.execute("CREATE TABLE tiles (zoom_level INTEGER, tile_column INTEGER, tile_row INTEGER, tile_data BLOB)")
        notes = {"name": "area", "format": "jpg", "type": "baselayer", "minzoom": str(COARSEST), "maxzoom": str(FINEST)}
        file.executemany("INSERT INTO metadata VALUES (?, ?)", notes.items())
        for zoom in range(COARSEST, FINEST + 1):
            side = 2**zoom
            column = (LON_DEG + 180) / 360 * side
            row = (1 - math.asinh(math.tan(math.radians(LAT_DEG))) / math.pi) / 2 * side
            around = AROUND_TILES / 2 ** (FINEST - zoom) + 1
            tiles = [
                (zoom, x, side - 1 - y, pictures[(x * 7 + y * 3) % PICTURES])
                for x in range(int(column - around), int(column + around) + 1)
                for y in range(int(row - around), int(row + around) + 1)
            ]
            file.executemany("INSERT INTO tiles VALUES (?, ?, ?, ?)", tiles)
            count += len(tiles)
        file.execute("CREATE UNIQUE INDEX tile ON tiles (zoom_level, tile_column, tile_row)")
    return count


@contextlib.contextmanager
def station(folder: Path) -> Iterator[str]:
    """Run a server that shows the area; yield its address."""
    (folder / "files").mkdir(parents=True)
    print(f"{write_mbtiles(folder / 'files/area.mbtiles')} tiles", flush=True)
    (folder / "sources.toml").write_text(
        '[[source]]\nid = "area"\nname = "Area"\nkind = "mbtiles"\npath = "files/area.mbtiles"\n', encoding="utf-8"
    )
    serve = [sys.executable, "-m", "vencejo.cli", "serve", "--port=0", "--json", "--no-record", f"--maps={folder}"]
    with running(serve) as server:
        yield result_of(server, 30.0)["url"]


def measure(seconds: float) -> dict[str, float]:
    """Drag for a time; return milliseconds and counts."""
    stored = {
        "map-view": {"lat_deg": LAT_DEG, "lon_deg": LON_DEG, "zoom": FINEST - 0.4},
        "map": {"hasGrid": True, "hasTrails": True, "follow": "free"},
    }
    with tempfile.TemporaryDirectory() as folder, station(Path(folder) / "maps") as url, chromium() as browser:
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        for name, value in stored.items():
            page.add_init_script(
                f"localStorage.setItem({json.dumps(f'vencejo.{name}')}, {json.dumps(json.dumps(value))})"
            )
        page.goto(url)
        page.wait_for_function("() => document.querySelector('.ol-layer canvas') !== null")
        page.get_by_role("region", name="No vehicle yet").get_by_role("button").first.click()
        page.wait_for_load_state("networkidle")
        page.evaluate(WATCH)
        begin = time.monotonic()
        moves, turn = 0, 0
        while time.monotonic() < begin + seconds:
            # In rows, each below the previous one.
            step = turn % 18
            angle = math.pi if step < 8 else 0.0 if 9 <= step < 17 else -math.pi / 2
            turn += 1
            x, y = 780.0, 450.0
            page.mouse.move(x, y)
            page.mouse.down()
            for _ in range(MOVES):
                x, y = x + DRAG_PX * math.cos(angle), y + DRAG_PX * math.sin(angle)
                page.mouse.move(x, y)
                moves += 1
            page.mouse.up()
        took = time.monotonic() - begin
        page.evaluate("() => { window.panningEnds = true; }")
        page.wait_for_function("() => window.panningEnded")
        seen: dict[str, Any] = page.evaluate("window.panned")
    assert seen["looks"] > 0, "no picture was seen at all"
    return {
        "seconds": took,
        "px_per_s": moves * DRAG_PX / took,
        "frames_per_s": seen["frames"] / took,
        "longest_frame_ms": seen["longest_frame_ms"],
        "gaps": seen["gaps"],
        "longest_gap_ms": seen["longest_gap_ms"],
    }


def main() -> None:
    """Run it from the command line."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seconds", type=float, default=20.0)
    keep("panning", measure(options.parse_args().seconds))


if __name__ == "__main__":
    main()
