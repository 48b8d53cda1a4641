"""What a camera sends is decoded in a child: when that dies, nothing else does, and the camera says so."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from vencejo.camera import Camera, CameraState, jpeg
from vencejo.camera.aside import DEATHS, REST_S, SOUND_S, Aside
from vencejo.camera.child import HEAD, OPEN, PIXELS, Child, ChildSource, StillDecoder
from vencejo.camera.sources import Source, open_source

from tests.camera.test_bytes import VIDEO
from tests.camera.test_camera import is_live
from tests.support import wait_for

pytestmark = pytest.mark.skipif(os.name != "posix", reason="processes are killed by signals")


def test_a_death_of_the_reader_is_told_and_the_camera_comes_back(tmp_path: Path) -> None:
    opened: list[ChildSource] = []

    def opening(address: object) -> Source:
        source = open_source(address)  # type: ignore[arg-type]
        assert isinstance(source, ChildSource)
        opened.append(source)
        return source

    reasons: set[str] = set()

    def is_told(camera: Camera) -> bool:
        reasons.add(str(camera.status.reason))
        return any("SIGKILL" in reason for reason in reasons)

    with Camera(str(VIDEO / "small-h264.mp4"), recording_dir=tmp_path, open=opening) as camera:
        wait_for(lambda: is_live(camera), "live")
        os.kill(opened[0].child.pid, signal.SIGKILL)
        wait_for(lambda: is_told(camera), "told")
        wait_for(lambda: is_live(camera), "live again")
        assert len(opened) == 2
        assert camera.latest(10.0) is not None
        decoder = camera._decoder
        assert decoder is not None
        assert decoder._child is not None
        os.kill(decoder._child.pid, signal.SIGKILL)
        wait_for(lambda: camera.latest(1.0) is not None and camera._decoder is not decoder, "another decoder")


def test_a_picture_that_claims_much_harms_nobody() -> None:
    whole = jpeg.encode(np.zeros((48, 64, 3), np.uint8))
    frame = whole.index(b"\xff\xc0")
    bomb = whole[: frame + 5] + b"\xff\xdc\xff\xdc" + whole[frame + 9 :]
    stills = StillDecoder()
    try:
        assert stills.decode(whole) is not None
        assert stills.decode(bomb) is None
        assert stills.decode(b"\xff\xd8 nothing") is None
        again = stills.decode(whole)
        assert again is not None
        assert again.shape[2] == 3
    finally:
        stills.close()
    assert stills.decode(whole) is None


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the limit is Linux's")
def test_the_child_gets_no_more_memory_than_it_is_given() -> None:
    program = "from vencejo.camera.worker import ROOM, limit_memory; limit_memory(); bytearray(ROOM // 2); bytearray(2 * ROOM)"
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False)
    assert ended.returncode == 1
    assert "MemoryError" in ended.stderr


def test_what_a_child_says_is_not_believed() -> None:
    def hears(*parts: bytes) -> object:
        child = Child.__new__(Child)
        child._out = io.BytesIO(b"".join(parts))
        return child.receive()

    assert hears(HEAD.pack(PIXELS, 2, 1, 1.5, 6), b"abcdef") == (PIXELS, 2, 1, 1.5, b"abcdef")
    for wrong in (
        (HEAD.pack(PIXELS, 2, 2, 0.0, 6), b"abcdef"),
        (HEAD.pack(PIXELS, 1 << 20, 1, 0.0, 3 << 20), b""),
        (HEAD.pack(OPEN, 0, 0, 0.0, 1 << 40), b""),
        (HEAD.pack(99, 0, 0, 0.0, 0), b""),
        (HEAD.pack(OPEN, 0, 0, 0.0, 5), b"abc"),
        (b"abc",),
        (),
    ):
        assert hears(*wrong) is None, wrong


def test_a_source_that_ends_its_readers_is_set_aside_also_after_a_restart(tmp_path: Path) -> None:
    now = [1e9]
    first = Aside(tmp_path, "rtsp://me:secret@camera/1", unix_s=lambda: now[0])
    assert first.left() is None
    for count in range(1, DEATHS):
        assert first.died("it died") == "it died", count
        assert first.wait_s == 0.0
    assert "set aside" in first.died("it died")
    assert first.wait_s == REST_S
    (note,) = (tmp_path / ".set-aside").iterdir()
    assert "secret" not in note.name + note.read_text()
    os.utime(note, (now[0], now[0]))
    again = Aside(tmp_path, "rtsp://me:secret@camera/1", unix_s=lambda: now[0] + 60.0)
    left = again.left()
    assert left is not None
    assert "it died" in left[0]
    assert left[1] == pytest.approx(REST_S - 60.0)
    assert Aside(tmp_path, "rtsp://other", unix_s=lambda: now[0]).left() is None
    assert Aside(tmp_path, "rtsp://me:secret@camera/1", unix_s=lambda: now[0] + REST_S + 1).left() is None, (
        "tried once more"
    )
    assert "set aside" in again.died("once more")
    again.came(0.0)
    again.came(SOUND_S + 1.0)
    assert again.wait_s == 0.0
    assert not note.exists()


def test_a_camera_that_was_set_aside_says_so_from_the_beginning(tmp_path: Path) -> None:
    video = str(VIDEO / "small-h264.mp4")
    aside = Aside(tmp_path, video)
    for _ in range(DEATHS):
        aside.died("it died")
    with Camera(video, recording_dir=tmp_path) as camera:
        wait_for(lambda: camera.status.state is CameraState.DEAD, "dead")
        assert "set aside" in str(camera.status.reason)
