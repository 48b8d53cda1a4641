"""Transfers while the plane reboots, and while another station transfers with the same plane."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import vencejo
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from tests.faults.mock import MockPlane
from tests.support import wait_for

OTHER_STATION = (254, 190)
TRANSFER = (
    "MISSION_COUNT",
    "MISSION_ITEM_INT",
    "MISSION_REQUEST_LIST",
    "MISSION_REQUEST_INT",
    "MISSION_CLEAR_ALL",
    "MISSION_ACK",
    "PARAM_REQUEST_LIST",
    "PARAM_REQUEST_READ",
    "PARAM_SET",
)


@pytest.fixture
def mock() -> Iterator[MockPlane]:
    with MockPlane() as mock:
        yield mock


def mission(number: int, items: int = 4) -> vencejo.Plan:
    """Return a mission unique to the number."""
    points = (
        vencejo.MissionItem.waypoint(40.3 + number / 1e4, -3.8 + place / 1e4, alt_rel_home_m=50.0 + place)
        for place in range(items)
    )
    return vencejo.Plan(items=tuple(points))


def holds(mock: MockPlane, plan: vencejo.Plan) -> bool:
    """Return whether the plane holds exactly this mission; item 0 is home."""
    stored = [(item.x, item.y, item.z) for item in mock.items[0]][1:]
    wanted = []
    for item in plan:
        lat, lon, alt = (value or 0.0 for value in item.params[4:])
        wanted.append((round(lat * 1e7), round(lon * 1e7), alt))
    return stored == wanted


OPERATIONS: dict[str, Callable[[vencejo.Vehicle], Any]] = {
    "upload": lambda plane: plane.upload(mission(2)),
    "download": lambda plane: plane.download(),
    "clear": lambda plane: plane.clear(confirm="clear-mission"),
    "parameters": lambda plane: plane.params.all(),
    "parameter": lambda plane: plane.params.get("WP_RADIUS"),
    "write a parameter": lambda plane: plane.params.set("WP_RADIUS", 60.0),
}


@pytest.mark.fault(15, figure="6 operations, a restart at each of their messages: noticed, plan unknown")
@pytest.mark.parametrize("operation", sorted(OPERATIONS))
def test_a_restart_at_each_step(operation: str) -> None:
    outcomes: list[str] = []
    while not outcomes or outcomes[-1] != "undisturbed":
        assert len(outcomes) < 60, "the operation ends some time"
        with MockPlane() as mock, vencejo.connect(mock.link, record=False) as plane:
            outcomes.append(restart_at(mock, plane, operation, len(outcomes)))
    assert len(outcomes) > 1


def restart_at(mock: MockPlane, plane: vencejo.Vehicle, operation: str, step: int) -> str:
    """Reboot the plane instead of its answer to one message of an operation; return the outcome."""
    plane.upload(mission(1))
    assert plane.plan_state().state == "verified"
    seen = 0

    def restart(message: Any) -> list[Any] | None:
        nonlocal seen
        if message.get_type() not in TRANSFER or message.get_srcSystem() != 255:
            return None
        seen += 1
        if seen == step + 1:
            mock.reboot()
            return []
        return None

    events: list[str] = []
    error = None
    with plane.on_event(lambda event: events.append(event.kind)):
        mock.on_message = restart
        try:
            OPERATIONS[operation](plane)
        except vencejo.VencejoError as caught:
            error = caught
        mock.on_message = None
        if seen <= step:
            assert error is None, "without a restart it works"
            return "undisturbed"
        wait_for(lambda: "rebooted" in events, f"noticing the restart at step {step}")
    assert plane.plan_state().state == "unknown", (step, error)
    if operation == "upload" and error is None:
        assert holds(mock, mission(2))
    return type(error).__name__


@pytest.mark.fault(32, figure="50 rounds between messages of another station: each plan exact", seeds=1)
def test_another_station_contaminates_nothing(mock: MockPlane) -> None:
    """50 rounds: between any two of our messages, the plane communicates with another station about other items."""
    choose = random.Random(32)
    foreign = mission(9_999)

    def noise() -> list[Any]:
        seq = choose.randrange(0, 12)
        item = foreign.items[seq % len(foreign.items)]
        lat, lon, alt = item.params[4:]
        assert lat is not None
        assert lon is not None
        every = [
            mavlink.MAVLink_mission_request_int_message(*OTHER_STATION, seq, 0),
            mavlink.MAVLink_mission_request_message(*OTHER_STATION, seq, 0),
            mavlink.MAVLink_mission_ack_message(*OTHER_STATION, choose.choice((0, 1, 4, 13, 14, 15)), 0),
            mavlink.MAVLink_mission_count_message(*OTHER_STATION, choose.randrange(0, 700), 0),
            mavlink.MAVLink_mission_item_int_message(
                *OTHER_STATION, seq, 3, 16, 0, 1, 0, 0, 0, 0, int(lat * 1e7), int(lon * 1e7), alt, 0
            ),
            mavlink.MAVLink_param_value_message(b"ANOTHER", 1.0, 9, 1_000, choose.randrange(0, 1_000)),
            mavlink.MAVLink_command_ack_message(mavlink.MAV_CMD_DO_CHANGE_SPEED, 4, 0, 0, *OTHER_STATION),
        ]
        return choose.sample(every, choose.randrange(0, 4))

    def with_noise(message: Any) -> list[Any] | None:
        if message.get_srcSystem() != 255 or message.get_type() not in (*TRANSFER, "COMMAND_LONG"):
            return None
        return [*noise(), *mock._answer(message), *noise()]

    with vencejo.connect(mock.link, record=False) as plane:
        mock.on_message = with_noise
        for number in range(50):
            plan = mission(number, items=choose.randrange(1, 9))
            state = plane.upload(plan)
            assert (state.state, state.count) == ("verified", len(plan))
            assert holds(mock, plan), number
            again = plane.download()
            assert [item.params[4:] for item in again] == [pytest.approx(item.params[4:], abs=1e-6) for item in plan]
            plane.params["WP_RADIUS"] = 30.0 + number
            assert plane.params["WP_RADIUS"] == 30.0 + number
            assert plane.command(mavlink.MAV_CMD_DO_CHANGE_SPEED, 0, 20, -1) == 0
        items = [message for name, message in mock.received if name == "MISSION_ITEM_INT"]
        assert all(message.seq < 10 for message in items)


@pytest.mark.fault(32, figure="refused as a whole, nothing of it on board")
def test_a_station_that_is_uploading_keeps_ours_out_whole(mock: MockPlane) -> None:
    """The plane accepts one upload at a time and says so; ours fails as a whole, and nothing of it is on board."""
    with vencejo.connect(mock.link, record=False) as plane:
        plane.upload(mission(1))
        count = mavlink.MAVLink_mission_count_message(1, 1, 5, 0)
        mock._incoming = (*OTHER_STATION, [], count)
        with pytest.raises(vencejo.TransferError, match="DENIED"):
            plane.upload(mission(2))
        assert holds(mock, mission(1))
        assert plane.plan_state().state == "unknown"
        mock._incoming = None
        plane.upload(mission(2))
        assert holds(mock, mission(2))
