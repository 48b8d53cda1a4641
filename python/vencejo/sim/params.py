"""The parameter store: ArduPlane's names, types and defaults, its conversions, and its packed file.

The protocol is in :mod:`vencejo.sim.mavlink.parameters`.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from importlib.resources import files

__all__ = ["ParamStore", "ParamType", "ParamValueError", "Parameter", "float32"]

PACK_MAGIC = 0x671B
PACK_MAGIC_WITH_DEFAULTS = 0x671C
_HEADER = struct.Struct("<HHH")
_ROUNDING = 0.01
"""Added away from zero before an integer parameter is truncated, as in AP_Param, so that 0.999 becomes 1."""


class ParamType(IntEnum):
    """MAV_PARAM_TYPE of the types that ArduPilot uses."""

    INT8 = 2
    INT16 = 4
    INT32 = 6
    REAL32 = 9


_LAYOUT: dict[ParamType, tuple[int, struct.Struct]] = {
    ParamType.INT8: (1, struct.Struct("<b")),
    ParamType.INT16: (2, struct.Struct("<h")),
    ParamType.INT32: (3, struct.Struct("<i")),
    ParamType.REAL32: (4, struct.Struct("<f")),
}
"""The number of each type in the packed file (AP_Param's own), and its encoding."""

_LIMITS: dict[ParamType, tuple[int, int]] = {
    ParamType.INT8: (-128, 127),
    ParamType.INT16: (-32768, 32767),
    ParamType.INT32: (-2147483648, 2147483647),
}


class ParamValueError(ValueError):
    """The value is not a finite 32-bit float."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter with its present value, as in PARAM_VALUE."""

    name: str
    value: float
    type: ParamType
    index: int


def float32(value: float) -> float:
    """The nearest 32-bit float, the vehicle's number type."""
    try:
        return float(struct.unpack("<f", struct.pack("<f", value))[0])
    except OverflowError:
        return math.copysign(math.inf, value)


def _convert(name: str, value: float, kind: ParamType) -> float:
    """The value as stored by the vehicle: integers are truncated and limited to their range."""
    if not math.isfinite(float32(value)):
        raise ParamValueError(f"{name} is {value!r}, should be a finite 32-bit float")
    if kind is ParamType.REAL32:
        return float32(value)
    low, high = _LIMITS[kind]
    return float(min(max(math.trunc(value + math.copysign(_ROUNDING, value)), low), high))


class ParamStore:
    """Parameters by name and by index, in the vehicle's own order.

    Parameters
    ----------
    rows : iterable of (name, value, type)
        The parameters in index order. The values are also the defaults.

    Examples
    --------
    >>> params = ParamStore.arduplane()
    >>> params.get("WP_RADIUS")
    50.0
    """

    def __init__(self, rows: Iterable[tuple[str, float, ParamType]]) -> None:
        self._names: list[str] = []
        self._types: list[ParamType] = []
        self._values: list[float] = []
        self._index: dict[str, int] = {}
        for name, value, kind in rows:
            if name in self._index:
                raise ValueError(f"parameter {name} is listed twice")
            self._index[name] = len(self._names)
            self._names.append(name)
            self._types.append(kind)
            self._values.append(_convert(name, value, kind))
        self._defaults = tuple(self._values)
        self._saved: dict[int, float] = {}
        """Saved values of the parameters whose present value is not saved, by index."""
        self._revision = 0

    @classmethod
    def arduplane(cls, overrides: Mapping[str, float] | None = None) -> ParamStore:
        """ArduPlane's parameters with the defaults of its simulated plane (``data/arduplane-4.8.param``).

        Parameters
        ----------
        overrides : mapping, optional
            Values that differ from the defaults.

        Raises
        ------
        KeyError
            ArduPlane has no such parameter.
        ParamValueError
            An override is not finite.
        """
        text = files("vencejo.sim").joinpath("data/arduplane-4.8.param").read_text(encoding="ascii")
        rows = []
        for line in text.splitlines():
            if line and not line.startswith("#"):
                name, value, kind = line.split()
                rows.append((name, float(value), ParamType(int(kind))))
        store = cls(rows)
        for name, number in (overrides or {}).items():
            store.set(name, number)
        return store

    def __len__(self) -> int:
        return len(self._names)

    @property
    def revision(self) -> int:
        """Increases with every change of any value."""
        return self._revision

    def get(self, name: str) -> float:
        """Value of a parameter; ``KeyError`` when it does not exist."""
        return self._values[self._index[name]]

    def integer(self, name: str) -> int:
        """Value of an integer parameter."""
        return int(self.get(name))

    def find(self, name: str) -> Parameter | None:
        """The parameter of that name, None when it does not exist."""
        index = self._index.get(name)
        return None if index is None else self.at(index)

    def at(self, index: int) -> Parameter:
        """The parameter with that index, 0 to ``len() − 1``."""
        return Parameter(self._names[index], self._values[index], self._types[index], index)

    def set(self, name: str, value: float) -> Parameter:
        """Store a value, converted to the parameter's type, and return what is stored.

        Raises
        ------
        KeyError
            There is no such parameter.
        ParamValueError
            The value is NaN, infinite or beyond a 32-bit float.
        """
        index = self._index[name]
        self._put(index, value)
        self._saved.pop(index, None)
        return self.at(index)

    def set_unsaved(self, name: str, value: float) -> None:
        """Set a value without saving it, until :meth:`load` (``AP_Param::set``); raises as :meth:`set`."""
        index = self._index[name]
        before = self._values[index]
        self._put(index, value)
        self._saved.setdefault(index, before)

    def load(self, name: str) -> None:
        """Restore the saved value (``AP_Param::load``); ``KeyError`` when the parameter does not exist."""
        index = self._index[name]
        if index in self._saved:
            self._put(index, self._saved.pop(index))

    def _put(self, index: int, value: float) -> None:
        stored = _convert(self._names[index], value, self._types[index])
        if stored != self._values[index]:
            self._values[index] = stored
            self._revision += 1

    def reset(self) -> None:
        """Restore the defaults."""
        self._values = list(self._defaults)
        self._saved.clear()
        self._revision += 1

    def pack(self, *, block_size: int, start: int = 0, count: int = 0, with_defaults: bool = False) -> bytes:
        """The packed parameter file (``@PARAM/param.pck``) as the vehicle builds it for one block size.

        Every entry has type and flags (4 bits each), the length of the prefix shared with the previous name and of
        the remaining name minus one (4 bits each), that remainder, the value and, when requested and different, the
        default. Zero bytes keep a value from crossing a block, so that a block read again later is consistent.

        Parameters
        ----------
        block_size : int
            Bytes of one MAVFTP read, 1 to 239; the padding depends on it.
        start, count : int
            A range of indices; ``count`` 0 means up to the last.
        with_defaults : bool
            Append each default that differs from the value.
        """
        stop = len(self) if count == 0 else min(len(self), start + count)
        magic = PACK_MAGIC_WITH_DEFAULTS if with_defaults else PACK_MAGIC
        out = bytearray(_HEADER.pack(magic, max(0, stop - start), len(self)))
        last = ""
        for index in range(start, stop):
            name = self._names[index]
            code, layout = _LAYOUT[self._types[index]]
            common = 0
            while common < min(len(name), len(last)) and name[common] == last[common]:
                common += 1
            common = min(common, len(name) - 1)
            rest = name[common:].encode("ascii")
            value = self._values[index]
            default = self._defaults[index]
            add_default = with_defaults and value != default
            entry = bytes((code | (0x10 if add_default else 0), common | (len(rest) - 1) << 4)) + rest
            entry += self._encode(layout, value)
            if add_default:
                entry += self._encode(layout, default)
            if layout.size > 1:
                over = (len(out) + len(entry)) % block_size
                if 0 < over < layout.size:
                    out += bytes(layout.size - over)
            out += entry
            last = name
        return bytes(out)

    @staticmethod
    def _encode(layout: struct.Struct, value: float) -> bytes:
        return layout.pack(value if layout.format == "<f" else int(value))

    def unpack(self, data: bytes) -> list[tuple[str, float]]:
        """Names and values of a packed file written by a station.

        Raises
        ------
        ValueError
            The file is malformed: bad magic, truncated, a name too long, an unknown type.
        """
        if len(data) < _HEADER.size:
            raise ValueError("packed parameters: shorter than the header")
        magic, number, length = _HEADER.unpack_from(data)
        if magic != PACK_MAGIC:
            raise ValueError(f"packed parameters: magic {magic:#06x} is not {PACK_MAGIC:#06x}")
        if length != len(data):
            raise ValueError(f"packed parameters: {len(data)} bytes, the header says {length}")
        layouts = dict(_LAYOUT.values())
        found: list[tuple[str, float]] = []
        offset, last = _HEADER.size, ""
        for _ in range(number):
            if offset + 2 > len(data):
                raise ValueError("packed parameters: cut short")
            kind, lengths = data[offset], data[offset + 1]
            common, rest = lengths & 15, (lengths >> 4) + 1
            layout = layouts.get(kind & 15)
            if kind >> 4 or layout is None or common + rest > 16 or common > len(last):
                raise ValueError(f"packed parameters: malformed entry at byte {offset}")
            offset += 2
            if offset + rest + layout.size > len(data):
                raise ValueError("packed parameters: cut short")
            last = last[:common] + data[offset : offset + rest].decode("ascii", "replace")
            offset += rest
            found.append((last, float(layout.unpack_from(data, offset)[0])))
            offset += layout.size
        return found
