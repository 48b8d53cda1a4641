"""What every kind of source is once it is open."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

from vencejo.camera.frames import EncodedFrame, Frame

__all__ = ["Source"]


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
        """Close it, from any thread; a pending read returns soon. Can be called again."""
        ...
