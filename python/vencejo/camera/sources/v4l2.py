"""Cameras at this machine by Video4Linux: USB cameras, capture cards, and what drivers show as ``/dev/video*``."""

from __future__ import annotations

import errno
import os
import threading
import time
from collections.abc import Iterator
from typing import Any, Final

from vencejo.camera import jpeg
from vencejo.camera.address import SourceAddress
from vencejo.camera.errors import CameraError
from vencejo.camera.frames import EncodedFrame, Frame, opencv

__all__ = ["V4l2Source"]

READ_TIMEOUT_MS: Final = 3_000
REASONS: Final = {
    errno.ENOENT: "is not there: is the camera plugged in? `ls /dev/video*` shows those that are",
    errno.EACCES: "may not be opened: add yourself to the group `video` and log in again",
    errno.EBUSY: "is used by another program",
}


class V4l2Source:
    """A device.

    It is asked for JPEG pictures first, which are passed on as they are; a device without them gives raw pictures.

    Parameters
    ----------
    address : SourceAddress
        The device, and the mode that is wanted.

    Raises
    ------
    CameraError
        When it cannot be opened, or is no camera.
    """

    def __init__(self, address: SourceAddress) -> None:
        self._address = address
        self._stop = threading.Event()
        try:
            os.close(os.open(address.location, os.O_RDWR | os.O_NONBLOCK))
        except OSError as error:
            why = REASONS.get(error.errno or 0, f"cannot be opened: {error.strerror}")
            raise CameraError(f"{address.location} {why}") from error
        self._capture = self._open(is_jpeg=True)
        cv2 = opencv()
        self._is_jpeg = int(self._capture.get(cv2.CAP_PROP_FOURCC)) == cv2.VideoWriter.fourcc(*"MJPG")
        if not self._is_jpeg:
            self._capture.release()
            self._capture = self._open(is_jpeg=False)

    def frames(self) -> Iterator[EncodedFrame | Frame]:
        """Pictures as they come. See `Source`."""
        try:
            while not self._stop.is_set():
                is_there, picture = self._capture.read()
                if not is_there:
                    break
                now = time.time()
                if not self._is_jpeg:
                    yield Frame(bgr=picture, captured_unix_s=now)
                    continue
                data = picture.tobytes()
                size = jpeg.size(data)
                if size is not None:  # a picture may be broken on its way through USB
                    width, height = size
                    yield EncodedFrame(
                        data=data, codec="jpeg", captured_unix_s=now, is_key=True, width=width, height=height
                    )
        finally:
            self._capture.release()
        if not self._stop.is_set():
            raise CameraError(f"{self._address.location} gives no pictures any more: was it unplugged?")

    def close(self) -> None:
        """End it. See `Source`."""
        self._stop.set()

    def _open(self, *, is_jpeg: bool) -> Any:
        cv2 = opencv()
        wanted = [cv2.CAP_PROP_READ_TIMEOUT_MSEC, READ_TIMEOUT_MS]
        if is_jpeg:
            wanted += [cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*"MJPG")]
        if self._address.width is not None and self._address.height is not None:
            wanted += [cv2.CAP_PROP_FRAME_WIDTH, self._address.width, cv2.CAP_PROP_FRAME_HEIGHT, self._address.height]
        if self._address.rate_hz is not None:
            wanted += [cv2.CAP_PROP_FPS, self._address.rate_hz]
        if is_jpeg:
            wanted += [cv2.CAP_PROP_CONVERT_RGB, 0]
        capture = cv2.VideoCapture(self._address.location, cv2.CAP_V4L2, wanted)
        if not capture.isOpened():
            # Some drivers refuse what they do not have instead of giving what is near it.
            capture = cv2.VideoCapture(self._address.location, cv2.CAP_V4L2)
            if is_jpeg and capture.isOpened():
                capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*"MJPG"))
                capture.set(cv2.CAP_PROP_CONVERT_RGB, 0)
        if not capture.isOpened():
            raise CameraError(f"{self._address.location} is no camera, or is used by another program")
        return capture
