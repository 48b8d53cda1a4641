"""The server's interface for cameras: encoded pictures and state in, requests of browsers out.

`vencejo.camera` does all of this for the sources that it supports. Use this for pictures of your own.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from vencejo import _native
from vencejo._forking import belongs_here
from vencejo.station import default_record_dir

__all__ = ["VideoFeed", "VideoRequest", "VideoStatus", "default_video_dir"]


def default_video_dir() -> Path:
    """Folder of recordings and pictures: ``$VENCEJO_DATA/video``, else the user's data folder (XDG base directories)."""
    return default_record_dir().parent / "video"


@dataclass(frozen=True, kw_only=True)
class VideoStatus:
    """State of a camera, as pages show it.

    Attributes
    ----------
    state : {"standby", "starting", "live", "stalled", "dead"}
    reason : str or None
        Why no pictures come.
    codec : {"h264", "jpeg"} or None
        Codec of the source; ``None`` if it is not known, and for pictures that are encoded here.
    size : tuple of int or None
        Width and height in pixels.
    rate_hz, bitrate_bit_s : float or None
        Recent pictures and bits per second.
    recording : tuple or None
        File name, duration in seconds, bytes, and the fault that ended it, if any.
    """

    state: Literal["standby", "starting", "live", "stalled", "dead"] = "starting"
    reason: str | None = None
    codec: Literal["h264", "jpeg"] | None = None
    size: tuple[int, int] | None = None
    rate_hz: float | None = None
    bitrate_bit_s: float | None = None
    recording: tuple[str, float, int, str | None] | None = None


class VideoRequest:
    """A browser's request to a camera. One that is never answered counts as refused.

    Attributes
    ----------
    kind : {"snapshot", "keep_snapshot", "start_recording", "stop_recording"}
        ``"keep_snapshot"``: write it beside the recordings, and answer with it as well.
    """

    def __init__(self, native: _native.VideoRequest) -> None:
        self._native = native
        self.kind: Literal["snapshot", "keep_snapshot", "start_recording", "stop_recording"] = native.kind

    def answer(self, data: bytes = b"") -> None:
        """Confirm that it is done; for a snapshot, with the JPEG file."""
        self._native.answer(data)

    def refuse(self, reason: str) -> None:
        """Refuse it, with the reason."""
        self._native.refuse(reason)


class VideoFeed:
    """Feeds one camera of a server: see `vencejo.serve.Server.add_camera`."""

    def __init__(self, native: _native.VideoFeed) -> None:
        self._native = native
        belongs_here(self)

    def publish(
        self,
        data: bytes,
        *,
        codec: Literal["h264", "jpeg"],
        is_key: bool,
        width: int,
        height: int,
        captured_unix_s: float,
    ) -> None:
        """Send a picture to all viewers; never waits.

        Parameters
        ----------
        data : bytes
            One access unit of H.264 as a byte stream, key frames with their parameter sets; or one JPEG file.
        codec : {"h264", "jpeg"}
        is_key : bool
            Whether it can be decoded without earlier ones.
        width, height : int
            Pixels.
        captured_unix_s : float
            When it was taken, in seconds since 1970, UTC.

        Raises
        ------
        InvalidRequest
            For invalid data.
        ClosedError
            When the feed is closed.
        """
        self._native.publish(data, codec, is_key, width, height, captured_unix_s)

    def set_status(self, status: VideoStatus) -> None:
        """Set the camera's state for the pages."""
        self._native.set_status(
            status.state,
            status.reason,
            status.codec,
            status.size,
            status.rate_hz,
            status.bitrate_bit_s,
            status.recording,
        )

    @property
    def jpeg_viewers(self) -> int:
        """Number of viewers that are sent JPEG."""
        return self._native.demand()[1]

    @property
    def h264_viewers(self) -> int:
        """Number of viewers that are sent H.264."""
        return self._native.demand()[0]

    def next_request(self, timeout_s: float) -> VideoRequest | None:
        """Wait for the next request.

        Returns
        -------
        VideoRequest or None
            ``None`` after `timeout_s`, and when the number of viewers changes (`jpeg_viewers`).

        Raises
        ------
        ClosedError
            When the feed is closed.
        """
        native = self._native.next_request(timeout_s)
        return None if native is None else VideoRequest(native)

    def close(self) -> None:
        """Take the camera away. May be called again."""
        self._native.close()
