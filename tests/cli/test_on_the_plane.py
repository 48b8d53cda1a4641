"""The command against a simulated plane over a real link."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

import pytest
import vencejo
from typer.testing import CliRunner, Result
from vencejo import MissionItem, Plan
from vencejo.cli.commands import app

from tests.support import HOME, simulated_plane, wait_for

pytestmark = pytest.mark.e2e

LAT, LON, _ = HOME


def east(metres: float) -> float:
    return LON + metres / 84_980.0


def north(metres: float) -> float:
    return LAT + metres / 111_050.0


def circuit() -> Plan:
    """Off to the west, round to the north, and back onto the place of take-off: about three minutes."""
    return Plan(
        items=(
            MissionItem.takeoff(LAT, east(-250), alt_rel_home_m=50.0, pitch_deg=15.0),
            MissionItem.waypoint(LAT, east(-500), alt_rel_home_m=70.0),
            MissionItem.waypoint(north(400), east(-300), alt_rel_home_m=70.0),
            MissionItem.waypoint(north(300), east(700), alt_rel_home_m=60.0),
            MissionItem.change_airspeed(14.0),
            MissionItem.waypoint(LAT, east(900), alt_rel_home_m=50.0),
            MissionItem.waypoint(LAT, east(500), alt_rel_home_m=35.0),
            MissionItem.land(LAT, LON),
        )
    )


@pytest.fixture
def plan_file(tmp_path: Path) -> Path:
    file = tmp_path / "circuit.waypoints"
    circuit().save(file)
    return file


@pytest.fixture(scope="module")
def parked_plane() -> Iterator[str]:
    """A plane that nobody flies."""
    with simulated_plane() as link:
        yield link


@pytest.fixture
def plane(request: pytest.FixtureRequest) -> Iterator[str]:
    """A plane to fly; fast where nobody talks with it in flight."""
    with simulated_plane("--seed", "3", "--speedup", str(getattr(request, "param", 1))) as link:
        yield link


in_a_hurry = pytest.mark.parametrize("plane", [10], indirect=True, ids=["10 times"])


@pytest.fixture(autouse=True)
def own_data_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("VENCEJO_DATA", str(tmp_path / "data"))


def run(*args: str, link: str) -> Result:
    return CliRunner().invoke(app, [*args, "--link", link])


def told(result: Result) -> list[dict[str, Any]]:
    return [json.loads(line) for line in result.stdout.splitlines()]


class Running:
    """The command as a process of its own, to send signals to."""

    def __init__(self, *args: str) -> None:
        command = [sys.executable, "-m", "vencejo.cli", *args]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        self.out: IO[str] = self.process.stdout

    def until(self, wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        for line in self.out:
            value: dict[str, Any] = json.loads(line)
            if wanted(value):
                return value
        _, errors = self.process.communicate(timeout=120)
        raise AssertionError(f"it ended with {self.process.returncode}: {errors}")

    def end(self, number: int | None = None) -> tuple[int, str, str]:
        if number is not None:
            self.process.send_signal(number)
        out, errors = self.process.communicate(timeout=60)
        return self.process.returncode, out, errors

    def __enter__(self) -> Running:
        return self

    def __exit__(self, *_: object) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()


@in_a_hurry
def test_fly(plane: str, plan_file: Path, tmp_path: Path) -> None:
    result = run("fly", str(plan_file), "--yes", "--json", link=plane)
    assert result.exit_code == 0, result.output
    events = told(result)
    acts = [
        event["event"]
        for event in events
        if event["event"] in ("loaded", "uploaded", "ready", "armed", "started", "end")
    ]
    assert acts == ["loaded", "uploaded", "ready", "armed", "started", "end"]
    assert events[-1]["outcome"] == "landed"
    assert events[-1]["landing_error_m"] < 20.0
    assert 100.0 < events[-1]["flight_time_s"] < 400.0
    reached = [event["item"] for event in events if event["event"] == "item_reached"]
    assert reached == sorted(reached)
    assert {2, 3, 4} & set(reached)
    pictures = [event for event in events if event["event"] == "progress"]
    assert max(picture["alt_rel_home_m"] for picture in pictures) > 60.0
    assert pictures[0]["total"] == 8
    recording = Path(events[-1]["recording"])
    assert recording.parent == tmp_path / "data" / "telemetry"
    summary = json.loads(CliRunner().invoke(app, ["replay", str(recording), "--json"]).stdout)
    kinds = [event["kind"] for event in summary["events"]]
    assert kinds.index("armed") < kinds.index("item_reached")


@in_a_hurry
def test_fly_again_and_again(plane: str, tmp_path: Path) -> None:
    """From where the last flight ended, in AUTO at the landing; each command is a driver of its own."""
    hop = tmp_path / "hop.waypoints"
    Plan(
        items=(
            MissionItem.takeoff(LAT, east(-250), alt_rel_home_m=40.0, pitch_deg=15.0),
            MissionItem.waypoint(north(150), east(-250), alt_rel_home_m=45.0),
            MissionItem.waypoint(LAT, east(500), alt_rel_home_m=40.0),
            MissionItem.land(LAT, LON),
        )
    ).save(hop)
    acts = ("preparing", "ready", "armed", "started", "end")
    for number in range(3):
        result = run("fly", str(hop), "--yes", "--json", link=plane)
        assert result.exit_code == 0, result.output
        events = [event for event in told(result) if event["event"] in acts]
        assert tuple(event["event"] for event in events) == (acts if number else acts[1:])
        assert events[-1]["outcome"] == "landed"
        assert events[-1]["landing_error_m"] < 20.0
        if number:
            # Its mission was replaced where it stood: that ends in RTL, which never arms.
            # Its own word of that may come after ours.
            assert events[0]["from_mode"] in {"AUTO", "RTL"}
            assert (events[0]["mode"], events[0]["rewinds_mission"]) == ("MANUAL", True)


def test_a_change_of_mode_is_told_and_not_undone(plane: str, plan_file: Path) -> None:
    with (
        Running("fly", str(plan_file), "--link", plane, "--yes", "--json", "--patience", "1") as flight,
        vencejo.connect(plane, record=False, own_component_id=191) as pilot,
    ):
        flight.until(lambda event: event["event"] == "item_reached")
        pilot.set_mode("LOITER")
        code, out, errors = flight.end()
        assert code == 1
        assert "left AUTO at item" in errors
        assert "it flies on in LOITER" in errors
        assert json.loads(out.splitlines()[-1])["ok"] is False
        assert pilot.telemetry.mode == "LOITER"


def test_ctrl_c_ends_the_following_only(plane: str, plan_file: Path) -> None:
    with (
        Running("fly", str(plan_file), "--link", plane, "--yes", "--json") as flight,
        vencejo.connect(plane, record=False, own_component_id=191) as watcher,
    ):
        flight.until(lambda event: event["event"] == "item_reached")
        code, _, errors = flight.end(signal.SIGINT)
        assert code == 130
        assert "The plane goes on flying: mode AUTO, item" in errors
        assert "Traceback" not in errors
        assert watcher.telemetry.mode == "AUTO"
        assert watcher.telemetry.is_armed


def test_a_mission_there_and_back(parked_plane: str, plan_file: Path, tmp_path: Path) -> None:
    sent = told(run("mission", "upload", str(plan_file), "--json", link=parked_plane))
    assert sent == [{"kind": "mission", "state": "verified", "count": 8, "hash": sent[0]["hash"]}]
    back = tmp_path / "back.waypoints"
    assert run("mission", "download", str(back), link=parked_plane).output.endswith("mission 8\n")
    commands = [item.command for item in circuit().items]
    assert [item.command for item in Plan.load(back).items] == commands
    shown = told(run("mission", "show", "--json", link=parked_plane))[0]
    assert [item["command"] for item in shown["items"]] == commands
    assert run("mission", "compare", str(back), link=parked_plane).stdout == "mission: as on board\n"
    shorter = tmp_path / "shorter.plan"
    Plan(items=circuit().items[1:]).save(shorter)
    differs = run("mission", "compare", str(shorter), "--kind", "all", link=parked_plane)
    first = "mission: item 1 on board is not in the file"
    assert (differs.exit_code, differs.stdout.splitlines()) == (3, [first, "fence: as on board", "rally: as on board"])
    step: dict[str, Any] = {"kind": "removed", "item": None, "on_board": 1, "fields": []}
    asked = run("mission", "compare", str(shorter), "--json", link=parked_plane)
    assert (asked.exit_code, told(asked)) == (3, [{"kind": "mission", "changes": [step]}])
    refused = run("mission", "clear", link=parked_plane)
    assert refused.exit_code == 2
    assert "add --yes" in refused.stderr
    assert run("mission", "clear", "--yes", link=parked_plane).exit_code == 0
    assert told(run("mission", "show", "--json", link=parked_plane))[0]["items"] == []


def test_a_fence_and_rally_points_there_and_back(parked_plane: str, tmp_path: Path) -> None:
    corners = [vencejo.GeoPoint(north(n), east(e)) for n, e in ((990, -990), (990, 990), (-990, 990), (-990, -990))]
    plan = Plan(
        items=circuit().items,
        fence=vencejo.Fence((vencejo.Polygon(tuple(corners)),)),
        rally=(vencejo.RallyPoint(north(100), east(100), 60.0),),
    )
    file = tmp_path / "field.plan"
    plan.save(file)
    sent = told(run("mission", "upload", str(file), "--kind", "all", "--json", link=parked_plane))
    assert [part["kind"] for part in sent] == ["mission", "fence", "rally"]
    back = tmp_path / "back.plan"
    assert run("mission", "download", str(back), "--kind", "all", link=parked_plane).exit_code == 0
    read = Plan.load(back)
    assert len(read.fence.zones) == 1
    assert len(read.rally) == 1
    shown = told(run("mission", "show", "--kind", "fence", "--json", link=parked_plane))[0]
    assert len(shown["fence"][0]["points"]) == 4


def test_parameters(parked_plane: str, tmp_path: Path) -> None:
    result = run("params", "get", "wp_radius", "RTL_AUTOLAND", link=parked_plane)
    assert result.exit_code == 0, result.output
    assert [line.split()[0] for line in result.stdout.splitlines()] == ["WP_RADIUS", "RTL_AUTOLAND"]
    changed = told(run("params", "set", "WP_RADIUS", "41", "--json", link=parked_plane))[0]
    assert changed["after"] == 41
    saved = tmp_path / "all.param"
    assert run("params", "save", str(saved), link=parked_plane).exit_code == 0
    assert vencejo.load_params(saved)["WP_RADIUS"] == 41.0
    asked = run("params", "set", "FENCE_ENABLE", "0", link=parked_plane)
    assert asked.exit_code == 2, "nobody is there to answer"
    assert "fence-off" in asked.stderr
    assert run("params", "set", "FENCE_ENABLE", "0", "--yes", link=parked_plane).exit_code == 0
    assert run("params", "set", "WP_RADIUS", "60", link=parked_plane).stdout == "WP_RADIUS 41 → 60\n"
    some = tmp_path / "some.param"
    some.write_text("WP_RADIUS,42\nWP_LOITER_RAD,80\nNO_SUCH_THING,1\n", encoding="utf-8")
    refused = run("params", "load", str(some), link=parked_plane)
    assert refused.exit_code == 2
    assert "60" in refused.stdout
    assert "left out: NO_SUCH_THING" in refused.stderr
    assert told(run("params", "get", "WP_RADIUS", "--json", link=parked_plane)) == [{"WP_RADIUS": 60}]
    loaded = run("params", "load", str(some), "--yes", "--json", link=parked_plane)
    assert told(loaded)[0]["refused"] == []
    assert told(run("params", "list", "WP_*", "--json", link=parked_plane))[0]["WP_RADIUS"] == 42
    unknown = run("params", "get", "NO_SUCH_THING", link=parked_plane)
    assert unknown.exit_code == 1
    assert "NO_SUCH_THING" in unknown.stderr


def test_one_thing_is_asked_for_by_its_name(parked_plane: str) -> None:
    assert run("ask", "mode", "mode=CIRCLE", link=parked_plane).stdout == "mode: done\n"
    assert told(run("ask", "mode", "mode=0", "--json", link=parked_plane)) == [
        {"request": "mode", "values": {"mode": 0}, "done": True}
    ]
    for words, says in (
        (("warp", "factor=9"), "there is no warp: one of arm, disarm, mode, takeoff,"),
        (("speed", "kind=airspeed"), "speed_m_s is missing (m/s, 0.1 to 200)"),
        (("speed", "kind=airspeed", "speed_m_s=9", "speed_m_s=99"), "speed_m_s is given twice"),
        (("speed", "kind=airspeed", "speed_m_s=fast"), 'speed_m_s is "fast", should be a number (m/s, 0.1 to 200)'),
        (("speed", "kind=airspeed", "speed_m_s=NaN"), "speed_m_s is NaN, should be 0.1 to 200 m/s"),
        (
            ("home", "lat_deg=40.3"),
            "lon_deg is missing, should be given with the others of lat_deg, lon_deg and alt_amsl_m",
        ),
        (("mission/current", "item=0"), "counted from 1"),
        (("set-message-rate", "message=ATTITUDES", "rate_hz=5"), "there is no message 'ATTITUDES'"),
        (("set-message-rate", "message=ATTITUDE", "rate_hz=1e3"), "rate_hz is 1000, should be 0.0005"),
        (("speed", "fast"), "NAME=VALUE"),
        (("reboot",), "(reboot)"),
        (("switch-fence", "on=false"), "(fence-off)"),
    ):
        refused = run("ask", *words, link=parked_plane)
        assert (refused.exit_code, says in refused.stderr) == (2, True), refused.output
    # Why it does not is told by the plane, as information.
    refused = run("ask", "set-message-rate", "message=WHEEL_DISTANCE", "rate_hz=1", link=parked_plane)
    assert (refused.exit_code, "No ap_message for mavlink id (9000)" in refused.stderr) == (1, True), refused.output
    for rate_hz in ("7", "stop", "default", "0"):
        asked = run("ask", "set-message-rate", "message=30", f"rate_hz={rate_hz}", link=parked_plane)
        assert asked.stdout == "set-message-rate: done\n", asked.output
    brought = told(run("ask", "request-message", "message=home_position", "--json", link=parked_plane))[0]
    assert (brought["message"], brought["fields"]["latitude"] / 1e7) == ("HOME_POSITION", pytest.approx(LAT, abs=1e-3))
    assert "latitude " in run("ask", "request-message", "message=242", link=parked_plane).stdout
    assert run("ask", "home", link=parked_plane).exit_code == 0


def test_telemetry_once(parked_plane: str) -> None:
    sample = told(run("telemetry", "--once", "--json", "--groups", "position,attitude,battery", link=parked_plane))[0]
    assert sorted(sample) == ["attitude", "battery", "position", "remote_name", "system_id", "time_s"]
    assert sample["position"]["lat_deg"] == pytest.approx(LAT, abs=1e-3)
    assert sample["battery"][0]["voltage_v"] > 10.0
    shown = run("telemetry", "--once", link=parked_plane)
    assert shown.exit_code == 0
    assert "heartbeat" in shown.stdout


@pytest.mark.parametrize("words", [["--json"], []], ids=["json", "lines"])
def test_telemetry_streams_until_ctrl_c(parked_plane: str, words: list[str]) -> None:
    with Running("telemetry", "--link", parked_plane, "--no-record", "--groups", "attitude", *words) as running:
        lines = [running.out.readline() for _ in range(4)]
        assert all("roll_rad" in line for line in lines[1:]), lines
        code, _, errors = running.end(signal.SIGINT)
    assert code == 130
    assert "Traceback" not in errors


def test_a_reader_that_goes_away_is_no_error_message(parked_plane: str) -> None:
    with Running("telemetry", "--link", parked_plane, "--no-record", "--json", "--rate", "20") as running:
        assert running.out.readline()
        running.out.close()
        assert running.process.stderr is not None
        errors = running.process.stderr.read()
        assert running.process.wait(20) != 0
    assert "Traceback" not in errors
    assert "internal error" not in errors


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_record_until_it_is_ended(parked_plane: str, tmp_path: Path, number: int) -> None:
    with Running("record", "--link", parked_plane, "--to", str(tmp_path / "flights"), "--json") as running:
        running.until(lambda told: told["recording"] is not None and told["recording"]["frames"] > 20)
        code, out, errors = running.end(number)
    assert code == 0, errors
    path = Path(json.loads(out.splitlines()[-1])["recording"]["path"])
    assert path.parent == tmp_path / "flights"
    summary = json.loads(CliRunner().invoke(app, ["replay", str(path), "--json"]).stdout)
    assert summary["frames"] > 20
    assert summary["skipped_bytes"] == 0


def test_links_of_a_live_vehicle(parked_plane: str) -> None:
    result = run("links", "--once", "--json", link=parked_plane)
    assert result.exit_code == 0, result.output
    assert told(result)[0]["links"][0]["state"] == "up"


def test_nothing_is_armed_by_looking(parked_plane: str) -> None:
    with vencejo.connect(parked_plane, record=False) as vehicle:
        wait_for(lambda: vehicle.telemetry.heartbeat is not None, "a heartbeat")
        assert vehicle.telemetry.is_armed is False
        assert vehicle.telemetry.mode == "MANUAL"
