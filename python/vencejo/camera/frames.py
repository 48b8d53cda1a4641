"""What comes from a camera: pictures, encoded or not, each with the time it was taken."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Any, Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

__all__ = ["Codec", "EncodedFrame", "Frame", "Pixels", "opencv"]

Codec: TypeAlias = Literal["h264", "jpeg"]
"""How a picture is encoded. H.264 is a byte stream (ITU-T H.264 annex B), one access unit a picture."""

Pixels: TypeAlias = NDArray[np.uint8]
"""Height × width × 3 bytes."""


FFMPEG_OPTIONS: Final = "|".join(
    (
        # One TCP connection: passes firewalls, and loses nothing on the way.
        "rtsp_transport;tcp",
        # RTP described by an .sdp file needs to be allowed.
        "protocol_whitelist;file,crypto,data,http,https,tcp,tls,udp,rtp,rtsp,srt,rtmp",
        # What the video is shows soon; how many pictures a second it has need not be counted before the first is given.
        "analyzeduration;1000000",
        "fpsprobesize;0",
    )
)
"""For whatever FFmpeg opens. The environment is of the whole process: so these are the same for all, and never changed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EncodedFrame:
    """A picture as its source encoded it.

    Attributes
    ----------
    data : bytes
        The code: one access unit of H.264 with start codes, or one JPEG file.
    codec : {"h264", "jpeg"}
    captured_unix_s : float
        When it was taken, in seconds since 1970, UTC. Sources that do not say are taken to be immediate.
    is_key : bool
        Whether it can be decoded without those before it. True for every JPEG; key frames of H.264 bring their
        parameter sets.
    width, height : int
        Pixels.
    """

    data: bytes = field(repr=False)
    codec: Codec
    captured_unix_s: float
    is_key: bool
    width: int
    height: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """A picture in pixels: of a source that does not encode, or decoded.

    Attributes
    ----------
    bgr : ndarray
        Height × width × 3 bytes: blue, green, red, as OpenCV has them. Not to be written to.
    captured_unix_s : float
        When it was taken, in seconds since 1970, UTC.
    """

    bgr: Pixels = field(repr=False)
    captured_unix_s: float

    @property
    def rgb(self) -> Pixels:
        """The same bytes seen as red, green, blue."""
        return self.bgr[:, :, ::-1]

    @property
    def width(self) -> int:
        """Pixels."""
        return int(self.bgr.shape[1])

    @property
    def height(self) -> int:
        """Pixels."""
        return int(self.bgr.shape[0])


def opencv() -> Any:
    """OpenCV, made quiet; it is loaded when it is first needed.

    Raises
    ------
    CameraError
        When it is not installed.
    """
    from vencejo.camera.errors import CameraError

    # It reads these once, or at each opening; what a person has set stands. What goes wrong is told by us; OpenCV's own
    # lines would stand in the middle of others, and name what is to be secret.
    os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    os.environ.setdefault("OPENCV_FFMPEG_CAPTURE_OPTIONS", FFMPEG_OPTIONS)
    try:
        import cv2
    except ImportError as error:
        raise CameraError("this needs the camera extra: pip install 'vencejo[camera]'") from error
    return cv2
