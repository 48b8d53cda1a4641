"""Power cuts at any moment, under the whole program: the synced data must be sufficient to continue.

There is no block device to replay and no Raspberry Pi to unplug. `vencejo serve` is traced by strace while it records a plane and writes
everything that it keeps; the trace is played onto a disk that loses more than a real one would (tests/faults/disk.py) and cut off again
and again. What is left is looked at file by file, and the program is started on a part of it.
"""

from __future__ import annotations

import contextlib
import functools
import http.server
import itertools
import json
import os
import random
import shutil
import signal
import sqlite3
import struct
import subprocess
import sys
import threading
import time
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from vencejo.recording import summarize

from tests.faults.disk import Disk, calls, strace
from tests.faults.test_clocks import mission
from tests.server.client import Client, serving
from tests.support import simulated_plane, wait_for

pytestmark = [pytest.mark.soak, pytest.mark.timeout(0)]

CUTS = max(500, int(os.environ.get("VENCEJO_SOAK_TIMES", "1000")))
SECONDS = 40.0
"""How long the program writes."""
STARTS = 25
"""Number of the resulting states on which the program is started."""
LOST_S = 2.0
"""Tolerated loss of a recording."""


@functools.cache
def picture(z: int, x: int, y: int) -> bytes:
    """Return a unique PNG tile of some kilobytes of incompressible data."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    grey = random.Random(f"{z}/{x}/{y}")
    rows = b"".join(b"\0" + grey.randbytes(64) for _ in range(64))
    header = struct.pack(">IIBBBBB", 64, 64, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


@contextlib.contextmanager
def tiles() -> Iterator[str]:
    """Run a service of map tiles; yield its address."""

    class Service(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            z, x, y = (int(part) for part in self.path.removesuffix(".png").split("/")[1:])
            body = picture(z, x, y)
            self.send_response(200)
            self.send_header("Content-Type", "image/png")
            self.send_header("Content-Length", str(len(body)))
            self.send_header("Cache-Control", "max-age=3")
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_: object) -> None:
            """Print nothing."""

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Service) as server:
        threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True).start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()


@dataclass
class Told:
    """What the program reported as done, and when: from then on it must survive."""

    drafts: list[tuple[float, int]] = field(default_factory=list)
    sources: list[tuple[float, str]] = field(default_factory=list)
    tokens: list[tuple[float, str]] = field(default_factory=list)
    keys: list[tuple[float, str]] = field(default_factory=list)

    @staticmethod
    def at(done: list[tuple[float, Any]], at_s: float) -> Any:
        """Return the newest reported by a time."""
        return next((value for told_s, value in reversed(done) if told_s <= at_s), None)


def write_everything(data: Path, logs: list[Path]) -> Told:
    """Let the program write all of its data, traced into `logs`; return its reports."""
    told = Told()
    options = ("--record", "--token", "--telemetry-floor=0", "--maps-floor=0", "--video-floor=0")
    trace = strace(logs[0])
    with (
        tiles() as service,
        serving(*options, "--link=udpin:127.0.0.1:0", data=data, under=trace) as served,
        contextlib.ExitStack() as stack,
    ):
        # SIGKILL at the end: a power cut does not shut anything down in order.
        stack.callback(kill_children, served.process.pid)
        client = served.client(token=served.token("operator"), name="pilot")
        link = client.done("GET", "links")[0]
        stack.enter_context(simulated_plane(f"--link=udpout:{link['local_address']}"))
        wait_for(lambda: client.done("GET", "vehicles") != [], "the plane")
        began = time.monotonic()
        for number in itertools.count():
            one_round(client, service, number, told)
            if number % 8 == 5:
                told.tokens.append(new_viewer_token(data, logs))
            if time.monotonic() - began > SECONDS:
                break
    return told


def kill_children(process: int) -> None:
    """End a process and its children."""
    for child in Path(f"/proc/{process}/task/{process}/children").read_text().split():
        os.kill(int(child), signal.SIGKILL)


def new_viewer_token(data: Path, logs: list[Path]) -> tuple[float, str]:
    """Let another process renew a token, traced too; return the time and the token."""
    logs.append(logs[0].with_name(f"trace-{len(logs)}"))
    command = [*strace(logs[-1]), sys.executable, "-m", "vencejo.cli", "tokens", "--new", "viewer", "--json"]
    env = {**os.environ, "VENCEJO_DATA": str(data)}
    said = subprocess.run(command, capture_output=True, text=True, check=True, env=env, timeout=60).stdout
    return time.time(), str(json.loads(said)["viewer"])


def one_round(client: Client, service: str, number: int, told: Told) -> None:
    """Change all stored data once."""
    plan = client.ask("POST", "plan/parse?name=m.waypoints", mission(number % 1000)).json
    base = (client.done("GET", "draft")["current"] or {"revision": 0})["revision"]
    revision = client.done("PUT", "draft", {"base": base, "author": f"author-{number % 3}", "plan": plan})["revision"]
    told.drafts.append((time.time(), revision))

    source = {"id": "field", "name": f"Field {number}", "kind": "xyz", "url": service + "/{z}/{x}/{y}.png"}
    client.done("PUT", "maps/sources/field", {**source, "local_network": True, "max_zoom": 18})
    told.sources.append((time.time(), f"Field {number}"))
    for x in range(8):
        assert client.ask("GET", f"tiles/field/{10 + number % 6}/{100 + x}/{100 + number}").status == 200

    client.operation("PUT", "vehicles/1/plan/mission", plan)
    if number % 4 == 1:
        signs = client.done("GET", "vehicles/1/signing")["must_sign"]
        change = {"act": "rotate" if signs else "set_up", "confirm_system_id": 1, "any_link": True}
        key = client.done("POST", "vehicles/1/signing", change)["key"]
        told.keys.append((time.time(), key))
    if number % 4 == 3:
        recording = client.done("GET", "recorder")["file"]
        client.done("PUT", f"recordings/{recording}/keep", {"is_kept": number % 8 == 3})


# After the power cut ----------------------------------------------------------------------------------------------


def kind_of(path: str) -> str:
    """Return the kind of a file in the data folder, by its name."""
    name = path.rpartition("/")[2]
    if name.startswith(".") and name.endswith((".lock", ".tmp")):
        return "passing"
    if name.endswith(".tlog"):
        return "recording"
    if ".mbtiles" in name:
        return "cache"
    if path.startswith("maps/reading/"):
        return "note"
    return "mark" if name.endswith(".keep") else "setting"


def entries_of(tlog: bytes) -> list[tuple[int, int, int]]:
    """Yield the range of each entry of a recording, and its time in microseconds, without a truncated end."""
    entries, at = [], 0
    while at + 20 <= len(tlog):
        end = at + 20 + tlog[at + 9]
        assert (tlog[at + 8], tlog[at + 10] & 1) == (0xFD, 0)
        if end > len(tlog):
            break
        entries.append((at, end, int.from_bytes(tlog[at : at + 8], "big")))
        at = end
    return entries


def lost_s(written: bytes, left: bytes, at_s: float) -> float:
    """Return the loss of a recording: the time since the last entry before which nothing is missing."""
    whole = 0
    for begin, end, time_us in entries_of(written):
        if left[begin:end] != written[begin:end]:
            break
        whole = time_us
    return at_s - whole / 1e6


def check_cache(path: Path) -> int:
    """Check that a cache and each tile in it are intact; return the number of tiles."""
    with contextlib.closing(sqlite3.connect(path)) as database:
        assert database.execute("PRAGMA integrity_check").fetchall() == [("ok",)], path
        if not database.execute("SELECT 1 FROM sqlite_master WHERE name = 'images'").fetchall():
            return 0
        rows = database.execute("SELECT level, col, row, data FROM images").fetchall()
    for level, column, row, data in rows:
        assert data == picture(level, column, row), (path, level, column, row)
    return len(rows)


@dataclass
class Seen:
    """Findings over all resulting states."""

    cuts: int = 0
    starts: int = 0
    recordings: int = 0
    tiles: int = 0
    settings: dict[str, set[bytes]] = field(default_factory=dict)
    worst_lost_s: float = 0.0


def check(disk: Disk, left: dict[str, bytes], folder: Path, at_s: float, told: Told, seen: Seen) -> None:
    """Check every file of a resulting state, which is in the folder."""
    live = disk.files()
    for path, content in left.items():
        kind = kind_of(path)
        if kind == "setting":
            assert content, f"{path} is empty"
            assert content in disk.whole[path], f"{path} is neither the old one nor the new: {content[:200]!r}"
            seen.settings.setdefault(path, set()).add(content)
        elif kind == "recording":
            found = summarize(folder / path)
            written = entries_of(bytes(live[path].now))
            assert found.frames <= len(written), "nothing is in it that was not written"
            seen.recordings += found.frames > 0
    # The current recording may be missing completely when it was just started.
    for path, file in live.items():
        if kind_of(path) == "recording" and (entries := entries_of(bytes(file.now))):
            missing_s = lost_s(bytes(file.now), left.get(path, b""), at_s) if path in left else 1e9
            if missing_s > 1e6:
                missing_s = at_s - entries[0][2] / 1e6
            assert missing_s <= LOST_S, f"{missing_s:.2f} s of {path} are lost"
            seen.worst_lost_s = max(seen.worst_lost_s, missing_s)

    def text(path: str) -> str:
        return left[path].decode()

    if (revision := told.at(told.drafts, at_s)) is not None:
        assert json.loads(text("plan-draft.json"))["current"]["revision"] >= revision
    if (name := told.at(told.sources, at_s)) is not None:
        number = int(text("maps/sources.toml").partition('name = "Field ')[2].partition('"')[0])
        assert number >= int(name.removeprefix("Field "))
    if (token := told.at(told.tokens, at_s)) is not None:
        newer = [value for at, value in told.tokens if at > at_s]
        assert json.loads(text("server-tokens.json"))["viewer"] in {token, *newer}
    if (key := told.at(told.keys, at_s)) is not None:
        assert key in {each["name"] for each in json.loads(text("signing/keys.json"))["keys"]}
    for path in [path for path in left if kind_of(path) == "cache" and path.endswith(".mbtiles")]:
        # On a copy, since opening it changes it.
        copy = folder / "of-the-check"
        copy.mkdir()
        for end in ("", "-wal", "-journal"):
            if path + end in left:
                (copy / f"cache{end}").write_bytes(left[path + end])
        seen.tiles += check_cache(copy / "cache")
        shutil.rmtree(copy)


def start_on(folder: Path, left: dict[str, bytes]) -> None:
    """The program starts on a resulting state, finds no faults, and continues."""
    for note in (folder / "maps").glob("reading/*.run"):
        note.write_text("of the machine's start before this one\n", encoding="ascii")
    with serving("--record", "--token", "--link=udpin:127.0.0.1:0", "--telemetry-floor=0", data=folder) as served:
        client = served.client(token=served.token("operator"))
        if "server-tokens.json" in left:
            assert served.token("operator") == json.loads(left["server-tokens.json"])["operator"]
        if "plan-draft.json" in left:
            assert client.done("GET", "draft") == json.loads(left["plan-draft.json"])
        if 'id = "field"' in left.get("maps/sources.toml", b"").decode():
            assert [each["id"] for each in client.done("GET", "maps/sources")["sources"]] == ["field"]
        wait_for(lambda: client.done("GET", "recorder")["is_recording"], "the next recording")
        listed = {each["name"] for each in client.done("GET", "recordings")}
        assert {path.rpartition("/")[2] for path in left if kind_of(path) == "recording"} <= listed
        assert client.done("GET", "storage") == []
        served.process.terminate()
        assert served.process.stderr is not None
        assert "Traceback" not in (said := served.process.stderr.read()), said
    assert not list(folder.rglob("*.broken*")), "nothing was set aside"


@pytest.mark.fault(
    57,
    figure="500 cuts of the real program's trace, names and data in any order: no setting empty or half, what was told is there, "
    "≤ 2 s of the recording lost, caches whole, it starts",
)
@pytest.mark.skipif(shutil.which("strace") is None, reason="traces with strace: sudo apt-get install -y strace")
def test_power_may_go_at_any_moment(tmp_path: Path) -> None:
    data, logs = tmp_path / "data", [tmp_path / "trace"]
    (data / "maps").mkdir(parents=True)
    (data / "maps" / "sources.toml").write_text("# none\n", encoding="utf-8")
    disk = Disk(data)
    told = write_everything(data, logs)
    every = list(calls(logs))

    # Once to see where something changes, and to check that the model ends with the folder's actual state.
    places = [number for number, call in enumerate(every) if disk.take(call)]
    for path, file in disk.files().items():
        if not path.endswith("-shm"):
            assert (data / path).read_bytes() == bytes(file.now), path
    assert set(disk.files()) == {str(path.relative_to(data)) for path in data.rglob("*") if path.is_file()}

    choose = random.Random(57)
    cuts = sorted(choose.sample(places, min(CUTS, len(places))))
    assert len(cuts) >= 500, "the program wrote enough to be cut off so often"
    shutil.rmtree(data)
    (data / "maps").mkdir(parents=True)
    (data / "maps" / "sources.toml").write_text("# none\n", encoding="utf-8")
    disk, seen, at = Disk(data), Seen(), 0
    for number, cut in enumerate(cuts):
        while at <= cut:
            disk.take(every[at])
            at += 1
        left = {path: content for path, content in disk.survivor(choose).items() if not path.endswith("-shm")}
        folder = tmp_path / "left"
        for path, content in left.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_bytes(content)
        folder.mkdir(exist_ok=True)
        check(disk, left, folder, every[cut].at_s, told, seen)
        seen.cuts += 1
        if number % (len(cuts) // STARTS) == 0:
            start_on(folder, left)
            seen.starts += 1
        shutil.rmtree(folder)
    versions = {path: len(contents) for path, contents in sorted(seen.settings.items())}
    sys.stdout.write(
        f"{seen.cuts} cuts among {len(places)} changes and {disk.forces} forces; {seen.starts} starts; at most "
        f"{seen.worst_lost_s:.2f} s of a recording lost, {seen.tiles} tiles whole; versions found: {versions}\n"
    )
    assert seen.starts >= STARTS
    assert seen.recordings > 100
    assert seen.tiles > 100
    assert {
        "plan-draft.json",
        "server-tokens.json",
        "maps/sources.toml",
        "signing/keys.json",
        "signing/times.json",
    } <= set(versions)
    assert any(path.startswith("missions/") for path in versions)
    assert all(count > 1 for path, count in versions.items() if "signing/times" not in path), versions
