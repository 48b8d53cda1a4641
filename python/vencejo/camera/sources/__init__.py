"""The kinds of sources, a file for each way to read: every one gives pictures until it ends or fails."""

from __future__ import annotations

from vencejo.camera.address import SourceAddress, SourceKind
from vencejo.camera.sources.source import Source

__all__ = ["Source", "open_source"]


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
