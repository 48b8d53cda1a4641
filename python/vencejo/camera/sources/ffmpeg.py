"""Streams and files by the FFmpeg inside OpenCV. What is H.264 or JPEG already is taken as it is; other video is decoded."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

from vencejo.camera import h264, jpeg
from vencejo.camera.address import SourceAddress
from vencejo.camera.errors import CameraError
from vencejo.camera.frames import Codec, EncodedFrame, RawFrame, opencv
from vencejo.camera.opening import SOURCES, ffmpeg_options

__all__ = ["FfmpegSource", "open_file", "open_stream"]

OPEN_TIMEOUT_MS: Final = 10_000
READ_TIMEOUT_MS: Final = 5_000
"""A stream in which nothing comes for so long is gone."""
PORTS: Final = {"rtsp": 554, "rtsps": 322, "rtmp": 1935, "http": 80, "https": 443}
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
    parts = urlsplit(address.location)
    port = parts.port or PORTS.get(parts.scheme)
    if parts.scheme in {*PORTS, "tcp"} and parts.hostname and port and not parts.query.startswith("listen"):
        # FFmpeg tells nobody why it failed. This does.
        try:
            socket.create_connection((parts.hostname, port), timeout=5.0).close()
        except OSError as error:
            raise CameraError(f"no answer from {parts.hostname}:{port}: {error.strerror or error}") from error
    return FfmpegSource(address.location, address.shown)


def open_file(address: SourceAddress) -> FfmpegSource:
    """Open a video file, to be played again and again at its own rate; or the stream that an .sdp file describes.

    Raises
    ------
    CameraError
        When there is no such file, or it holds no video.
    """
    path = Path(address.location).expanduser()
    if not path.is_file():
        what = "is a folder" if path.is_dir() else "is not there"
        raise CameraError(f"{address.shown} {what}; give the path of a video file")
    is_stream = path.suffix.lower() == ".sdp"
    return FfmpegSource(str(path), address.shown, is_looped=not is_stream)


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
        self._capture, self._codec = self._open()

    def frames(self) -> Iterator[EncodedFrame | RawFrame]:
        """Pictures as they come. See `Source`."""
        try:
            if not self._is_looped:
                yield from self._pictures(self._capture)
                if not self._stop.is_set():
                    raise CameraError("the stream ended, or nothing came for some time")
                return
            pace = Pace(self._stop, self._unix_s)
            while not self._stop.is_set():
                count = 0
                for at_s, frame in self._timed(self._capture):
                    captured_unix_s = pace.wait(at_s, count == 0)
                    if captured_unix_s is None:
                        return
                    count += 1
                    yield _at(frame, captured_unix_s)
                if count == 0:
                    raise CameraError(f"{self._shown} holds no pictures")
                self._capture.release()
                self._capture, self._codec = self._open()
        finally:
            self._capture.release()

    def close(self) -> None:
        """End it. See `Source`. A network that hangs is left within five seconds."""
        self._stop.set()

    def _open(self) -> tuple[Any, Codec | None]:
        cv2 = opencv()
        timeouts = [
            *(cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, OPEN_TIMEOUT_MS),
            *(cv2.CAP_PROP_READ_TIMEOUT_MSEC, READ_TIMEOUT_MS),
        ]
        with ffmpeg_options(SOURCES, own_stand=True):
            capture = cv2.VideoCapture(self._location, cv2.CAP_FFMPEG, [*timeouts, cv2.CAP_PROP_FORMAT, -1])
        if not capture.isOpened():
            raise CameraError(f"{self._shown} holds no video that can be read")
        fourcc = int(capture.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, "little").decode("latin-1").lower()
        codec = _CODECS.get(fourcc)
        if codec is None:
            capture.release()
            with ffmpeg_options(SOURCES, own_stand=True):
                capture = cv2.VideoCapture(self._location, cv2.CAP_FFMPEG, timeouts)
            if not capture.isOpened():
                raise CameraError(f"{self._shown} holds video that cannot be decoded ({fourcc!r})")
        return capture, codec

    def _pictures(self, capture: Any) -> Iterator[EncodedFrame | RawFrame]:
        cv2 = opencv()
        width, height = int(capture.get(cv2.CAP_PROP_FRAME_WIDTH)), int(capture.get(cv2.CAP_PROP_FRAME_HEIGHT))
        while not self._stop.is_set():
            is_there, picture = capture.read()
            if not is_there:
                return
            now = self._unix_s()
            if self._codec is None:
                yield RawFrame(bgr=picture, captured_unix_s=now)
                continue
            data = picture.tobytes()
            is_key = True
            if self._codec == "h264":
                is_key = h264.is_key(data)
                if is_key:
                    self._sets = h264.parameter_sets(data) or self._sets
                    data = h264.with_parameter_sets(data, self._sets)
            elif (size := jpeg.size(data)) is not None:
                width, height = size
            else:
                continue  # a broken picture
            yield EncodedFrame(
                data=data, codec=self._codec, captured_unix_s=now, is_key=is_key, width=width, height=height
            )

    def _timed(self, capture: Any) -> Iterator[tuple[float, EncodedFrame | RawFrame]]:
        """Pictures of a file, each with its time from the beginning, in seconds and never going back.

        Pictures that are coded before others that are shown first (B pictures) come a picture's time apart.
        """
        cv2 = opencv()
        rate_hz = capture.get(cv2.CAP_PROP_FPS)
        step_s = 1.0 / rate_hz if 1.0 <= rate_hz <= 1000.0 else 1.0 / 30.0
        at_s = -step_s
        for frame in self._pictures(capture):
            said_s = float(capture.get(cv2.CAP_PROP_POS_MSEC)) / 1000.0
            at_s = said_s if said_s > at_s else at_s + step_s
            yield at_s, frame


class Pace:
    """Holds the pictures of a file back until their time has come, round after round."""

    def __init__(self, stop: threading.Event, unix_s: Callable[[], float]) -> None:
        self._stop = stop
        self._unix_s = unix_s
        self._begin_s: float | None = None
        self._last_s = 0.0
        self._step_s = 0.0

    def wait(self, at_s: float, is_first: bool) -> float | None:
        """Wait for the picture at a time of the file; gives the time of day that it stands for, ``None`` to end."""
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
        if pause_s > 0 and self._stop.wait(pause_s):
            return None
        return None if self._stop.is_set() else self._unix_s()


def _at(frame: EncodedFrame | RawFrame, captured_unix_s: float) -> EncodedFrame | RawFrame:
    return replace(frame, captured_unix_s=captured_unix_s)
