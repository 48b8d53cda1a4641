"""Commands to a plane that answers late, wrongly, twice or not at all, and calls that must not move it."""

from __future__ import annotations

import contextlib
import random
import threading
from collections.abc import Callable, Iterator
from typing import Any, cast

import pytest
import vencejo
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from tests.faults.mock import MockPlane
from tests.support import wait_for

SPEED = mavlink.MAV_CMD_DO_CHANGE_SPEED
OTHER_STATION = 254


@pytest.fixture
def mock() -> Iterator[MockPlane]:
    with MockPlane() as mock:
        yield mock


@pytest.fixture
def plane(mock: MockPlane) -> Iterator[vencejo.Vehicle]:
    with vencejo.connect(mock.link, record=False) as plane:
        yield plane


def is_speed(message: Any) -> bool:
    return bool(message.get_type() == "COMMAND_LONG" and message.command == SPEED)


def foreign(mock: MockPlane, message: Any, result: int) -> Any:
    return mavlink.MAVLink_command_ack_message(message.command, result, 0, 0, OTHER_STATION, 190)


def of_another_command(result: int) -> Any:
    return mavlink.MAVLink_command_ack_message(mavlink.MAV_CMD_DO_SET_SERVO, result, 0, 0, 255, 190)


def without_target(message: Any, result: int) -> Any:
    return mavlink.MAVLink_command_ack_message(message.command, result)


Script = Callable[[MockPlane, Any, int], list[Any]]
"""The plane's answer to the nth transmission of a command, from 0."""

ACKS: dict[str, tuple[Script, str | None]] = {
    "accepted": (lambda mock, message, n: [mock.ack(message)], None),
    "accepted by an old autopilot": (lambda mock, message, n: [without_target(message, 0)], None),
    "accepted three times": (lambda mock, message, n: [mock.ack(message)] * 3, None),
    "accepted, then denied": (lambda mock, message, n: [mock.ack(message), mock.ack(message, 2)], None),
    "denied, then accepted": (lambda mock, message, n: [mock.ack(message, 2), mock.ack(message)], "DENIED"),
    "only the third try": (lambda mock, message, n: [mock.ack(message)] if n == 2 else [], None),
    "rejected for now": (lambda mock, message, n: [mock.ack(message, 1)], "TEMPORARILY_REJECTED"),
    "denied": (lambda mock, message, n: [mock.ack(message, 2)], "DENIED"),
    "unsupported": (lambda mock, message, n: [mock.ack(message, 3)], "UNSUPPORTED"),
    "failed": (lambda mock, message, n: [mock.ack(message, 4)], "FAILED"),
    "cancelled": (lambda mock, message, n: [mock.ack(message, 6)], "CANCELLED"),
    "wrong frame": (lambda mock, message, n: [mock.ack(message, 9)], "COMMAND_UNSUPPORTED_MAV_FRAME"),
    "not in control": (lambda mock, message, n: [mock.ack(message, 10)], "NOT_IN_CONTROL"),
    "a result of the future": (lambda mock, message, n: [mock.ack(message, 200)], "unknown MAV_RESULT"),
    "in progress, then accepted": (
        lambda mock, message, n: [
            *(mock.ack(message, 5, progress=percent) for percent in (0, 50, 255)),
            mock.ack(message),
        ],
        None,
    ),
    "in progress, then failed": (lambda mock, message, n: [mock.ack(message, 5), mock.ack(message, 4)], "FAILED"),
    "another station's first": (lambda mock, message, n: [foreign(mock, message, 2), mock.ack(message)], None),
    "another station's only": (lambda mock, message, n: [foreign(mock, message, 0)], "silence"),
    "another command's first": (lambda mock, message, n: [of_another_command(4), mock.ack(message)], None),
    "another command's only": (lambda mock, message, n: [of_another_command(0)], "silence"),
    "none": (lambda mock, message, n: [], "silence"),
}


@pytest.mark.fault(21, figure="21 cases: one result each, and the next command is its own")
@pytest.mark.parametrize("case", sorted(ACKS))
def test_each_answer_gives_one_result(mock: MockPlane, plane: vencejo.Vehicle, case: str) -> None:
    script, expected = ACKS[case]
    sent: list[Any] = []

    def answer(message: Any) -> list[Any] | None:
        if not is_speed(message):
            return None
        sent.append(message)
        return script(mock, message, len(sent) - 1)

    mock.on_message = answer
    if expected is None:
        assert plane.command(SPEED, 0, 20, -1) == 0
    elif expected == "silence":
        with pytest.raises(vencejo.CommandTimeout) as silent:
            plane.command(SPEED, 0, 20, -1)
        assert silent.value.command == "DO_CHANGE_SPEED"
    else:
        with pytest.raises(vencejo.CommandRefused) as refused:
            plane.command(SPEED, 0, 20, -1)
        assert (refused.value.command, refused.value.result) == ("DO_CHANGE_SPEED", expected)
    assert [message.confirmation for message in sent] == list(range(len(sent)))
    if expected != "silence" and case != "only the third try":
        assert len(sent) == 1, "an answer ends it"
    # Nothing of it remains: the next command gets its own answer.
    mock.on_message = None
    assert plane.command(SPEED, 0, 21, -1) == 0


@pytest.mark.fault(22, figure="1 in flight, 9 refused, for arm and reboot")
@pytest.mark.parametrize("act", ["arm", "reboot"])
def test_of_ten_clicks_one_is_in_flight(mock: MockPlane, plane: vencejo.Vehicle, act: str) -> None:
    number = mavlink.MAV_CMD_COMPONENT_ARM_DISARM if act == "arm" else mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN
    held: list[Any] = []

    def hold(message: Any) -> list[Any] | None:
        if message.get_type() == "COMMAND_LONG" and message.command == number:
            held.append(message)
            return []
        return None

    mock.on_message = hold
    errors: list[BaseException | None] = []

    def click() -> None:
        try:
            plane.arm() if act == "arm" else plane.reboot(confirm="reboot")
            errors.append(None)
        except vencejo.VencejoError as error:
            errors.append(error)

    clicks = [threading.Thread(target=click) for _ in range(10)]
    for thread in clicks:
        thread.start()
    wait_for(lambda: len(errors) == 9 and len(held) == 1, "nine refusals and one command")
    assert all(isinstance(error, vencejo.Busy) for error in errors), errors

    def grant() -> None:
        mock.is_armed = act == "arm"
        mock.say(mock.ack(held[0]), *mock._beat())
        if act == "reboot":
            mock.reboot()

    mock.do(grant)
    for thread in clicks:
        thread.join(30)
    assert errors[9] is None
    assert len(held) == 1
    assert plane.telemetry.is_armed is (act == "arm")


@pytest.mark.fault(27, figure="10,000 calls: 0 frames that arm, change mode or start", seeds=1)
def test_ten_thousand_random_calls_move_nothing(mock: MockPlane, plane: vencejo.Vehicle) -> None:
    """Whatever is requested, and however it is cancelled: no arming, mode or start is sent without a request."""
    choose = random.Random(27)
    point = vencejo.MissionItem.waypoint(40.3, -3.8, alt_rel_home_m=60.0)
    bad = float("nan")

    def cancelled(start: Callable[[], Any]) -> None:
        pending = start()
        pending.cancel()
        with contextlib.suppress(vencejo.VencejoError):
            pending.wait(10.0)

    def plan() -> vencejo.Plan:
        return vencejo.Plan(items=(point,) * choose.randrange(1, 4))

    def clear(kind: Any) -> None:
        plane.clear(kind=kind, confirm=cast("Any", f"clear-{kind}"))

    quick: list[Callable[[], Any]] = [
        lambda: plane.telemetry.to_dict(),
        lambda: plane.mission_progress,
        lambda: plane.plan_state(),
        lambda: plane.station.links,
        lambda: plane.station.vehicles,
        lambda: plane.texts,
        lambda: plane.link,
        lambda: plane.mode_names,
        lambda: plane.check_plan(plan()),
        lambda: plane.on_event(lambda event: None).close(),
        lambda: next(plane.stream(rate_hz=50.0)),
        lambda: plane.station.set_heartbeat(choose.random() < 0.5),
        lambda: plane.send_message("PARAM_REQUEST_READ", param_id="WP_RADIUS", param_index=-1),
        lambda: plane.goto(bad, -3.8, alt_rel_home_m=50.0),
        lambda: plane.goto(40.3, -3.8),
        lambda: plane.takeoff(alt_rel_home_m=bad),
        lambda: plane.set_mode("NO SUCH MODE"),
        lambda: plane.set_airspeed(-bad),
        lambda: plane.set_current_item(0),
        lambda: plane.command("NO_SUCH_COMMAND"),
        lambda: plane.params.set("WP_RADIUS", bad),
        lambda: plane.upload(vencejo.Plan(items=(vencejo.MissionItem.waypoint(91.0, 0.0, alt_rel_home_m=1.0),))),
    ]
    with_answer: list[Callable[[], Any]] = [
        lambda: plane.upload(plan()),
        lambda: plane.download(),
        lambda: plane.download(kinds=("fence", "rally")),
        lambda: clear(choose.choice(("mission", "fence", "rally"))),
        lambda: plane.params.get("WP_RADIUS"),
        lambda: plane.params.set("WP_RADIUS", choose.randrange(10, 90)),
        lambda: plane.set_message_rate("ATTITUDE", 10.0),
        lambda: plane.command(mavlink.MAV_CMD_GET_HOME_POSITION),
        lambda: cancelled(lambda: plane._upload(plan(), "mission", False)[0]),
        lambda: cancelled(lambda: plane._native.download("mission")),
        lambda: cancelled(lambda: plane._native.param_list()),
        lambda: mock.do(mock.reboot) if choose.random() < 0.1 else None,
        lambda: plane.reboot(confirm="reboot") if plane.telemetry.is_armed else None,
    ]
    succeeded = 0
    for _ in range(10_000):
        call = choose.choice(with_answer if choose.random() < 0.12 else quick)
        with contextlib.suppress(vencejo.VencejoError):
            call()
            succeeded += 1
    assert succeeded > 4_000
    assert mock.acts() == []
    assert any(name == "MISSION_COUNT" for name, _ in mock.received)
    # Requested actions are sent.
    plane.station.set_heartbeat(True)
    plane.set_mode("RTL")
    assert len(mock.acts()) == 1


@pytest.mark.parametrize("disarms", [True, False])
def test_a_plane_that_was_armed_for_a_flight_that_does_not_begin_is_disarmed(
    mock: MockPlane, plane: vencejo.Vehicle, disarms: bool
) -> None:
    def answer(message: Any) -> list[Any] | None:
        command = getattr(message, "command", None) if message.get_type().startswith("COMMAND_") else None
        is_disarm = command == mavlink.MAV_CMD_COMPONENT_ARM_DISARM and message.param1 == 0
        refused = command == mavlink.MAV_CMD_DO_SET_MODE or (is_disarm and not disarms)
        return [mock.ack(message, mavlink.MAV_RESULT_DENIED)] if refused else None

    mock.on_message = answer
    mock.do(lambda: mock.say(mavlink.MAVLink_extended_sys_state_message(0, mavlink.MAV_LANDED_STATE_ON_GROUND)))
    here = mavlink.MAVLink_global_position_int_message(0, 400_000_000, -30_000_000, 600_000, 0, 0, 0, 0, 0)
    mock.do(lambda: mock.say(here))
    wait_for(lambda: plane.telemetry.is_on_ground is True and plane.telemetry.position is not None, "on the ground")
    plan = vencejo.Plan(items=(vencejo.MissionItem.waypoint(40.0, -3.0, alt_rel_home_m=60.0),))
    with pytest.raises(vencejo.VencejoError, match="DENIED" if disarms else "MAY STILL BE ARMED"):
        plane.send_and_fly(plan)
    assert mock.is_armed is not disarms
    assert f"COMMAND_LONG {mavlink.MAV_CMD_COMPONENT_ARM_DISARM}" in mock.acts(), "it was armed"
