"""The picture of a flight: what is shown, what is told, and when it is over."""

from __future__ import annotations

import io
import json
from typing import Any

import pytest
from rich.console import Console
from vencejo import MissionItem, Plan, StatusText
from vencejo.cli.follow import Ending, Follower, Note, distance_from_landing_m, line, render, view_of

from tests.cli.doubles import LAT, LON, circuit, flying, parked, progress, telemetry

ON_GROUND: dict[str, Any] = {"landed": "on ground", "height_m": 0.0, "speed_m_s": 0.0}


def kinds(notes: list[Note]) -> list[str]:
    return [note.kind for note in notes]


def goes_on(follower: Follower) -> bool:
    return follower.outcome is None


def started(plan: Plan | None = None, patience_s: float = 120.0) -> Follower:
    """A follower that has seen the plane take off."""
    follower = Follower(plan or circuit(), patience_s=patience_s)
    follower.step(flying(100.0, **ON_GROUND), progress(1), [])
    assert follower.step(flying(110.0), progress(2, reached=(1,)), []) != []
    assert goes_on(follower)
    return follower


def shown(text_width: int, **changes: object) -> str:
    console = Console(file=io.StringIO(), width=text_width, force_terminal=False)
    sample = flying(100.0, **changes)  # type: ignore[arg-type]
    texts = [StatusText(99.0, 4, "Bad \x1b[31mwords\x07")]
    console.print(render(view_of(sample, progress(2), texts, plan=circuit(), elapsed_s=65.0)))
    file = console.file
    assert isinstance(file, io.StringIO)
    return file.getvalue()


def test_a_flight_from_take_off_to_landing() -> None:
    follower = started()
    assert [note.text for note in follower.step(flying(150.0), progress(4, reached=(1, 2)), [])] == [
        "reached item 2 NAV_WAYPOINT"
    ]
    assert kinds(follower.step(flying(190.0), progress(5, reached=(1, 2, 4)), [])) == ["item_reached"]
    follower.step(flying(200.0, **ON_GROUND), progress(5, reached=(1, 2, 4)), [])
    assert goes_on(follower), "still armed"
    follower.step(flying(220.0, armed=False, **ON_GROUND), progress(5, reached=(1, 2, 4)), [])
    outcome = follower.outcome
    assert outcome is not None
    assert outcome.ok
    assert outcome.ending is Ending.LANDED
    assert follower.flight_time_s == 80.0


def test_items_that_are_reached_out_of_order_are_each_told_once() -> None:
    follower = started()
    told = []
    # As the core has them, ascending: item 5 was chosen, then 3, and then the mission began anew.
    for item, reached in ((5, (1, 2)), (3, (1, 2, 5)), (4, (1, 2, 3, 5)), (5, (1, 2, 3, 4, 5)), (2, (1,)), (3, (1, 2))):
        notes = follower.step(flying(120.0), progress(item, reached=reached), [])
        told.append([note.values["item"] for note in notes])
    assert told == [[2], [5], [3], [4], [], [2]]


def test_flight_time_is_on_the_vehicles_clock() -> None:
    follower = Follower(circuit())

    def at(time_s: float, boot_s: float, **changes: object) -> None:
        clock = {"boot_ms": round(boot_s * 1000)}
        follower.step(flying(time_s, system_time=clock, **changes), progress(5), [])  # type: ignore[arg-type]

    at(100.0, 1000.0, **ON_GROUND)
    at(101.0, 1010.0)
    at(120.0, 1200.0)
    at(121.0, 1210.0, armed=False, **ON_GROUND)
    assert follower.outcome is not None
    assert follower.flight_time_s == 190.0
    assert follower.elapsed_s == 210.0


def test_a_failsafe_is_told_with_its_reason_and_is_no_success() -> None:
    follower = started()
    texts = [StatusText(119.0, 4, "GCS Failsafe"), StatusText(119.5, 6, "something else")]
    notes = follower.step(flying(120.0, mode="RTL"), progress(2, reached=(1,)), texts)
    assert kinds(notes) == ["text", "text", "mode"]
    assert notes[-1].text == "mode AUTO → RTL at item 2: GCS Failsafe"
    follower.step(flying(180.0, mode="RTL", armed=False, **ON_GROUND), progress(2, reached=(1,)), texts)
    assert follower.outcome is not None
    assert not follower.outcome.ok
    assert "left AUTO at item 2 for RTL (GCS Failsafe)" in follower.outcome.text


def test_a_plane_that_stays_away_from_auto_is_given_up() -> None:
    follower = started(patience_s=60.0)
    follower.step(flying(120.0, mode="LOITER"), progress(2), [])
    follower.step(flying(180.0, mode="LOITER"), progress(2), [])
    assert goes_on(follower)
    follower.step(flying(180.1, mode="LOITER"), progress(2), [])
    assert follower.outcome is not None
    assert follower.outcome.ending is Ending.INTERRUPTED
    assert not follower.outcome.ok
    assert "it flies on in LOITER" in follower.outcome.text


def test_a_pilot_who_gives_it_back_spoils_nothing() -> None:
    follower = started()
    assert kinds(follower.step(flying(120.0, mode="FBWA"), progress(2), [])) == ["mode"]
    notes = follower.step(flying(140.0), progress(2), [])
    assert [note.text for note in notes] == ["back in AUTO at item 2"]
    follower.step(flying(150.0), progress(4), [])  # item 3 is no place to go to
    follower.step(flying(190.0), progress(5), [])
    follower.step(flying(220.0, armed=False, **ON_GROUND), progress(5), [])
    assert follower.outcome is not None
    assert follower.outcome.ok


def test_items_left_out_on_the_way_back_are_told() -> None:
    follower = started()
    follower.step(flying(120.0, mode="RTL"), progress(2), [StatusText(119.0, 4, "Battery failsafe")])
    follower.step(flying(130.0), progress(2), [])  # MISSION_CURRENT comes later than the mode
    follower.step(flying(131.0), progress(5), [])
    follower.step(flying(220.0, armed=False, **ON_GROUND), progress(5), [])
    assert follower.outcome is not None
    assert not follower.outcome.ok
    assert "Battery failsafe" in follower.outcome.text


def test_a_pilot_who_takes_the_landed_plane_spoils_nothing() -> None:
    follower = started()
    follower.step(flying(190.0), progress(5), [])
    follower.step(flying(200.0, **ON_GROUND), progress(5), [])
    follower.step(flying(210.0, mode="MANUAL", **ON_GROUND), progress(5), [])
    follower.step(flying(212.0, mode="MANUAL", armed=False, **ON_GROUND), progress(5), [])
    assert follower.outcome is not None
    assert follower.outcome.ok


def test_a_landed_plane_that_stays_armed_ends_it_too() -> None:
    follower = started()
    follower.step(flying(190.0), progress(5), [])
    follower.step(flying(200.0, **ON_GROUND), progress(5), [])
    follower.step(flying(246.0, **ON_GROUND), progress(5), [])
    assert follower.outcome is not None
    assert follower.outcome.ok
    assert "STILL ARMED" in follower.outcome.text


def test_coming_down_early_is_no_landing() -> None:
    follower = started()
    follower.step(flying(140.0, armed=False, **ON_GROUND), progress(2), [])
    assert follower.outcome is not None
    assert not follower.outcome.ok
    assert "at item 2 of 4" in follower.outcome.text


def test_disarmed_before_it_flew() -> None:
    follower = Follower(circuit())
    follower.step(flying(100.0, **ON_GROUND), progress(1), [])
    follower.step(parked(105.0), progress(1), [])
    assert follower.outcome is not None
    assert follower.outcome.ending is Ending.NOT_FLOWN
    assert not follower.outcome.ok


@pytest.mark.parametrize("mode", ["AUTO", "RTL"])
def test_a_mission_without_a_landing_ends_in_the_air(mode: str) -> None:
    follower = started(circuit(lands=False))
    follower.step(flying(150.0, mode=mode, state="complete"), progress(4, is_complete=True), [])
    assert follower.outcome is not None
    assert follower.outcome.ok
    assert follower.outcome.ending is Ending.ENDED_IN_AIR
    assert mode in follower.outcome.text


def test_a_px4_flies_its_mission_in_a_mode_of_another_name() -> None:
    follower = Follower(circuit())
    follower.step(flying(100.0, mode="AUTO_MISSION", **ON_GROUND), progress(1), [])
    follower.step(flying(110.0, mode="AUTO_MISSION"), progress(2, reached=(1,)), [])
    notes = follower.step(flying(120.0, mode="POSCTL"), progress(2), [])
    assert "POSCTL" in notes[0].text
    notes = follower.step(flying(130.0, mode="AUTO_MISSION"), progress(2), [])
    assert "back in AUTO_MISSION" in notes[0].text


def test_an_old_completion_does_not_count() -> None:
    follower = Follower(circuit(lands=False))
    follower.step(flying(100.0, state="complete"), progress(4, is_complete=True), [])
    assert goes_on(follower)
    follower.step(flying(101.0), progress(1), [])
    follower.step(flying(150.0, state="complete"), progress(4, is_complete=True), [])
    assert follower.outcome is not None


def test_circling_for_ever_at_the_last_item_is_an_end() -> None:
    plan = Plan(items=(*circuit(lands=False).items, MissionItem.loiter(LAT, LON, alt_rel_home_m=60.0, radius_m=-60.0)))
    follower = started(plan)
    follower.step(flying(150.0), progress(5, 5, leg_distance_m=101.0), [])
    assert goes_on(follower)
    follower.step(flying(160.0), progress(5, 5, leg_distance_m=99.0), [])
    assert follower.outcome is not None
    assert follower.outcome.ok


def test_a_lost_link_is_told_once_and_nothing_is_concluded() -> None:
    follower = started()
    gone = flying(130.0, mode="RTL", armed=False, age_s=5.1, **ON_GROUND)
    assert kinds(follower.step(gone, progress(2), [])) == ["lost"]
    assert follower.step(flying(140.0, armed=False, age_s=15.0, **ON_GROUND), progress(2), []) == []
    assert goes_on(follower)
    assert "regained" in kinds(follower.step(flying(150.0), progress(2), []))


def test_only_new_texts_are_told() -> None:
    follower = Follower(circuit())
    old, new = StatusText(90.0, 6, "old"), StatusText(100.5, 6, "new")
    assert follower.step(flying(100.0), progress(1), [old]) == []
    assert [note.text for note in follower.step(flying(101.0), progress(1), [old, new])] == ["info: new"]
    assert follower.step(flying(102.0), progress(1), [old, new]) == []


def test_the_picture_says_in_words_what_it_shows_in_colour() -> None:
    picture = shown(100)
    for part in (
        "AUTO, armed",
        "2 of 4 NAV_WAYPOINT",
        "1.50 km, 1:15",
        "80 m above home",
        "21.0 m/s",
        "1:05",
        "0.0 s ago",
    ):
        assert part in picture, part
    assert "stale" in shown(100, age_s=4.0)
    assert "LOST, silent for 0:09" in shown(100, age_s=9.0)


def test_what_the_vehicle_writes_cannot_steer_the_terminal() -> None:
    picture = shown(100)
    assert "\x1b" not in picture
    assert "\x07" not in picture
    assert "words" in picture


def test_a_picture_of_nothing() -> None:
    view = view_of(telemetry(), progress(None, None, distance_m=None, time_s=None), [], plan=None, elapsed_s=0.0)
    assert "nothing heard yet" in line(view)
    console = Console(file=io.StringIO(), width=100)
    console.print(render(view))
    assert json.loads(json.dumps(view.as_json(), allow_nan=False))["mode"] is None


def test_the_picture_as_a_line_and_as_json() -> None:
    view = view_of(flying(100.0), progress(2), [], plan=circuit(), elapsed_s=12.0)
    assert line(view).startswith("0:12 AUTO armed, item 2 of 4 NAV_WAYPOINT, to go 1.50 km 1:15, height 80 m")
    values = json.loads(json.dumps(view.as_json(), allow_nan=False))
    assert values["item"] == 2
    assert values["alt_rel_home_m"] == 80.0
    assert values["wind_m_s"] is None


def test_distance_from_the_landing_point() -> None:
    near = distance_from_landing_m(circuit(), parked(lat_deg=LAT + 1e-4))
    assert near == pytest.approx(11.1, abs=0.1)
    assert distance_from_landing_m(circuit(), parked()) == pytest.approx(0.0, abs=1e-3)
    assert distance_from_landing_m(circuit(lands=False), parked()) is None
    assert distance_from_landing_m(circuit(), telemetry()) is None
