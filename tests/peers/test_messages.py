"""Raw messages by field name, compared with pymavlink, which is generated from MAVLink's definitions."""

from __future__ import annotations

import itertools
import pickle
import random
import struct
from typing import Any

import pytest
import vencejo
from pymavlink.dialects.v20 import ardupilotmega

from tests.faults.mock import MockPlane
from tests.support import wait_for

pytestmark = pytest.mark.peer


def a_value(kind: str, rng: random.Random) -> Any:
    if kind == "char":
        return rng.choice(b"ABCxyz_09")
    if kind in {"float", "double"}:
        return struct.unpack("<f", struct.pack("<f", rng.uniform(-1e6, 1e6)))[0]
    bits, is_signed = int(kind.strip("uint_")), kind.startswith("int")
    return rng.randrange(-(1 << (bits - 1)), 1 << (bits - 1)) if is_signed else rng.randrange(1 << bits)


def test_every_field_of_every_message_is_read() -> None:
    rng = random.Random(7)
    for message_id, kind in ardupilotmega.mavlink_map.items():
        wanted: dict[str, Any] = {}
        packed: list[Any] = []
        for name, length, is_array in zip(kind.ordered_fieldnames, kind.lengths, kind.array_lengths, strict=True):
            of = kind.fieldtypes[kind.fieldnames.index(name)]
            values = [a_value(of, rng) for _ in range(max(length, is_array))]
            if of == "char":
                wanted[name] = bytes(values).decode()
                packed += [bytes(values)]
            else:
                wanted[name] = values if is_array else values[0]
                packed += values
        payload = kind.unpacker.pack(*packed)
        assert vencejo.MavlinkMessage(kind.msgname, 1, 1, 0.0, message_id, payload).fields == wanted, kind.msgname
        # Trailing zeros are truncated in MAVLink 2.
        cut = vencejo.MavlinkMessage(kind.msgname, 1, 1, 0.0, message_id, payload[:1])
        assert set(cut.fields) == set(kind.fieldnames), kind.msgname
    unknown = vencejo.MavlinkMessage("UNKNOWN_16777215", 1, 1, 0.0, 0xFFFFFF, b"ab")
    assert unknown.fields == {"payload": b"ab"}


def test_a_message_is_a_value() -> None:
    message = vencejo.MavlinkMessage("SYSTEM_TIME", 1, 2, 3.5, 2, b"\x01")
    assert message.fields["time_unix_usec"] == 1
    same = pickle.loads(pickle.dumps(message))
    assert (same, hash(same)) == (message, hash(message))
    assert same != vencejo.MavlinkMessage("SYSTEM_TIME", 1, 2, 3.5, 2, b"\x02")
    other: object = "SYSTEM_TIME"
    assert message != other
    assert repr(message) == (
        "MavlinkMessage(name='SYSTEM_TIME', system_id=1, component_id=2, time_s=3.5, id=2, payload=b'\\x01')"
    )
    with pytest.raises(AttributeError):
        message.id = 3  # type: ignore[misc]
    with pytest.raises(TypeError):
        message.fields["time_unix_usec"] = 2  # type: ignore[index]


def test_values_of_python_become_those_of_the_wire() -> None:
    with MockPlane() as mock, vencejo.connect(mock.link, record=False) as plane:

        def sent(name: str, **fields: Any) -> Any:
            before = len(mock.received)
            plane.send_message(name, **fields)
            wait_for(lambda: any(heard == name for heard, _ in mock.received[before:]), name)
            return next(message for heard, message in mock.received[before:] if heard == name)

        text = sent("STATUSTEXT", severity=6, text="a text", id=None)
        assert (text.severity, text.text, text.id) == (6, "a text", 0)
        assert sent("STATUSTEXT", text=b"B\xff").text.startswith("B")
        area = sent("TUNNEL", payload=b"\x00\xff\x10", payload_length=3, target_component=42)
        assert (area.payload[:4], area.target_system, area.target_component) == ([0, 255, 16, 0], 1, 42)
        point = sent("SET_POSITION_TARGET_GLOBAL_INT", lat_int=-5, alt=12, vx=True)
        assert (point.lat_int, point.alt, point.vx, point.target_system) == (-5, 12.0, 1.0, 1)
        itself: list[Any] = []
        itself.append(itself)
        for name, fields in (
            ("TUNNEL", {"payload": itself}),
            ("TUNNEL", {"payload": itertools.count()}),
            ("TUNNEL", {"payload": [256]}),
            ("TUNNEL", {"payload": [0] * 129}),
            ("STATUSTEXT", {"text": "x" * 51}),
            ("STATUSTEXT", {"severity": 1.5}),
            ("ATTITUDE", {"roll": 1e300}),
            ("ATTITUDE", {"roll": object()}),
            ("ATTITUDE", {"roll": [1.0]}),
        ):
            with pytest.raises(vencejo.InvalidRequest, match=f"{name}.{next(iter(fields))}"):
                plane.send_message(name, **fields)
