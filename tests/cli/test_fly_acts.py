"""Uploading, arming and starting are separate acts: their order, and what is left when one of them fails."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from typing import Any, cast

import pytest
from vencejo import (
    CommandRefused,
    CommandTimeout,
    Fence,
    Finding,
    FlightPreparation,
    NotPossibleNow,
    Plan,
    StatusText,
    Vehicle,
)
from vencejo.cli.common import Failed
from vencejo.cli.fly import Flight, fly_plan
from vencejo.cli.follow import Ending
from vencejo.cli.report import Reporter
from vencejo.plan import Circle, GeoPoint

from tests.cli.doubles import LAT, LON, FakeVehicle, circuit, flying, parked, progress

GROUND: dict[str, Any] = {"landed": "on ground", "height_m": 0.0, "speed_m_s": 0.0}


def fly(
    vehicle: FakeVehicle,
    *,
    plan: Plan | None = None,
    ask: Callable[[str], bool] = lambda _: True,
    ready_timeout_s: float = 60.0,
    despite_mixed_plan: bool = False,
) -> Flight:
    with Reporter(json=True) as reporter:
        return fly_plan(
            cast(Vehicle, vehicle),
            plan or circuit(),
            reporter,
            ask=ask,
            ready_timeout_s=ready_timeout_s,
            patience_s=60.0,
            despite_mixed_plan=despite_mixed_plan,
        )


def ready_vehicle() -> FakeVehicle:
    """A plane on the ground that flies its mission once it is started."""
    vehicle = FakeVehicle(parked())

    def arm() -> None:
        vehicle.show(parked(mode="MANUAL", armed=True))

    def start() -> None:
        vehicle.mission_progress = progress(5)
        vehicle.show(flying(101.0, **GROUND))
        vehicle.frames = [
            flying(101.0, **GROUND),
            flying(110.0),
            flying(200.0, armed=False, lat_deg=LAT + 1e-5, **GROUND),
        ]

    vehicle.frames = [parked(), parked()]
    vehicle.after = {"arm": arm, "start_mission": start}
    return vehicle


def test_everything_in_order(capsys: pytest.CaptureFixture[str]) -> None:
    vehicle = ready_vehicle()
    asked: list[str] = []

    def ask(question: str) -> bool:
        asked.append(question)
        vehicle.calls.append("asked")
        return True

    flight = fly(vehicle, ask=ask)
    assert vehicle.calls == ["upload mission", "prepare_flight", "command 401", "asked", "arm", "start_mission 1"]
    assert "Arm" in asked[0]
    assert flight.outcome.ending is Ending.LANDED
    assert flight.landing_error_m == pytest.approx(1.1, abs=0.05)
    events = [json.loads(line)["event"] for line in capsys.readouterr().out.splitlines()]
    assert [event for event in events if event != "progress"] == ["uploaded", "ready", "armed", "started"]


def test_a_mission_that_may_be_mixed_is_flown_only_by_name() -> None:
    vehicle = ready_vehicle()
    fly(vehicle, despite_mixed_plan=True)
    assert vehicle.calls[1:] == ["prepare_flight despite", "command 401", "arm despite", "start_mission 1 despite"]
    vehicle = ready_vehicle()
    vehicle.fails["arm"] = NotPossibleNow("the mission on board is perhaps mixed (despite_mixed_plan)")
    with pytest.raises(NotPossibleNow):
        fly(vehicle)
    assert vehicle.calls[-1] == "arm", "nothing is started"


def test_a_no_leaves_it_disarmed() -> None:
    vehicle = ready_vehicle()
    with pytest.raises(Failed, match="not armed: the mission is on board"):
        fly(vehicle, ask=lambda _: False)
    assert vehicle.calls == ["upload mission", "prepare_flight", "command 401"]


def test_an_error_in_the_plan_sends_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    vehicle = ready_vehicle()
    vehicle.findings = (Finding("error", "far_away", 2, "item 2 is 900 km away", "plan it here"),)
    with pytest.raises(Failed, match="1 error: nothing was sent"):
        fly(vehicle)
    assert vehicle.calls == []
    assert "error: item 2 is 900 km away; plan it here" in capsys.readouterr().out


def test_fence_comes_before_the_mission_and_only_when_there_is_one() -> None:
    vehicle = ready_vehicle()
    fence = Fence((Circle(GeoPoint(LAT, LON), 2000.0),))
    fly(vehicle, plan=Plan(items=circuit().items, fence=fence))
    assert vehicle.calls[:2] == ["upload fence", "upload mission"]


def test_pre_arm_reasons_are_told_while_it_waits(capsys: pytest.CaptureFixture[str]) -> None:
    vehicle = ready_vehicle()
    vehicle.texts = [
        StatusText(10.0, 2, "PreArm: of long ago"),
        StatusText(95.0, 2, "PreArm: Need Position Estimate"),
        StatusText(96.0, 2, "PreArm: Need Position Estimate"),
        StatusText(97.0, 6, "something else"),
    ]
    vehicle.frames = [parked(ready=True), parked(ready=False), parked(ready=False), parked(ready=True)]
    fly(vehicle)
    assert vehicle.calls == ["upload mission", "prepare_flight", "command 401", "arm", "start_mission 1"]
    told = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [event["reason"] for event in told if event["event"] == "prearm"] == ["Need Position Estimate"]


def test_a_vehicle_that_is_never_ready_is_never_armed() -> None:
    vehicle = ready_vehicle()
    vehicle.texts = [StatusText(99.0, 2, "PreArm: Compass not healthy")]
    vehicle.frames = [parked(ready=False), parked(ready=False)]
    with pytest.raises(Failed, match="not ready to arm after 0 s: Compass not healthy"):
        fly(vehicle, ready_timeout_s=0.0)
    assert "arm" not in vehicle.calls


def test_what_was_said_before_the_upload_does_not_count() -> None:
    vehicle = ready_vehicle()
    old = {"is_ready_to_arm": True, "unhealthy_sensors": (), "age_s": 3.0}
    vehicle.frames = [parked(sys_status=old), parked(sys_status=old), parked(ready=False)]
    with pytest.raises(Failed, match="not ready"):
        fly(vehicle, ready_timeout_s=0.0)
    assert "arm" not in vehicle.calls


def test_a_refusal_to_arm_starts_nothing() -> None:
    vehicle = ready_vehicle()
    vehicle.fails["arm"] = CommandRefused("refused", reasons=("Throttle too high",))
    with pytest.raises(CommandRefused):
        fly(vehicle)
    assert vehicle.calls[-1] == "arm"


def test_what_cannot_be_started_is_disarmed_again(capsys: pytest.CaptureFixture[str]) -> None:
    vehicle = ready_vehicle()
    vehicle.after["start_mission"] = lambda: None
    vehicle.fails["start_mission"] = CommandRefused("mode AUTO refused")
    with pytest.raises(CommandRefused):
        fly(vehicle)
    assert vehicle.calls[-2:] == ["start_mission 1", "disarm"]
    vehicle = ready_vehicle()
    vehicle.after["start_mission"] = lambda: None
    vehicle.fails = {"start_mission": CommandRefused("no"), "disarm": CommandRefused("in the air")}
    with pytest.raises(CommandRefused, match="no"):
        fly(vehicle)
    assert "THE PLANE IS STILL ARMED" in capsys.readouterr().err


@pytest.mark.parametrize("end", [KeyboardInterrupt(), SystemExit(143), BrokenPipeError(), CommandTimeout("not shown")])
@pytest.mark.parametrize("act", ["arm", "armed", "start_mission"])
def test_whatever_ends_it_before_the_start_the_plane_is_not_left_armed(
    act: str, end: BaseException, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    vehicle = ready_vehicle()
    if act == "arm":
        del vehicle.after["arm"]  # the heartbeat that would show it has not come yet
    vehicle.after["start_mission"] = lambda: None
    if act == "armed":

        def step(self: Reporter, event: str, text: str, /, **_: Any) -> None:
            if event == "armed":
                raise end

        monkeypatch.setattr(Reporter, "step", step)
    else:
        vehicle.fails[act] = end
    with pytest.raises(type(end)):
        fly(vehicle)
    assert vehicle.calls[-1] == "disarm"
    assert "the plane is disarmed again" in capsys.readouterr().err
    vehicle.fails["disarm"] = KeyboardInterrupt()
    vehicle.show(parked())
    vehicle.frames = [parked(), parked()]
    with pytest.raises(type(end)):
        fly(vehicle)
    state = "MAY BE ARMED" if act == "arm" else "IS STILL ARMED"
    assert f"THE PLANE {state}: KeyboardInterrupt" in capsys.readouterr().err


def test_a_pilot_who_arms_during_the_upload_is_not_disarmed() -> None:
    vehicle = ready_vehicle()
    vehicle.frames = []
    vehicle.after["upload"] = lambda: vehicle.show(parked(armed=True))
    vehicle.after["start_mission"] = lambda: None
    vehicle.fails["start_mission"] = CommandRefused("mode AUTO refused")
    with pytest.raises(CommandRefused):
        fly(vehicle)
    assert vehicle.calls == ["upload mission", "start_mission 1"]


@pytest.mark.parametrize("end", [TimeoutError("no answer, but it shows AUTO"), SystemExit(143)])
def test_a_start_that_may_have_worked_is_not_undone(end: BaseException, capsys: pytest.CaptureFixture[str]) -> None:
    vehicle = ready_vehicle()
    vehicle.fails["start_mission"] = end
    with pytest.raises(type(end)):
        fly(vehicle)
    assert vehicle.calls[-1] == "start_mission 1"
    assert "THE PLANE IS ARMED, in AUTO" in capsys.readouterr().err


def test_what_a_flight_needs_first_is_said_before_it_is_done(capsys: pytest.CaptureFixture[str]) -> None:
    vehicle = ready_vehicle()
    vehicle.flight_preparation = FlightPreparation("RTL", "MANUAL", True, True, "mode RTL to MANUAL")
    said: list[str] = []
    vehicle.after["prepare_flight"] = lambda: said.append(capsys.readouterr().out.splitlines()[-1])
    fly(vehicle)
    event = json.loads(said[0])
    assert (event["event"], event["from_mode"], event["mode"], event["rewinds_mission"]) == (
        "preparing",
        "RTL",
        "MANUAL",
        True,
    )
    vehicle = ready_vehicle()
    vehicle.fails["prepare_flight"] = NotPossibleNow("the vehicle is in the air")
    with pytest.raises(NotPossibleNow):
        fly(vehicle)
    assert vehicle.calls[-1] == "prepare_flight"


def test_a_pilot_who_chose_auto_before_it_was_armed_has_started_it() -> None:
    vehicle = ready_vehicle()
    vehicle.after["arm"] = lambda: vehicle.show(parked(mode="AUTO", armed=True))
    fly(vehicle)
    assert vehicle.calls[-2:] == ["arm", "start_mission None"]


def test_a_plane_in_the_air_is_not_armed_but_asked_about() -> None:
    vehicle = ready_vehicle()
    vehicle.show(flying(mode="LOITER"))
    fly(vehicle)
    assert vehicle.calls == ["upload mission", "start_mission 1"]


def test_a_flown_mission_is_replaced_only_when_wanted() -> None:
    vehicle = ready_vehicle()
    vehicle.show(flying(mode="AUTO"))
    with pytest.raises(Failed, match="goes on with its mission"):
        fly(vehicle, ask=lambda question: "Replace" not in question)
    assert vehicle.calls == []


def test_a_broken_picture_says_that_the_plane_flies_on(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    vehicle = ready_vehicle()

    def stream(**_: Any) -> Any:
        raise KeyboardInterrupt

    vehicle.after["start_mission"] = lambda: monkeypatch.setattr(vehicle, "stream", stream)
    with pytest.raises(KeyboardInterrupt):
        fly(vehicle)
    assert "The plane goes on flying" in capsys.readouterr().err


def test_plain_lines_without_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    out = io.StringIO()
    monkeypatch.setattr("sys.stdout", out)
    vehicle = ready_vehicle()
    with Reporter(json=False) as reporter:
        fly_plan(cast(Vehicle, vehicle), circuit(), reporter, ask=lambda _: True, ready_timeout_s=1.0, patience_s=1.0)
    assert "mission started: the plane is in AUTO" in out.getvalue()
    assert "item 5 of 4" in out.getvalue()
    assert "\x1b" not in out.getvalue()
