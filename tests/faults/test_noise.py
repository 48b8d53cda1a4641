"""Data that no aircraft would send: absurd values in every field, and a flood of ids."""

from __future__ import annotations

import dataclasses
import gc
import math
import resource
from typing import Any

import pytest
import vencejo
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from tests.faults.mock import MockPlane
from tests.faults.test_links import resident_bytes
from tests.support import wait_for

INTEGERS = {
    "int8_t": (-(2**7), 2**7 - 1),
    "int16_t": (-(2**15), 2**15 - 1),
    "int32_t": (-(2**31), 2**31 - 1),
    "int64_t": (-(2**63), 2**63 - 1),
    "uint8_t": (0, 2**8 - 1),
    "uint16_t": (0, 2**16 - 1),
    "uint32_t": (0, 2**32 - 1),
    "uint64_t": (0, 2**64 - 1),
    "uint8_t_mavlink_version": (3, 3),
}
REALS = (math.nan, math.inf, -math.inf, 3.4e38, -3.4e38)
LAT_91 = 910_000_000


def absurd(message_class: Any, variant: int) -> Any:
    """Return a message with extreme values only."""
    values: list[Any] = []
    lengths = dict(zip(message_class.ordered_fieldnames, message_class.array_lengths, strict=True))
    for name, kind in zip(message_class.fieldnames, message_class.fieldtypes, strict=True):
        length = lengths[name]
        if kind == "char":
            values.append((b"\xff" if variant % 2 else b"\x1b[31m<script>")[: max(length, 1)])
            continue
        if kind in ("float", "double"):
            value: Any = REALS[variant % len(REALS)]
        elif name == "lat" and variant == 0:
            value = LAT_91 if kind == "int32_t" else INTEGERS[kind][0]
        else:
            value = INTEGERS[kind][variant % 2]
        values.append([value] * length if length else value)
    return message_class(*values)


def walk(value: Any) -> list[float]:
    """Yield every number in a structure."""
    if isinstance(value, dict):
        return [number for each in value.values() for number in walk(each)]
    if isinstance(value, (list, tuple)):
        return [number for each in value for number in walk(each)]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return walk(dataclasses.asdict(value))
    return [value] if isinstance(value, float) else []


@pytest.mark.fault(
    24, figure="5 extremes in all fields of more than 200 messages: every number finite, every place on Earth"
)
def test_absurd_telemetry_is_never_shown() -> None:
    with MockPlane() as mock, vencejo.connect(mock.link, record=False) as plane:
        events: list[vencejo.Event] = []
        plane.on_event(events.append)
        writer = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        told = {"HEARTBEAT", "SYSTEM_TIME", "SETUP_SIGNING"}
        classes = [each for each in mavlink.mavlink_map.values() if each.msgname not in told]
        assert len(classes) > 200
        for variant in range(5):
            sent = 0
            before = plane.station.links[0].frames_received
            for message_class in classes:
                data = absurd(message_class, variant).pack(writer)
                mock.do(lambda data=data: mock.say(bytes(data)))  # type: ignore[misc]
                sent += 1
            wait_for(
                lambda sent=sent, before=before: plane.station.links[0].frames_received >= before + sent,  # type: ignore[misc]
                "all of them",
            )
            telemetry = plane.telemetry
            numbers = [
                *walk(telemetry.to_dict()),
                *walk(dataclasses.asdict(plane.mission_progress)),
                *walk([dict(event.detail) for event in list(events)]),
            ]
            assert numbers
            assert all(math.isfinite(number) for number in numbers), variant
            for group in (telemetry.position, telemetry.gps, telemetry.home):
                if group is not None:
                    assert group.lat_deg is None or abs(group.lat_deg) <= 90.0
                    assert group.lon_deg is None or abs(group.lon_deg) <= 180.0
            repr(plane)
        assert telemetry.invalid_values > 20
        # The next valid values are accepted.
        good = mavlink.MAVLink_global_position_int_message(
            70_000, 403_332_000, -37_978_000, 650_000, 50_000, 0, 0, 0, 0
        )
        mock.do(lambda: mock.say(good))
        plane.wait_until(
            lambda now: now.position is not None and now.position.lat_deg == 40.3332, timeout_s=120, what="the position"
        )
        assert plane.params["WP_RADIUS"] == 50.0
        assert mock.acts() == []


FLOOD_PER_S = 5_000
"""Rate of the flood of ids, messages per second."""


def computed_s() -> float:
    """Return the CPU time of this process, over all threads."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


@pytest.mark.fault(
    25,
    figure="65,024 heartbeats: ≤ 64 vehicles, < 50 MB more, less CPU than half the time they take at 5,000 a second, the real vehicle answers",
)
def test_a_flood_of_ids_is_bounded() -> None:
    class Out:
        def __init__(self) -> None:
            self.data = bytearray()

        def write(self, data: bytes) -> None:
            self.data += data

    with MockPlane() as mock, vencejo.connect(mock.link, record=False) as plane:
        out = Out()
        for system in range(1, 256):
            writer = mavlink.MAVLink(out, srcSystem=system)
            for component in range(1, 256):
                if (system, component) != (1, 1):
                    writer.srcComponent = component
                    writer.heartbeat_send(1, 3, 1, 0, 4)
        gc.collect()
        memory = resident_bytes()
        frames, began_s = plane.station.links[0].frames_received, computed_s()
        for start in range(0, len(out.data), 100_000):
            chunk = bytes(out.data[start : start + 100_000])
            mock.do(lambda chunk=chunk: mock.say(chunk))  # type: ignore[misc]
        wait_for(lambda: plane.station.links[0].frames_received >= frames + 65_024, "the flood")
        # No queue grows because of it, and messages of the real vehicle are not delayed.
        assert computed_s() - began_s < 65_024 / FLOOD_PER_S / 2
        assert 1 < len(plane.station.vehicles) <= 64
        assert resident_bytes() - memory < 50 << 20
        assert plane.params["WP_RADIUS"] == 50.0
        plane.wait_until(
            lambda now: now.heartbeat is not None and now.heartbeat.freshness == "fresh",
            timeout_s=120,
            what="the real vehicle's heartbeat",
        )
        assert mock.acts() == []
