"""The kinds of sources, a file for each way to read: every one gives pictures until it ends or fails."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

from vencejo.camera.address import SourceAddress, SourceKind
from vencejo.camera.frames import EncodedFrame, Frame

__all__ = ["Source", "open_source"]


class Source(Protocol):
    """An open source."""

    def frames(self) -> Iterator[EncodedFrame | Frame]:
        """Pictures as they come, until the source ends.

        Raises
        ------
        CameraError
            When it fails; the text says why.
        """
        ...

    def close(self) -> None:
        """End it, from any thread: whoever waits for a picture comes back soon. May be called again."""
        ...


def open_source(address: SourceAddress) -> Source:
    """Open a source.

    Raises
    ------
    CameraError
        When it is not there; the text says why and what to do.
    """
    match address.kind:
        case SourceKind.HTTP:
            from vencejo.camera.sources.http import open_http

            return open_http(address)
        case SourceKind.V4L2:
            from vencejo.camera.sources.v4l2 import V4l2Source

            return V4l2Source(address)
        case SourceKind.RPICAM:
            from vencejo.camera.sources.rpicam import RpicamSource

            return RpicamSource(address)
        case SourceKind.STREAM | SourceKind.FILE:
            from vencejo.camera.child import ChildSource
            from vencejo.camera.sources.ffmpeg import require_file

            if address.kind is SourceKind.FILE:
                require_file(address)
            return ChildSource(address)
