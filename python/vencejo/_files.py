"""Reading files of others: never more than is needed to see that one is too large."""

from __future__ import annotations

from pathlib import Path
from typing import Final

__all__ = ["read_bounded"]

MAX_BYTES: Final = 16 << 20
"""The core reads plans and parameters up to this, and says so of what is longer."""


def read_bounded(path: Path) -> bytes:
    """The bytes of a file, or one more than are taken when it has more."""
    with path.open("rb") as file:
        return file.read(MAX_BYTES + 1)
