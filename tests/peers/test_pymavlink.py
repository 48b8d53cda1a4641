"""pymavlink works with the simulated plane on the ground: connect, telemetry, mission both ways, parameters."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import pytest
from pymavlink import mavutil, mavwp

from tests.peers.support import ITEMS, PATIENCE_S, running_plane

pytestmark = pytest.mark.peer


@pytest.fixture
def vehicle() -> Iterator[Any]:
    with running_plane() as sim:
        connection = mavutil.mavlink_connection(sim.link, source_system=255, dialect="ardupilotmega")
        try:
            assert connection.wait_heartbeat(timeout=PATIENCE_S) is not None
            yield connection
        finally:
            connection.close()


def receive(vehicle: Any, *kinds: str, condition: str | None = None) -> Any:
    message = vehicle.recv_match(type=list(kinds), condition=condition, blocking=True, timeout=PATIENCE_S)
    assert message is not None, f"no {kinds} came"
    return message


def test_it_is_an_arduplane(vehicle: Any) -> None:
    assert vehicle.target_system == 1
    assert vehicle.mav_type == mavutil.mavlink.MAV_TYPE_FIXED_WING
    assert vehicle.flightmode == "MANUAL"
    assert vehicle.mode_mapping()["AUTO"] == 10


def test_telemetry(vehicle: Any) -> None:
    vehicle.mav.request_data_stream_send(1, 1, mavutil.mavlink.MAV_DATA_STREAM_ALL, 10, 1)
    position = receive(vehicle, "GLOBAL_POSITION_INT", condition="GLOBAL_POSITION_INT.lat != 0")
    assert position.lat * 1e-7 == pytest.approx(40.3332, abs=1e-3)
    assert position.lon * 1e-7 == pytest.approx(-3.7978, abs=1e-3)
    assert position.alt * 1e-3 == pytest.approx(600.0, abs=5.0)
    for kind in ("ATTITUDE", "VFR_HUD", "SYS_STATUS", "RAW_IMU", "SCALED_PRESSURE", "WIND", "BATTERY_STATUS"):
        receive(vehicle, kind)
    assert receive(vehicle, "GPS_RAW_INT", condition="GPS_RAW_INT.fix_type >= 3").satellites_visible >= 6


def test_mission_both_ways(vehicle: Any) -> None:
    loader = mavwp.MAVWPLoader()
    for item in ITEMS:
        loader.add(mavutil.mavlink.MAVLink_mission_item_message(1, 1, *item))
    vehicle.waypoint_clear_all_send()
    assert receive(vehicle, "MISSION_ACK").type == 0
    vehicle.waypoint_count_send(loader.count())
    while (message := receive(vehicle, "MISSION_REQUEST", "MISSION_ACK")).get_type() == "MISSION_REQUEST":
        vehicle.mav.send(loader.wp(message.seq))
    assert message.type == 0

    vehicle.waypoint_request_list_send()
    count = receive(vehicle, "MISSION_COUNT").count
    assert count == len(ITEMS)
    for seq in range(1, count):
        vehicle.waypoint_request_send(seq)
        back = receive(vehicle, "MISSION_ITEM", condition=f"MISSION_ITEM.seq == {seq}")
        sent = loader.wp(seq)
        assert (back.command, back.frame) == (sent.command, sent.frame)
        assert (back.x, back.y, back.z) == pytest.approx((sent.x, sent.y, sent.z), abs=1e-5)


def test_all_parameters(vehicle: Any) -> None:
    vehicle.param_fetch_all()
    end = time.monotonic() + PATIENCE_S
    while len(vehicle.params) < 1399 and time.monotonic() < end:
        receive(vehicle, "PARAM_VALUE")
    assert len(vehicle.params) == 1399
    assert vehicle.params["WP_RADIUS"] == 50.0
    vehicle.param_set_send("WP_RADIUS", 35)
    assert receive(vehicle, "PARAM_VALUE", condition="PARAM_VALUE.param_id == 'WP_RADIUS'").param_value == 35.0


def test_modes_and_arming_checks(vehicle: Any) -> None:
    vehicle.set_mode("FBWA")
    receive(vehicle, "HEARTBEAT", condition="HEARTBEAT.custom_mode == 5")
    assert vehicle.flightmode == "FBWA"
    vehicle.mav.command_long_send(1, 1, mavutil.mavlink.MAV_CMD_RUN_PREARM_CHECKS, 0, 0, 0, 0, 0, 0, 0, 0)
    assert receive(vehicle, "COMMAND_ACK").result == 0
