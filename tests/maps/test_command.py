"""The commands `vencejo maps …` against a tile service on this machine: the folder opened here, and a station that runs."""

from __future__ import annotations

import contextlib
import http.server
import json
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner, Result
from vencejo.cli.commands import app
from vencejo.cli.map_areas import size

from tests.server.client import WebSocket, serving
from tests.support import wait_for

PICTURE = cv2.imencode(".png", np.full((256, 256, 3), (40, 90, 60), np.uint8))[1].tobytes()
BOX = "-4.02,40.0,-4.0,40.02"


@dataclass
class Tiles:
    """A service of tiles that counts, and answers only while it may."""

    url: str = ""
    asked: list[str] = field(default_factory=list)
    may_answer: threading.Event = field(default_factory=threading.Event)


@contextlib.contextmanager
def tile_service() -> Iterator[Tiles]:
    tiles = Tiles()
    tiles.may_answer.set()

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            tiles.asked.append(self.path)
            tiles.may_answer.wait(60)
            missing = self.path.startswith("/none/")
            self.send_response(500 if missing else 200)
            self.end_headers()
            with contextlib.suppress(OSError):
                self.wfile.write(b"out of order" if missing else PICTURE)

        def log_message(self, format: str, *args: object) -> None:
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True).start()
    tiles.url = f"http://127.0.0.1:{server.server_port}"
    try:
        yield tiles
    finally:
        tiles.may_answer.set()
        server.shutdown()
        server.server_close()


@pytest.fixture(name="tiles")
def _tiles() -> Iterator[Tiles]:
    with tile_service() as tiles:
        yield tiles


@pytest.fixture(name="folder")
def _folder(tmp_path: Path) -> Path:
    folder = tmp_path / "maps"
    folder.mkdir()
    (folder / "sources.toml").write_text("# mine\n")
    return folder


HERE = ("--local-network",)
"""The service of these tests is on this machine, which a source has to say."""


def run(*args: str, folder: Path | None = None, data: Path | None = None) -> Result:
    where = ["--maps", str(folder)] if folder else []
    env = {"VENCEJO_STATION": "", "VENCEJO_TOKEN": "", "VENCEJO_DATA": str(data or (folder or Path.cwd()).parent)}
    return CliRunner().invoke(app, ["maps", *args, *where], env={name: text or None for name, text in env.items()})


def told(*args: str, folder: Path) -> Any:
    result = run(*args, "--json", folder=folder)
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


def test_a_source_is_added_tried_and_removed(tiles: Tiles, folder: Path) -> None:
    tried = told(
        "add", f"{tiles.url}/{{z}}/{{x}}/{{y}}.png", *HERE, "--name", "Club", "--set", "max_zoom=18", folder=folder
    )
    assert (tried["id"], tried["ok"], tried["type"], tried["bytes"]) == ("club", True, "image/png", len(PICTURE))
    assert tiles.asked == [f"/{tried['tile']}.png"]
    assert 'id = "club"' in (folder / "sources.toml").read_text()
    listed = told("list", folder=folder)["sources"]
    assert [(source["id"], source["kind"], source["max_zoom"]) for source in listed] == [("club", "xyz", 18)]
    shown = run("test", "club", folder=folder)
    assert shown.exit_code == 0
    assert "image/png" in shown.stdout
    assert told("cache", folder=folder)["club"]["tiles"] == 1
    assert run("clear", "club", "--yes", folder=folder).exit_code == 0
    assert told("cache", folder=folder)["club"]["tiles"] == 0
    assert run("remove", "club", "--cache", "--yes", folder=folder).exit_code == 0
    assert told("list", folder=folder)["sources"] == []


def test_a_source_that_fails_says_why(tiles: Tiles, folder: Path) -> None:
    result = run("add", f"{tiles.url}/none/{{z}}/{{x}}/{{y}}", *HERE, "--id", "broken", folder=folder)
    assert result.exit_code == 1
    assert "out of order" in result.stdout
    tried = run("test", "--json", folder=folder)
    assert tried.exit_code == 1
    assert json.loads(tried.stdout)[0]["status"] == "failing"
    for args, said in [
        (("test", "nowhere"), "no map source 'nowhere'"),
        (("add", "nonsense.txt"), "no preset"),
        (("add", "https://a.example/wms"), "which layer?"),
        (("add", f"{tiles.url}/{{z}}/{{x}}/{{y}}", *HERE, "--set", "opacity"), "FIELD=VALUE"),
        (("area", "estimate", "broken"), "--around"),
        (("area", "estimate", "broken", "--box", "1,2,3"), "four numbers"),
        (("area", "estimate", "broken", "--box", BOX, "--zoom", "high"), "10-17"),
        (("area", "estimate", "broken", "--box", BOX, "--zoom", "1²"), "10-17"),
        (("area", "estimate", "broken", "--box", "nan,40,-4,41"), "give finite ones"),
        (("area", "estimate", "broken", "--box", BOX, "--buffer", "nan"), "--buffer"),
        (("add", ""), "what is to be added?"),
        (("area", "import", "broken", "/dev/zero"), "is not a file"),
        (("list", "--station", "ftp://x"), "takes an address"),
        (("list", "--station", "http://x:port"), "takes an address"),
        (("list", "--station", "http://[::1"), "takes an address"),
    ]:
        wrong = run(*args, folder=None if "--station" in args else folder)
        assert wrong.exit_code == 2, f"{args}: {wrong.output}"
        assert said in wrong.stderr
    wrong = run("list", folder=folder / "sources.toml")
    assert (wrong.exit_code, "is not a folder" in wrong.stderr) == (2, True)
    refused = run("add", f"{tiles.url}/{{z}}/{{x}}/{{y}}", *HERE, "--set", "opacity=7", folder=folder)
    assert (refused.exit_code, "opacity" in refused.stderr) == (1, True)
    # What to do is told as a command.
    for args, said in [
        (("layers", f"{tiles.url}/wms"), "--local-network"),
        (("remove", "nowhere", "--yes"), "`vencejo maps list` lists them"),
    ]:
        refused = run(*args, folder=folder)
        assert (refused.exit_code, said in refused.stderr) == (1, True), refused.stderr


def test_presets_and_files(folder: Path) -> None:
    found = told("presets", folder=folder)
    assert {"pnoa", "osm", "google-satellite"} <= {preset["id"] for preset in found}
    cog = Path(__file__).parents[1] / "fixtures/maps/cog-jpeg-mask.tif"
    tried = told("add", str(cog), folder=folder)
    assert (tried["id"], tried["ok"], tried["type"]) == ("cog-jpeg-mask", True, "image/png")
    assert (folder / "files" / cog.name).read_bytes() == cog.read_bytes()


def test_an_area_is_reckoned_fetched_and_handed_on(tiles: Tiles, folder: Path, tmp_path: Path) -> None:
    run("add", f"{tiles.url}/{{z}}/{{x}}/{{y}}", *HERE, "--id", "club", folder=folder)
    wanted = ("club", "--box", BOX, "--zoom", "12-15")
    estimate = told("area", "estimate", *wanted, folder=folder)
    assert estimate["tiles"] > 8
    unasked = run("area", "download", *wanted, "--name", "Field", folder=folder)
    assert (unasked.exit_code, "--yes" in unasked.stderr) == (2, True)
    area = told("area", "download", *wanted, "--name", "Field", "--yes", folder=folder)
    assert (area["state"], area["done"], area["failed"]) == ("done", estimate["tiles"], 0)
    file = tmp_path / "field.mbtiles"
    assert told("area", "export", "Field", str(file), folder=folder)["bytes"] == file.stat().st_size
    assert run("area", "remove", "Field", "--yes", folder=folder).exit_code == 0
    assert told("area", "import", "club", str(file), "--name", "Again", folder=folder)["done"] == estimate["tiles"]
    shown = run("area", "list", folder=folder)
    assert "Again" in shown.stdout
    assert run("area", "remove", "Field", "--yes", folder=folder).exit_code == 1


def test_a_folder_of_tiles_is_added_by_its_name(folder: Path, tmp_path: Path) -> None:
    place = tmp_path / "field" / "3" / "3"
    place.mkdir(parents=True)
    (place / "2.png").write_bytes(PICTURE)
    elsewhere = run("add", str(tmp_path / "field"), folder=folder)
    assert (elsewhere.exit_code, "copy it into" in elsewhere.stderr) == (2, True), elsewhere.stderr
    (folder / "files").mkdir(exist_ok=True)
    (tmp_path / "field").rename(folder / "files" / "field")
    added = told("add", "field", folder=folder)
    assert (added["ok"], added["tile"], added["bytes"]) == (True, "3/3/2", len(PICTURE)), added
    (source,) = told("list", folder=folder)["sources"]
    assert (source["id"], source["kind"], source["role"]) == ("field", "folder", "base")


def test_ctrl_c_pauses_and_a_plan_leads(tiles: Tiles, folder: Path) -> None:
    from vencejo.cli.demo import demo_mission

    run("add", f"{tiles.url}/{{z}}/{{x}}/{{y}}", *HERE, "--id", "club", folder=folder)
    tiles.may_answer.clear()
    before = len(tiles.asked)
    wanted = ["download", "club", "--name", "Field", "--around", str(demo_mission()), "--zoom", "12-16", "--yes"]
    command = [sys.executable, "-m", "vencejo.cli", "maps", "area", *wanted, "--maps", str(folder)]
    env = {**os.environ, "VENCEJO_DATA": str(folder.parent)}
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=env)
    wait_for(lambda: len(tiles.asked) > before, "the first tile")
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130, said
    assert "Paused" in said
    (area,) = told("area", "list", folder=folder)
    assert area["state"] == "paused"
    tiles.may_answer.set()
    done = told("area", "resume", "Field", folder=folder)
    assert (done["state"], done["done"]) == ("done", area["tiles"])


def test_a_station_that_runs_is_asked_with_its_token(tiles: Tiles, folder: Path) -> None:
    with serving("--token", "--link", "udpin:127.0.0.1:0", data=folder.parent) as served:
        station = ("--station", served.url)
        refused = run("list", *station)
        assert refused.exit_code == 1
        assert "--token" in refused.stderr
        token = ("--token", served.token("operator"))
        added = run("add", f"{tiles.url}/{{z}}/{{x}}/{{y}}", *HERE, "--id", "club", *station, *token)
        assert added.exit_code == 0, added.stderr
        browser = served.client(name="browser", token=served.token("operator"))
        assert browser.done("GET", "session")["has_control"], "the command holds no control"
        with WebSocket(browser) as socket:
            assert run("remove", "club", "--yes", *station, *token).exit_code == 0
            assert socket.until("maps") == {"type": "maps"}


@contextlib.contextmanager
def stranger(answers: dict[str, tuple[int, bytes, int | None]]) -> Iterator[str]:
    """Something that answers HTTP: by path a status, a body, and how long it says that is. Bodies are not read."""

    class Handler(http.server.BaseHTTPRequestHandler):
        def answer(self) -> None:
            path = self.path.removeprefix("/api/v1/").partition("?")[0]
            status, body, length = answers.get(path, answers[""])
            self.send_response(status)
            self.send_header("Content-Length", str(len(body) if length is None else length))
            self.end_headers()
            self.wfile.write(body)

        do_GET = do_POST = do_DELETE = answer

        def log_message(self, format: str, *args: object) -> None:
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}"
    finally:
        server.shutdown()
        server.server_close()


SESSION = b'{"role": "operator"}'
AREA = b'[{"id": "a1", "name": "Field", "source": "pnoa", "done": 1, "tiles": 1}]'


@pytest.mark.parametrize(
    ("args", "answers", "said"),
    [
        (("list",), {"": (200, b"<html>It works!</html>", None)}, "is no Vencejo"),
        (("list",), {"": (200, b"{}", None)}, "is no Vencejo"),
        (("list",), {"session": (200, SESSION, None), "": (200, b"<html>", None)}, "is no Vencejo"),
        (("list",), {"session": (200, SESSION, None), "": (200, b"{}", 100)}, "does not answer: IncompleteRead"),
        (
            ("area", "export", "Field", "out.mbtiles"),
            {"session": (200, SESSION, None), "maps/areas": (200, AREA, None), "": (200, b"SQLite", 100)},
            "does not answer: IncompleteRead",
        ),
        (
            ("area", "import", "pnoa", "in.mbtiles"),
            {"session": (200, SESSION, None), "": (507, b'{"detail": "the disk is too full"}', None)},
            "the disk is too full",
        ),
    ],
)
def test_what_answers_badly_is_told_and_leaves_nothing(
    args: tuple[str, ...],
    answers: dict[str, tuple[int, bytes, int | None]],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    # More than a connection holds, so that it is refused while it comes.
    Path("in.mbtiles").write_bytes(bytes(20_000_000 if "import" in args else 0))
    with stranger(answers | {"control/release": (200, b"{}", None)}) as url:
        result = run(*args, "--station", url)
    assert result.exit_code == 1
    assert said in result.stderr
    assert "internal error" not in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["in.mbtiles"]


def test_where_nobody_listens_it_is_said() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"127.0.0.1:{server.getsockname()[1]}"
    for station, said in ((address, "does not answer: Connection refused"), ("a..b", "does not answer: ")):
        result = run("list", "--station", station)
        assert (result.exit_code, said in result.stderr, "internal" in result.stderr) == (1, True, False), result.stderr


def test_sizes_are_for_people() -> None:
    assert [size(n) for n in (0, 999, 1000, 12_345_678, 1_234_567_890)] == [
        "0 B",
        "999 B",
        "1 kB",
        "12.3 MB",
        "1.23 GB",
    ]
