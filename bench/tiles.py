#!/usr/bin/env python3
"""Serves the same MBTiles with our server and with others, in turn, and writes the speeds to bench/RESULTS.md.

    .venv/bin/python bench/tiles.py [--runs 5] [--tiles 2000]

Contestants: our server with the file as a source (`file`), our server with the same tiles in the cache of a service
(`cache`), and `martin` where installed (`cargo install martin --no-default-features --features mbtiles`; with its
default memory cache). Each gets the same requests for 256-pixel tiles of about 20 kB in random order: each tile once
over 16 connections, all read from SQLite; then all one after another on one connection (median, 99 %), and again over
16 connections for some seconds (tiles/s, CPU of the server), all from memory. The client is one process that only reads
sockets; it takes the same part of the two cores from all contestants.
"""

from __future__ import annotations

import argparse
import contextlib
import http.server
import json
import os
import random
import re
import selectors
import shutil
import socket
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from statistics import median

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from bench import harness

ZOOM = 14
SIDE = 256
CONNECTIONS = 16
HEADING = "## Map tiles"


def make(path: Path, count: int) -> list[tuple[int, int]]:
    """Write an MBTiles file of images like aerial photographs; return the tiles' columns and rows, from the top."""
    noise = np.random.default_rng(1)
    with contextlib.closing(sqlite3.connect(path)) as file:
        file.executescript(
            "CREATE TABLE metadata (name TEXT, value TEXT); CREATE TABLE tiles (zoom_level INTEGER, tile_column INTEGER,"
            "tile_row INTEGER, tile_data BLOB); INSERT INTO metadata VALUES ('name', 'bench'), ('format', 'jpg'),"
            f"('minzoom', '{ZOOM}'), ('maxzoom', '{ZOOM}'), ('bounds', '-180,-85,180,85'), ('type', 'baselayer')"
        )
        width = int(count**0.5)
        places = [(8000 + index % width, 6000 + index // width) for index in range(count)]
        for column, row in places:
            coarse = noise.integers(0, 255, (32, 32, 3), np.uint8)
            picture = cv2.resize(coarse, (SIDE, SIDE), interpolation=cv2.INTER_CUBIC)
            picture = cv2.add(picture, noise.integers(0, 24, (SIDE, SIDE, 3), np.uint8))
            data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 75])[1].tobytes()
            file.execute("INSERT INTO tiles VALUES (?, ?, ?, ?)", (ZOOM, column, 2**ZOOM - 1 - row, data))
        file.execute("CREATE UNIQUE INDEX tile_index ON tiles (zoom_level, tile_column, tile_row)")
        file.commit()
    return places


def request(port: int, path: str) -> bytes:
    """Return the bytes of a request."""
    return f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nAccept: */*\r\n\r\n".encode()


def length_of(data: bytes) -> int | None:
    """Return the size of a whole answer, once its head is complete."""
    head, end, _ = data.partition(b"\r\n\r\n")
    if not end:
        return None
    if not head.startswith(b"HTTP/1.1 200"):
        raise harness.NotMeasured(head.split(b"\r\n")[0].decode())
    found = re.search(rb"(?i)content-length: (\d+)", head)
    if found is None:
        raise harness.NotMeasured("an answer without a length")
    return len(head) + 4 + int(found[1])


def ask(connection: socket.socket, asked: bytes) -> int:
    """Send one request; return the size of the answer."""
    connection.sendall(asked)
    data = b""
    wanted: int | None = None
    while wanted is None or len(data) < wanted:
        part = connection.recv(1 << 18)
        if not part:
            raise harness.NotMeasured("the server hung up")
        data += part
        wanted = wanted or length_of(data)
    return wanted


def connect(port: int) -> socket.socket:
    """Open a connection."""
    connection = socket.create_connection(("127.0.0.1", port), 30)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return connection


def one_by_one(port: int, paths: list[str]) -> list[float]:
    """Return the duration of each request, one after another, seconds."""
    times = []
    with connect(port) as connection:
        for path in paths:
            began = time.perf_counter()
            ask(connection, request(port, path))
            times.append(time.perf_counter() - began)
    return times


def each_once(port: int, paths: list[str]) -> Iterator[bytes]:
    """Return a request for each tile."""
    return iter([request(port, path) for path in paths])


def at_random(port: int, paths: list[str], seconds: float) -> Iterator[bytes]:
    """Yield requests for random tiles, for a time."""
    turn, asked = random.Random(2), [request(port, path) for path in paths]
    began = time.perf_counter()
    while time.perf_counter() - began < seconds:
        yield turn.choice(asked)


def all_at_once(port: int, asked: Iterable[bytes]) -> int:
    """Send all requests over many connections; return the number of tiles received."""
    waiting, asked = selectors.DefaultSelector(), iter(asked)
    state: dict[socket.socket, tuple[int, int | None, bytes]] = {}
    connections = [connect(port) for _ in range(CONNECTIONS)]
    for connection, first in zip(connections, asked, strict=False):
        connection.sendall(first)
        state[connection] = (0, None, b"")
        waiting.register(connection, selectors.EVENT_READ)
    done = 0
    while state:
        for key, _ in waiting.select(1):
            ready = key.fileobj
            assert isinstance(ready, socket.socket)
            got, wanted, head = state[ready]
            part = ready.recv(1 << 18)
            if not part:
                raise harness.NotMeasured("the server hung up")
            got += len(part)
            if wanted is None:
                head += part
                wanted = length_of(head)
            if wanted is not None and got >= wanted:
                done += 1
                following = next(asked, None)
                if following is None:
                    waiting.unregister(ready)
                    del state[ready]
                    continue
                ready.sendall(following)
                got, wanted, head = 0, None, b""
            state[ready] = (got, wanted, head)
    for connection in connections:
        connection.close()
    return done


def rate_and_cpu(port: int, pid: int, asked: Iterable[bytes]) -> tuple[float, float, float]:
    """Return tiles per second, CPU (1 = one core), and CPU seconds per tile."""
    before, began = harness.cpu_seconds(pid), time.perf_counter()
    done = all_at_once(port, asked)
    used_s, lasted_s = harness.cpu_seconds(pid) - before, time.perf_counter() - began
    return done / lasted_s, used_s / lasted_s, used_s / done


@contextlib.contextmanager
def tile_service(file: Path) -> Iterator[str]:
    """Run a service of the same tiles, from which the cache is filled."""

    class Handler(http.server.BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_GET(self) -> None:
            column, row = (int(part) for part in self.path.partition("?")[0].strip("/").split("/"))
            with contextlib.closing(sqlite3.connect(file)) as tiles:
                (data,) = tiles.execute(
                    "SELECT tile_data FROM tiles WHERE tile_column=? AND tile_row=?", (column, 2**ZOOM - 1 - row)
                ).fetchone()
            self.send_response(200)
            self.send_header("Content-Length", str(len(data)))
            self.send_header("Cache-Control", "max-age=86400")
            self.end_headers()
            self.wfile.write(data)

        def log_message(self, format: str, *args: object) -> None:
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/{{x}}/{{y}}?z={{z}}"
    finally:
        server.shutdown()
        server.server_close()


@contextlib.contextmanager
def running(command: list[str], port: int | None = None, **environment: str) -> Iterator[tuple[int, int]]:
    """Run a server; yield its port and process id once it answers."""
    env = {**os.environ, **environment}
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=env)
    try:
        assert process.stdout is not None
        if port is None:
            port = int(json.loads(process.stdout.readline())["url"].rpartition(":")[2])
        deadline = time.monotonic() + 30
        while True:
            try:
                socket.create_connection(("127.0.0.1", port), 1).close()
                break
            except OSError:
                if time.monotonic() > deadline or process.poll() is not None:
                    raise harness.NotMeasured("it did not start") from None
                time.sleep(0.05)
        yield port, process.pid
    finally:
        process.terminate()
        process.wait(20)


def free_tcp_port() -> int:
    """Return an unused TCP port."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def measure(port: int, pid: int, paths: list[str], seconds: float, *, fetches: bool = False) -> dict[str, float]:
    """Return the figures of one contestant; `fetches` says that it fetches missing tiles."""
    idle_mb = harness.rss_mb(pid)
    if fetches:
        one_by_one(port, paths)
    first_rate, _, first_s = rate_and_cpu(port, pid, each_once(port, paths))
    times = one_by_one(port, paths)
    rate, cpu, each_s = rate_and_cpu(port, pid, at_random(port, paths, seconds))
    return {
        "first_tiles_s": first_rate,
        "first_cpu_us": first_s * 1e6,
        "median_ms": median(times) * 1e3,
        "p99_ms": harness.quantile(times, 0.99) * 1e3,
        "tiles_s": rate,
        "cpu": cpu,
        "cpu_us": each_s * 1e6,
        "idle_mb": idle_mb,
        "rss_mb": harness.rss_mb(pid),
        "load": os.getloadavg()[0],
    }


def load(figures: dict[str, dict[str, float] | str]) -> str:
    """Return the machine's load, including the benchmark itself."""
    found = [row["load"] for row in figures.values() if not isinstance(row, str)]
    return f"{min(found):.1f} to {max(found):.1f} on {os.cpu_count()} cores" if found else "unknown"


def table(figures: dict[str, dict[str, float] | str], runs: int) -> str:
    """Return the section of RESULTS.md."""
    lines = [
        HEADING,
        "",
        f"256-pixel tiles of one MBTiles file, median of {runs} runs in turn (`bench/tiles.py`). Aim: median ≤ 2 ms, ≥ 2,000 tiles/s.",
        f"Load of the machine meanwhile: {load(figures)}. Memory is that of the whole process: ours is Python with the whole ground station.",
        "The first time each tile comes from SQLite; then all have it in memory.",
        "",
        "| | first time, tiles/s | CPU a tile | then: median | 99 % | tiles/s | CPU of a core | CPU a tile | memory before / after |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name, row in figures.items():
        if isinstance(row, str):
            lines.append(f"| {name} | not measured: {row} | | | | | | | |")
        else:
            lines.append(
                f"| {name} | {row['first_tiles_s']:,.0f} | {row['first_cpu_us']:.0f} µs | {row['median_ms']:.2f} ms | {row['p99_ms']:.2f} ms | {row['tiles_s']:,.0f} | {row['cpu']:.0%} "
                f"| {row['cpu_us']:.0f} µs | {row['idle_mb']:.0f} / {row['rss_mb']:.0f} MB |"
            )
    return "\n".join([*lines, ""])


def main() -> int:
    """Measure all contestants and write the section."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--tiles", type=int, default=2000)
    parser.add_argument("--seconds", type=float, default=4.0)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name, contextlib.ExitStack() as stack:
        folder = Path(name)
        file = folder / "bench.mbtiles"
        places = make(file, options.tiles)
        random.Random(1).shuffle(places)
        service = stack.enter_context(tile_service(file))
        (folder / "maps").mkdir()
        (folder / "maps/sources.toml").write_text(
            f'[[source]]\nid = "file"\nname = "file"\nkind = "mbtiles"\npath = "{file}"\n'
            f'[[source]]\nid = "cache"\nname = "cache"\nkind = "xyz"\nurl = "{service}"\nlocal_network = true\n'
        )

        def ours(source: str) -> Callable[[], dict[str, float]]:
            def run() -> dict[str, float]:
                command = [sys.executable, "-m", "vencejo.cli", "serve", "--port", "0", "--json", "--no-record"]
                command += ["--link", "udpin:127.0.0.1:0"]
                with running(command, VENCEJO_DATA=name) as (port, pid):
                    paths = [f"/api/v1/tiles/{source}/{ZOOM}/{column}/{row}" for column, row in places]
                    return measure(port, pid, paths, options.seconds, fetches=source == "cache")

            return run

        def martin() -> dict[str, float]:
            program = shutil.which("martin")
            if program is None:
                raise harness.NotMeasured("martin is not installed")
            port = free_tcp_port()
            with running([program, "--listen-addresses", f"127.0.0.1:{port}", str(file)], port) as (port, pid):
                paths = [f"/bench/{ZOOM}/{column}/{row}" for column, row in places]
                return measure(port, pid, paths, options.seconds)

        contestants = {
            "Vencejo, file": ours("file"),
            "Vencejo, cache of a service": ours("cache"),
            "martin": martin,
        }
        figures = harness.repeat(options.runs, contestants)
    section = table(figures, options.runs)
    print(section)
    page = harness.ROOT / "bench/RESULTS.md"
    text = page.read_text(encoding="utf-8")
    before, found, after = text.partition(HEADING)
    _, more, rest = after.partition("\n## ")
    text = before.rstrip("\n") + "\n\n" + section + (f"\n## {rest}" if found and more else "")
    page.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
