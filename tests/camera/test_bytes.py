"""Video as bytes: addresses, H.264 units, JPEG segments, and files that another program reads back."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from vencejo.camera import CameraError, EncodedFrame, h264, jpeg, named_source, parse_source
from vencejo.camera.address import SourceKind
from vencejo.camera.matroska import MatroskaWriter

from tests.support import FIXTURES

VIDEO = FIXTURES / "camera"


def coded(path: Path) -> list[EncodedFrame]:
    """The pictures of a file as they are encoded, read with OpenCV alone."""
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG, [cv2.CAP_PROP_FORMAT, -1])
    width, height = int(capture.get(cv2.CAP_PROP_FRAME_WIDTH)), int(capture.get(cv2.CAP_PROP_FRAME_HEIGHT))
    is_h264 = path.suffix == ".mp4"
    frames = []
    while True:
        is_there, data = capture.read()
        if not is_there:
            break
        frames.append(
            EncodedFrame(
                data=data.tobytes(),
                codec="h264" if is_h264 else "jpeg",
                captured_unix_s=1_700_000_000 + capture.get(cv2.CAP_PROP_POS_MSEC) / 1000,
                is_key=not is_h264 or h264.is_key(data.tobytes()),
                width=width,
                height=height,
            )
        )
    capture.release()
    return frames


@pytest.mark.parametrize(
    ("text", "kind", "location"),
    [
        ("/dev/video0", SourceKind.V4L2, "/dev/video0"),
        ("v4l2:/dev/v4l/by-id/cam", SourceKind.V4L2, "/dev/v4l/by-id/cam"),
        ("sim", SourceKind.HTTP, "http://127.0.0.1:8554/stream.mjpg"),
        ("rpicam", SourceKind.RPICAM, "0"),
        ("rpicam:1,640x480@30", SourceKind.RPICAM, "1"),
        ("rtsp://10.0.0.5/live", SourceKind.STREAM, "rtsp://10.0.0.5/live"),
        ("udp://@:5600", SourceKind.STREAM, "udp://@:5600"),
        ("http://cam.local:8080/?action=stream", SourceKind.HTTP, "http://cam.local:8080/?action=stream"),
        ("flight.mp4", SourceKind.FILE, "flight.mp4"),
        ("file:///tmp/a,b.mp4", SourceKind.FILE, "/tmp/a,b.mp4"),
        ("a,b.mp4", SourceKind.FILE, "a,b.mp4"),
    ],
)
def test_a_source_is_understood(text: str, kind: SourceKind, location: str) -> None:
    address = parse_source(text)
    assert (address.kind, address.location) == (kind, location)


def test_a_device_takes_a_mode() -> None:
    address = parse_source("/dev/video1,1280x720@25")
    assert (address.location, address.width, address.height, address.rate_hz) == ("/dev/video1", 1280, 720, 25)
    assert parse_source("/dev/video1").width is None


def test_a_password_is_not_shown() -> None:
    address = parse_source("rtsp://admin:s3cret@10.0.0.5:8554/live")
    assert address.shown == "rtsp://…@10.0.0.5:8554/live"
    assert "s3cret" in address.location


@pytest.mark.parametrize("text", ["", "  ", "gopher://x/", "rtsp://", "rpicam:front", "http://[::1/"])
def test_what_is_no_source_says_what_one_is(text: str) -> None:
    with pytest.raises(CameraError, match=r"source|URL|number"):
        parse_source(text)


def test_cameras_have_names_of_their_own() -> None:
    assert named_source("nose=rtsp://x/?a=b") == ("nose", "rtsp://x/?a=b")
    assert named_source("http://x/?a=b") == ("camera", "http://x/?a=b")
    assert named_source("/dev/video1", frozenset({"camera"})) == ("camera2", "/dev/video1")
    with pytest.raises(CameraError, match="two cameras"):
        named_source("nose=/dev/video1", frozenset({"nose"}))


def test_a_byte_stream_is_cut_where_pictures_begin_however_it_arrives() -> None:
    frames = coded(VIDEO / "small-h264.mp4")
    assert len(frames) == 60
    stream = b"".join(frame.data for frame in frames)
    for piece in (1, 7, 1000, len(stream)):
        cut = h264.AccessUnits()
        found = [unit for at in range(0, len(stream), piece) for unit in cut.push(stream[at : at + piece])]
        assert len(found) == 59, "the last is known to be whole when the next begins"
        for unit, frame in zip(found, frames, strict=False):
            assert list(h264.units(unit)) == list(h264.units(frame.data))
    assert [index for index, frame in enumerate(frames) if frame.is_key] == [0, 15, 30, 45]


def test_noise_is_no_video_and_ends() -> None:
    cut = h264.AccessUnits()
    noise = np.random.default_rng(1).integers(0, 256, 200_000, np.uint8).tobytes()
    units = [unit for at in range(0, len(noise), 4096) for unit in cut.push(noise[at : at + 4096])]
    assert sum(map(len, units)) <= 2 * len(noise)
    assert cut.push(b"") == []


def test_key_frames_bring_their_parameter_sets() -> None:
    key = coded(VIDEO / "small-h264.mp4")[0].data
    sets = h264.parameter_sets(key)
    assert sets is not None
    bare = b"".join(b"\0\0\0\1" + unit for unit in h264.units(key) if h264.kind(unit) not in (h264.SPS, h264.PPS))
    assert h264.parameter_sets(bare) is None
    assert h264.parameter_sets(h264.with_parameter_sets(bare, sets)) == sets
    assert h264.with_parameter_sets(key, sets) == key


def test_the_size_of_a_jpeg_file_is_read_and_broken_ones_are_none() -> None:
    data = jpeg.encode(np.zeros((48, 64, 3), np.uint8))
    assert jpeg.size(data) == (64, 48)
    assert jpeg.size(data + b"\0" * 100) == (64, 48), "some cameras fill up"
    assert jpeg.size(data[: len(data) // 2]) is None
    assert jpeg.size(b"") is None
    assert jpeg.size(b"\xff\xd8\xff\xd9") is None
    assert jpeg.size(b"GIF89a" + data) is None
    more = jpeg.with_segments(data, b"Exif\0\0x")
    assert jpeg.size(more) == (64, 48)
    again, once = (cv2.imdecode(np.frombuffer(code, np.uint8), 1) for code in (more, data))
    assert again is not None
    assert once is not None
    assert np.array_equal(again, once)


@pytest.mark.parametrize("name", ["small-h264.mp4", "small-mjpeg.avi"])
def test_another_program_reads_what_was_written_to_its_last_whole_picture(name: str, tmp_path: Path) -> None:
    frames = coded(VIDEO / name)
    writer = MatroskaWriter(frames[0])
    blocks = [writer.block(frame) for frame in frames]
    path = tmp_path / "whole.mkv"
    path.write_bytes(writer.header() + b"".join(blocks))
    again = coded_times(path)
    assert len(again) == len(frames)
    for at_s, frame in zip(again, frames, strict=True):
        assert at_s == pytest.approx(frame.captured_unix_s - frames[0].captured_unix_s, abs=0.002)
    # The battery is empty in the middle of a picture.
    path.write_bytes(writer.header() + b"".join(blocks[:10]) + blocks[10][: len(blocks[10]) // 2])
    assert len(coded_times(path)) >= 10


def coded_times(path: Path) -> list[float]:
    """Times of the pictures that can be decoded."""
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    assert capture.isOpened()
    times = []
    while capture.grab():
        times.append(capture.get(cv2.CAP_PROP_POS_MSEC) / 1000)
    capture.release()
    return times


def test_a_file_does_not_begin_in_the_middle() -> None:
    frames = coded(VIDEO / "small-h264.mp4")
    with pytest.raises(CameraError, match="key frame"):
        MatroskaWriter(frames[1])
