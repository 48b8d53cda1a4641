"""Fields of raw MAVLink messages by name, for the escape hatch: reading any message and sending any message.

Field layouts come from pymavlink's generated dialect, so that names and values are those that the field knows: enums
and bit masks are integers, texts are strings without trailing zeros, arrays are lists. It is imported on first use.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from vencejo.errors import InvalidRequest

__all__ = ["decode_payload", "encode_payload", "field_names"]


@cache
def _dialect() -> Any:
    from pymavlink.dialects.v20 import ardupilotmega

    return ardupilotmega


@cache
def _class_by_name(name: str) -> Any:
    for message_class in _dialect().mavlink_map.values():
        if message_class.msgname == name:
            return message_class
    raise InvalidRequest(f"'{name}' is no message of the ardupilotmega dialect; names are like 'COMMAND_LONG'")


def field_names(name: str) -> tuple[str, ...]:
    """The fields of a message by its name, in the order of its definition.

    Raises
    ------
    InvalidRequest
        When the dialect does not have it.
    """
    return tuple(_class_by_name(name).fieldnames)


def decode_payload(message_id: int, payload: bytes) -> dict[str, Any]:
    """Read a payload's fields, in the order of the message definition. Zeros cut off its end are put back.

    An id that the dialect does not have gives ``{"payload": payload}``.
    """
    message_class = _dialect().mavlink_map.get(message_id)
    if message_class is None:
        return {"payload": payload}
    size = message_class.unpacker.size
    values = list(message_class.unpacker.unpack(payload[:size].ljust(size, b"\0")))
    by_name: dict[str, Any] = {}
    for name, length in zip(message_class.ordered_fieldnames, message_class.lengths, strict=True):
        taken, values = values[:length], values[length:]
        if length == 1 and isinstance(taken[0], bytes):
            by_name[name] = taken[0].split(b"\0", 1)[0].decode("utf-8", "replace")
        else:
            by_name[name] = taken[0] if length == 1 else taken
    return {name: by_name[name] for name in message_class.fieldnames}


def encode_payload(name: str, fields: Mapping[str, Any]) -> tuple[int, bytes]:
    """Write a message's fields as a payload; those not given are zero.

    Returns
    -------
    tuple of (int, bytes)
        Message id and payload.

    Raises
    ------
    InvalidRequest
        For a message or field that does not exist, or a value that does not fit.
    """
    message_class = _class_by_name(name)
    unknown = sorted(set(fields) - set(message_class.fieldnames))
    if unknown:
        known = ", ".join(message_class.fieldnames)
        raise InvalidRequest(f"{name} has no field {', '.join(map(repr, unknown))}; it has {known}")
    zeros = message_class.unpacker.unpack(bytes(message_class.unpacker.size))
    values: list[Any] = []
    for field_name, length in zip(message_class.ordered_fieldnames, message_class.lengths, strict=True):
        default = zeros[len(values) : len(values) + length]
        given = fields.get(field_name)
        if given is None:
            values.extend(default)
        elif isinstance(default[0], bytes):
            values.append(given.encode("utf-8") if isinstance(given, str) else bytes(given))
        elif length == 1:
            values.append(given)
        else:
            given = list(given)
            if len(given) > length:
                raise InvalidRequest(f"{name}.{field_name} holds {length} values, not {len(given)}")
            values.extend([*given, *default[len(given) :]])
    try:
        return int(message_class.id), bytes(message_class.unpacker.pack(*values))
    except Exception as error:
        raise InvalidRequest(f"{name}: a value does not fit its field: {error}") from error
