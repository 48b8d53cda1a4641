"""Streams and files through OpenCV's FFmpeg. H.264 and JPEG are passed on unchanged; other video is decoded."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from vencejo.camera import h264, jpeg
from vencejo.camera.address import SourceAddress
from vencejo.camera.errors import CameraError
from vencejo.camera.frames import Codec, EncodedFrame, Frame, opencv
from vencejo.camera.sources.reasons import why_not
from vencejo.camera.timing import CaptureClock

__all__ = ["FfmpegSource", "open_file", "open_stream"]

OPEN_TIMEOUT_MS: Final = 10_000
READ_TIMEOUT_MS: Final = 5_000
"""A stream without data for this long is gone, s."""
NEW_S: Final = 0.005
"""A picture that was waited for this long is a live one, s."""
MAX_WAITED: Final = 300
"""Pictures that waited while a stream was opened, at most."""
MAX_PAUSE_S: Final = 10.0
"""Longest pause between two pictures of a file; a broken one may say more."""
_CODECS: Final[dict[str, Codec]] = {"h264": "h264", "avc1": "h264", "mjpg": "jpeg", "jpeg": "jpeg"}


def open_stream(address: SourceAddress) -> FfmpegSource:
    """Open a stream from the network.

    Raises
    ------
    CameraError
        When nobody answers, or what comes is no video.
    """
    return FfmpegSource(address.location, address.shown)


def open_file(address: SourceAddress) -> FfmpegSource:
    """Open a video file, to be played again and again at its own rate; or the stream that an .sdp file describes.

    Raises
    ------
    CameraError
        When there is no such file, or it holds no video.
    """
    path = require_file(address)
    is_stream = path.suffix.lower() == ".sdp"
    return FfmpegSource(str(path), address.shown, is_looped=not is_stream)


def require_file(address: SourceAddress) -> Path:
    """The path of a video file that is there.

    Raises
    ------
    CameraError
        When there is no such file.
    """
    try:
        path = Path(address.location).expanduser()
        if path.is_file():
            return path
        what = "is not a file" if path.exists() else "is not there"
    except (OSError, RuntimeError) as error:  # a name that is too long, or of nobody's home
        what = f"cannot be read ({getattr(error, 'strerror', None) or error})"
    raise CameraError(f"{address.shown[:200]} {what}; give the path of a video file")


class FfmpegSource:
    """Video that FFmpeg reads.

    Parameters
    ----------
    location : str
        URL or path.
    shown : str
        The same for people.
    is_looped : bool, optional
        Whether it is a file, to be played at its own rate and from the beginning when it ends.
    unix_s : callable, optional
        The time of day.
    """

    def __init__(
        self, location: str, shown: str, *, is_looped: bool = False, unix_s: Callable[[], float] = time.time
    ) -> None:
        self._location = location
        self._shown = shown
        self._is_looped = is_looped
        self._unix_s = unix_s
        self._stop = threading.Event()
        self._sets: tuple[bytes, bytes] | None = None
        self._size = (0, 0)
        self._capture, self._codec = self._open()

    def frames(self) -> Iterator[EncodedFrame | Frame]:
        """Pictures as they come. See `Source`."""
        try:
            if not self._is_looped:
                yield from self._live()
                if not self._stop.is_set():
                    raise CameraError("the stream ended, or nothing came for some time")
                return
            pace = Pace(self._stop)
            while not self._stop.is_set():
                count = 0
                clock = CaptureClock(unix_s=self._unix_s)
                for due_s, at_s, frame in self._due(self._capture):
                    if not pace.wait(due_s, count == 0):
                        return
                    count += 1
                    yield _at(frame, clock.captured_unix_s(at_s))
                if count == 0:
                    raise CameraError(f"{self._shown} holds no pictures")
                self._capture.release()
                self._capture, self._codec = self._open()
        finally:
            self._capture.release()

    def _live(self) -> Iterator[EncodedFrame | Frame]:
        """Pictures of a stream. Those that waited while it was opened come all at once: how old they are shows when one is new."""
        clock = CaptureClock(unix_s=self._unix_s)
        waited: list[tuple[float, EncodedFrame | Frame]] = []
        has_caught_up = False
        asked_s = time.monotonic()
        for at_s, frame in self._pictures(self._capture):
            clock.came(at_s)
            waited.append((at_s, frame))
            has_caught_up = has_caught_up or time.monotonic() - asked_s > NEW_S or len(waited) > MAX_WAITED
            if has_caught_up:
                for its_s, one in waited:
                    yield _at(one, clock.taken_unix_s(its_s))
                waited.clear()
            asked_s = time.monotonic()

    def close(self) -> None:
        """End it. See `Source`. A network that hangs is left within five seconds."""
        self._stop.set()

    def _open(self) -> tuple[Any, Codec | None]:
        cv2 = opencv()
        timeouts = [
            *(cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, OPEN_TIMEOUT_MS),
            *(cv2.CAP_PROP_READ_TIMEOUT_MSEC, READ_TIMEOUT_MS),
        ]
        capture = cv2.VideoCapture(self._location, cv2.CAP_FFMPEG, [*timeouts, cv2.CAP_PROP_FORMAT, -1])
        if not capture.isOpened():
            raise CameraError(why_not(self._location) or f"{self._shown} holds, or sends, no video that can be read")
        fourcc = int(capture.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, "little").decode("latin-1").lower()
        codec = _CODECS.get(fourcc)
        if codec is None:
            capture.release()
            capture = cv2.VideoCapture(self._location, cv2.CAP_FFMPEG, timeouts)
            if not capture.isOpened():
                raise CameraError(f"{self._shown} holds video that cannot be decoded ({fourcc!r})")
        return capture, codec

    def _pictures(self, capture: Any) -> Iterator[tuple[float, EncodedFrame | Frame]]:
        """Pictures in the order of their code, each with its time in the stream, in seconds."""
        cv2 = opencv()
        self._size = (int(capture.get(cv2.CAP_PROP_FRAME_WIDTH)), int(capture.get(cv2.CAP_PROP_FRAME_HEIGHT)))
        while not self._stop.is_set():
            is_there, picture = capture.read()
            if not is_there:
                return
            at_s = float(capture.get(cv2.CAP_PROP_POS_MSEC)) / 1000.0
            if self._codec is None:
                yield at_s, Frame(bgr=picture, captured_unix_s=0.0)
            elif (frame := self._encoded(picture.tobytes(), self._codec)) is not None:
                yield at_s, frame

    def _encoded(self, data: bytes, codec: Codec) -> EncodedFrame | None:
        """A picture as it came; ``None`` for a broken one."""
        is_key = True
        if codec == "h264":
            is_key = h264.is_key(data)
            if is_key:
                self._sets = h264.parameter_sets(data) or self._sets
                data = h264.with_parameter_sets(data, self._sets)
                if self._sets is not None:
                    # Cameras that are set to another size change it in the middle of the stream.
                    self._size = h264.size(self._sets[0]) or self._size
        else:
            size = jpeg.size(data)
            if size is None:
                return None
            self._size = size
        width, height = self._size
        return EncodedFrame(data=data, codec=codec, captured_unix_s=0.0, is_key=is_key, width=width, height=height)

    def _due(self, capture: Any) -> Iterator[tuple[float, float, EncodedFrame | Frame]]:
        """Pictures of a file, each with the time when it is due, which never goes back, and its time in the file.

        Pictures that are coded before others that are shown first (B pictures) are due a picture's time apart.
        """
        cv2 = opencv()
        rate_hz = capture.get(cv2.CAP_PROP_FPS)
        step_s = 1.0 / rate_hz if 1.0 <= rate_hz <= 1000.0 else 1.0 / 30.0
        due_s = -step_s
        for at_s, frame in self._pictures(capture):
            due_s = at_s if at_s > due_s else due_s + step_s
            yield due_s, at_s, frame


class Pace:
    """Holds the pictures of a file back until their time has come, round after round."""

    def __init__(self, stop: threading.Event) -> None:
        self._stop = stop
        self._begin_s: float | None = None
        self._last_s = 0.0
        self._step_s = 0.0

    def wait(self, at_s: float, is_first: bool) -> bool:
        """Wait for the picture at a time of the file; ``False`` to end."""
        now = time.monotonic()
        if self._begin_s is None:
            self._begin_s = now - at_s
        elif is_first:
            # The next round begins a picture's time after the end of the last.
            self._begin_s += self._last_s + self._step_s - at_s
        else:
            self._step_s = min(max(at_s - self._last_s, 0.0), MAX_PAUSE_S)
        self._last_s = at_s
        pause_s = self._begin_s + at_s - now
        if pause_s > MAX_PAUSE_S or pause_s < -MAX_PAUSE_S:
            # A file with a hole, or a machine that slept: go on from here.
            self._begin_s, pause_s = now - at_s, 0.0
        return not self._stop.wait(max(pause_s, 0.0))


def _at(frame: EncodedFrame | Frame, captured_unix_s: float) -> EncodedFrame | Frame:
    return replace(frame, captured_unix_s=captured_unix_s)
