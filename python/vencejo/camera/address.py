"""Camera sources as people write them: ``/dev/video0``, ``rpicam``, ``rtsp://…``, ``http://…``, a file."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from enum import Enum
from typing import Final
from urllib.parse import urlsplit, urlunsplit

from vencejo.camera.errors import CameraError

__all__ = ["SourceAddress", "SourceKind", "named_source", "parse_source"]

NAME: Final = re.compile(r"[A-Za-z0-9_-]{1,32}")
MODE: Final = re.compile(r"(?P<width>\d{2,5})x(?P<height>\d{2,5})(?:@(?P<rate>\d{1,3}))?")
STREAMS: Final = frozenset({"rtsp", "rtsps", "rtp", "udp", "tcp", "srt", "rtmp"})

SIMULATED: Final = "http://127.0.0.1:8554/stream.mjpg"
"""Where `vencejo sim --camera` serves its nose camera."""

ON_DEMAND: Final = "on-demand:"
SECRETS: Final = re.compile(r"(?i)([^&;=]*(?:pass|pwd|secret|token|auth|key|usr|user|login)[^&;=]*)=[^&;]*")
"""URL parameters that hold secrets: many cameras take their password this way."""

HELP: Final = (
    "a source is a device (/dev/video0), rpicam, sim, a stream (rtsp://…, http://…, udp://…, tcp://…), an .sdp file for RTP, or a "
    "video file; NAME= before it gives it a name, on-demand: before it has it read only while somebody looks"
)


class SourceKind(Enum):
    """What a source is."""

    V4L2 = "v4l2"
    RPICAM = "rpicam"
    HTTP = "http"
    STREAM = "stream"
    FILE = "file"


@dataclass(frozen=True, kw_only=True)
class SourceAddress:
    """A source that was understood.

    Attributes
    ----------
    kind : SourceKind
    location : str
        Device, URL, path, or number of the Raspberry Pi's camera.
    width, height, rate_hz : int or None
        What a device is asked for; ``None`` leaves it to the device.
    shown : str
        The same without passwords, for people.
    is_on_demand : bool
        Whether it is read only while somebody looks, records or asks for pictures.
    """

    kind: SourceKind
    location: str
    width: int | None = None
    height: int | None = None
    rate_hz: int | None = None
    shown: str = ""
    is_on_demand: bool = False


def parse_source(text: str) -> SourceAddress:
    """Understand a source.

    Parameters
    ----------
    text : str
        ``/dev/video0`` or ``v4l2:/dev/video0``; ``rpicam`` or ``rpicam:1``; either with a mode behind a comma, such as
        ``/dev/video0,1280x720@30``. ``rtsp://``, ``rtsps://``, ``udp://``, ``tcp://``, ``srt://``, ``rtmp://``,
        ``http://`` and ``https://`` URLs. ``sim`` is the nose camera of `vencejo sim --camera`. Anything else is the
        path of a video file; an ``.sdp`` file describes an RTP stream. With ``on-demand:`` before it, it is read only
        while somebody wants pictures.

    Raises
    ------
    CameraError
        For what is none of these.

    Examples
    --------
    >>> parse_source("/dev/video2,640x480@30").rate_hz
    30
    >>> parse_source("rtsp://me:secret@10.0.0.5/live").shown
    'rtsp://…@10.0.0.5/live'
    """
    text = text.strip()
    found = _source(text.removeprefix(ON_DEMAND).strip())
    return replace(found, is_on_demand=text.startswith(ON_DEMAND))


def _source(text: str) -> SourceAddress:
    if text.startswith(ON_DEMAND):
        raise CameraError(f"{ON_DEMAND} stands once before a source; {HELP}")
    if not text or "\0" in text:
        raise CameraError(f"no camera source: {HELP}")
    scheme = text.partition("://")[0].lower() if "://" in text else ""
    if scheme:
        return _url(text, scheme)
    if text == "sim":
        return SourceAddress(kind=SourceKind.HTTP, location=SIMULATED, shown=text)
    location, width, height, rate_hz = _mode(text)
    if location == "rpicam" or location.startswith("rpicam:"):
        number = location.partition(":")[2] or "0"
        if not number.isdecimal():
            raise CameraError(f"{text!r}: after rpicam: stands the camera's number, such as rpicam:1")
        return SourceAddress(
            kind=SourceKind.RPICAM, location=number, width=width, height=height, rate_hz=rate_hz, shown=text
        )
    if location.startswith(("v4l2:", "/dev/video")):
        device = location.removeprefix("v4l2:")
        return SourceAddress(
            kind=SourceKind.V4L2, location=device, width=width, height=height, rate_hz=rate_hz, shown=text
        )
    return SourceAddress(kind=SourceKind.FILE, location=text.removeprefix("file:"), shown=text)


def _url(text: str, scheme: str) -> SourceAddress:
    try:
        parts = urlsplit(text)
        host, _ = parts.hostname, parts.port
    except ValueError as error:
        # An invalid URL may hold a password all the same.
        raise CameraError(f"{scheme}://… is no URL ({error}); {HELP}") from error
    shown = text
    if parts.username is not None:
        shown = urlunsplit(parts._replace(netloc="…@" + parts.netloc.rpartition("@")[2]))
    if SECRETS.search(parts.query):
        shown = shown.replace(parts.query, SECRETS.sub(r"\1=…", parts.query))
    if scheme == "file":
        return SourceAddress(kind=SourceKind.FILE, location=text.removeprefix("file://"), shown=text)
    if scheme in {"http", "https"} and host:
        return SourceAddress(kind=SourceKind.HTTP, location=text, shown=shown)
    if scheme in STREAMS and (host or scheme in {"udp", "rtp"}):
        return SourceAddress(kind=SourceKind.STREAM, location=text, shown=shown)
    raise CameraError(f"{shown!r} is not a camera source: {HELP}")


def _mode(text: str) -> tuple[str, int | None, int | None, int | None]:
    location, comma, mode = text.rpartition(",")
    found = MODE.fullmatch(mode) if comma else None
    if found is None:
        return text, None, None, None
    rate = found["rate"]
    return location, int(found["width"]), int(found["height"]), None if rate is None else int(rate)


def named_source(text: str, taken: frozenset[str] = frozenset()) -> tuple[str, str]:
    """Name and source of ``NAME=SOURCE`` or ``SOURCE``; those without a name are called camera, camera2 and so on.

    Raises
    ------
    CameraError
        For a name that is taken.
    """
    name, equals, source = text.partition("=")
    if not equals or NAME.fullmatch(name) is None:
        number = 1
        while (name := "camera" if number == 1 else f"camera{number}") in taken:
            number += 1
        return name, text
    if name in taken:
        raise CameraError(f"two cameras are called {name!r}; give each a name of its own")
    return name, source
