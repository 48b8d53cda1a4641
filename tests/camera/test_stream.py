"""What a stream says of itself: when its pictures were taken, their size, where decoding may begin; and sources read on demand."""

from __future__ import annotations

import itertools
import queue
import random
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import pytest
from vencejo.camera import Camera, CameraError, CameraState, EncodedFrame, h264, parse_source, recorder
from vencejo.camera.address import SourceAddress
from vencejo.camera.decoder import Decoder
from vencejo.camera.matroska import MatroskaWriter
from vencejo.camera.recorder import RecorderLimits
from vencejo.camera.sources import Source
from vencejo.camera.timing import CaptureClock

from tests.camera.mjpeg_server import picture
from tests.camera.test_bytes import VIDEO, coded, coded_times
from tests.support import wait_for


class Clocks:
    """Our two clocks, moved by hand."""

    def __init__(self) -> None:
        self.now_s = 50.0
        self.clock = CaptureClock(monotonic_s=lambda: self.now_s, unix_s=lambda: 1e9 + self.now_s)

    def age_s(self, at_s: float, came_s: float) -> float:
        """How old a picture with that time in the stream is when it comes at a time of ours."""
        self.now_s = came_s
        return 1e9 + came_s - self.clock.captured_unix_s(at_s)


def test_what_the_network_held_back_is_older() -> None:
    random.seed(1)
    clocks = Clocks()
    ages = []
    for number in range(600):
        at_s = number / 30
        held_s = 0.0 if number % 40 == 0 else random.uniform(0.0, 0.3)
        ages.append((clocks.age_s(at_s, 100.0 + at_s * (1 + 1e-4) + held_s), held_s))
    assert max(abs(age - held) for age, held in ages[1:]) < 0.005
    # A stall is told, and not taken for a new beginning.
    assert clocks.age_s(600 / 30, 100.0 + 20.0 + 3.0) == pytest.approx(3.0, abs=0.01)


def test_pictures_shown_before_others_are_older_than_those() -> None:
    clocks = Clocks()
    order = [0, 4, 2, 1, 3, 8, 6, 5, 7, 12, 10, 9, 11]
    taken = []
    for place, number in enumerate(order):
        came_s = 100.0 + place / 30
        taken.append((number, came_s - clocks.age_s(number / 30 + 0.001, came_s)))
    times = [at_s for _, at_s in sorted(taken)[3:]]
    assert [b - a for a, b in itertools.pairwise(times)] == pytest.approx([1 / 30] * (len(times) - 1), abs=1e-6)


def test_a_stream_that_begins_anew_or_tells_no_times_is_immediate() -> None:
    clocks = Clocks()
    assert clocks.age_s(1000.0, 100.0) == 0.0
    assert clocks.age_s(1000.1, 100.1) == pytest.approx(0.0)
    assert clocks.age_s(0.0, 101.0) == 0.0, "the camera was switched off and on"
    assert clocks.age_s(0.5, 101.6) == pytest.approx(0.1)
    silent = Clocks()
    assert [silent.age_s(0.0, 102.0 + tenth / 10) for tenth in range(5)] == [0.0] * 5


@pytest.mark.parametrize(
    ("sps", "size"),
    [
        # By x264, `ffmpeg -f lavfi -i testsrc=size=… -c:v libx264`: cropped from 1088 rows in 4:2:0, the same in 4:4:4, and
        # interlaced.
        ("67640028acd940780227e5c044000003000400000300f03c60c658", (1920, 1080)),
        ("67f40028919b280f0044fc4e0220000003002000000781e30632c0", (1920, 1080)),
        ("6764001eacd940b424d8088000000300800000190f8a14cb", (720, 576)),
        ("", None),
        ("67", None),
        ("6764002800", None),
    ],
)
def test_a_parameter_set_tells_the_size(sps: str, size: tuple[int, int] | None) -> None:
    assert h264.size(bytes.fromhex(sps)) == size


def test_parameter_sets_cut_short_tell_nothing() -> None:
    sets = h264.parameter_sets(coded(VIDEO / "counter-640x480-30.mp4")[0].data)
    assert sets is not None
    assert h264.size(sets[0]) == (640, 480)
    for end in range(len(sets[0])):
        assert h264.size(sets[0][:end]) in (None, (640, 480))


def test_decoding_may_begin_at_a_recovery_point() -> None:
    slice_unit = bytes([0x41, 0x9A, 0x00])
    recovery = bytes([0x06, 0x06, 0x01, 0xC4, 0x80])
    other_then_recovery = bytes([0x06, 0x05, 0x02, 0xAA, 0xBB, 0x06, 0x01, 0xC4, 0x80])
    other = bytes([0x06, 0xFF, 0x05, 0x02, 0xAA, 0x06, 0x80])

    def unit(*parts: bytes) -> bytes:
        return b"".join(b"\0\0\0\1" + part for part in parts)

    assert h264.is_key(unit(recovery, slice_unit))
    assert h264.is_key(unit(other_then_recovery, slice_unit))
    assert not h264.is_key(unit(other, slice_unit))
    assert not h264.is_key(unit(bytes([0x06, 0xFF]), slice_unit))
    assert not h264.is_key(unit(slice_unit))


def test_a_decoder_gives_its_first_picture_of_a_single_one() -> None:
    frames = coded(VIDEO / "small-h264.mp4")
    seen: list[float] = []
    decoder = Decoder(frames[:2], on_picture=lambda frame: seen.append(frame.captured_unix_s))
    wait_for(lambda: len(seen) >= 1, "a picture, though no more come")
    for frame in frames[2:20]:
        assert decoder.feed(frame)
    shown = decoder.wait(frames[18].captured_unix_s, 120.0)
    assert shown is not None
    assert shown.captured_unix_s >= frames[18].captured_unix_s - 0.002
    assert seen == sorted(set(seen)), "none twice"
    # The clock is set back: pictures have the time that their frames have.
    set_back = [replace(frame, captured_unix_s=frame.captured_unix_s - 3600.0) for frame in frames[20:40]]
    for frame in set_back:
        assert decoder.feed(frame)
    first_s = set_back[0].captured_unix_s
    wait_for(lambda: first_s - 1.0 < seen[-1] <= set_back[-1].captured_unix_s, "a picture of the new time")
    decoder.close()


def test_a_file_that_is_ended_in_order_has_a_length_and_players_jump_in_it(tmp_path: Path) -> None:
    frames = coded(VIDEO / "small-h264.mp4")
    first = frames[0].captured_unix_s
    # Six rounds, so that there are several clusters.
    frames = [
        EncodedFrame(
            data=frame.data,
            codec="h264",
            captured_unix_s=first + number / 30,
            is_key=frame.is_key,
            width=160,
            height=120,
        )
        for number, frame in enumerate(frames * 6)
    ]
    writer = MatroskaWriter(frames[0], title="nose")
    body = bytearray(writer.header())
    for frame in frames:
        body += writer.block(frame)
    tail, patches = writer.end()
    path = tmp_path / "a.mkv"
    path.write_bytes(body)
    assert len(coded_times(path)) == len(frames), "before its end, too"
    size = len(body)
    body += tail
    for position, data in patches:
        body[position : position + len(data)] = data
    assert len(body) == size + len(tail)
    path.write_bytes(body)
    assert len(coded_times(path)) == len(frames)
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    duration_s = capture.get(cv2.CAP_PROP_FRAME_COUNT) / capture.get(cv2.CAP_PROP_FPS)
    assert duration_s == pytest.approx(len(frames) / 30, abs=0.2)
    assert capture.set(cv2.CAP_PROP_POS_MSEC, 9000.0)
    assert capture.grab()
    assert capture.get(cv2.CAP_PROP_POS_MSEC) == pytest.approx(9000.0, abs=200.0)
    capture.release()


@pytest.mark.parametrize("size", [10, 1 << 10, 1 << 20, 5 << 20])
def test_what_is_written_at_the_end_fits_where_it_goes(size: int) -> None:
    frame = EncodedFrame(data=bytes(size), codec="jpeg", captured_unix_s=1e9, is_key=True, width=64, height=48)
    writer = MatroskaWriter(frame)
    file = bytearray(writer.header())
    for second in range(12):
        file += writer.block(replace(frame, captured_unix_s=1e9 + second))
    tail, patches = writer.end()
    assert tail.startswith(bytes.fromhex("1c53bb6b"))
    places = {position: len(data) for position, data in patches}
    assert [bytes(file[position : position + 1]) for position, length in places.items() if length == 160] == [b"\xec"]
    # Sizes of the segment and of three clusters, the length, and where the parts are.
    assert sorted(places.values()) == [8, 8, 8, 8, 18, 160]
    for position, data in patches:
        file[position : position + len(data)] = data
    segment = next(position for position, length in places.items() if length == 160)
    whole = int.from_bytes(file[segment - 7 : segment], "big")
    assert segment + whole == len(file) + len(tail)


def test_a_recording_keeps_the_order_of_b_pictures_and_survives_a_clock_that_is_set() -> None:
    frame = EncodedFrame(data=picture(1), codec="jpeg", captured_unix_s=1e9, is_key=True, width=64, height=48)

    def taken(at_s: float) -> EncodedFrame:
        return EncodedFrame(data=b"x", codec="jpeg", captured_unix_s=1e9 + at_s, is_key=False, width=64, height=48)

    writer = MatroskaWriter(frame)

    def ticks(at_s: float) -> int:
        block = writer.block(taken(at_s))
        return int.from_bytes(block[-4:-2], "big", signed=True)

    assert [ticks(at_s) for at_s in (0.0, 0.4, 0.2, 0.1, 0.3, 0.5)] == [0, 400, 200, 100, 300, 500]
    assert [ticks(at_s) for at_s in (-3600.0, -3599.9)] == [500, 600]
    # A computer without a clock of its own learns the time; a pause of an hour is one, in a cluster of its own.
    assert [ticks(at_s) for at_s in (95e6, 95e6 + 0.2, 95e6 + 3600.2)] == [600, 800, 0]
    assert writer.duration_s == pytest.approx(3600.8)
    times = [writer.unix_s(at_s) - 1e9 for at_s in (0.0, 0.499, 0.5, 0.599, 0.6, 0.8, 3600.8)]
    assert times == pytest.approx([0.0, 0.499, -3600.0, -3599.901, 95e6, 95e6 + 0.2, 95e6 + 3600.2], abs=1e-3)


@pytest.mark.parametrize(
    ("source", "shown"),
    [
        ("http://cam/video.cgi?user=admin&pwd=s3cret&rate=5", "http://cam/video.cgi?user=…&pwd=…&rate=5"),
        ("rtsp://cam/live?Password=s3cret", "rtsp://cam/live?Password=…"),
        ("http://cam/?action=stream", "http://cam/?action=stream"),
        ("on-demand:rtsp://me:s3cret@cam/live", "rtsp://…@cam/live"),
    ],
)
def test_secrets_of_a_url_are_shown_to_nobody(source: str, shown: str) -> None:
    assert parse_source(source).shown == shown


def test_what_is_no_url_is_not_repeated() -> None:
    with pytest.raises(CameraError) as refused:
        parse_source("rtsp://me:s3cret@[::1/live")
    assert "s3cret" not in str(refused.value)


@pytest.mark.parametrize("source", ["on-demand:" * 5000 + "rtsp://cam/live", "on-demand:on-demand:sim"])
def test_on_demand_stands_once(source: str) -> None:
    with pytest.raises(CameraError, match="on-demand: stands once"):
        parse_source(source)


class OnDemand:
    """Sources that count how often they are opened, each with a picture a turn."""

    def __init__(self) -> None:
        self.opened = 0
        self.closed = 0
        self._given = threading.Semaphore(0)

    def open(self, address: SourceAddress) -> Source:
        assert address.is_on_demand
        self.opened += 1
        return self

    def give(self) -> None:
        self._given.release()

    def frames(self) -> Iterator[EncodedFrame]:
        while self._given.acquire(timeout=120.0):
            yield EncodedFrame(data=picture(1), codec="jpeg", captured_unix_s=1e9, is_key=True, width=64, height=48)

    def close(self) -> None:
        self.closed += 1
        self.give()


def test_a_source_on_demand_is_read_while_somebody_looks() -> None:
    now = [0.0]
    source = OnDemand()
    with Camera("on-demand:rtsp://camera/", open=source.open, monotonic_s=lambda: now[0]) as camera:
        assert camera.status.state is CameraState.STANDBY
        assert camera.latest(timeout_s=0.0) is None, "who asks wakes it"
        wait_for(lambda: source.opened == 1, "it is opened")
        source.give()
        wait_for(lambda: camera.status.state is CameraState.LIVE, "live")
        camera.watch(True)
        now[0] += 100.0
        source.give()
        wait_for(lambda: camera.status.frames == 2, "it goes on while somebody looks")
        camera.watch(False)
        now[0] += 1.0
        source.give()
        wait_for(lambda: camera.status.frames == 3, "not at once")
        now[0] += 100.0
        source.give()
        wait_for(lambda: camera.status.state is CameraState.STANDBY, "nobody asks any more")
        assert (source.opened, source.closed, camera.status.codec) == (1, 1, "jpeg")
        assert camera.latest_jpeg(timeout_s=0.0) is None, "nothing old is shown as new"
        wait_for(lambda: source.opened == 2, "and again")
        source.give()


def test_a_source_on_demand_that_is_slow_to_come_is_waited_for() -> None:
    now = [0.0]
    source = OnDemand()
    with Camera("on-demand:rtsp://camera/", open=source.open, monotonic_s=lambda: now[0]) as camera:
        found: list[EncodedFrame | None] = []
        asker = threading.Thread(target=lambda: found.append(camera.latest_jpeg(timeout_s=120.0)))
        asker.start()
        wait_for(lambda: source.opened == 1, "it is opened")
        now[0] += 100.0
        source.give()
        asker.join(120.0)
        assert [frame is not None for frame in found] == [True]
        assert source.opened == 1


def test_a_source_on_demand_is_read_while_it_is_recorded(tmp_path: Path) -> None:
    now = [0.0]
    source = OnDemand()
    with Camera(
        "on-demand:rtsp://camera/", open=source.open, monotonic_s=lambda: now[0], recording_dir=tmp_path
    ) as camera:
        source.give()
        begun = camera.start_recording()
        now[0] += 100.0
        source.give()
        source.give()
        wait_for(lambda: camera.status.frames == 3, "pictures")
        ended = camera.stop_recording()
        assert ended is not None
        assert (ended.path, len(coded_times(begun.path))) == (begun.path, 2), "all but the first, which was over"
        now[0] += 100.0
        source.give()
        wait_for(lambda: camera.status.state is CameraState.STANDBY, "standby")


def test_a_recording_that_the_disk_ended_keeps_no_source_on_demand_on_the_air(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder, "SYNC_INTERVAL_S", 0.0)
    now = [0.0]
    source = OnDemand()
    with Camera(
        "on-demand:rtsp://camera/",
        open=source.open,
        monotonic_s=lambda: now[0],
        recording_dir=tmp_path,
        recording_limits=RecorderLimits(quota_bytes=1, free_floor_bytes=0),
    ) as camera:
        source.give()
        camera.start_recording()
        source.give()

        def problem() -> str | None:
            recording = camera.status.recording
            return None if recording is None else recording.problem

        wait_for(lambda: problem() is not None, "its end")
        now[0] += 100.0
        source.give()
        wait_for(lambda: camera.status.state is CameraState.STANDBY, "standby")
        assert "all they may" in (problem() or ""), "it is told on"
        ended = camera.stop_recording()
        assert ended is not None
        assert ended.problem is not None
        assert camera.status.recording is None


class Given:
    """A source that gives what it is given; ``None`` ends it, until it is opened again."""

    def __init__(self) -> None:
        self._given: queue.Queue[EncodedFrame | None] = queue.Queue()
        self.give = self._given.put
        self._is_read = False

    def frames(self) -> Iterator[EncodedFrame]:
        self._is_read = True
        yield from iter(self._given.get, None)
        self._is_read = False

    def close(self) -> None:
        if self._is_read:
            self.give(None)


def test_a_recording_goes_on_at_a_key_frame_when_its_camera_is_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vencejo.camera.camera.FIRST_RETRY_S", 0.0)
    frames = coded(VIDEO / "small-h264.mp4")
    assert [number for number, frame in enumerate(frames[:20]) if frame.is_key] == [0, 15]
    source = Given()
    with Camera("rtsp://camera/", open=lambda _: source, recording_dir=tmp_path) as camera:
        source.give(frames[0])
        wait_for(lambda: camera.status.frames == 1, "a picture")
        camera.start_recording()
        for given in (*frames[1:3], None, *frames[5:8], *frames[15:18]):
            source.give(given)
        wait_for(lambda: camera.status.frames == 9, "all pictures")
        ended = camera.stop_recording()
    assert ended is not None
    assert (len(coded_times(ended.path)), ended.dropped) == (6, 3)


def test_a_disk_that_is_slow_to_begin_a_recording_holds_up_no_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked, answered = threading.Event(), threading.Event()

    def slow(_: Path) -> None:
        asked.set()
        assert answered.wait(120.0)

    monkeypatch.setattr(recorder, "sync_folder", slow)
    frames = coded(VIDEO / "small-h264.mp4")[:9]
    source = Given()
    with Camera("rtsp://camera/", open=lambda _: source, recording_dir=tmp_path) as camera:

        def give(upto: int) -> None:
            for frame in frames[camera.status.frames : upto]:
                source.give(frame)
            wait_for(lambda: camera.status.frames == upto, f"{upto} pictures")

        give(3)
        starter = threading.Thread(target=camera.start_recording)
        starter.start()
        assert asked.wait(120.0)
        give(6)
        assert camera.status.recording is None, "not begun yet"
        answered.set()
        starter.join(120.0)
        give(9)
        ended = camera.stop_recording()
    assert ended is not None
    assert len(coded_times(ended.path)) == 9, "from the key frame on, without a gap"
