"""One plane's MAVLink half with an autopilot double: commands, streams, failsafe, fence, radio, reboot, noise."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import Any

import pytest
from vencejo.sim.autopilot.interface import FenceBreach, LandedState, MavResult, Mode, Severity, StoredItem
from vencejo.sim.autopilot.testing import item
from vencejo.sim.config import SimOptions
from vencejo.sim.fence import FenceType
from vencejo.sim.mavlink.codec import dialect
from vencejo.sim.world import MemoryLink, World

from tests.sim.flying import mission, waypoint
from tests.sim.transcripts import double, listen, outline, settled_world

ACK = {"COMMAND_ACK": ("command", "result")}


def long(number: int, *params: float, system: int = 1, component: int = 1) -> Any:
    return dialect.MAVLink_command_long_message(system, component, number, 0, *(*params, *[0.0] * (7 - len(params))))


def integer(number: int, frame: int, params: tuple[float, ...] = (), x: int = 0, y: int = 0, z: float = 0.0) -> Any:
    four = (*params, *[0.0] * (4 - len(params)))
    return dialect.MAVLink_command_int_message(1, 1, frame, number, 0, 0, *four, x, y, z)


def ask(world: World, station: MemoryLink, message: Any) -> tuple[int, list[Any]]:
    """Send a command; returns its result, and all received messages."""
    station.receive()
    station.send(message)
    heard = listen(world, station, 0.02)
    acks = [m for m in heard if m.get_type() == "COMMAND_ACK"]
    assert [m.command for m in acks] == [message.command]
    return acks[0].result, heard


@pytest.mark.parametrize(
    ("message", "result"),
    [
        # results of ArduPlane in its own simulator, plane standing in MANUAL
        (integer(42, 3), 3),
        (long(9999), 3),
        (long(511, 74, -1), 0),
        (long(511, 74, -5), 2),
        (long(511, 74, 100), 2),
        (long(511, 9999, 100000), 2),
        (long(510, 74), 0),
        (long(510, 9999), 4),
        (long(512, 245), 0),
        (long(512, 9999), 4),
        (long(519, 1), 3),
        (long(520, 1), 0),
        (long(410), 0),
        (long(179, 1), 0),
        (long(179, 0, 0, 0, 0, 40.334, -3.797, 610), 0),
        (integer(179, 3, (), 403340000, -37970000, 5), 0),
        (long(179, 2, 0, 0, 0, 1, 1), 4),
        (long(192, -1, 1, 0, 0, 40.334, -3.797, 50), 3),
        (integer(192, 3, (-1.0,), 2000000000, 0, 50), 2),
        (integer(192, 3, (-1.0,), 403340000, -37970000, 50), 4),
        (long(178, 0, 15, -1), 4),
        (long(186, 50, 3), 0),
        (long(186, 50, 99), 2),
        (long(43000, 0, 15), 4),
        (long(193, 1), 3),
        (long(300), 0),
        (long(300, 1, 2), 2),
        (long(207, 1), 4),
        (long(207, 0), 0),
        (long(207, 7), 4),
        (long(176, 0, 10), 2),
        (long(176, 1, 99), 4),
        (long(400, 2), 3),
        (long(224, 50), 2),
        (long(241, 1), 0),
        (long(241), 3),
        (long(245, 0), 2),
        (long(22, 0, 0, 0, 0, 0, 0, 50), 4),
        (integer(22, 3, z=50), 2),
        (long(32), 2),
        (long(520), 4),
        (long(179, 0, 0, 0, 0, 91, 0, 10), 4),
        (integer(179, 10, (), 403340000, -37970000, 5), 4),
        # equipment that it does not have
        (long(181, 0, 1), 0),
        (long(181, 5, 1), 4),
        (long(183, 5, 1500), 0),
        (long(183, 33, 1500), 4),
        (long(203), 0),
        (long(205, -10, 0, 0, 0, 0, 0, 2), 4),
        (long(209), 4),
        (long(211, 1, 1), 4),
        (long(216, 1), 4),
        (long(218, 9, 2), 0),
        (long(223, 1), 4),
        (long(531, 1, 2), 3),
        (long(532), 2),
        (long(532, 1, 1), 4),
        (long(534, 0, 1), 2),
        (long(1000, -10), 4),
        (long(2500), 4),
    ],
    ids=str,
)
def test_command_is_answered_as_arduplane_answers_it(message: Any, result: int) -> None:
    world, station = settled_world()
    assert ask(world, station, message)[0] == result


@pytest.mark.parametrize(
    ("message", "text"),
    [
        (long(183, 1, 1500), (6, "ServoRelayEvent: Channel 1 is already in use")),
        (long(218), (6, "Invalid channel option (0)")),
        (long(3000, 3), (5, "VTOL not available")),
    ],
    ids=str,
)
def test_a_refused_command_is_explained_in_arduplanes_words(message: Any, text: tuple[int, str]) -> None:
    world, station = settled_world()
    result, heard = ask(world, station, message)
    assert result == MavResult.FAILED
    assert text in [(m.severity, m.text) for m in heard if m.get_type() == "STATUSTEXT"]


@pytest.mark.parametrize(
    ("afs_enable", "p1", "result", "text"),
    [
        (0, 1, MavResult.FAILED, "AFS not enabled, can't terminate the vehicle"),
        (0, 0, MavResult.FAILED, "AFS not enabled, can't terminate the vehicle"),
        (1, 1, MavResult.FAILED, "Unable to terminate, termination is not configured"),
        (1, 0, MavResult.ACCEPTED, "Aborting termination due to GCS request"),
    ],
)
def test_a_termination_is_answered_by_what_is_configured(afs_enable: int, p1: int, result: int, text: str) -> None:
    """AP_AdvancedFailsafe::gcs_terminate."""
    world, station = flying_world(mission())
    world.planes[0].params.set("AFS_ENABLE", afs_enable)
    world.advance(0.1)
    answer, heard = ask(world, station, long(185, p1))
    assert answer == result
    assert "".join(m.text for m in heard if m.get_type() == "STATUSTEXT") == text


def test_an_unknown_frame_is_named() -> None:
    world, station = settled_world()
    result, heard = ask(world, station, long(186, 50, 7))
    assert result == MavResult.DENIED
    assert "Unknown mavlink coordinate frame 7" in [m.text for m in heard if m.get_type() == "STATUSTEXT"]


def test_internal_parameters_are_not_set() -> None:
    """GCS_MAVLINK::handle_param_set: a text, PARAM_ERROR 3 and the present value."""
    world, station = settled_world()
    station.send(dialect.MAVLink_param_set_message(1, 1, b"MIS_TOTAL", 5.0, 4))
    heard = listen(world, station, 0.1)
    told = outline(heard, {"STATUSTEXT": ("text",), "PARAM_ERROR": ("error",), "PARAM_VALUE": ("param_value",)})
    assert told == [("PARAM_ERROR", 3), ("PARAM_VALUE", 1.0), ("STATUSTEXT", "Param write denied (MIS_TOTAL)")]
    store = world.planes[0].params
    for name in (store.at(index).name for index in range(len(store))):
        station.send(dialect.MAVLink_param_set_message(1, 1, name.encode(), store.get(name), 9))
    denied = {m.param_id for m in listen(world, station, 0.1) if m.get_type() == "PARAM_ERROR"}
    # AP_PARAM_FLAG_INTERNAL_USE_ONLY; the SIM_MAGn_DEVID do not have it.
    barometers = {f"BARO{number}_{name}" for number in (1, 2, 3) for name in ("DEVID", "GND_PRESS")}
    assert denied == {"MIS_TOTAL", "ARSPD_DEVID"} | barometers


def send_fence(world: World, station: MemoryLink, *items: tuple[int, float, int, int]) -> int:
    """Upload fence items (command, parameter 1, x, y); returns the number read back half a second later."""
    station.send(dialect.MAVLink_mission_count_message(1, 1, len(items), 1))
    for seq, (command, p1, x, y) in enumerate(items):
        station.send(dialect.MAVLink_mission_item_int_message(1, 1, seq, 3, command, 0, 1, p1, 0, 0, 0, x, y, 0, 1))
    acks = [m for m in listen(world, station, 0.5) if m.get_type() == "MISSION_ACK"]
    assert [ack.type for ack in acks] == [0]
    station.send(dialect.MAVLink_mission_request_list_message(1, 1, 1))
    return int(next(m.count for m in listen(world, station, 0.05) if m.get_type() == "MISSION_COUNT"))


def test_a_circle_that_replaces_a_polygon_is_accepted_and_erased() -> None:
    """AC_PolyFence_loader::update; seen in ArduPlane 4.8-dev: the same upload once more stays."""
    world, station = settled_world()
    square = [(5001, 4.0, 403300000 + n, -37950000 + e) for n, e in ((0, 0), (60000, 0), (60000, 60000), (0, 60000))]
    circle = (5003, 500.0, 403332000, -37978000)
    assert send_fence(world, station, *square) == 4
    assert send_fence(world, station, circle) == 0
    assert send_fence(world, station, circle) == 1
    assert send_fence(world, station, *square, circle) == 5
    station.send(dialect.MAVLink_param_set_message(1, 1, b"FENCE_TOTAL", 0.0, 2))
    listen(world, station, 0.2)
    assert not world.planes[0].plans.fence_store.shapes


def test_a_cleared_fence_is_indexed_too() -> None:
    world, station = settled_world()
    station.send(dialect.MAVLink_mission_clear_all_message(1, 1, 1))
    heard = listen(world, station, 0.1)
    assert outline(heard, {"STATUSTEXT": ("text",)}) == [("STATUSTEXT", "Fence Indexed OK")]


@pytest.mark.parametrize("position", range(7))
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 3e38])
def test_no_command_is_upset_by_a_wild_number(position: int, value: float) -> None:
    world, station = settled_world()
    for number in [*range(16, 1001), 2000, 2500, 42428, 43000, 43001, 43002]:
        params = [0.0] * 7
        params[position] = value
        station.send(long(number, *params))
        station.receive()
    assert world.planes[0].snapshot().mode in set(Mode)


def test_commands_for_others_are_left_alone() -> None:
    world, station = settled_world()
    for message in (long(400, 1, system=2), long(400, 1, component=154)):
        station.send(message)
    assert not [m for m in listen(world, station, 0.1) if m.get_type() == "COMMAND_ACK"]
    station.send(long(512, 245, system=0, component=0))
    assert outline(listen(world, station, 0.02), ACK) == [("COMMAND_ACK", 512, 0)]


def test_message_interval_is_kept_in_simulated_time() -> None:
    world, station = settled_world()
    station.send(dialect.MAVLink_request_data_stream_message(1, 1, 0, 1, 0))
    assert ask(world, station, long(511, 30, 100_000))[0] == 0
    assert ask(world, station, long(511, 33, 500_000))[0] == 0
    station.receive()
    heard = listen(world, station, 10.0)
    counts = {kind: sum(m.get_type() == kind for m in heard) for kind in ("ATTITUDE", "GLOBAL_POSITION_INT", "VFR_HUD")}
    assert counts == {"ATTITUDE": 100, "GLOBAL_POSITION_INT": 20, "VFR_HUD": 0}
    assert sum(m.get_type() == "HEARTBEAT" for m in heard) == 10
    _, heard = ask(world, station, long(510, 30))
    assert [m.interval_us for m in heard if m.get_type() == "MESSAGE_INTERVAL"] == [100_000]


def test_streams_are_per_link_and_no_faster_than_the_main_loop() -> None:
    world, one = settled_world()
    two = world.connect(system=254)
    one.send(dialect.MAVLink_request_data_stream_message(1, 1, 10, 50, 1))
    two.send(dialect.MAVLink_request_data_stream_message(1, 1, 0, 1, 0))
    listen(world, one, 0.5)
    two.receive()
    heard = listen(world, one, 10.0)
    # SCHED_LOOP_RATE is 50 Hz, of which 0.8 may be used; a message leaves on a tick of 10 ms.
    assert 330 <= sum(m.get_type() == "ATTITUDE" for m in heard) <= 400
    assert not [m for m in two.receive() if m.get_type() == "ATTITUDE"]


def test_long_texts_come_in_chunks() -> None:
    world, station = settled_world()
    text = "x" * 49 + "é" + "y" * 60
    world.planes[0].say(Severity.INFO, text)
    chunks = [m for m in station.receive() if m.get_type() == "STATUSTEXT"]
    assert [(m.id, m.chunk_seq) for m in chunks] == [(1, 0), (1, 1), (1, 2)]
    assert b"".join(m._text_raw.rstrip(b"\0") for m in chunks).decode() == text
    world.planes[0].say(Severity.INFO, "z" * 50)
    (whole,) = [m for m in station.receive() if m.get_type() == "STATUSTEXT"]
    assert (whole.id, whole.chunk_seq, whole.text) == (0, 0, "z" * 50)


def mission_with_landing(world: World, station: MemoryLink) -> None:
    items = [(16, 0), (22, 3), (189, 3), (21, 3)]
    station.send(dialect.MAVLink_mission_count_message(1, 1, len(items), 0))
    for seq, (command, frame) in enumerate(items):
        station.send(
            dialect.MAVLink_mission_item_int_message(
                1, 1, seq, frame, command, 0, 1, 0, 0, 0, 0, 403340000, -37970000, 50, 0
            )
        )
    assert len(world.planes[0].plans.mission_store) == 4


def test_prearm_reasons_have_arduplanes_words() -> None:
    world, station = settled_world()
    mission_with_landing(world, station)
    result, heard = ask(world, station, long(400, 1))
    assert result == 4
    texts = [(m.severity, m.text) for m in heard if m.get_type() == "STATUSTEXT"]
    assert texts == [(2, "Arm: DO_LAND_START set and RTL_AUTOLAND disabled")]
    _, heard = ask(world, station, long(401))
    prearm = [m.text for m in heard if m.get_type() == "STATUSTEXT"]
    assert "".join(prearm) == "PreArm: DO_LAND_START set and RTL_AUTOLAND disabled"
    world.advance(1.0)
    prearm_bit = 1 << 28
    _, heard = ask(world, station, long(512, 1))
    assert not next(m for m in heard if m.get_type() == "SYS_STATUS").onboard_control_sensors_health & prearm_bit
    station.send(dialect.MAVLink_param_set_message(1, 1, b"RTL_AUTOLAND", 2, 9))
    listen(world, station, 0.3)
    _, heard = ask(world, station, long(512, 1))
    assert next(m for m in heard if m.get_type() == "SYS_STATUS").onboard_control_sensors_health & prearm_bit
    assert ask(world, station, long(400, 1))[0] == 0


def prearm_texts(world: World, station: MemoryLink, seconds: float) -> int:
    """Number of failing checks told meanwhile."""
    heard = listen(world, station, seconds)
    return sum(m.get_type() == "STATUSTEXT" and m.text.startswith("PreArm: ") for m in heard)


def test_prearm_fails_are_told_when_they_begin_and_every_half_minute() -> None:
    """AP_Arming::update. The mode's own check is not among those that are told when they begin."""
    world, station = settled_world()
    mission_with_landing(world, station)
    assert prearm_texts(world, station, 5.0) == 1
    assert prearm_texts(world, station, 90.0) == 3
    world, station = settled_world()
    assert ask(world, station, long(176, 1, Mode.RTL))[0] == MavResult.ACCEPTED
    assert prearm_texts(world, station, 20.0) == 0
    assert prearm_texts(world, station, 10.0) == 1


@pytest.mark.parametrize(
    ("parameter", "value", "reason"),
    [
        ("BATT_ARM_VOLT", 13.0, "Battery 1 below minimum arming voltage"),
        ("BATT_LOW_VOLT", 13.0, "Battery 1 low voltage failsafe"),
        ("ROLL_LIMIT_DEG", 1.0, "ROLL_LIMIT_DEG too small (1.0)"),
        ("AIRSPEED_MIN", 3.0, "AIRSPEED_MIN too low (3 < 5)"),
        ("ARMING_MIS_ITEMS", 1.0, "Missing mission item: Land"),
    ],
)
def test_prearm_parameters(parameter: str, value: float, reason: str) -> None:
    world, _ = settled_world()
    assert double(world).prearm() == []
    world.planes[0].params.set(parameter, value)
    assert double(world).prearm() == [reason]


def test_prearm_waits_for_the_estimator_and_the_mode() -> None:
    world, _ = settled_world()
    double(world).set_mode(Mode.RTL)
    world.advance(0.02)
    assert double(world).prearm() == ["RTL mode not armable"]
    double(world).in_landing = True
    world.advance(0.02)
    assert double(world).prearm() == ["In landing sequence", "RTL mode not armable"]
    double(world).radio_lost = True
    world.advance(0.02)
    assert double(world).prearm()[0] == "Radio failsafe on"
    double(world).reboot()
    world.advance(0.02)
    assert double(world).prearm() == ["AHRS: not using configured AHRS type", "GPS 1: Bad fix"]
    world.planes[0].params.set("ARMING_SKIPCHK", -1)
    assert double(world).prearm() == []
    double(world).set_mode(Mode.RTL)
    world.advance(0.02)
    assert double(world).prearm() == [], "all checks are skipped, that of the mode too"


def heartbeat(station: MemoryLink) -> None:
    station.send(dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3))


def gcs_calls(world: World) -> list[object]:
    return [call[1] for call in double(world).calls if call[0] == "failsafe_gcs"]


def test_gcs_failsafe_counts_only_its_station() -> None:
    world, station = settled_world()
    other = world.connect(system=254)
    world.planes[0].params.set("FS_GCS_ENABL", 1)
    listen(world, station, 20.0)
    assert gcs_calls(world) == []  # no heartbeat yet, so none is missed
    heartbeat(station)
    for _ in range(8):
        heartbeat(other)
        listen(world, station, 1.0)
    assert gcs_calls(world) == [True]
    heartbeat(station)
    listen(world, station, 0.2)
    assert gcs_calls(world) == [True, False]


@pytest.mark.parametrize(("enabled", "mode", "acts"), [(0, 10, False), (3, 0, False), (3, 10, True), (2, 0, True)])
def test_gcs_failsafe_modes(enabled: int, mode: int, acts: bool) -> None:
    world, station = settled_world()
    world.planes[0].params.set("FS_GCS_ENABL", enabled)
    double(world).set_mode(mode)
    heartbeat(station)
    listen(world, station, 4.8)
    assert gcs_calls(world) == []
    listen(world, station, 0.5)
    assert gcs_calls(world) == ([True] if acts else [])


def fence_calls(world: World) -> list[object]:
    return [call[1] for call in double(world).calls if call[0] == "fence_breached"]


def polygon(world: World, station: MemoryLink) -> None:
    corners = [(40.32, -3.81), (40.32, -3.78), (40.345, -3.78), (40.345, -3.81)]
    station.send(dialect.MAVLink_mission_count_message(1, 1, 4, 1))
    for seq, (lat, lon) in enumerate(corners):
        station.send(
            dialect.MAVLink_mission_item_int_message(
                1, 1, seq, 0, 5001, 0, 1, 4, 0, 0, 0, round(lat * 1e7), round(lon * 1e7), 0, 1
            )
        )
    assert len(world.planes[0].plans.fence_store.shapes) == 1


def test_fence_breach_and_recovery() -> None:
    world, station = settled_world()
    polygon(world, station)
    autopilot = double(world)
    # A fence is loaded at the first fix; before, there is none to enable.
    autopilot.settled = False
    world.planes[0].fence.reset()
    assert ask(world, station, long(207, 1))[0] == 4
    autopilot.settled = True
    listen(world, station, 0.2)
    assert ask(world, station, long(512, 162))[0] == 0
    assert not [m for m in station.receive() if m.get_type() == "FENCE_STATUS"]
    assert ask(world, station, long(207, 1))[0] == 0
    autopilot.armed = autopilot.flying = True
    autopilot.landed_state = LandedState.IN_AIR
    listen(world, station, 0.5)
    assert fence_calls(world) == []
    autopilot.lat_deg = 40.3455
    listen(world, station, 0.5)
    assert double(world).calls[-1] == ("fence_breached", FenceBreach.POLYGON, pytest.approx((40.3325, -3.795)))
    _, heard = ask(world, station, long(512, 162))
    (status,) = [m for m in heard if m.get_type() == "FENCE_STATUS"][:1]
    assert (status.breach_status, status.breach_count, status.breach_type) == (1, 1, 3)
    autopilot.lat_deg = 40.3332
    listen(world, station, 0.5)
    assert fence_calls(world) == [FenceBreach.POLYGON, None]


GOTO = {"lat": 403340000, "lon": -37970000, "alt": 50.0, "frame": 3}


@pytest.mark.parametrize(
    ("order", "result"),
    [
        ({}, 0),
        ({"lat": 403500000}, 2),  # outside the polygon
        ({"lon": -37940000}, 2),  # and outside the circle
        ({"alt": 121.0}, 2),
        ({"alt": 721.0, "frame": 0}, 2),
        ({"alt": 700.0, "frame": 0}, 0),
        ({"alt": 29.0}, 2),
        ({"lat": 0, "lon": 0}, 2),
        ({"alt": 0.0}, 2),
        ({"alt": 0.0, "frame": 10}, 2),
    ],
    ids=str,
)
def test_a_destination_outside_the_fence_or_without_a_height_is_denied(order: dict[str, float], result: int) -> None:
    """Location::sanitize and AC_Fence::check_destination_within_fence, which send no text."""
    world, station = settled_world()
    polygon(world, station)
    listen(world, station, 0.2)
    for name, value in (
        ("FENCE_TYPE", 15),
        ("FENCE_ALT_MIN", 30),
        ("FENCE_ALT_MAX", 120),
        ("FENCE_RADIUS", 200),
        ("FENCE_ENABLE", 1),
    ):
        world.planes[0].params.set(name, value)
    listen(world, station, 0.2)
    world.planes[0].fence.enable(True, FenceType(15))
    goal = GOTO | order
    message = integer(192, int(goal["frame"]), (-1.0, 1.0), int(goal["lat"]), int(goal["lon"]), goal["alt"])
    answer, heard = ask(world, station, message)
    assert answer == result
    assert not [m for m in heard if m.get_type() == "STATUSTEXT"]


def test_fence_altitudes_and_circle() -> None:
    world, station = settled_world()
    plane, autopilot = world.planes[0], double(world)
    for name, value in (("FENCE_TYPE", 15), ("FENCE_ALT_MIN", 20), ("FENCE_RADIUS", 300), ("FENCE_ENABLE", 1)):
        plane.params.set(name, value)
    autopilot.armed = autopilot.flying = True
    autopilot.landed_state = LandedState.IN_AIR

    def told(**state: float) -> list[object]:
        autopilot.calls.clear()
        for name, value in state.items():
            setattr(autopilot, name, value)
        listen(world, station, 0.3)
        return [call[1] for call in autopilot.calls if call[0] == "fence_breached"]

    assert told(alt_rel_home_m=10.0) == []  # the floor counts once the plane has climbed above it
    assert told(alt_rel_home_m=50.0) == []
    assert told(alt_rel_home_m=15.0) == [FenceBreach.MIN_ALT]
    assert told(alt_rel_home_m=50.0) == [None]
    assert told(alt_rel_home_m=101.0) == [FenceBreach.MAX_ALT]
    assert told(alt_rel_home_m=50.0, lat_deg=40.3362) == [FenceBreach.CIRCLE]
    assert told(lat_deg=40.3358) == [None]


def test_radio_overrides_expire() -> None:
    world, station = settled_world()
    values = [1200, 0, 65535, 1600, *[0] * 4, *[0] * 10]
    station.send(dialect.MAVLink_rc_channels_override_message(1, 1, *values))
    assert double(world).calls[-1] == ("rc_input", {1: 1200, 2: None, 4: 1600, 5: None, 6: None, 7: None, 8: None})
    listen(world, station, 3.3)
    assert double(world).calls[-1] == ("rc_input", {1: None, 4: None})
    station.send(dialect.MAVLink_manual_control_message(1, 500, -1000, 1000, 32767, 0))
    assert double(world).calls[-1] == ("rc_input", {1: 1000, 2: 1250, 3: 2000})
    stranger = world.connect(system=7)
    stranger.send(dialect.MAVLink_manual_control_message(1, 0, 0, 0, 0, 0))
    assert double(world).calls[-1] == ("rc_input", {1: 1000, 2: 1250, 3: 2000})


def test_guided_items_and_position_targets() -> None:
    world, station = settled_world()

    def item(current: int) -> Any:
        return dialect.MAVLink_mission_item_int_message(
            1, 1, 0, 3, 16, current, 1, 0, 0, 0, 0, 403340000, -37970000, 70, 0
        )

    for current in (2, 3):
        station.send(item(current))
    reposition, altitude = double(world).calls[-2:]
    assert (reposition[0], altitude) == ("reposition", ("change_altitude", 70.0, 3))
    acks = [m.type for m in station.receive() if m.get_type() == "MISSION_ACK"]
    assert acks == [0, 0]
    target = dialect.MAVLink_set_position_target_global_int_message(
        0, 1, 1, 6, 0b110111111000, 0, 0, 120.0, 0, 0, 0, 0, 0, 0, 0, 0
    )
    before = len(double(world).calls)
    station.send(target)
    assert len(double(world).calls) == before
    double(world).mode = Mode.GUIDED
    station.send(target)
    assert double(world).calls[-1] == ("change_altitude", 120.0, 3)


def test_attitude_targets_and_local_offsets_count_in_guided_alone() -> None:
    """GCS_MAVLink_Plane.cpp: an axis counts when its attitude or its rate is not ignored."""
    world, station = settled_world()
    autopilot = double(world)
    half = math.radians(-15.0)
    attitude = dialect.MAVLink_set_attitude_target_message(
        0, 1, 1, 0b01111110, [math.cos(half), math.sin(half), 0.0, 0.0], 0, 0, 0, 0.7
    )
    offset = dialect.MAVLink_set_position_target_local_ned_message(0, 1, 1, 7, 0xDF8, 0, 0, -10, *[0] * 8)
    for mode, calls in ((Mode.LOITER, []), (Mode.GUIDED, ["force_attitude", "raise_target"])):
        autopilot.mode = mode
        autopilot.calls.clear()
        station.send(attitude)
        station.send(offset)
        assert [call[0] for call in autopilot.calls] == calls
    (_, roll_rad, pitch_rad, throttle), (_, metres) = autopilot.calls
    assert roll_rad == pytest.approx(math.radians(-30.0))
    assert (pitch_rad, metres) == (pytest.approx(0.0), 10.0)
    assert throttle is None, "its bit says to ignore it"


@pytest.mark.parametrize("channel", [-1.0, 0.0, 17.0, 99.0])
def test_a_stick_without_a_channel_moves_nothing(channel: float) -> None:
    """RC_Channels::get_rcmap_channel_nonnull; the other sticks move theirs."""
    world, station = settled_world()
    station.send(dialect.MAVLink_param_set_message(1, 1, b"RCMAP_ROLL", channel, 2))
    station.send(dialect.MAVLink_manual_control_message(1, 32767, 1000, 1000, 32767, 0))
    assert double(world).calls == [("rc_input", {3: 2000})]


@pytest.mark.parametrize("z", [3.4e38, -3.4e38])
def test_a_target_keeps_an_altitude_that_a_location_can_hold(z: float) -> None:
    """An int32 of centimetres: the altitude stays finite however often it is raised."""
    world, station = flying_world(mission())
    world.planes[0].autopilot.set_mode(Mode.GUIDED)
    raised = dialect.MAVLink_set_position_target_local_ned_message(0, 1, 1, 7, 0xDF8, 0, 0, z, *[0] * 8)
    absolute = dialect.MAVLink_set_position_target_global_int_message(0, 1, 1, 0, 0xDF8, 0, 0, z, *[0] * 8)
    turned = dialect.MAVLink_set_attitude_target_message(0, 1, 1, 0, [z] * 4, 0, 0, 0, abs(z))
    for message in (raised, raised, absolute, integer(43001, 0, z=z), long(186, z, 0), turned):
        station.send(message)
        world.advance(0.2)
        _, heard = ask(world, station, long(512, 87))
        targets = [m.alt for m in heard if m.get_type() == "POSITION_TARGET_GLOBAL_INT"]
        assert abs(targets[-1]) == pytest.approx(2**31 / 100)


def test_reboot_turns_time_back_and_keeps_plan_and_parameters() -> None:
    world, station = settled_world()
    mission_with_landing(world, station)
    world.planes[0].params.set("WP_RADIUS", 33)
    double(world).armed = True
    assert ask(world, station, long(246, 1))[0] == 4
    double(world).armed = False
    before_s = world.planes[0].autopilot.time_s
    unix_us = listen(world, station, 1.0)
    told_us = max(m.time_unix_usec for m in unix_us if m.get_type() == "SYSTEM_TIME")
    assert ask(world, station, long(246, 1))[0] == 0
    assert double(world).rebooted == 0
    station.send(dialect.MAVLink_mission_request_list_message(1, 1, 0))
    assert listen(world, station, 1.9) == [], "while it is off it neither says nor hears anything"
    world.advance(0.1)
    assert double(world).rebooted == 1
    assert world.planes[0].autopilot.time_s < 0.1 < before_s
    assert world.planes[0].params.get("WP_RADIUS") == 33
    station.send(dialect.MAVLink_mission_count_message(1, 1, 2, 0))
    heard = listen(world, station, 0.5)
    assert [m.get_seq() for m in heard[:3]] == [0, 1, 2]
    assert heard[0].get_type() == "HEARTBEAT"
    assert [(m.type) for m in heard if m.get_type() == "MISSION_ACK"] == [4]
    assert "Only 0 items are supported" in [m.text for m in heard if m.get_type() == "STATUSTEXT"]
    assert min(m.time_boot_ms for m in heard if m.get_type() == "ATTITUDE") < 300
    assert len(world.planes[0].plans.mission_store) == 4
    later_us = [m.time_unix_usec for m in listen(world, station, 3.0) if m.get_type() == "SYSTEM_TIME"]
    assert max(later_us) > told_us, "the time of day is its receiver's, and goes on"


def test_calibration_takes_a_while() -> None:
    world, station = settled_world()
    station.send(long(241, 0, 0, 1))
    heard = listen(world, station, 2.5)
    results = [m.result for m in heard if m.get_type() == "COMMAND_ACK"]
    assert results[0] == 5
    assert results[-1] == 0
    assert set(results) == {0, 5}


def test_timesync_and_ping_are_answered() -> None:
    world, station = settled_world()
    station.send(dialect.MAVLink_timesync_message(0, 123456789))
    station.send(dialect.MAVLink_ping_message(77, 5, 0, 0))
    heard = listen(world, station, 0.02)
    (sync,) = [m for m in heard if m.get_type() == "TIMESYNC"]
    assert sync.ts1 == 123456789
    assert sync.tc1 == pytest.approx(world.planes[0].autopilot.time_s * 1e9, rel=0.02)
    assert [(m.time_usec, m.seq) for m in heard if m.get_type() == "PING"] == [(77, 5)]
    heard = listen(world, station, 20.0)
    assert sum(m.get_type() == "TIMESYNC" and m.tc1 == 0 for m in heard) == 2


def test_plan_of_another_station_is_not_mixed_in() -> None:
    world, one = settled_world()
    two = world.connect(system=254)
    one.send(dialect.MAVLink_mission_count_message(1, 1, 3, 0))
    two.receive()
    two.send(dialect.MAVLink_mission_count_message(1, 1, 2, 0))
    two.send(dialect.MAVLink_mission_item_int_message(1, 1, 0, 0, 16, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0))
    two.send(dialect.MAVLink_mission_request_list_message(1, 1, 0))
    assert [m.type for m in two.receive() if m.get_type() == "MISSION_ACK"] == [14, 14, 14]
    assert world.planes[0]._plans._protocols[0].receiving


def test_a_hundred_thousand_frames_of_noise_change_nothing() -> None:
    world, station = settled_world()
    plane = world.planes[0]
    before = (plane.params.revision, plane.plans.mission_revision, plane.snapshot().mode, list(double(world).calls))
    noise = random.Random(11)
    for _ in range(100):
        chunk = b"".join(
            bytes((noise.choice((0xFD, 0xFE)), noise.randrange(40))) + noise.randbytes(noise.randrange(8, 40))
            for _ in range(1000)
        )
        station.send_bytes(chunk)
    assert station.link.decoder.bad > 1000
    assert before == (
        plane.params.revision,
        plane.plans.mission_revision,
        plane.snapshot().mode,
        list(double(world).calls),
    )
    station.send_bytes(bytes(300))
    assert ask(world, station, long(512, 245))[0] == MavResult.ACCEPTED


def wild_message(chance: random.Random, kind: type[Any]) -> Any:
    """A message with random fields over their whole range, to the plane or as a broadcast."""
    ranges = {"int8_t": 7, "int16_t": 15, "int32_t": 31, "int64_t": 63}
    values: list[Any] = []
    for name, field in zip(kind.fieldnames, kind.fieldtypes, strict=True):
        length = kind.array_lengths[kind.ordered_fieldnames.index(name)]

        def one(name: str = name, field: str = field) -> Any:
            if name in ("target_system", "target_component", "target"):
                return chance.choice((0, 1))
            if field == "float":
                return chance.choice((math.nan, math.inf, -math.inf, 0.0, 3e38, -1.0, chance.uniform(-1e3, 1e3)))
            if field in ranges:
                limit = 1 << ranges[field]
                return chance.choice((-limit, limit - 1, 0, chance.randrange(-limit, limit)))
            bits = {"uint8_t": 8, "uint16_t": 16, "uint32_t": 32, "uint64_t": 64, "double": 8}[field]
            return chance.choice((0, (1 << bits) - 1, chance.randrange(1 << bits), chance.randrange(40)))

        if field == "char":
            values.append(chance.randbytes(length))
        elif length:
            values.append([one() for _ in range(length)])
        else:
            values.append(one())
    return kind(*values)


def test_no_message_brings_the_plane_down() -> None:
    world, station = settled_world()
    chance = random.Random(3)
    kinds = [k for k in dialect.mavlink_map.values() if k.msgname in world.planes[0]._handlers]
    assert len(kinds) == len(world.planes[0]._handlers)
    for _ in range(200):
        for kind in kinds:
            station.send(wild_message(chance, kind))
        world.tick()
        station.receive()
    assert world.planes[0].snapshot().gps_fix_type in (1, 6)


@pytest.mark.parametrize("seed", range(4))
def test_no_message_brings_a_flying_plane_down(seed: int) -> None:
    """The real autopilot, with parameters and sticks out of every range while modes change."""
    world, station = flying_world(mission(waypoint(0, 500, 0, 60), waypoint(0, 500, 500, 60)))
    world.advance(12.0)
    plane = world.planes[0]
    for message in (long(400, 1, 21196), long(176, 1, Mode.TAKEOFF)):
        assert ask(world, station, message)[0] == 0
    world.advance(12.0)
    chance = random.Random(seed)
    kinds = [k for k in dialect.mavlink_map.values() if k.msgname in plane._handlers]
    for _ in range(100):
        for _ in range(10):
            name = plane.params.at(chance.randrange(len(plane.params))).name.encode()
            value = chance.choice((0.0, -1.0, 99.0, 1e-30, 3e38, -3e38, chance.uniform(-1e3, 1e3)))
            station.send(dialect.MAVLink_param_set_message(1, 1, name, value, 9))
        station.send(long(176, 1, chance.choice(list(Mode))))
        station.send(dialect.MAVLink_manual_control_message(1, *(chance.choice((-1000, 500, 1000)) for _ in "xyzr"), 0))
        for kind in kinds:
            station.send(wild_message(chance, kind))
        world.advance(0.1)
        station.receive()
    assert math.isfinite(plane.snapshot().alt_amsl_m)


def test_the_current_item_is_announced_on_the_link_that_set_it() -> None:
    """MISSION_SET_CURRENT with the requested number, DO_SET_MISSION_CURRENT with the resulting item."""
    world, station = flying_world(
        mission(waypoint(0, 500, 0, 60), item(0, 178, params=(0, 15, -1)), waypoint(0, 500, 500, 60))
    )
    other = world.connect(system=254)
    for link in (station, other):
        link.send(dialect.MAVLink_request_data_stream_message(1, 1, 0, 1, 0))
    listen(world, station, 0.1)
    other.receive()

    def announced(message: Any) -> list[int]:
        station.receive()
        station.send(message)
        return [m.seq for m in listen(world, station, 0.1) if m.get_type() == "MISSION_CURRENT"]

    assert announced(dialect.MAVLink_mission_set_current_message(1, 1, 2)) == [2]
    assert announced(dialect.MAVLink_mission_set_current_message(1, 1, 0)) == [0]
    assert announced(dialect.MAVLink_mission_set_current_message(1, 1, 9)) == []
    assert announced(long(224, 2)) == [3]
    assert announced(long(224, 0)) == [1]
    assert not [m for m in other.receive() if m.get_type() == "MISSION_CURRENT"]


def test_a_mission_that_is_reset_counts_its_jumps_anew() -> None:
    world, station = flying_world(
        mission(waypoint(0, 500, 0, 60), waypoint(0, 500, 500, 60), item(0, 177, params=(1, 1)), waypoint(0, 0, 0, 60))
    )
    runner = world.planes[0].autopilot.mission  # type: ignore[attr-defined]
    runner._jumps[3] = 1
    assert ask(world, station, long(224, 2))[0] == 0
    assert runner._jumps == {3: 1}
    assert ask(world, station, long(224, 2, 1))[0] == 0
    assert (runner._jumps, runner.current_seq, runner.state.name) == ({}, 2, "RUNNING")


def flying_world(items: Sequence[StoredItem]) -> tuple[World, MemoryLink]:
    """A world whose plane has the real autopilot and a mission on board."""
    world = World(SimOptions(start_unix_s=1.7e9, links=()))
    station = world.connect()
    listen(world, station, 11.0)
    station.send(dialect.MAVLink_mission_count_message(1, 1, len(items), 0))
    for entry in items:
        station.send(
            dialect.MAVLink_mission_item_int_message(
                1, 1, entry.seq, entry.frame, entry.command, 0, 1, entry.p1, entry.p2, entry.p3, entry.p4,
                round(entry.lat_deg * 1e7), round(entry.lon_deg * 1e7), entry.alt_m, 0,
            )
        )  # fmt: skip
    listen(world, station, 0.1)
    assert len(world.planes[0].plans.mission) == len(items)
    return world, station


@pytest.mark.parametrize("kind", [0, 1, 2])
def test_a_request_beyond_the_end_is_answered_with_the_count(kind: int) -> None:
    world, station = settled_world()
    station.receive()
    station.send(dialect.MAVLink_mission_request_int_message(1, 1, 50, kind))
    heard = [m for m in listen(world, station, 0.02) if m.get_type().startswith("MISSION_")]
    answers = outline(heard, {"MISSION_COUNT": ("count", "mission_type"), "MISSION_ACK": ("type", "mission_type")})
    assert answers == [("MISSION_COUNT", 1 if kind == 0 else 0, kind), ("MISSION_ACK", 13, kind)]


@pytest.mark.parametrize(
    ("message", "result"),
    [
        (integer(43000, 0, (0.0, 99.0)), 4),
        (integer(43000, 0, (1.0, 15.0)), 2),
        (integer(43002, 0, (2.0, 0.0)), 0),
        (integer(43002, 0, (3.0, 0.0)), 2),
    ],
    ids=str,
)
def test_a_guided_command_is_answered_as_arduplane_answers_it(message: Any, result: int) -> None:
    world, station = flying_world(mission())
    world.planes[0].autopilot.set_mode(Mode.GUIDED)
    assert ask(world, station, message)[0] == result


@pytest.mark.parametrize(
    ("mode", "texts"),
    [
        (9, [(4, "No such mode 9")]),
        (17, [(6, "Q_ENABLE 0")]),
        (24, [(4, "Flight mode change failed")]),
        (26, [(4, "Must already be flying!"), (4, "Flight mode change failed")]),
    ],
)
def test_a_mode_that_cannot_be_entered_is_refused_in_arduplanes_words(mode: int, texts: list[tuple[int, str]]) -> None:
    """Seen of ArduPlane 4.8 in its own simulator, on the ground."""
    world, station = flying_world(mission())
    result, heard = ask(world, station, long(176, 1, mode))
    assert result == 4
    assert [(m.severity, m.text) for m in heard if m.get_type() == "STATUSTEXT"] == texts


def test_go_around_hands_its_altitude_over() -> None:
    world, station = settled_world()
    assert ask(world, station, long(191, 120))[0] == 0
    assert ask(world, station, long(191, math.nan))[0] == 0
    assert [call for call in double(world).calls if call[0] == "abort_landing"] == [
        ("abort_landing", 120.0),
        ("abort_landing", 0.0),
    ]


def test_the_same_conversation_gives_the_same_bytes() -> None:
    def run() -> bytes:
        world, station = settled_world()
        station.send(dialect.MAVLink_request_data_stream_message(1, 1, 0, 10, 1))
        station.send(dialect.MAVLink_param_request_list_message(1, 1))
        out = b""
        for _ in range(300):
            world.tick()
            out += b"".join(station.link.take(1 << 20))
        return out

    first = run()
    assert len(first) > 50_000
    assert first == run()
