"""Parameter files: ``.param`` and ``.parm`` (Mission Planner, MAVProxy), ``.params`` (QGroundControl)."""

from __future__ import annotations

import fnmatch
import math
import os
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Final

from vencejo import _native
from vencejo._files import read_bounded
from vencejo.errors import FileFormatError
from vencejo.storage import write_file

if TYPE_CHECKING:
    from vencejo.values import Parameter

__all__ = ["load_params", "save_params"]

OWN_VALUES: Final = ("STAT_*", "BARO?_GND_PRESS")
"""Names of what the vehicle counts or measures by itself, ``*`` and ``?`` standing for anything: a file never sets them."""


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


def save_params(path: str | os.PathLike[str], params: Mapping[str, float | Parameter]) -> None:
    """Write a ``.param`` file: one ``NAME,value`` a line, sorted by name. It takes what `Parameters.all` returns, too.

    Raises
    ------
    InvalidRequest
        For a name or a value that no parameter has, such as NaN; nothing is written.
    OSError
    """
    if not isinstance(params, Mapping):
        raise TypeError(f"params is a {type(params).__name__}: give a dict of values by name, after the path")
    values = sorted((name, one if isinstance(one, (int, float)) else one.value) for name, one in params.items())
    write_file(path, _native.format_params(values).encode())


def differing(
    wanted: Mapping[str, float], present: Mapping[str, Parameter]
) -> tuple[dict[str, float], tuple[str, ...]]:
    """The values of a file that a vehicle does not have yet, by name, and the names that it does not know."""
    taken = [name for name in sorted(wanted) if not any(fnmatch.fnmatchcase(name, own) for own in OWN_VALUES)]
    unknown = tuple(name for name in taken if name not in present)
    known = [name for name in taken if name in present]
    return {name: wanted[name] for name in known if not same(present[name].value, wanted[name])}, unknown


def same(one: float, other: float) -> bool:
    """Whether two values are the same to a vehicle, which keeps 32-bit floats, and to a file, which rounds to six digits."""
    try:
        (kept,) = struct.unpack("<f", struct.pack("<f", other))
    except OverflowError:
        return False
    return bool(one == kept or math.isclose(one, kept, rel_tol=2e-6, abs_tol=1e-9))
