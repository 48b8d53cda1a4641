"""Where the user's data is, and what the program is called.

Texts, not a `Path`: every station asks, and to import `pathlib` takes longer than to start one.
"""
# ruff: noqa: PTH110, PTH111, PTH112, PTH118, PTH119

from __future__ import annotations

import os
import sys


def data_dir(name: str) -> str:
    """A folder in the user's data (XDG base directories), or in ``$VENCEJO_DATA``.

    Raises
    ------
    InvalidRequest
        When ``$VENCEJO_DATA`` is a file, in which nothing would be found or stored.
    """
    own = os.environ.get("VENCEJO_DATA")
    if own:
        if os.path.exists(own) and not os.path.isdir(own):
            from vencejo.errors import InvalidRequest

            raise InvalidRequest(f"VENCEJO_DATA is {own}, a file: set it to a folder")
        return os.path.join(own, name)
    base = os.environ.get("XDG_DATA_HOME") or os.path.join(os.path.expanduser("~"), ".local", "share")
    return os.path.join(base, "vencejo", name)


def program() -> str:
    """What the program is called, for others to see."""
    folder, name = os.path.split(sys.argv[0] if sys.argv else "")
    # What is started by `-m` as a package is called as that is.
    name = os.path.basename(folder) if name == "__main__.py" else name
    return name if name not in ("", "-c", "-m") else "program"
