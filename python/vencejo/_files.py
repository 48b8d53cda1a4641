"""Reading files of others: never more than is needed to see that one is too large."""

from __future__ import annotations

import errno
from pathlib import Path
from typing import Final

__all__ = ["read_bounded", "read_small"]

MAX_BYTES: Final = 16 << 20
"""The core reads plans and parameters up to this, and says so of what is longer."""
MAX_SMALL_BYTES: Final = 4 << 20
"""Most bytes of a key, a certificate or settings, as `read_small` of the crate vencejo-store has it."""


def read_bounded(path: Path, most: int = MAX_BYTES) -> bytes:
    """The bytes of a file, or one more than are taken when it has more."""
    with path.open("rb") as file:
        return file.read(most + 1)


def read_small(path: Path) -> bytes:
    """The bytes of a file with a key, a certificate or settings.

    Raises
    ------
    OSError
        When it cannot be read, or has more than `MAX_SMALL_BYTES`.
    """
    data = read_bounded(path, MAX_SMALL_BYTES)
    if len(data) > MAX_SMALL_BYTES:
        raise OSError(errno.EFBIG, f"it has more than {MAX_SMALL_BYTES} bytes", str(path))
    return data
