"""Camera: pictures of the cameras on board."""

from __future__ import annotations

import hashlib
import threading
import time
import zlib
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, Final, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from vencejo.errors import Busy, InvalidRequest, VencejoError
from vencejo.jderobot.runtime import Slices
from vencejo.jderobot.settings import IceSettings
from vencejo.jderobot.stamp import age_text, stamped
from vencejo.jderobot.workers import Workers
from vencejo.telemetry import LOST_AFTER_S, STALE_AFTER_S

__all__ = ["Camera", "Frame", "FrameSource", "Recording"]

_DEFLATE_LEVEL: Final = 1
"""zlib's fastest: a picture of 640 by 480 in about 15 ms."""


class Frame(Protocol):
    """A picture."""

    @property
    def rgb(self) -> NDArray[np.uint8]:
        """Height × width × 3 bytes: red, green, blue."""

    @property
    def captured_unix_s(self) -> float:
        """When it was taken, seconds since 1970, UTC."""

    @property
    def width(self) -> int:
        """Pixels."""

    @property
    def height(self) -> int:
        """Pixels."""


class FrameSource(Protocol):
    """A camera (`vencejo.camera` has them)."""

    @property
    def name(self) -> str:
        """What to call it."""

    def latest(self) -> Frame | None:
        """The newest picture, ``None`` before the first.

        Raises
        ------
        VencejoError
            When the camera is dead.
        """


@runtime_checkable
class Recording(Protocol):
    """A camera that records."""

    def record(self, wanted: bool) -> None:
        """Start or stop recording to a file."""


@dataclass(frozen=True)
class _Picture:
    """A picture in a format, ready to be given."""

    captured_unix_s: float
    width: int
    height: int
    format: str
    data: bytes
    md5: str
    mark: str
    """Its age as it is written into it, or nothing."""


def _shrunk(rgb: NDArray[np.uint8], width: int, height: int) -> NDArray[np.uint8]:
    """The picture reduced to at most this size by taking every n-th pixel, keeping its aspect ratio."""
    rows, columns = rgb.shape[:2]
    factor = max(rows / height, columns / width, 1.0)
    if factor == 1.0:
        return rgb
    down = (np.arange(max(1, int(rows / factor))) * factor).astype(int)
    across = (np.arange(max(1, int(columns / factor))) * factor).astype(int)
    shrunk: NDArray[np.uint8] = rgb[down[:, None], across]
    return shrunk


class Camera:
    """Servant of ``jderobot::Camera``, for one camera at a time; ArDroneExtra's toggleCam takes the next.

    Parameters
    ----------
    slices : Slices
    sources : sequence of FrameSource
    settings : IceSettings
    workers : Workers
        Waiting for a picture, and encoding it, holds up no other call.
    jpeg : function of an RGB picture, optional
        Encodes it; format ``"JPEG"`` is offered when there is one.
    clock : function, optional
        Seconds since 1970, UTC.
    """

    def __init__(
        self,
        slices: Slices,
        sources: Sequence[FrameSource],
        settings: IceSettings,
        workers: Workers,
        jpeg: Callable[[NDArray[np.uint8]], bytes] | None = None,
        *,
        clock: Callable[[], float] = time.time,
    ) -> None:
        self._slices = slices
        self._sources = sources
        self._settings = settings
        self._workers = workers
        self._clock = clock
        self._lock = threading.Lock()
        self._index = 0
        self._encoders: dict[str, Callable[[NDArray[np.uint8]], bytes]] = {
            "RGB8": lambda rgb: rgb.tobytes(),
            "RGB8_Z": lambda rgb: zlib.compress(rgb.tobytes(), _DEFLATE_LEVEL),
        }
        if jpeg is not None:
            self._encoders["JPEG"] = jpeg
        self._last: tuple[int, Frame] | None = None
        """Number of a camera and its last picture."""
        self._made: dict[str, _Picture] = {}
        self._described: Any = None

    # For ArDroneExtra --------------------------------------------------------------------------------------------------

    def toggle(self) -> str:
        """Take the next camera; its name."""
        with self._lock:
            if not self._sources:
                return "there is none"
            self._index = (self._index + 1) % len(self._sources)
            self._made.clear()
            return self._sources[self._index].name

    def record(self, wanted: bool) -> None:
        """Start or stop recording.

        Raises
        ------
        InvalidRequest
            When there is no camera, or it does not record.
        """
        source: object = self._source()
        if not isinstance(source, Recording):
            raise InvalidRequest("there is no camera that records")
        source.record(wanted)

    # ImageProvider -----------------------------------------------------------------------------------------------------

    def getImageDescription(self, current: Any = None) -> Any:
        """Description of the pictures; all zeros without one, because this operation has no exception."""
        try:
            return self._workers.later(self._description)
        except Busy:
            return self._slices.jderobot.ImageDescription(format="RGB8")

    def _description(self) -> Any:
        description = self._slices.jderobot.ImageDescription(format="RGB8")
        try:
            frame, _ = self._frame()
        except VencejoError:
            return description
        if frame is not None:
            rows, columns = _shrunk(frame.rgb, self._settings.camera_width, self._settings.camera_height).shape[:2]
            description.width, description.height, description.size = columns, rows, rows * columns * 3
        return description

    def getImageFormat(self, current: Any = None) -> list[str]:
        """Names of the formats."""
        return list(self._encoders)

    def getImageData(self, format: str, current: Any = None) -> Future[Any]:
        """The newest picture; one that was given is given again until a newer one may be (Camera.Rate)."""
        try:
            return self._workers.later(lambda: self._image(format))
        except Busy as error:
            raise self._slices.jderobot.DataNotExistException(str(error)) from error

    def _image(self, format: str) -> Any:
        jderobot = self._slices.jderobot
        name = format or "RGB8"
        if name not in self._encoders:
            formats = ", ".join(self._encoders)
            raise jderobot.DataNotExistException(f"format {name[:40]!r} is not given; the formats are {formats}")
        if not self._sources:
            raise jderobot.DataNotExistException("there is no camera; start the driver with --camera SOURCE")
        try:
            frame, has_failed = self._frame()
        except VencejoError as error:
            raise jderobot.HardwareFailedException(str(error)) from error
        if frame is None:
            raise jderobot.DataNotExistException(f"camera {self._source_name()} has given no picture yet")
        age_s = self._clock() - frame.captured_unix_s
        mark = ""
        if self._settings.old_pictures == "mark":
            mark = age_text(age_s) if has_failed or age_s > STALE_AFTER_S else ""
        elif age_s > LOST_AFTER_S:
            raise jderobot.HardwareFailedException(
                f"camera {self._source_name()} has given no picture for {age_s:.0f} s"
            )
        picture = self._picture(name, frame, mark)
        seconds, fraction = divmod(picture.captured_unix_s, 1.0)
        return jderobot.ImageData(
            jderobot.Time(int(seconds), int(fraction * 1e6)),
            jderobot.ImageDescription(picture.width, picture.height, len(picture.data), picture.format, picture.md5),
            picture.data,
        )

    # Camera ------------------------------------------------------------------------------------------------------------

    def getCameraDescription(self, current: Any = None) -> Any:
        """What was described, else the camera's name."""
        with self._lock:
            if self._described is not None:
                return self._described
        return self._slices.jderobot.CameraDescription(name=self._source_name(), shortDescription=self._source_name())

    def setCameraDescription(self, description: Any, current: Any = None) -> int:
        """Keep a description for others to read; the camera itself does not change."""
        if description is None:
            return 1
        with self._lock:
            self._described = description
        return 0

    def startCameraStreaming(self, current: Any = None) -> str:
        """Where the stream is; empty: pictures come by getImageData, at any time."""
        with self._lock:
            return "" if self._described is None else str(self._described.streamingUri)

    def stopCameraStreaming(self, current: Any = None) -> None:
        """Nothing to stop: other viewers look at the same camera."""

    def reset(self, current: Any = None) -> None:
        """Go back to the first camera and its own description."""
        with self._lock:
            self._index = 0
            self._described = None
            self._made.clear()

    def _source(self) -> FrameSource | None:
        with self._lock:
            return self._sources[self._index] if self._sources else None

    def _source_name(self) -> str:
        source = self._source()
        return "" if source is None else source.name

    def _frame(self) -> tuple[Frame | None, bool]:
        """The newest picture, and whether the camera fails and it is its last one.

        Raises
        ------
        VencejoError
            When the camera fails, and its last picture is not wanted, or there is none.
        """
        with self._lock:
            index, last = self._index, self._last
        if not self._sources:
            return None, False
        kept = last[1] if last is not None and last[0] == index and self._settings.old_pictures == "mark" else None
        try:
            frame = self._sources[index].latest()
        except VencejoError:
            if kept is None:
                raise
            return kept, True
        if frame is None:
            return kept, kept is not None
        with self._lock:
            self._last = index, frame
        return frame, False

    def _picture(self, name: str, frame: Frame, mark: str) -> _Picture:
        with self._lock:
            made = self._made.get(name)
        # A little earlier than due, so that the rate of a camera is not halved by its jitter.
        least_s = 0.9 / self._settings.camera_rate_hz
        if made is not None and mark == made.mark and frame.captured_unix_s - made.captured_unix_s < least_s:
            return made
        rgb = _shrunk(frame.rgb, self._settings.camera_width, self._settings.camera_height)
        if mark:
            rgb = stamped(rgb, mark)
        data = self._encoders[name](rgb)
        md5 = hashlib.md5(data, usedforsecurity=False).hexdigest()
        picture = _Picture(frame.captured_unix_s, rgb.shape[1], rgb.shape[0], name, data, md5, mark)
        with self._lock:
            self._made[name] = picture
        return picture
