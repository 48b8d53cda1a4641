"""Parameter files: ``.param`` and ``.parm`` (Mission Planner, MAVProxy), ``.params`` (QGroundControl)."""

from __future__ import annotations

import fnmatch
import math
import os
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from vencejo import _native
from vencejo._files import read_bounded
from vencejo.errors import FileFormatError
from vencejo.storage import write_file
from vencejo.values import Parameter

__all__ = ["load_params", "save_params"]

OWN_VALUES: Final = ("STAT_*", "BARO?_GND_PRESS")
"""Names of what the vehicle counts or measures by itself, ``*`` and ``?`` standing for anything: a file never sets them."""

FIRST_FLOAT: Final = 9
"""MAV_PARAM_TYPE_REAL32; those before it are whole numbers."""


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
    values = sorted((name, one.value if isinstance(one, Parameter) else one) for name, one in params.items())
    write_file(path, _native.format_params(values).encode())


def differing(
    wanted: Mapping[str, float], present: Mapping[str, Parameter]
) -> tuple[dict[str, float], tuple[str, ...]]:
    """The values of a file that a vehicle does not have yet, by name, and the names that it does not know."""
    taken = [name for name in sorted(wanted) if not any(fnmatch.fnmatchcase(name, own) for own in OWN_VALUES)]
    unknown = tuple(name for name in taken if name not in present)
    known = [name for name in taken if name in present]
    return {name: wanted[name] for name in known if not same(present[name], wanted[name])}, unknown


def same(parameter: Parameter, wanted: float) -> bool:
    """Whether a parameter has the value of a file.

    A vehicle keeps 32-bit floats, which files write with as few as six digits. Whole numbers are written in full: in a
    bit mask, or the id of a device, each one counts.
    """
    try:
        (kept,) = struct.unpack("<f", struct.pack("<f", wanted))
    except OverflowError:
        return False
    if parameter.value in (wanted, kept):
        return True
    return parameter.type >= FIRST_FLOAT and math.isclose(parameter.value, kept, rel_tol=2e-6, abs_tol=1e-9)
