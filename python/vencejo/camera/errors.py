"""What can go wrong with a camera."""

from __future__ import annotations

from vencejo.errors import VencejoError

__all__ = ["CameraError"]


class CameraError(VencejoError):
    """A source that cannot be read, or a picture or recording that cannot be made; the text says why and what to do."""
