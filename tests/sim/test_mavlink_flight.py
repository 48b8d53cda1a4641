"""A whole automatic flight over MAVLink has the texts of a recorded ArduPlane, in the same order."""

from __future__ import annotations

import re
from typing import Any

import pytest
from vencejo.sim.config import SimOptions
from vencejo.sim.mavlink.codec import dialect
from vencejo.sim.world import World

from tests.sim.transcripts import listen, read

NOT_OURS = re.compile(r"EKF2|SIM Hit ground")
"""Texts of parts that the simulated plane lacks: a second estimator, ArduPilot's own simulator."""


def story(messages: list[Any]) -> list[str]:
    """Texts from arming on, without figures, which differ between flights."""
    texts = [m.text for m in messages if m.get_type() == "STATUSTEXT" and not NOT_OURS.search(m.text)]
    texts = texts[texts.index("Throttle armed") :]
    return [text if text.startswith("Mission: ") else re.sub(r"-?\d+(\.\d+)?", "#", text) for text in texts]


def test_the_recorded_mission_is_the_same_story() -> None:
    world = World(SimOptions(start_unix_s=1.7e9, links=(), params={"RTL_AUTOLAND": 2}))
    station = world.connect()
    plane = world.planes[0]
    listen(world, station, 25.0)
    for entry in read("mission-upload-items.tlog"):
        if entry.from_station:
            station.send_bytes(entry.frame)
    heard = listen(world, station, 0.5)
    for command, *params in ((176, 1, 10), (400, 1, 0)):
        message = dialect.MAVLink_command_long_message(1, 1, command, 0, *params, 0, 0, 0, 0, 0)
        station.send(message)
    heard += listen(world, station, 5.0)
    assert [(m.command, m.result) for m in heard if m.get_type() == "COMMAND_ACK"] == [(176, 0), (400, 0)]
    for _ in range(100):
        heard += listen(world, station, 5.0)
        if not plane.snapshot().armed:
            break
    recorded = [entry.message for entry in read("arduplane-takeoff-to-landing.tlog")]
    told = story(recorded)
    assert len(told) > 25
    ours = story(heard)
    assert ours[: len(told)] == told
    # The recording ends with the disarming; afterwards the failing check is reported every half minute.
    assert set(ours[len(told) :]) <= {"PreArm: In landing sequence"}

    def reached(messages: list[Any]) -> list[int]:
        return [m.seq for m in messages if m.get_type() == "MISSION_ITEM_REACHED"]

    assert reached(recorded) == reached(heard) == [1, 2, 3, 4, 5, 6, 8, 9, 10], (
        "7 and the DO item after it end together"
    )

    def counted(messages: list[Any]) -> list[str]:
        return [m.param_id for m in messages if m.get_type() == "PARAM_VALUE" and m.param_id.startswith("STAT_")]

    # At 30 s, with the flight count, and every half minute after it.
    assert counted(heard)[:7] == counted(recorded)[:7]
    assert plane.params.get("STAT_FLTTIME") == pytest.approx(258, abs=30)
    assert plane.params.get("STAT_DISTFLWN") == pytest.approx(5690, rel=0.05)
    assert plane.params.get("STAT_FLTCNT") == 1

    def extremes(messages: list[Any], kind: str, field: str) -> tuple[float, float]:
        values = [getattr(m, field) for m in messages if m.get_type() == kind]
        return min(values), max(values)

    for kind, field, slack in (
        ("GLOBAL_POSITION_INT", "relative_alt", 12_000.0),
        ("NAV_CONTROLLER_OUTPUT", "wp_dist", 150.0),
    ):
        ours_seen, theirs = extremes(heard, kind, field), extremes(recorded, kind, field)
        assert abs(ours_seen[1] - theirs[1]) <= slack, (kind, field, ours_seen, theirs)
