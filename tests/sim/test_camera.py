"""The nose camera: pictures by the geometry, served like a network camera, and only while there are viewers."""

from __future__ import annotations

import http.client
import math
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any
from urllib.parse import urlsplit

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from vencejo.sim import SimOptions, SimulatedPlane
from vencejo.sim.autopilot.interface import Outlook
from vencejo.sim.camera.airfield import RUNWAY_BEHIND_M, RUNWAY_WIDTH_M
from vencejo.sim.camera.http import parse_address
from vencejo.sim.camera.nose import NoseCamera
from vencejo.sim.camera.render import SUN_AZIMUTH_DEG, SUN_ELEVATION_DEG, Renderer
from vencejo.sim.camera.view import EARTH_RADIUS_M, NOSE_M, Pose

WIDTH, HEIGHT = 640, 480
FOCAL = 320 / math.tan(math.radians(35))
"""70° across 640 pixels."""
MIDDLE = (319.5, 239.5)
LEVEL = Outlook(0.0, 0.0, 0.112, 0.0, 0.0, 0.0, (0.0, 0.0), ())


@lru_cache(1)
def renderer() -> Renderer:
    """One for all tests: a runway to the west."""
    return Renderer(270.0)


def picture(north: float, east: float, up: float, *, roll: float = 0, pitch: float = 0, yaw: float = 270) -> Any:
    return renderer().render(Pose(north, east, up, *map(math.radians, (roll, pitch, yaw))))


def horizon(image: Any, columns: range) -> tuple[float, float]:
    """Slope (pixels per pixel, positive to the lower right) and row in the middle column of the horizon."""
    rows = []
    for column in columns:
        # The sky fades to white towards the horizon; the land begins with a step.
        line = image[:, column].astype(int)
        sky = (line[:, 0] - line[:, 2] >= 18) & (line.sum(axis=1) >= line[0].sum() - 40)
        land = np.flatnonzero(~sky)
        rows.append(float(land[0]) - 0.5)
    slope, offset = np.polyfit(np.array(columns, float) - MIDDLE[0], rows, 1)
    return float(slope), float(offset)


@pytest.mark.parametrize("roll_deg", [-45, -30, 0, 10, 30])
@pytest.mark.parametrize("pitch_deg", [-8, 0, 5])
def test_the_horizon_leans_with_the_bank_and_moves_with_the_pitch(roll_deg: float, pitch_deg: float) -> None:
    height = 120.0
    image = picture(0, 3000, height, roll=roll_deg, pitch=pitch_deg)
    slope, row = horizon(image, range(240, 400))
    # Right wing down: the horizon rises to the right.
    assert math.degrees(math.atan(slope)) == pytest.approx(-roll_deg, abs=0.6)
    # Below eye level by the dip, acos(R / (R + h)), of the height of the nose, which depends on the pitch.
    dip = math.acos(EARTH_RADIUS_M / (EARTH_RADIUS_M + height + NOSE_M * math.sin(math.radians(pitch_deg))))
    below = FOCAL * math.tan(math.radians(pitch_deg) + dip) / math.cos(math.radians(roll_deg))
    assert row - MIDDLE[1] == pytest.approx(below, abs=1.6)


def step(line: npt.NDArray[np.uint8], is_it: Any) -> int:
    """Index of the first pixel of a row or column that is of a kind."""
    found = np.flatnonzero([is_it(pixel) for pixel in line.astype(int)])
    assert len(found)
    return int(found[0])


def is_asphalt(pixel: Any) -> bool:
    return bool(max(pixel) - min(pixel) < 12 and 70 < pixel.mean() < 110)


def is_white(pixel: Any) -> bool:
    return bool(pixel.min() > 190)


def test_the_runway_threshold_lies_where_the_pinhole_formula_puts_it() -> None:
    away, height = 100.0, 20.0
    image = picture(0, RUNWAY_BEHIND_M + away + NOSE_M, height)
    # Level and straight in front: row = f h / d below the middle, half the width f w / 2d to each side.
    row = MIDDLE[1] + FOCAL * (height + away**2 / (2 * EARTH_RADIUS_M)) / away
    bottom = HEIGHT - 1 - step(image[::-1, 320], is_asphalt)
    assert bottom + 0.5 == pytest.approx(row, abs=1.0)
    # A metre beyond, there is nothing but asphalt between the edges' lines, 0.35 m inside.
    beyond = away + 1.0
    line = image[round(MIDDLE[1] + FOCAL * height / beyond)]
    half = FOCAL * (RUNWAY_WIDTH_M / 2 - 0.35) / beyond
    assert step(line, is_white) == pytest.approx(MIDDLE[0] - half, abs=1.5)
    assert WIDTH - 1 - step(line[::-1], is_white) == pytest.approx(MIDDLE[0] + half, abs=1.5)


def test_from_above_the_grid_is_metric() -> None:
    height = 100.0
    # Straight down over a crossing of the lines of 100 m, top of the picture to the north.
    image = picture(300, 700, height, pitch=-90, yaw=0).astype(int)
    for turned, name in ((image, "columns"), (image.transpose(1, 0, 2), "rows")):
        bright = turned.min(axis=2).mean(axis=0)
        middle = (len(bright) - 1) / 2
        expected = [middle + FOCAL * metres / (height - NOSE_M) for metres in (-100, 0, 100)]
        inside = [at for at in expected if 5 < at < len(bright) - 5]
        assert inside, name
        for at in inside:
            near = bright[round(at) - 4 : round(at) + 5]
            around = np.concatenate((bright[round(at) - 5 : round(at) - 3], bright[round(at) + 4 : round(at) + 6]))
            assert near.max() > around.mean() + 8, (name, at)


def test_the_sun_stands_where_it_should() -> None:
    image = picture(0, 0, 100, pitch=SUN_ELEVATION_DEG - 10, yaw=SUN_AZIMUTH_DEG)
    rows, columns = np.nonzero((image > 245).all(axis=2))
    assert columns.mean() == pytest.approx(MIDDLE[0], abs=1)
    assert rows.mean() == pytest.approx(MIDDLE[1] - FOCAL * math.tan(math.radians(10)), abs=1)


def orange_px(image: Any) -> int:
    return int(((image[:, :, 2] > 200) & (image[:, :, 0] < 70)).sum())


def test_the_landing_mark_is_seen() -> None:
    pose = Pose(0, -100, 60, 0, math.radians(-25), math.radians(270))
    own = Renderer(270.0)
    assert orange_px(own.render(pose)) < 30
    own.mark((0.0, 0.0), ((0.0, -220.0),))
    assert orange_px(own.render(pose)) > 300


@pytest.mark.parametrize("angles", [(0, 90, 0), (0, -90, 33), (180, 0, 0), (90, 0, 270), (-179, 89, 180)])
@pytest.mark.parametrize("up", [-3.0, 0.0, 5.0, 12_000.0])
def test_no_attitude_and_no_height_spoil_a_picture(angles: tuple[float, float, float], up: float) -> None:
    roll, pitch, yaw = angles
    with np.errstate(all="raise"):
        image = picture(-70_000.0 if up > 10 else 5.0, 1.0, up, roll=roll, pitch=pitch, yaw=yaw)
    assert image.shape == (HEIGHT, WIDTH, 3)
    assert image.dtype == np.uint8


def is_watched(camera: NoseCamera) -> bool:
    """A function, because a type checker assumes that a property does not change."""
    return camera.watched


def test_nothing_is_rendered_while_nobody_looks() -> None:
    camera = NoseCamera(270.0, 30.0)
    camera.see(1.0, LEVEL)
    assert is_watched(camera) is False
    assert camera.next_frame(timeout_s=0.0) is None
    with camera:
        assert is_watched(camera)
        # A state from before the first viewer must not be shown.
        camera.see(2.0, LEVEL)
        frame = camera.next_frame(timeout_s=120.0)
        assert frame is not None
        camera.see(3.0, LEVEL)
        later = camera.next_frame(frame.number, timeout_s=120.0)
        assert later is not None
        assert later.number > frame.number
        last = later if later.unix_s == 3.0 else camera.next_frame(later.number, timeout_s=120.0)
        assert last is not None
        # a simulator that is slower than the camera: one picture per state
        assert camera.next_frame(last.number, timeout_s=0.2) is None
    assert not camera.watched
    camera.close()
    with camera:
        assert camera.next_frame(timeout_s=120.0) is None


@contextmanager
def connected(url: str) -> Iterator[http.client.HTTPResponse]:
    parts = urlsplit(url)
    connection = http.client.HTTPConnection(parts.hostname or "", parts.port, timeout=120)
    connection.request("GET", parts.path)
    try:
        yield connection.getresponse()
    finally:
        connection.close()


def part(response: http.client.HTTPResponse, boundary: str) -> tuple[dict[str, str], bytes]:
    """The next part of a stream."""
    assert response.readline().strip() == f"--{boundary}".encode()
    headers = {}
    while line := response.readline().strip().decode():
        name, _, value = line.partition(": ")
        headers[name] = value
    data = response.read(int(headers["Content-Length"]))
    assert response.readline() == b"\r\n"
    return headers, data


def decoded(jpeg: bytes) -> Any:
    image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    assert image.shape == (HEIGHT, WIDTH, 3)
    return image


def test_it_is_a_network_camera() -> None:
    options = SimOptions(links=("tcp:127.0.0.1:0",), camera="127.0.0.1:0", camera_rate_hz=30.0, planes=2)
    with SimulatedPlane(options) as sim:
        assert sim.camera is not None
        assert sim.snapshot is not None
        began = time.time()
        sim.hold(30.0, 0.0, 90.0, up_m=1.5)
        with connected(sim.camera) as response:
            assert response.status == 200
            kind, _, boundary = response.headers["Content-Type"].partition(";boundary=")
            assert kind == "multipart/x-mixed-replace"
            taken = []
            for _ in range(3):
                headers, jpeg = part(response, boundary)
                assert headers["Content-Type"] == "image/jpeg"
                taken.append(float(headers["X-Timestamp"]))
                slope, _ = horizon(decoded(jpeg), range(280, 360))
                assert math.degrees(math.atan(slope)) == pytest.approx(-30, abs=2)
        assert began <= taken[0] < taken[1] < taken[2] <= time.time()
        # The second plane has a camera of its own, and stands level.
        other = sim.snapshot.replace("/snapshot.jpg", "/2/snapshot.jpg")
        with urllib.request.urlopen(other, timeout=120) as answer:
            assert answer.headers["Content-Type"] == "image/jpeg"
            assert float(answer.headers["X-Timestamp"]) >= began
            slope, _ = horizon(decoded(answer.read()), range(280, 360))
        assert abs(math.degrees(math.atan(slope))) < 2
        with pytest.raises(urllib.error.HTTPError, match="404"):
            urllib.request.urlopen(sim.camera + "x", timeout=120)


def test_viewers_are_told_when_the_simulator_ends() -> None:
    sim = SimulatedPlane(SimOptions(links=("tcp:127.0.0.1:0",), camera="127.0.0.1:0"))
    assert sim.camera is not None
    with connected(sim.camera) as response:
        boundary = response.headers["Content-Type"].partition(";boundary=")[2]
        part(response, boundary)
        sim.close()
        response.read()


@pytest.mark.parametrize("text", ["0.0.0.0:8554", "8554", "camera.example:80", "127.0.0.1:http", "127.0.0.1:70000"])
def test_other_addresses_than_this_machines_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match="camera"):
        parse_address(text)
    assert parse_address("[::1]:0") == ("::1", 0)
