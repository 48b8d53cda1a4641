"""Cameras in the server: list, stream, still pictures with the plane's position, recordings; and the command."""

from __future__ import annotations

import io
import json
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from PIL import Image
from vencejo import InvalidRequest, Station
from vencejo.camera import Camera, ServedCamera
from vencejo.serve import Server

from tests.camera.mjpeg_server import MjpegServer, picture
from tests.camera.test_bytes import VIDEO, coded, coded_times
from tests.server.client import PATIENCE_S, Client, WebSocket, serving
from tests.support import HOME, simulated_plane, wait_for


@dataclass
class Seen:
    """A picture on the wire."""

    codec: int
    is_key: bool
    width: int
    height: int
    captured_unix_s: float
    number: int
    data: bytes


class Viewer(WebSocket):
    """A viewer of one camera."""

    def __init__(self, client: Client, name: str, accept: str) -> None:
        super().__init__(client, path=f"/api/v1/cameras/{name}/stream?accept={accept}")
        self.told: list[dict[str, object]] = []

    def __enter__(self) -> Viewer:
        return self

    def pictures(self) -> Iterator[Seen]:
        """Pictures until the end."""
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            try:
                opcode, payload = self._frame()
            except (ConnectionError, EOFError):
                return
            if opcode == 0x1:
                self.told.append(json.loads(payload))
            elif opcode == 0x9:
                self._send(0xA, payload)
            elif opcode == 0x8:
                return
            elif opcode == 0x2:
                version, codec, flags, _, width, height, at_us, number = struct.unpack("<4B2HQI", payload[:20])
                assert version == 1
                yield Seen(codec, bool(flags & 1), width, height, at_us / 1e6, number, payload[20:])

    def take_pictures(self, count: int) -> list[Seen]:
        """So many pictures."""
        found = []
        for seen in self.pictures():
            found.append(seen)
            if len(found) == count:
                return found
        raise AssertionError(f"{len(found)} pictures before the end: {self.told[-3:]}")


def test_h264_goes_to_those_who_show_it_and_jpeg_to_the_others(tmp_path: Path) -> None:
    originals = {frame.data for frame in coded(VIDEO / "small-h264.mp4")}
    with (
        Station(record=False) as station,
        Server(station, port=0) as server,
        Camera(str(VIDEO / "small-h264.mp4"), name="nose", recording_dir=tmp_path) as camera,
        ServedCamera(server, camera),
    ):
        client = Client(server.url)
        client.open_session(name="Ana")
        wait_for(lambda: client.done("GET", "cameras/nose")["state"] == "live", "live")
        (listed,) = client.done("GET", "cameras")
        assert (listed["name"], listed["codec"], listed["width"], listed["height"]) == ("nose", "h264", 160, 120)
        with Viewer(client, "nose", "h264,jpeg") as viewer:
            seen = viewer.take_pictures(40)
            assert seen[0].is_key, "it begins with what can be shown"
            assert {picture.codec for picture in seen} == {1}
            assert all(picture.data in originals for picture in seen), "passed on, not encoded anew"
            numbers = [picture.number for picture in seen]
            assert numbers == list(range(numbers[0], numbers[0] + 40)), "nothing is lost"
            assert 0.0 <= time.time() - seen[-1].captured_unix_s < 30.0
            assert {told["type"] for told in viewer.told} >= {"camera", "clock"}
        with Viewer(client, "nose", "jpeg") as plain:
            seen = plain.take_pictures(3)
            assert {picture.codec for picture in seen} == {2}
            with Image.open(io.BytesIO(seen[0].data)) as image:
                assert image.size == (160, 120)
        wait_for(lambda: not camera._wants_jpeg, "nothing is encoded for nobody")


def test_what_the_browser_asks_for(tmp_path: Path) -> None:
    folder = tmp_path / "video"
    with (
        MjpegServer() as source,
        Station(record=False) as station,
        Server(station, port=0) as server,
        Camera(source.url, name="nose", recording_dir=folder) as camera,
        ServedCamera(server, camera),
    ):
        client = Client(server.url)
        client.open_session(name="Ana")
        refused = client.ask("GET", "cameras/nose/snapshot")
        assert (refused.status, refused.json["type"]) == (409, "urn:vencejo:camera")
        assert client.ask("POST", "cameras/nose/recording").status == 409, "there is nothing to record"
        for name in ("tail", "..%2F..%2Fetc"):
            assert client.ask("GET", f"cameras/{name}/snapshot").status == 404
        source.send(picture(50))
        wait_for(lambda: client.done("GET", "cameras/nose")["state"] == "live", "live")
        still = client.ask("GET", "cameras/nose/snapshot")
        assert (still.status, still.headers["content-type"]) == (200, "image/jpeg")
        with Image.open(io.BytesIO(still.body)) as image:
            assert image.size == (64, 48)
            assert image.getexif()[0x0131] == "Vencejo"
        begun = client.done("POST", "cameras/nose/recording")["recording"]
        assert begun["problem"] is None
        for number in range(20):
            source.send(picture(number))
        wait_for(lambda: camera.status.frames == 21, "all pictures")
        assert client.done("DELETE", "cameras/nose/recording")["recording"] is None
        assert len(coded_times(folder / begun["file"])) == 20
        with pytest.raises(InvalidRequest, match="nose"):
            server.add_camera("nose", "again")
    assert not [path for path in folder.iterdir() if path.suffix != ".mkv"]


def test_what_was_recorded_is_listed_downloaded_and_deleted(tmp_path: Path) -> None:
    folder = tmp_path / "video"
    with (
        MjpegServer() as source,
        Station(record=False) as station,
        Server(station, port=0, video_folder=folder) as server,
        Camera(source.url, name="nose", recording_dir=folder) as camera,
        ServedCamera(server, camera),
    ):
        client = Client(server.url)
        client.open_session(name="Ana")
        assert client.done("GET", "footage") == []
        source.send(picture(50))
        wait_for(lambda: client.done("GET", "cameras/nose")["state"] == "live", "live")
        still = client.ask("POST", "cameras/nose/snapshot")
        assert still.status == 200
        begun = client.done("POST", "cameras/nose/recording")["recording"]["file"]
        for number in range(20):
            source.send(picture(number))
        wait_for(lambda: camera.status.frames == 21, "all pictures")
        listed = {one["kind"]: one for one in client.done("GET", "footage")}
        assert (listed["video"]["name"], listed["video"]["is_current"]) == (begun, True)
        assert client.ask("DELETE", f"footage/{begun}").status == 409
        client.done("DELETE", "cameras/nose/recording")
        video, kept = client.ask("GET", f"footage/{begun}").body, listed["picture"]["name"]
        assert video == (folder / begun).read_bytes()
        (ended,) = (one for one in client.done("GET", "footage") if one["kind"] == "video")
        assert (ended["camera"], ended["is_current"], ended["bytes"]) == ("nose", False, len(video))
        assert ended["duration_s"] == pytest.approx(coded_times(folder / begun)[-1], abs=0.002)
        assert abs(ended["begin_unix_s"] - time.time()) < 60
        assert (folder / kept).read_bytes() == still.body
        client.done("DELETE", f"footage/{begun}")
        assert [path.name for path in folder.iterdir()] == [kept]


def test_a_viewer_looks_and_does_not_record(tmp_path: Path) -> None:
    with serving(
        "--token", "--link", "udpin:127.0.0.1:0", "--camera", f"nose={VIDEO / 'small-h264.mp4'}", data=tmp_path
    ) as served:
        assert Client(served.url).ask("GET", "cameras").status == 401
        viewer = served.client(token=served.token("viewer"))
        wait_for(lambda: viewer.done("GET", "cameras/nose")["state"] == "live", "live")
        wait_for(lambda: viewer.ask("GET", "cameras/nose/snapshot").status == 200, "the first picture that is decoded")
        assert viewer.ask("POST", "cameras/nose/recording").status == 403
        assert viewer.ask("POST", "cameras/nose/snapshot").status == 403
        assert viewer.ask("DELETE", "footage/any").status == 403
        operator = served.client(token=served.token("operator"))
        begun = operator.done("POST", "cameras/nose/recording")["recording"]
        assert (tmp_path / "video" / begun["file"]).exists()
        operator.done("DELETE", "cameras/nose/recording")


@pytest.mark.e2e
def test_a_still_from_the_plane_says_where_the_plane_was() -> None:
    with (
        simulated_plane() as link,
        MjpegServer() as source,
        Station(link, record=False) as station,
        Server(station, port=0) as server,
        Camera(source.url, name="nose") as camera,
        ServedCamera(server, camera),
    ):
        plane = station.wait_vehicle()
        wait_for(lambda: plane.telemetry.position is not None and plane.telemetry.attitude is not None, "a position")
        client = Client(server.url)
        client.open_session()
        stills = []

        def is_taken() -> bool:
            source.send(picture(1))  # of an old one there is no still
            stills.append(client.ask("GET", "cameras/nose/snapshot"))
            return stills[-1].status == 200

        wait_for(is_taken, "a still")
        with Image.open(io.BytesIO(stills[-1].body)) as image:
            gps = image.getexif().get_ifd(0x8825)
            assert "Camera:Yaw" in image.info["xmp"].decode()
        lat = [float(part) for part in gps[2]]
        assert lat[0] + lat[1] / 60 + lat[2] / 3600 == pytest.approx(HOME[0], abs=1e-3)
        assert float(gps[6]) == pytest.approx(HOME[2], abs=30.0)


def command(*arguments: str, data: Path) -> subprocess.CompletedProcess[str]:
    import os

    return subprocess.run(
        [sys.executable, "-m", "vencejo.cli", "camera", *arguments],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        env={**os.environ, "VENCEJO_DATA": str(data)},
        check=False,
    )


def test_the_command_tells_takes_and_records(tmp_path: Path) -> None:
    video = str(VIDEO / "small-h264.mp4")
    told = command(video, "--seconds", "2", "--record", "--json", data=tmp_path)
    assert told.returncode == 0, told.stderr
    states = [json.loads(line) for line in told.stdout.splitlines()]
    assert states[-1]["state"] == "live"
    assert states[-1]["codec"] == "h264"
    (recorded,) = (tmp_path / "video").glob("*_camera.mkv")
    assert len(coded_times(recorded)) > 10
    still = tmp_path / "still.jpg"
    assert command(video, "--snapshot", str(still), "--seconds", "60", data=tmp_path).returncode == 0
    with Image.open(still) as image:
        assert image.size == (160, 120)
    failed = command(str(tmp_path / "nothing.mp4"), "--snapshot", str(still), "--seconds", "0.5", data=tmp_path)
    assert failed.returncode == 1
    assert "is not there" in failed.stderr
    assert command("gopher://x", data=tmp_path).returncode == 1
