"""Rehearsals through the Python package and the command, and one beside a recorded flight of a real ArduPlane."""

from __future__ import annotations

import _thread
import dataclasses
import json
import math
import os
import threading
from collections.abc import Callable
from pathlib import Path
from statistics import fmean
from typing import Any

import pytest
import vencejo
from typer.testing import CliRunner
from vencejo import Home, MissionItem, Plan
from vencejo.cli.commands import app
from vencejo.landing import Wind
from vencejo.params import load_params
from vencejo.recording import summarize
from vencejo.rehearsal import Battery, Elevation, Moment, learn, rehearse, rehearse_many
from vencejo.what_if import TRIGGERS, what_if

from tests.sim.flying import CAPTURES, FRAME, HOME, recorded, recorded_mission

HERE = Home(*HOME[:2], alt_amsl_m=HOME[2])


def plan_of(name: str) -> Plan:
    items = [
        MissionItem(stored.command, stored.frame, (stored.p1, stored.p2, stored.p3, stored.p4, *place), True)
        for stored in recorded_mission(name)[1:]
        for place in [(stored.lat_deg, stored.lon_deg, stored.alt_m)]
    ]
    return Plan(items=tuple(items), home=HERE)


def test_a_recorded_flight_is_rehearsed_as_it_was_flown() -> None:
    """Wind 6 m/s from 240°; climbs, a descent in a circle, a jump, a landing 30° off the wind."""
    parameters = load_params(CAPTURES / "arduplane-params.parm")
    flown = rehearse(
        plan_of("arduplane-wind-flight.tlog"), parameters=parameters, wind=Wind(240.0, 6.0), heading_deg=270.0
    )
    assert (flown.ending, flown.airframe) == ("landed", "simulator")
    track = [(moment, *FRAME.to_plane(moment.lat_deg, moment.lon_deg)) for moment in flown.track]
    across, heights, at = [], [], 0
    for message in recorded("arduplane-wind-flight.tlog"):
        if message.get_type() != "GLOBAL_POSITION_INT" or message.relative_alt < 500:
            continue
        north, east = FRAME.to_plane(message.lat / 1e7, message.lon / 1e7)
        nearby = range(max(0, at - 50), min(len(track) - 1, at + 100))
        _, at = min((math.hypot(track[i][1] - north, track[i][2] - east), i) for i in nearby)
        # The samples lie 5 m apart along the way; what is across is off the line between two.
        ahead = track[at + 1]
        leg_n, leg_e = ahead[1] - track[at][1], ahead[2] - track[at][2]
        length = math.hypot(leg_n, leg_e) or 1.0
        across.append(((north - track[at][1]) * leg_e - (east - track[at][2]) * leg_n) / length)
        heights.append(message.relative_alt / 1000.0 - track[at][0].alt_rel_home_m)
    assert len(across) > 1000
    assert math.sqrt(fmean(value**2 for value in across)) < 5.0
    assert math.sqrt(fmean(value**2 for value in heights)) < 3.0


def test_a_plane_is_learned_from_its_recording(tmp_path: Path) -> None:
    """From the calm flight, without being told that a simulator flew it; the wind and the pitot from the other."""
    calm = learn(CAPTURES / "arduplane-takeoff-to-landing.tlog")
    assert calm.wind.speed_m_s < 0.3
    assert calm.airframe.pitot == pytest.approx(
        1.033, abs=0.01
    )  # the simulator divides by true over equivalent airspeed twice
    assert 1.0 / (1.0 + calm.airframe.skid) == pytest.approx(0.747, abs=0.03)
    assert calm.airframe.throttle_cruise == pytest.approx(0.48, abs=0.04)
    assert math.degrees(calm.airframe.level_pitch_rad) == pytest.approx(-3.5, abs=0.5)
    # That simulator's propeller hangs 2 kg at 70 % throttle, which at 22 m/s is 7.3 m/s² more than its drag, and takes 50 A times the square of
    # the throttle at 12.6 V.
    assert calm.airframe.thrust_full_m_s2 - calm.airframe.drag_m_s2 == pytest.approx(7.3, rel=0.3)
    assert calm.airframe.power_exponent == pytest.approx(2.0, abs=0.4)
    assert calm.airframe.voltage_v == pytest.approx(12.6, abs=0.4)
    windy = learn(CAPTURES / "arduplane-wind-flight.tlog")
    assert windy.wind.speed_m_s == pytest.approx(6.0, abs=0.2)
    assert windy.wind.from_deg == pytest.approx(240.0, abs=3.0)
    plan = plan_of("arduplane-wind-flight.tlog")
    flown = rehearse(plan, airframe=calm.airframe, wind=windy.wind)
    assert (flown.ending, flown.airframe) == ("landed", "flight")
    (tmp_path / "empty.tlog").write_bytes(b"")
    with pytest.raises(vencejo.InvalidRequest, match="no flight to learn from"):
        learn(tmp_path / "empty.tlog")
    with pytest.raises(vencejo.FileFormatError):
        learn(tmp_path / "none.tlog")


def test_what_is_told_of_a_flight() -> None:
    items = (
        MissionItem.takeoff(*HOME[:2], alt_rel_home_m=50.0),
        MissionItem.waypoint(HOME[0] + 0.01, HOME[1], alt_rel_home_m=80.0),
        MissionItem.return_to_launch(),
    )
    plan = Plan(items=items, home=HERE)
    calm, windy = rehearse(plan), rehearse(plan, wind=Wind(0.0, 10.0))
    assert calm.ending == windy.ending == "returned"
    assert [passage.item for passage in calm.passages] == [1, 2, 3]
    assert windy.passages[1].reached_s > calm.passages[1].reached_s + 20.0  # type: ignore[operator]
    highest = max(calm.track, key=lambda moment: moment.alt_rel_home_m)
    assert isinstance(highest, Moment)
    assert highest.alt_amsl_m == pytest.approx(highest.alt_rel_home_m + HOME[2])
    gusty = [rehearse(plan, wind=Wind(0.0, 5.0), gust_m_s=2.0, seed=seed) for seed in (1, 1, 2)]
    assert gusty[0] == gusty[1] != gusty[2]
    with pytest.raises(vencejo.InvalidRequest, match="home"):
        rehearse(Plan(items=items))


def test_many_flights_give_the_odds() -> None:
    plan = plan_of("arduplane-wind-flight.tlog")
    parameters = load_params(CAPTURES / "arduplane-params.parm")
    odds = rehearse_many(plan, parameters=parameters, wind=Wind(240.0, 6.0), runs=12)
    assert (odds.runs, sum(odds.endings.values()), odds.endings["landed"] >= 10) == (12, 12, True)
    assert odds.duration_s.low < odds.expected.duration_s < odds.duration_s.high
    assert odds.energy_wh is not None
    assert odds.corridor[10].across_m.low <= odds.corridor[10].across_m.high
    assert odds == rehearse_many(plan, parameters=parameters, wind=Wind(240.0, 6.0), runs=12)
    with pytest.raises(vencejo.InvalidRequest, match="runs is 0, should be 1 to 100,000"):
        rehearse_many(plan, runs=0)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no file that never ends on this system")
def test_ctrl_c_ends_what_would_take_minutes(tmp_path: Path) -> None:
    plan = plan_of("arduplane-wind-flight.tlog")
    os.mkfifo(endless := tmp_path / "endless.tlog")
    calls: list[Callable[[], object]] = [
        lambda: rehearse_many(plan, runs=100_000),
        lambda: what_if(plan, [second / 1000.0 for second in range(1_000_000)]),
        lambda: learn(endless),
        lambda: summarize(endless),
    ]
    for call in calls:
        interrupt = threading.Timer(0.2, _thread.interrupt_main)
        interrupt.start()
        with pytest.raises(KeyboardInterrupt):
            call()
        interrupt.join()
    os.close(os.open(endless, os.O_RDWR))  # ends the reading that nobody waits for


def test_what_is_left_of_the_battery_is_told_where_it_is_known(tmp_path: Path) -> None:
    plan = plan_of("arduplane-wind-flight.tlog")
    assert rehearse(plan).battery_unknown == "power"
    learned = learn(CAPTURES / "arduplane-wind-flight.tlog").airframe
    assert rehearse(plan, airframe=learned).battery_unknown == "capacity"
    flown = rehearse(plan, airframe=learned, battery=Battery(capacity_mah=5_000.0))
    assert flown.battery is not None
    assert flown.energy_wh is not None
    assert flown.battery.capacity_wh == pytest.approx(5.0 * learned.voltage_v)  # type: ignore[operator]
    assert flown.battery.left_wh == pytest.approx(flown.battery.capacity_wh - flown.energy_wh)
    assert 0.2 < flown.battery.left < 1.0
    thirsty = rehearse(plan, battery=Battery(capacity_mah=5_000.0, voltage_v=11.1, power_cruise_w=120.0))
    assert thirsty.energy_wh == pytest.approx(2.0 * thirsty.duration_s / 60.0, rel=0.5), "120 W, more or less"
    small = rehearse(plan, airframe=learned, battery=Battery(capacity_mah=400.0, reserve_pct=30.0))
    assert [finding.code for finding in small.findings if finding.code.startswith("battery")] == ["battery-empty"]
    assert small.battery is not None
    assert small.battery.empty_s is not None
    odds = rehearse_many(plan, airframe=learned, battery=Battery(capacity_mah=5_000.0), runs=4)
    assert odds.battery_left is not None
    assert odds.battery_left.low < odds.battery_left.high
    assert odds.below_reserve == 0
    (back,) = what_if(plan, 60.0, ["return-asked"], airframe=learned, battery=Battery(capacity_mah=5_000.0))
    assert back.flown is not None
    assert back.flown.battery is not None
    for faulty in (Battery(capacity_mah=math.nan), Battery(reserve_pct=101.0)):
        with pytest.raises(vencejo.InvalidRequest, match=r"battery\.(capacity_mah|reserve_pct)"):
            rehearse(plan, battery=faulty)
    with pytest.raises(vencejo.InvalidRequest, match=r"airframe\.pitot"):
        rehearse(plan, airframe=dataclasses.replace(learned, pitot=math.nan))
    plan.save(tmp_path / "out.plan")
    recording = str(CAPTURES / "arduplane-wind-flight.tlog")
    said = ["plan", "rehearse", str(tmp_path / "out.plan"), "--capacity", "5000", "--learn", recording]
    assert "give --power" in CliRunner().invoke(app, said[:5]).output
    run = CliRunner().invoke(app, said)
    assert "% are left" in run.output, run.output


def test_a_landing_that_is_broken_off_is_flown_again() -> None:
    plan = plan_of("arduplane-wind-flight.tlog")
    flown = rehearse(plan)
    assert flown.touch_down is not None
    (again,) = what_if(plan, flown.touch_down.time_s - 8.0, ["go-around"])
    assert again.reaction == "goes-around"
    assert again.flown is not None
    assert again.flown.ending == "landed"
    assert again.flown.duration_s > flown.duration_s + 30.0


@pytest.mark.parametrize("call", [rehearse, rehearse_many, lambda plan: what_if(plan, 10.0)])
def test_what_is_no_plan_is_said(call: Callable[[Any], object]) -> None:
    with pytest.raises(TypeError, match=r"a Plan is wanted, not NoneType"):
        call(None)


def test_the_command_says_when_and_where(tmp_path: Path) -> None:
    file = tmp_path / "out.plan"
    plan = Plan(
        items=(
            MissionItem.takeoff(*HOME[:2], alt_rel_home_m=50.0),
            MissionItem.waypoint(HOME[0] + 0.02, HOME[1], alt_rel_home_m=60.0),
        ),
        home=HERE,
    )
    plan.save(file)
    run = CliRunner().invoke(app, ["plan", "rehearse", str(file), "--wind", "5", "--wind-from", "90", "--runs", "4"])
    assert run.exit_code == 0, run.output
    assert "NAV_WAYPOINT" in run.output
    assert "Circles over home" in run.output
    assert "Of 4 flights: 4 returned" in run.output
    told = CliRunner().invoke(app, ["plan", "rehearse", str(file), "--json"])
    assert json.loads(told.output)["ending"] == "returned"
    held = CliRunner().invoke(app, ["plan", "rehearse", str(file), "--wind", "40"])
    assert (held.exit_code, "HELD BY THE WIND" in held.output) == (1, True)


def test_what_fails_is_answered_as_the_vehicle_is_set() -> None:
    items = (
        MissionItem.takeoff(*HOME[:2], alt_rel_home_m=50.0),
        MissionItem.waypoint(HOME[0] + 0.03, HOME[1], alt_rel_home_m=80.0),
    )
    plan = Plan(home=HERE, items=items)
    set_to_return = {"FS_GCS_ENABL": 1.0, "FS_LONG_ACTN": 1.0, "FS_LONG_TIMEOUT": 20.0}
    early, late = what_if(plan, (40.0, 80.0), ["link-lost"], parameters=set_to_return)
    assert (early.trigger, early.reaction) == ("link-lost", "returns")
    assert early.decisions[0].time_s == pytest.approx(60.0, abs=0.2)
    assert early.flown is not None
    assert late.flown is not None
    assert early.flown.ending == late.flown.ending == "returned"
    assert early.flown.duration_s < late.flown.duration_s
    assert len(early.glide_range) == 72
    assert [one.trigger for one in what_if(plan, 40.0)] == list(TRIGGERS)
    assert what_if(plan, 0.0) == (), "on the ground"
    with pytest.raises(vencejo.InvalidRequest, match="growing"):
        what_if(plan, (80.0, 40.0))
    for no_moment in ("12", None):
        with pytest.raises(vencejo.InvalidRequest, match="moments are seconds"):
            what_if(plan, no_moment)  # type: ignore[arg-type]
    with pytest.raises(vencejo.InvalidRequest, match="engine-stopped"):
        what_if(plan, 40.0, ["meteor"])  # type: ignore[list-item]


def test_the_ground_is_that_of_a_file_or_of_a_function(tmp_path: Path) -> None:
    """A step of 100 m in latitude 40.34, and 5 m that the map is off everywhere, home included."""
    rows = [105 if 41.0 - row / 1200 > 40.34 else 5 for row in range(1201)]
    heights = b"".join(int(600 + height).to_bytes(2, "big") * 1201 for height in rows)
    (tmp_path / "N40W004.hgt").write_bytes(heights)
    home = Home(40.3332, -3.7978, alt_amsl_m=600.0)
    way = [MissionItem.waypoint(lat, -3.7978, alt_rel_home_m=120.0) for lat in (40.338, 40.346, 40.35)]
    plan = Plan(home=home, items=(MissionItem.takeoff(40.3332, -3.7978, alt_rel_home_m=80.0), *way))
    elevation = Elevation(tmp_path)
    assert elevation(40.3332, -3.7978) == 605.0
    assert elevation(10.0, 10.0) is None
    flown = rehearse(plan, ground=elevation)
    assert [(finding.code, finding.item) for finding in flown.findings] == [("near-ground", 3), ("near-ground", 4)]
    assert flown.track[0].clearance_m == pytest.approx(0.0, abs=0.1)
    assert min(moment.clearance_m or 99.0 for moment in flown.track if moment.item == 4) == pytest.approx(20.0, abs=4.0)
    assert rehearse(plan, ground=elevation, clearance_m=10.0).findings == ()
    stepped = rehearse(plan, ground=lambda lat, _: 700.0 if lat > 40.34 else 600.0)
    assert [finding.item for finding in stepped.findings] == [3, 4]
    assert rehearse(plan).track[0].clearance_m is None
    assert rehearse_many(plan, ground=elevation, runs=2).expected == flown
    (back,) = what_if(plan, flown.passages[3].begins_s, ["return-asked"], ground=elevation)
    assert back.flown is not None
    lowest_m = min(moment.clearance_m or 99.0 for moment in back.flown.track)
    assert lowest_m < 15.0, "it sinks towards 100 m, over ground as high"
    with pytest.raises(ZeroDivisionError):
        rehearse(plan, ground=lambda *_: 1 / 0)
    with pytest.raises(vencejo.FileFormatError, match="nothing"):
        Elevation(tmp_path / "nothing.hgt")
    plan.save(tmp_path / "mission.plan")
    said = CliRunner().invoke(app, ["plan", "rehearse", str(tmp_path / "mission.plan"), "--ground", str(tmp_path)])
    assert "above the ground" in said.output, said.output


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"wind": Wind(math.nan, 5.0)}, "wind.from_deg"),
        ({"wind": Wind(0.0, 61.0)}, "wind.speed_m_s"),
        ({"heading_deg": math.nan}, "heading_deg"),
        ({"gust_m_s": -1.0}, "gust_m_s"),
        ({"seed": -1}, "seed"),
        ({"clearance_m": math.inf}, "clearance_m"),
    ],
)
def test_a_number_that_cannot_be_is_named(given: dict[str, Any], named: str) -> None:
    plan = Plan(home=HERE, items=(MissionItem.takeoff(*HOME[:2], alt_rel_home_m=50.0),))
    with pytest.raises(vencejo.InvalidRequest, match=named):
        rehearse(plan, **given)
    if given.keys() & {"wind", "heading_deg"}:
        with pytest.raises(vencejo.InvalidRequest, match=named):
            what_if(plan, 10.0, **given)
