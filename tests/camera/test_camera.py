"""Cameras: sources that come, die and return; pixels, stills and recordings of them.

V4L2 and the Raspberry Pi's camera are not here. Instead of a device's raw pictures, video that has to be decoded goes the same
way; instead of ``rpicam-vid``, a program that writes the same kind of byte stream is started by the same code.
"""

from __future__ import annotations

import io
import os
import stat
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import cast

import cv2
import numpy as np
import pytest
from PIL import Image
from vencejo.camera import (
    Camera,
    CameraError,
    CameraState,
    CameraStatus,
    EncodedFrame,
    FrameSource,
    Recording,
    still_picture,
)
from vencejo.camera.address import SourceAddress, parse_source
from vencejo.camera.recorder import RecorderLimits, VideoRecorder
from vencejo.camera.sources import Source
from vencejo.camera.sources.rpicam import RpicamSource, command
from vencejo.camera.still import Pose, with_pose
from vencejo.cli.camera import watch
from vencejo.cli.common import Failed

from tests.camera.mjpeg_server import MjpegServer, picture
from tests.camera.test_bytes import VIDEO, coded, coded_times
from tests.support import reserved_ports, wait_for


@pytest.fixture
def server() -> Iterator[MjpegServer]:
    with MjpegServer() as server:
        yield server


def is_live(camera: Camera) -> bool:
    return camera.status.state is CameraState.LIVE


class Scripted:
    """A source that gives what it is told to, then ends or fails."""

    def __init__(self, frames: list[EncodedFrame], failure: str | None = None) -> None:
        self._frames = frames
        self._failure = failure
        self._closed = threading.Event()

    def frames(self) -> Iterator[EncodedFrame]:
        yield from self._frames
        if self._failure is None:
            self._closed.wait()
        else:
            raise CameraError(self._failure)

    def close(self) -> None:
        self._closed.set()


def test_mjpeg_is_passed_on_byte_for_byte(server: MjpegServer) -> None:
    heard: list[EncodedFrame] = []
    with Camera(server.url) as camera:
        camera.listen(heard.append)
        sent = [picture(number) for number in (10, 20, 30)]
        for data in sent:
            server.send(data)
        wait_for(lambda: len(heard) == 3, "three pictures")
        assert [frame.data for frame in heard] == sent
        assert {(frame.width, frame.height, frame.codec, frame.is_key) for frame in heard} == {(64, 48, "jpeg", True)}
        frame = camera.latest()
        assert frame is not None
        assert frame.rgb.shape == (48, 64, 3)
        assert abs(int(frame.rgb.mean()) - 30) <= 1


@pytest.mark.parametrize("has_lengths", [True, False])
def test_broken_pictures_are_left_out(server: MjpegServer, has_lengths: bool) -> None:
    server.has_lengths = has_lengths
    heard: list[bytes] = []
    with Camera(server.url) as camera:
        camera.listen(lambda frame: heard.append(frame.data))
        whole = [picture(10), picture(20)]
        server.send(whole[0])
        if has_lengths:
            server.send(picture(99)[:200])
        server.send(whole[1])
        wait_for(lambda: len(heard) == 2, "the whole pictures")
        assert heard == whole


def test_the_time_of_capture_is_believed_on_this_machine_only_when_it_can_be(server: MjpegServer) -> None:
    heard: list[float] = []
    with Camera(server.url) as camera:
        camera.listen(lambda frame: heard.append(frame.captured_unix_s))
        server.headers = {"X-Timestamp": "12345.0"}
        server.send(picture(1))
        wait_for(lambda: len(heard) == 1, "a picture")
        assert heard[0] > 1_700_000_000, "a camera that counts from its start"
        said = f"{heard[0] - 1.5:.6f}"
        server.headers = {"X-Timestamp": said}
        server.send(picture(2))
        wait_for(lambda: len(heard) == 2, "a picture")
        assert heard[1] == pytest.approx(float(said), abs=1e-5)


def test_a_source_that_dies_is_tried_until_it_returns() -> None:
    with reserved_ports() as (port,), MjpegServer(port) as first, Camera(first.url) as camera:
        first.send(picture(10))
        wait_for(lambda: is_live(camera), "live")
        first.close()
        wait_for(lambda: camera.status.state is CameraState.DEAD, "dead")
        assert camera.status.reason
        assert camera.latest(timeout_s=0.0) is None, "nothing old is shown as new"
        wait_for(lambda: "refused" in (camera.status.reason or ""), "the reason of the next try")
        with MjpegServer(port) as second:
            second.send(picture(77))
            wait_for(lambda: is_live(camera), "live again")
            frame = camera.latest()
            assert frame is not None
            assert abs(int(frame.rgb.mean()) - 77) <= 1


def test_a_source_that_falls_silent_is_stalled() -> None:
    now = [100.0]
    data = picture(1)
    frame = EncodedFrame(data=data, codec="jpeg", captured_unix_s=1e9, is_key=True, width=64, height=48)

    def open(_: SourceAddress) -> Source:
        return Scripted([frame])

    with Camera("anything.mp4", open=open, monotonic_s=lambda: now[0]) as camera:
        wait_for(lambda: is_live(camera), "live")
        now[0] += 1.9
        assert is_live(camera)
        now[0] += 0.2
        assert camera.status.state is CameraState.STALLED
        assert "no pictures" in str(camera.status.reason)
        now[0] += 100.0


def test_reasons_say_what_to_do(server: MjpegServer, tmp_path: Path) -> None:
    server.password = "Basic bWU6c2VjcmV0"
    broken = tmp_path / "broken.mp4"
    broken.write_bytes(b"no video at all")
    for source, words in [
        (server.url, "401"),
        (server.url + "page", "text/html"),
        ("http://127.0.0.1:9/", "127.0.0.1"),
        ("rtsp://127.0.0.1:9/live", "refused"),
        (str(tmp_path / "nothing.mp4"), "is not there"),
        (str(tmp_path), "is not a file"),
        ("a" * 300 + ".mp4", "File name too long"),
        (str(broken), "no video"),
        ("/dev/video-none", "plugged in"),
        ("rpicam", "rpicam"),
    ]:
        with Camera(source) as camera:
            wait_for(lambda camera=camera: camera.status.state is CameraState.DEAD, source)  # type: ignore[misc]
            assert words in str(camera.status.reason), source
    with Camera(server.url.replace("//", "//me:secret@")) as camera:
        server.send(picture(1))
        wait_for(lambda: is_live(camera), "live with the password")
        assert "secret" not in camera.source


@pytest.mark.parametrize(
    ("name", "codec"), [("small-h264.mp4", "h264"), ("small-mjpeg.avi", "jpeg"), ("small-mpeg4.mp4", None)]
)
def test_a_file_is_played_again_and_again(name: str, codec: str | None) -> None:
    heard: list[EncodedFrame] = []
    with Camera(str(VIDEO / name)) as camera:
        camera.listen(heard.append)
        camera.want_jpeg(codec is None)
        wait_for(lambda: is_live(camera), "live")
        assert camera.status.codec == codec
        assert (camera.status.width, camera.status.height) == (160, 120)
        wait_for(lambda: len(heard) > 35, "more than a round")
        times = [frame.captured_unix_s for frame in heard]
        assert times == sorted(times)
        if codec is not None:
            originals = [frame.data for frame in coded(VIDEO / name)]
            assert all(frame.data in originals for frame in heard), "passed on, not encoded anew"
        frame = camera.latest(30.0)
        assert frame is not None
        assert frame.rgb.shape == (120, 160, 3)
        assert frame.rgb.std() > 30, "a picture, not a grey"


def decodes(camera: Camera) -> bool:
    return camera._decoder is not None


def test_h264_is_decoded_only_while_somebody_asks() -> None:
    frames = coded(VIDEO / "small-h264.mp4")
    camera_now = [0.0]
    given = threading.Semaphore(1)
    position = [0]

    class Stepped(Scripted):
        def frames(self) -> Iterator[EncodedFrame]:
            while position[0] < len(frames) and not self._closed.is_set():
                if given.acquire(timeout=0.05):
                    position[0] += 1
                    yield frames[position[0] - 1]

    with Camera("a.mp4", open=lambda _: Stepped([]), monotonic_s=lambda: camera_now[0]) as camera:
        wait_for(lambda: is_live(camera), "live")
        assert not decodes(camera)
        for _ in range(5):
            given.release()
        wait_for(lambda: camera.status.frames == 6, "six pictures")
        shown = camera.latest(timeout_s=120.0)
        assert shown is not None
        assert shown.captured_unix_s >= frames[4].captured_unix_s - 0.002, "one behind the newest at most"
        assert decodes(camera)
        camera_now[0] += 10.0
        given.release()
        wait_for(lambda: not decodes(camera), "no decoder when nobody asks")


def test_viewers_without_h264_get_jpeg() -> None:
    heard: list[EncodedFrame] = []
    with Camera(str(VIDEO / "small-h264.mp4")) as camera:
        camera.listen(heard.append)
        wait_for(lambda: len(heard) > 2, "pictures")
        assert {frame.codec for frame in heard} == {"h264"}
        camera.want_jpeg(True)
        wait_for(lambda: any(frame.codec == "jpeg" for frame in heard), "JPEG too")
        found = next(frame for frame in heard if frame.codec == "jpeg")
        assert jpeg_size(found.data) == (160, 120)
        camera.want_jpeg(False)


def jpeg_size(data: bytes) -> tuple[int, int]:
    with Image.open(io.BytesIO(data)) as image:
        image.load()
        return image.size


def test_pictures_for_programs_stay_within_their_limits(server: MjpegServer) -> None:
    now = [0.0]
    with Camera(server.url, name="nose") as camera:
        source = FrameSource(camera, max_width=32, max_rate_hz=10, monotonic_s=lambda: now[0])
        server.send(picture(10))
        first = source.latest(timeout_s=120.0)
        assert first is not None
        assert (source.name, first.width, first.height) == ("nose", 32, 24)
        small = source.latest_jpeg()
        assert small is not None
        assert jpeg_size(small.data) == (32, 24)
        server.send(picture(200))
        wait_for(lambda: camera.status.frames == 2, "the next picture")
        assert source.latest() is first, "not sooner than the rate allows"
        now[0] += 0.11
        later = source.latest()
        assert later is not None
        assert later.rgb.mean() > 190
        whole = FrameSource(camera).latest_jpeg()
        assert whole is not None
        assert whole.data == picture(200), "the camera's own, where it fits"
    for wrong in ({"max_width": 3}, {"max_rate_hz": 0.0}, {"jpeg_quality": 0}):
        with pytest.raises(CameraError, match="should be"):
            FrameSource(camera, **wrong)


def test_a_program_is_told_when_the_source_is_gone(tmp_path: Path) -> None:
    with Camera(str(tmp_path / "nothing.mp4")) as camera:
        wait_for(lambda: camera.status.state is CameraState.DEAD, "dead")
        with pytest.raises(CameraError, match="not there"):
            FrameSource(camera).latest()


def test_a_still_knows_where_it_was_taken() -> None:
    data = picture(1)
    pose = Pose(
        lat_deg=-40.33321234,
        lon_deg=-3.79785678,
        alt_amsl_m=712.345,
        alt_rel_home_m=112.3,
        roll_deg=-12.5,
        pitch_deg=3.25,
        yaw_deg=271.5,
    )
    still = with_pose(data, 1_763_740_800.25, pose)
    with Image.open(io.BytesIO(still)) as image:
        exif = image.getexif()
        gps = exif.get_ifd(0x8825)
        assert exif.get_ifd(0x8769)[0x9003] == "2025:11:21 16:00:00"
        assert exif.get_ifd(0x8769)[0x9291] == "250"
        degrees = [float(part) for part in gps[2]]
        assert gps[1] == "S"
        assert degrees[0] + degrees[1] / 60 + degrees[2] / 3600 == pytest.approx(40.33321234, abs=3e-8)
        degrees = [float(part) for part in gps[4]]
        assert gps[3] == "W"
        assert degrees[0] + degrees[1] / 60 + degrees[2] / 3600 == pytest.approx(3.79785678, abs=3e-8)
        assert float(gps[6]) == pytest.approx(712.345)
        assert gps[16] == "T"
        assert float(gps[17]) == pytest.approx(271.5)
        xmp = image.info["xmp"].decode()
        for said in (
            'Camera:Roll="-12.500"',
            'Camera:Pitch="3.250"',
            'Camera:Yaw="271.500"',
            'AltitudeAboveHome="112.300"',
        ):
            assert said in xmp
    whole, bare = cv2.imdecode(np.frombuffer(still, np.uint8), 1), cv2.imdecode(np.frombuffer(data, np.uint8), 1)
    assert whole is not None
    assert bare is not None
    assert np.array_equal(whole, bare), "the picture itself is untouched"


def test_a_still_without_a_known_position_says_none() -> None:
    with Image.open(io.BytesIO(with_pose(picture(1), 1_763_740_800.0, Pose()))) as image:
        gps = image.getexif().get_ifd(0x8825)
        assert 2 not in gps
        assert 6 not in gps
        assert 17 not in gps


def test_no_still_is_made_of_an_old_picture(server: MjpegServer) -> None:
    with Camera(server.url) as camera:
        server.send(picture(1))
        wait_for(lambda: is_live(camera), "live")
        taken = camera.status.captured_unix_s
        assert taken is not None
        assert still_picture(camera, unix_s=taken + 1.0)
        with pytest.raises(CameraError, match="60 s old"):
            still_picture(camera, unix_s=taken + 60.0)


def test_a_stream_that_is_joined_between_key_frames_is_recorded_from_the_next_one_on(tmp_path: Path) -> None:
    frames = coded(VIDEO / "small-h264.mp4")
    keys = [number for number, frame in enumerate(frames) if frame.is_key]
    go = threading.Event()

    class Joined(Scripted):
        def frames(self) -> Iterator[EncodedFrame]:
            yield from frames[1 : keys[1]]
            assert go.wait(30.0)
            yield from frames[keys[1] :]
            self._closed.wait()

    with Camera("rtsp://camera/", open=lambda _: Joined([]), recording_dir=tmp_path) as camera:
        wait_for(lambda: camera.status.frames == keys[1] - 1, "live, without a key frame")
        camera.start_recording()
        go.set()
        wait_for(lambda: camera.status.frames == len(frames) - 1, "the rest")
        ended = camera.stop_recording()
    assert ended is not None
    assert sum(1 for _ in raw_packets(ended.path)) == len(frames) - keys[1]


def test_a_recording_holds_what_the_source_sent(tmp_path: Path) -> None:
    with Camera(str(VIDEO / "small-h264.mp4"), name="nose", recording_dir=tmp_path) as camera:
        wait_for(lambda: camera.status.frames > 3, "pictures")
        begun = camera.start_recording()
        assert camera.start_recording().path == begun.path, "one at a time"
        wait_for(
            lambda: camera.status.recording is not None and camera.status.recording.duration_s > 0.5, "half a second"
        )
        ended = camera.stop_recording()
        assert ended is not None
        assert camera.status.recording is None
    assert ended.path.parent == tmp_path
    assert ended.path.name.endswith("_nose.mkv")
    assert ended.problem is None
    assert ended.bytes == ended.path.stat().st_size
    originals = [list(h264_units(frame.data)) for frame in coded(VIDEO / "small-h264.mp4")]
    again = [list(h264_units(frame)) for frame in raw_packets(ended.path)]
    assert len(again) > 10
    assert all(units in originals for units in again), "not encoded anew"
    times = coded_times(ended.path)
    assert times[-1] == pytest.approx(ended.duration_s, abs=0.05)


def test_the_command_fails_when_nothing_came_of_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for options, says in (
        ({"record": True, "seconds": 0.1}, "nothing was recorded: .* is not there"),
        ({"record": False, "seconds": 0.1}, "no picture came from .*none.mp4 in 0.1 s: .* is not there"),
    ):
        with Camera(str(tmp_path / "none.mp4")) as camera, pytest.raises(Failed, match=says):
            watch(camera, json=False, **options)  # type: ignore[arg-type]

    class Filling:
        """Its disk is full by the time of Ctrl-C."""

        looks = 0

        @property
        def status(self) -> CameraStatus:
            self.looks += 1
            if self.looks > 1:
                raise KeyboardInterrupt
            return CameraStatus(state=CameraState.LIVE, frames=9)

        def start_recording(self) -> Recording:
            return Recording(
                path=tmp_path / "nose.mkv", duration_s=4.0, bytes=10**6, dropped=0, problem="the disk is full"
            )

        stop_recording = start_recording

    def unread(*_: object, **__: object) -> None:
        raise BrokenPipeError

    monkeypatch.setattr("builtins.print", unread)
    with pytest.raises(Failed, match="the disk is full"):
        watch(cast("Camera", Filling()), record=True, seconds=None, json=False)
    monkeypatch.undo()
    with pytest.raises(Failed, match="the disk is full"):
        watch(cast("Camera", Filling()), record=True, seconds=None, json=False)
    assert "Recorded 4.0 s, 1.0 MB" in capsys.readouterr().err


def h264_units(data: bytes) -> Iterator[bytes]:
    from vencejo.camera import h264

    return (unit for unit in h264.units(data) if h264.kind(unit) in h264.SLICES)


def raw_packets(path: Path) -> Iterator[bytes]:
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG, [cv2.CAP_PROP_FORMAT, -1])
    while True:
        is_there, data = capture.read()
        if not is_there:
            return
        yield data.tobytes()


def test_a_recording_stops_before_the_disk_is_full_and_never_overwrites(tmp_path: Path) -> None:
    frame = EncodedFrame(data=picture(1), codec="jpeg", captured_unix_s=1e9, is_key=True, width=64, height=48)
    with pytest.raises(CameraError, match="MB are free"):
        VideoRecorder(tmp_path, "nose", free_bytes=lambda _: 1000)
    with pytest.raises(CameraError, match="delete some"):
        VideoRecorder(tmp_path, "nose", limits=RecorderLimits(quota_bytes=0))
    files = []
    for _ in range(2):
        recorder = VideoRecorder(tmp_path, "nose", group=[frame], unix_s=lambda: 1e9)
        files.append(recorder.close())
    assert len({recording.path for recording in files}) == 2
    assert all(recording.path.stat().st_size == recording.bytes > 0 for recording in files)
    empty = VideoRecorder(tmp_path, "tail", unix_s=lambda: 1e9).close()
    assert not empty.path.exists(), "an empty file helps nobody"
    with pytest.raises(CameraError, match="nothing can be recorded"):
        VideoRecorder(files[0].path / "below-a-file", "nose")


def test_a_recording_goes_on_in_the_next_file(tmp_path: Path) -> None:
    frames = coded(VIDEO / "small-h264.mp4")
    recorder = VideoRecorder(tmp_path, "nose", limits=RecorderLimits(max_file_bytes=4000), unix_s=lambda: 1e9)
    for frame in frames:
        recorder.add(frame)
    recorder.close()
    files = sorted(tmp_path.glob("*.mkv"))
    assert len(files) > 1
    assert sum(len(coded_times(path)) for path in files) == len(frames), "nothing is lost between them"


def test_the_raspberry_pis_program_is_read(tmp_path: Path) -> None:
    stream = tmp_path / "stream.h264"
    stream.write_bytes(b"".join(frame.data for frame in coded(VIDEO / "small-h264.mp4")))
    program = tmp_path / "rpicam-vid"
    program.write_text(
        f"#!{sys.executable}\nimport sys\nsys.stdout.buffer.write(open({str(stream)!r}, 'rb').read())\nprint('no cameras available', file=sys.stderr)\n"
    )
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    address = parse_source("rpicam:1,160x120@30")
    assert list(command("rpicam-vid", "1", (160, 120), 30))[-6:] == [
        "--width",
        "160",
        "--height",
        "120",
        "--output",
        "-",
    ]
    source = RpicamSource(address, find=lambda name: os.fspath(program) if name == "rpicam-vid" else None)
    frames: list[EncodedFrame] = []
    with pytest.raises(CameraError, match="no cameras available"):
        frames.extend(source.frames())
    assert len(frames) == 59, "all but the last, which the end cut short"
    frames.clear()
    source = RpicamSource(address, find=lambda name: os.fspath(program) if name == "rpicam-vid" else None)
    for frame in source.frames():
        frames.append(frame)
        if len(frames) == 30:
            break
    source.close()
    assert [frame.is_key for frame in frames[:16]] == [True, *[False] * 14, True]
    assert {(frame.width, frame.height, frame.codec) for frame in frames} == {(160, 120, "h264")}
    with pytest.raises(CameraError, match="apt install"):
        RpicamSource(address, find=lambda _: None)
    # One that hangs, as when the camera's ribbon is loose, is given up.
    program.write_text("#!/bin/sh\nexec sleep 600\n")
    source = RpicamSource(address, find=lambda name: os.fspath(program), patience_s=0.05)
    with pytest.raises(CameraError, match=r"nothing for 0\.05 s"):
        next(source.frames())
