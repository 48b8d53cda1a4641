"""JPEG as bytes: its segments (ITU-T T.81, annex B), and pictures to and from it."""

from __future__ import annotations

from typing import Final

import numpy as np

from vencejo.camera.errors import CameraError
from vencejo.camera.frames import EncodedFrame, Frame, Pixels, opencv

__all__ = ["BEGIN", "END", "decode", "encode", "encode_rgb", "encoded", "size", "with_segments"]

BEGIN: Final = b"\xff\xd8"
END: Final = b"\xff\xd9"
MAX_SIDE: Final = 16384
"""Most pixels of a picture: more than any camera has."""


def size(data: bytes) -> tuple[int, int] | None:
    """Width and height in the header of a JPEG file; ``None`` for anything but a complete JPEG file.

    Some cameras fill up behind the end mark; that is no fault.
    """
    if not data.startswith(BEGIN) or data.rfind(END, len(data) - 4096 if len(data) > 4096 else 0) < 0:
        return None
    at = 2
    while at + 9 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker == 0xFF:  # filling
            at += 1
            continue
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):  # SOF
            height = int.from_bytes(data[at + 5 : at + 7], "big")
            width = int.from_bytes(data[at + 7 : at + 9], "big")
            return (width, height) if 0 < width <= MAX_SIDE and 0 < height <= MAX_SIDE else None
        length = int.from_bytes(data[at + 2 : at + 4], "big")
        if length < 2:
            return None
        at += 2 + length
    return None


def with_segments(data: bytes, *payloads: bytes) -> bytes:
    """A JPEG file with application segments (APP1) behind its beginning; the picture itself is untouched.

    Raises
    ------
    CameraError
        For a payload that is too large for a segment.
    """
    segments = b""
    for payload in payloads:
        if len(payload) + 2 > 0xFFFF:
            raise CameraError("what is to be written into the picture is too long")
        segments += b"\xff\xe1" + (len(payload) + 2).to_bytes(2, "big") + payload
    return data[:2] + segments + data[2:]


def encode(bgr: Pixels, *, quality: int = 80) -> bytes:
    """Encode a picture.

    Parameters
    ----------
    bgr : ndarray
        Height × width × 3 bytes: blue, green, red.
    quality : int, optional
        1 to 100, default 80.
    """
    cv2 = opencv()
    done, data = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, quality])
    if not done:
        raise CameraError("the picture could not be encoded")
    return bytes(data)


def encoded(frame: Frame, *, quality: int = 80) -> EncodedFrame:
    """A picture of the same moment, encoded. See `encode`."""
    return EncodedFrame(
        data=encode(frame.bgr, quality=quality),
        codec="jpeg",
        captured_unix_s=frame.captured_unix_s,
        is_key=True,
        width=frame.width,
        height=frame.height,
    )


def encode_rgb(rgb: Pixels) -> bytes:
    """Encode a picture whose bytes stand as red, green, blue, at quality 80."""
    return encode(np.ascontiguousarray(rgb[:, :, ::-1]))


def decode(data: bytes) -> Pixels | None:
    """Blue, green and red of a JPEG file; ``None`` when it is broken."""
    cv2 = opencv()
    bgr: Pixels | None = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    return bgr
