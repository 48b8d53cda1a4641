"""Stored parameters and plans, against those stored by a real ArduPlane."""

from __future__ import annotations

import json
import math

import pytest
from vencejo.sim.params import ParamStore, ParamType, ParamValueError
from vencejo.sim.plan_store import FenceStore, MissionResult, MissionStore, PlanStore, RallyStore, WireItem, normalise

from tests.sim.transcripts import CAPTURES, FACTS

COMMANDS = json.loads((FACTS / "arduplane-mission-commands.json").read_text(encoding="utf-8"))["commands"]
HERE = {"x": 403340000, "y": -37970000}


@pytest.mark.parametrize("fact", COMMANDS, ids=lambda fact: fact["name"])
def test_command_is_kept_as_arduplane_keeps_it(fact: dict[str, object]) -> None:
    """The item of the facts: frame 3, params 1.25 2.5 3.75 4.5, x 403355555, y −37966666, z 77.77."""
    number = fact["command"]
    assert isinstance(number, int)
    stored = normalise(WireItem(1, 3, number, 1.25, 2.5, 3.75, 4.5, 403355555, -37966666, 77.77))
    if not fact["accepted"]:
        assert stored == fact["ack"]
        return
    assert isinstance(stored, WireItem)
    found = {
        "frame": stored.frame,
        "command": stored.command,
        "param1": stored.p1,
        "param2": stored.p2,
        "param3": stored.p3,
        "param4": stored.p4,
        "x": stored.x,
        "y": stored.y,
        "z": pytest.approx(stored.z, abs=1e-4),
        "autocontinue": stored.autocontinue,
    }
    assert found == fact["read_back"]


@pytest.mark.parametrize(
    ("item", "kept"),
    [
        # as read back from ArduPlane in its own simulator
        (WireItem(1, 3, 18, p1=0.3, p3=-300.0, **HERE), {"p1": 76 / 256, "p3": -300.0, "p4": 0.0}),
        (WireItem(1, 3, 18, p1=300.0, p3=254.9, p4=-1.0, **HERE), {"p1": 255.0, "p3": 254.0}),
        (WireItem(1, 3, 16, p1=1.0, p2=300.0, **HERE, z=-33.33), {"p1": 0.0, "p2": 255.0, "z": -33.33}),
        (WireItem(1, 3, 19, p1=70000.0, p3=-1.0, **HERE), {"p1": 4464.0, "p3": -1.0}),
        (WireItem(1, 3, 93, p1=-1.0, p2=-1.0, p3=-1.0, p4=-1.0), {"p1": -1.0, "p2": -1.0, "p4": -1.0}),
        (WireItem(1, 3, 21, p4=-1.0, **HERE), {"p4": -1.0}),
        (WireItem(1, 3, 16, p4=math.nan, **HERE), {"p4": 0.0}),
        (WireItem(1, 6, 16, **HERE), {"frame": 3}),
        (WireItem(1, 2, 16, **HERE), {"frame": 0}),
        (WireItem(1, 11, 16, **HERE), {"frame": 10}),
    ],
)
def test_packing_limits(item: WireItem, kept: dict[str, float]) -> None:
    stored = normalise(item)
    assert isinstance(stored, WireItem)
    assert {name: getattr(stored, name) for name in kept} == pytest.approx(kept, abs=1e-4)


@pytest.mark.parametrize(
    ("item", "refused"),
    [
        (WireItem(1, 3, 16, p1=math.nan, **HERE), MissionResult.INVALID_PARAM1),
        (WireItem(1, 3, 16, p4=math.inf, **HERE), MissionResult.INVALID_PARAM4),
        (WireItem(1, 3, 18, p4=math.nan, **HERE), MissionResult.INVALID_PARAM4),
        (WireItem(1, 3, 16, x=950000000), MissionResult.INVALID_PARAM5_X),
        (WireItem(1, 3, 16, y=1900000000), MissionResult.INVALID_PARAM6_Y),
        (WireItem(1, 3, 16, **HERE, z=1e6), MissionResult.INVALID_PARAM7),
        (WireItem(1, 3, 16, **HERE, z=math.nan), MissionResult.INVALID_PARAM7),
        (WireItem(1, 1, 16, **HERE), MissionResult.UNSUPPORTED_FRAME),
        (WireItem(1, 3, 0, **HERE), MissionResult.INVALID),
    ],
)
def test_refusals(item: WireItem, refused: MissionResult) -> None:
    assert normalise(item) is refused


def test_jumps_must_stay_in_the_mission() -> None:
    store = MissionStore()
    store.begin(3)
    assert store.put(WireItem(0, 0, 16, **HERE), last_seq=2) is MissionResult.ACCEPTED
    assert store.put(WireItem(1, 3, 177, p1=9.0, p2=1.0), last_seq=2) is MissionResult.ERROR
    assert store.put(WireItem(1, 3, 177, p1=0.0, p2=1.0), last_seq=2) is MissionResult.ERROR
    assert store.put(WireItem(1, 3, 177, p1=2.0, p2=1.0), last_seq=2) is MissionResult.ACCEPTED


def test_home_is_item_zero_wherever_it_was_written() -> None:
    plans = PlanStore()
    plans.mission_store.set_home(40.5, -3.5, 612.34)
    assert len(plans.mission_store) == 1
    plans.mission_store.begin(2)
    plans.mission_store.put(WireItem(0, 0, 16, **HERE, z=600), last_seq=1)
    plans.mission_store.put(WireItem(1, 3, 22, p1=12.0, **HERE, z=50), last_seq=1)
    home, takeoff = plans.mission
    assert (home.lat_deg, home.lon_deg, home.alt_m) == pytest.approx((40.5, -3.5, 612.34))
    assert (takeoff.command, takeoff.p1, takeoff.frame, takeoff.alt_m) == (22, 12.0, 3, 50.0)
    assert plans.mission is plans.mission  # one view until something changes


def fence(*items: WireItem) -> tuple[FenceStore, MissionResult]:
    store = FenceStore()
    store.begin(len(items))
    for item in items:
        assert store.put(item, last_seq=len(items) - 1) is MissionResult.ACCEPTED
    return store, store.complete()


def test_fence_is_taken_whole_or_not_at_all() -> None:
    corners = [WireItem(i, 3, 5001, p1=3.0, x=403340000 + 10000 * i, y=-37970000 + 5000 * i * i) for i in range(3)]
    store, result = fence(*corners)
    assert result is MissionResult.ACCEPTED
    assert (len(store), store.vertex_total) == (3, 5)
    for bad, complaint in (
        (corners[:2], "Incorrect item count"),
        ([WireItem(0, 3, 5001, p1=2.0, **HERE), WireItem(1, 3, 5001, p1=2.0, **HERE)], "Invalid vertex count (2)"),
        ([WireItem(0, 3, 5003, p1=-5.0, **HERE)], "Non-positive circle radius"),
    ):
        store.begin(len(bad))
        for item in bad:
            store.put(item, last_seq=len(bad) - 1)
        assert store.complete() is MissionResult.ERROR
        assert [text for _, text in store.complaints] == [complaint, "Fence validation failed"]
        assert len(store) == 3  # the fence before is still there


def test_rally_points_are_whole_metres_in_three_frames() -> None:
    store = RallyStore()
    store.begin(3)
    for seq, (frame, height) in enumerate(((3, 60.9), (0, 700.0), (10, -5.5))):
        result = store.put(WireItem(seq, frame, 5100, p1=1.0, **HERE, z=height), last_seq=2)
        assert result is MissionResult.ACCEPTED
    back = [store.read(seq) for seq in range(3)]
    assert [(item.frame, item.z, item.p1, item.autocontinue) for item in back if item] == [
        (3, 60.0, 0.0, 0),
        (0, 700.0, 0.0, 0),
        (10, -5.0, 0.0, 0),
    ]
    assert [point.relative for point in store.points()] == [True, False, True]
    assert store.put(WireItem(3, 3, 5100, **HERE, z=99999.0), last_seq=3) is MissionResult.INVALID_PARAM7


def test_defaults_are_the_recorded_ones() -> None:
    params = ParamStore.arduplane()
    lines = (CAPTURES / "arduplane-params.parm").read_text(encoding="ascii").splitlines()
    assert len(lines) == len(params) == 1399
    for line in lines:
        name, value, kind = line.split()
        parameter = params.find(name)
        assert parameter is not None
        assert parameter.type == int(kind)
        assert parameter.value == pytest.approx(float(value), rel=1e-7)


def test_values_are_converted_as_the_vehicle_does() -> None:
    params = ParamStore.arduplane()
    for given, kept in ((1.6, 1.0), (0.999, 1.0), (200.0, 127.0), (-200.0, -128.0)):
        assert params.set("RTL_AUTOLAND", given).value == kept
    assert params.set("FS_LONG_TIMEOUT", 0.1).value == pytest.approx(0.1)
    assert params.at(0).type is ParamType.INT16
    before = params.revision
    for wrong in (math.nan, math.inf, 1e39):
        with pytest.raises(ParamValueError, match="should be a finite 32-bit float"):
            params.set("FS_LONG_TIMEOUT", wrong)
    with pytest.raises(KeyError):
        params.set("NOT_A_PARAM", 1)
    assert params.revision == before
    assert params.set("RTL_AUTOLAND", 1).value == 1.0
    assert params.revision == before + 1


def test_an_unsaved_value_is_read_until_it_is_loaded_or_set() -> None:
    params = ParamStore.arduplane()
    params.set_unsaved("TRIM_THROTTLE", 63.0)
    params.set_unsaved("TRIM_THROTTLE", 64.0)
    assert (params.get("TRIM_THROTTLE"), params.revision) == (64.0, 2)
    params.load("TRIM_THROTTLE")
    params.load("MIN_GROUNDSPEED")
    assert (params.get("TRIM_THROTTLE"), params.revision) == (50.0, 3)
    params.set_unsaved("TRIM_THROTTLE", 64.0)
    params.set("TRIM_THROTTLE", 55.0)
    params.load("TRIM_THROTTLE")
    assert params.get("TRIM_THROTTLE") == 55.0


@pytest.mark.parametrize("block_size", [1, 7, 80, 239])
def test_packed_values_never_cross_a_block(block_size: int) -> None:
    data = ParamStore.arduplane().pack(block_size=block_size)
    sizes = {1: 1, 2: 2, 3: 4, 4: 4}
    offset, name, count = 6, b"", 0
    while offset < len(data):
        if data[offset] == 0:
            offset += 1
            continue
        size = sizes[data[offset] & 15]
        common, rest = data[offset + 1] & 15, (data[offset + 1] >> 4) + 1
        name = name[:common] + data[offset + 2 : offset + 2 + rest]
        value_at = offset + 2 + rest
        if size <= block_size:
            assert value_at // block_size == (value_at + size - 1) // block_size, name
        offset = value_at + size
        count += 1
    assert count == 1399


def test_packed_range_and_defaults() -> None:
    params = ParamStore.arduplane({"AUTOTUNE_LEVEL": 9})
    data = params.pack(block_size=239, start=1, count=2, with_defaults=True)
    assert data == (
        b"\x1c\x67\x02\x00\x77\x05\x11\xd0AUTOTUNE_LEVEL\x09\x06" + b"\x03\x69OPTIONS\0\0\0\0".replace(b"\x69", b"\x69")
    )


def test_uploaded_parameters_are_read_or_refused() -> None:
    params = ParamStore.arduplane()
    body = b"\x01\xd0AUTOTUNE_LEVEL\x07" + b"\x02\x80WP_RADIUS\x1e\x00"
    data = b"\x1b\x67\x02\x00" + (6 + len(body)).to_bytes(2, "little") + body
    assert params.unpack(data) == [("AUTOTUNE_LEVEL", 7.0), ("WP_RADIUS", 30.0)]
    for bad in (b"", data[:-1], b"\0" + data[1:], data[:4] + (300).to_bytes(2, "little") + body):
        with pytest.raises(ValueError, match="packed parameters"):
            params.unpack(bad)
