"""Pictures for programs, limited in size and rate."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Final

from vencejo.camera import jpeg
from vencejo.camera.camera import Camera, CameraState
from vencejo.camera.errors import CameraError
from vencejo.camera.frames import EncodedFrame, Frame, Pixels, opencv

__all__ = ["FrameSource"]

MAX_SIDE: Final = 8192


class FrameSource:
    """The newest picture of a camera within limits. Each call is quick; many threads may ask.

    Parameters
    ----------
    camera : Camera
    max_width, max_height : int, optional
        Pixels; larger pictures are made smaller, keeping their proportions. Default: as they are.
    max_rate_hz : float, optional
        Who asks more often gets the same picture again, default 30.
    jpeg_quality : int, optional
        JPEG quality, 1 to 100, default 80, of pictures that are encoded here.
    monotonic_s : callable, optional
        The clock.

    Raises
    ------
    CameraError
        For limits that are none.

    Examples
    --------
    >>> from vencejo.camera import Camera, FrameSource
    >>> with Camera("no-such-file.mp4", name="nose") as camera:
    ...     FrameSource(camera, max_width=320).name
    'nose'
    """

    def __init__(
        self,
        camera: Camera,
        *,
        max_width: int | None = None,
        max_height: int | None = None,
        max_rate_hz: float = 30.0,
        jpeg_quality: int = 80,
        monotonic_s: Callable[[], float] = time.monotonic,
    ) -> None:
        for what, side in (("max_width", max_width), ("max_height", max_height)):
            if side is not None and not 16 <= side <= MAX_SIDE:
                raise CameraError(f"{what} is {side}, should be 16 to {MAX_SIDE} pixels")
        if not 0.01 <= max_rate_hz <= 1000.0:
            raise CameraError(f"max_rate_hz is {max_rate_hz}, should be 0.01 to 1000")
        if not 1 <= jpeg_quality <= 100:
            raise CameraError(f"jpeg_quality is {jpeg_quality}, should be 1 to 100")
        self.camera = camera
        self._limits = (max_width, max_height)
        self._period_s = 1.0 / max_rate_hz
        self._quality = jpeg_quality
        self._monotonic_s = monotonic_s
        self._lock = threading.Lock()
        self._frame: tuple[float, Frame] | None = None
        self._jpeg: tuple[float, EncodedFrame] | None = None

    @property
    def name(self) -> str:
        """The camera's name."""
        return self.camera.name

    def record(self, wanted: bool) -> None:
        """Begin or end recording the camera, as it is: the limits are for looking.

        Raises
        ------
        CameraError
            When nothing can be recorded.
        """
        if wanted:
            self.camera.start_recording()
        else:
            self.camera.stop_recording()

    def latest(self, timeout_s: float = 1.0) -> Frame | None:
        """The newest picture in pixels; ``None`` when there was none in time. See `Camera.latest`.

        Raises
        ------
        CameraError
            When the source is not there.
        """
        self._check()
        with self._lock:
            now = self._monotonic_s()
            if self._frame is not None and now - self._frame[0] < self._period_s:
                return self._frame[1]
        # Waited for outside the lock, so that callers wait beside each other.
        frame = self.camera.latest(timeout_s)
        if frame is not None:
            size = self._fitted(frame.width, frame.height)
            if size != (frame.width, frame.height):
                frame = Frame(bgr=_resized(frame.bgr, size), captured_unix_s=frame.captured_unix_s)
        with self._lock:
            self._frame = None if frame is None else (now, frame)
        return frame

    def latest_jpeg(self, timeout_s: float = 1.0) -> EncodedFrame | None:
        """The newest picture as JPEG, the source's own where that is one and fits; ``None`` when there was none in time.

        Raises
        ------
        CameraError
            When the source is not there.
        """
        self._check()
        with self._lock:
            now = self._monotonic_s()
            if self._jpeg is not None and now - self._jpeg[0] < self._period_s:
                return self._jpeg[1]
        own = self.camera.latest_jpeg(timeout_s)
        if own is not None and self._fitted(own.width, own.height) != (own.width, own.height):
            frame = self.latest(timeout_s)
            own = None if frame is None else jpeg.encoded(frame, quality=self._quality)
        with self._lock:
            self._jpeg = None if own is None else (now, own)
        return own

    def _check(self) -> None:
        status = self.camera.status
        if status.state is CameraState.DEAD:
            raise CameraError(f"camera {self.name} is dead: {status.reason}")

    def _fitted(self, width: int, height: int) -> tuple[int, int]:
        max_width, max_height = self._limits
        scale = min(1.0, (max_width or width) / width, (max_height or height) / height)
        return max(1, round(width * scale)), max(1, round(height * scale))


def _resized(bgr: Pixels, size: tuple[int, int]) -> Pixels:
    cv2 = opencv()
    made: Pixels = cv2.resize(bgr, size, interpolation=cv2.INTER_AREA)
    return made
