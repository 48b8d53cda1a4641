"""FFmpeg's options for what OpenCV opens next: they go through the environment, so one opens at a time."""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Iterator
from typing import Final

__all__ = ["SOURCES", "STREAM_OF_OURS", "ffmpeg_options"]

VARIABLE: Final = "OPENCV_FFMPEG_CAPTURE_OPTIONS"
SOURCES: Final = (
    # One TCP connection: passes firewalls, and loses nothing on the way. RTP described by an .sdp file needs to be allowed.
    "rtsp_transport;tcp|protocol_whitelist;file,crypto,data,http,https,tcp,tls,udp,rtp,rtsp,srt,rtmp|analyzeduration;1000000"
)
STREAM_OF_OURS: Final = "probesize;32"
"""What we wrote ourselves says at its beginning what it is: nothing has to be waited for to find out."""

_one_opens = threading.Lock()


@contextlib.contextmanager
def ffmpeg_options(options: str, *, own_stand: bool = False) -> Iterator[None]:
    """Let FFmpeg have these options for what is opened inside.

    Parameters
    ----------
    options : str
        As OpenCV has them: ``key;value|key;value``.
    own_stand : bool, optional
        Whether what a person has set in the environment stands instead.
    """
    with _one_opens:
        own = os.environ.get(VARIABLE)
        if not (own_stand and own):
            os.environ[VARIABLE] = options
        os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
        try:
            yield
        finally:
            if own is None:
                os.environ.pop(VARIABLE, None)
            else:
                os.environ[VARIABLE] = own
