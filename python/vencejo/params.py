"""Parameter files: ``.param`` and ``.parm`` (Mission Planner, MAVProxy), ``.params`` (QGroundControl)."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from vencejo import _native
from vencejo._files import read_bounded
from vencejo.errors import FileFormatError
from vencejo.storage import write_file

__all__ = ["load_params", "save_params"]


def load_params(path: str | os.PathLike[str]) -> dict[str, float]:
    """Read a parameter file of any known kind, recognised by its content.

    Raises
    ------
    FileFormatError
        When it cannot be read; the message names the line.
    """
    path = Path(path)
    try:
        return dict(_native.parse_params(read_bounded(path)))
    except OSError as error:
        raise FileFormatError(f"{path}: {error.strerror or error}") from error
    except FileFormatError as error:
        raise FileFormatError(f"{path}: {error}") from None


def save_params(path: str | os.PathLike[str], params: Mapping[str, float]) -> None:
    """Write a ``.param`` file: one ``NAME,value`` a line, sorted by name.

    Raises
    ------
    InvalidRequest
        For a name or a value that no parameter has, such as NaN; nothing is written.
    OSError
    """
    write_file(path, _native.format_params(sorted(params.items())).encode())
