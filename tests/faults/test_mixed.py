"""A mission that may be a mixture: refused by every interface, after a restart too, and with a damaged record."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import vencejo
from typer.testing import CliRunner
from vencejo.cli.commands import app

from tests.faults.mock import MockPlane
from tests.faults.test_transfers import mission

DOORS: dict[str, Callable[[vencejo.Vehicle], Any]] = {
    "arm": lambda plane: plane.arm(),
    "arm by force": lambda plane: plane.arm(force=True, confirm="force-arm"),
    "AUTO": lambda plane: plane.set_mode("AUTO"),
    "AUTO by number": lambda plane: plane.set_mode(10),
    "start": lambda plane: plane.start_mission(),
    "start in it": lambda plane: plane.start_mission(from_item=2),
    "resume": lambda plane: plane.resume_mission(),
    "jump": lambda plane: plane.set_current_item(2),
    "command": lambda plane: plane.command("COMPONENT_ARM_DISARM", 1.0, 21196.0, confirm="force-arm"),
    "command by COMMAND_INT": lambda plane: plane.command_int("MISSION_START", frame=0),
    "raw COMMAND_LONG": lambda plane: plane.send_message("COMMAND_LONG", command=400, param1=1.0),
    "raw COMMAND_INT": lambda plane: plane.send_message("COMMAND_INT", command=176, param1=1.0, param2=10.0),
    "raw SET_MODE": lambda plane: plane.send_message("SET_MODE", base_mode=1, custom_mode=10),
    "raw MISSION_SET_CURRENT": lambda plane: plane.send_message("MISSION_SET_CURRENT", seq=2),
}


def assert_held_back(mock: MockPlane, plane: vencejo.Vehicle, detail: str) -> None:
    state = plane.plan_state()
    assert state.may_be_mixed, state
    assert detail in state.detail, state
    before = len(mock.acts())
    for name, act in DOORS.items():
        with pytest.raises(vencejo.NotPossibleNow) as caught:
            act(plane)
        assert "despite_mixed_plan" in str(caught.value), name
    assert mock.acts()[before:] == []


def test_a_doubt_outlives_the_program_and_a_damaged_record_is_one(tmp_path: Path) -> None:
    with MockPlane() as mock:
        with vencejo.connect(mock.link, record=False) as plane:
            plane.upload(mission(1))
            assert not plane.plan_state().may_be_mixed
            plane.send_message("MISSION_COUNT", count=9, confirm="clear-mission")  # an upload that ends here
            assert_held_back(mock, plane, "upload has not ended")
        with vencejo.connect(mock.link, record=False) as plane:
            assert_held_back(mock, plane, "upload has not ended")
            plane.arm(despite_mixed_plan=True)
            assert plane.telemetry.is_armed
            with pytest.raises(vencejo.NotPossibleNow, match="despite_mixed_plan"):
                plane.land()
            assert any("arming by override, although" in text.text for text in plane.texts), plane.texts
            plane.disarm(confirm="disarm-in-flight")  # it does not report whether it is on the ground
        (record,) = (Path(os.environ["VENCEJO_DATA"]) / "missions").iterdir()
        assert json.loads(record.read_bytes())["doubt"] is not None
        record.write_bytes(record.read_bytes()[:30])
        with vencejo.connect(mock.link, record=False) as plane:
            assert_held_back(mock, plane, "what was written down of it is damaged")
            assert plane.download().items, "reading it is possible"
            assert_held_back(mock, plane, "perhaps mixed")
        mission(1).save(tmp_path / "it.waypoints")
        told = CliRunner().invoke(app, ["mission", "compare", str(tmp_path / "it.waypoints"), "--link", mock.link])
        assert told.exit_code == 1
        assert "the mission on board cannot be compared: perhaps mixed" in told.stderr
        assert "upload it again" in told.stderr
        with vencejo.connect(mock.link, record=False) as plane:
            plane.upload(mission(2))
            assert not plane.plan_state().may_be_mixed
            plane.arm()
        assert json.loads(record.read_bytes())["doubt"] is None
