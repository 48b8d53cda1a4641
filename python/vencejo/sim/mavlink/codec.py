"""MAVLink frames, in and out, on top of pymavlink's generated ardupilotmega dialect.

pymavlink packs a message for one sender, link and sequence number at a time. Telemetry goes to many links, so
the payload is packed here once (:func:`payload_of`) and framed for each link (:func:`frame`). Format:
https://mavlink.io/en/guide/serialization.html
"""

from __future__ import annotations

import functools
import struct
from collections.abc import Callable
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, TypeAlias

from pymavlink.dialects.v20 import ardupilotmega as dialect

from vencejo.sim.params import float32

__all__ = ["Decoder", "MavMessage", "Payload", "dialect", "frame", "payload_of", "source_version"]

MavMessage: TypeAlias = Any
"""A message of pymavlink's generated dialect (pymavlink has no type information)."""

_V2_HEADER = struct.Struct("<BBBBBBBHB")
_V1_HEADER = struct.Struct("<BBBBBB")
_CRC = struct.Struct("<H")
_V2_MARK = 0xFD
_V1_MARK = 0xFE


@dataclass(frozen=True, slots=True)
class Payload:
    """A packed message: the part that is the same on every link."""

    message_id: int
    crc_extra: int
    data: bytes
    """All fields, extensions included, trailing zeros not yet cut."""


class _Packer:
    """Packs the messages of one class: field values in wire order, arrays flattened."""

    __slots__ = ("crc_extra", "get", "lengths", "message_id", "pack", "single")

    def __init__(self, cls: Any) -> None:
        names = []
        self.lengths: list[int] = []
        for name, array, length in zip(cls.ordered_fieldnames, cls.array_lengths, cls.lengths, strict=True):
            text = cls.fieldtypes[cls.fieldnames.index(name)] == "char" and array
            # Text fields keep their raw bytes, padding included, next to the decoded string.
            names.append(f"_{name}_raw" if text else name)
            self.lengths.append(0 if text or not array else length)
        self.get: Callable[[MavMessage], Any] = attrgetter(*names)
        self.single = len(names) == 1
        self.pack = cls.unpacker.pack
        self.message_id = int(cls.id)
        self.crc_extra = int(cls.crc_extra)
        if not any(self.lengths):
            self.lengths = []

    def __call__(self, message: MavMessage) -> Payload:
        values = self.get(message)
        if self.single:
            values = (values,)
        if self.lengths:
            flat: list[Any] = []
            for value, length in zip(values, self.lengths, strict=True):
                if length:
                    flat.extend(value)
                else:
                    flat.append(value)
            values = flat
        try:
            data = self.pack(*values)
        except OverflowError:  # a number beyond a 32-bit float: infinite, as in the vehicle's arithmetic
            data = self.pack(*(float32(value) if isinstance(value, float) else value for value in values))
        return Payload(self.message_id, self.crc_extra, data)


_packers: dict[type, _Packer] = {}


def payload_of(message: MavMessage) -> Payload:
    """Pack a message's fields; a number beyond a 32-bit float becomes infinite.

    Raises
    ------
    struct.error
        An integer field is out of its type's range.
    """
    cls = type(message)
    packer = _packers.get(cls)
    if packer is None:
        packer = _packers[cls] = _Packer(cls)
    return packer(message)


@functools.cache
def _v1_length(message_id: int) -> int | None:
    """Payload length without MAVLink 2 extensions; None when MAVLink 1 cannot carry the message."""
    if message_id > 255:
        return None
    from pymavlink.dialects.v10 import ardupilotmega as v1

    cls = v1.mavlink_map.get(message_id)
    return None if cls is None else int(cls.unpacker.size)


def frame(
    payload: Payload, *, sequence: int, system: int, component: int, version: int, signed: bool = False
) -> bytes | None:
    """A whole frame; None for MAVLink 1 when that cannot carry the message.

    ``signed`` sets the flag that a signature follows (MAVLink 2 only).
    """
    data = payload.data
    if version == 1:
        length = _v1_length(payload.message_id)
        if length is None:
            return None
        data = data[:length]
        head = _V1_HEADER.pack(_V1_MARK, len(data), sequence, system, component, payload.message_id)
    else:
        data = data.rstrip(b"\0") or data[:1]
        message_id = payload.message_id
        head = _V2_HEADER.pack(
            _V2_MARK, len(data), int(signed), 0, sequence, system, component, message_id & 0xFFFF, message_id >> 16
        )
    body = head + data
    crc = dialect.x25crc(body[1:])
    crc.accumulate(bytes((payload.crc_extra,)))
    return body + _CRC.pack(crc.crc)


def source_version(message: MavMessage) -> int:
    """MAVLink version (1 or 2) that a received message was framed in."""
    return 1 if message.get_msgbuf()[0] == _V1_MARK else 2


class Decoder:
    """Decodes a byte stream into messages; anything that is not a valid frame is counted and skipped."""

    def __init__(self) -> None:
        self._parser = dialect.MAVLink(None)
        self._parser.robust_parsing = True
        self.bad = 0
        """Number of skipped byte sequences and of frames with a wrong checksum."""

    def feed(self, data: bytes) -> list[MavMessage]:
        """Take received bytes and return the messages they complete."""
        try:
            found = self._parser.parse_buffer(data) or []
        except Exception:  # noqa: BLE001  (whatever a hostile frame makes the parser raise: reset it)
            self._parser = dialect.MAVLink(None)
            self._parser.robust_parsing = True
            self.bad += 1
            return []
        good = []
        for message in found:
            if message.get_type() == "BAD_DATA" or message.get_type().startswith("UNKNOWN_"):
                self.bad += 1
            else:
                good.append(message)
        return good
