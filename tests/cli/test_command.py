"""The command without a vehicle: help, usage, errors, files."""

from __future__ import annotations

import contextlib
import inspect
import io
import json
import os
import re
import shlex
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
import typer
import vencejo
import vencejo.errors
from typer.testing import CliRunner, Result
from vencejo.cli import common
from vencejo.cli.aboard import KNOWS, LinkNote, PlaneLinks, link_checks
from vencejo.cli.commands import app
from vencejo.cli.common import EXIT_CODES, Exit, clean, describe_error
from vencejo.cli.connecting import why_not_up
from vencejo.cli.demo import demo_mission
from vencejo.cli.map_areas import _wanted
from vencejo.cli.onboard import tell_status
from vencejo.cli.params import Change, compare, write_all
from vencejo.cli.record import _watch_recording
from vencejo.cli.serve import tell_storage
from vencejo.params import same
from vencejo.recording import summarize
from vencejo.storage import StorageProblem
from vencejo.values import Parameter

if KNOWS:
    import fcntl

from tests.cli.doubles import FakeStation
from tests.support import CAPTURES, reserved_ports, wait_for

FLIGHT = CAPTURES / "arduplane-takeoff-to-landing.tlog"


def run(*args: str, **env: str) -> Result:
    return CliRunner().invoke(app, list(args), env={"VENCEJO_LINK": "", "VENCEJO_DEBUG": "", **env})


def commands() -> dict[str, Any]:
    """All commands by their words, groups included."""
    found: dict[str, Any] = {}

    def walk(command: Any, words: tuple[str, ...]) -> None:
        found[" ".join(words)] = command
        for name, child in getattr(command, "commands", {}).items():
            walk(child, (*words, name))

    walk(typer.main.get_command(app), ())
    return found


COMMANDS = commands()


def test_all_commands_are_there() -> None:
    assert {
        "fly",
        "telemetry",
        "mission upload",
        "mission download",
        "mission clear",
        "mission show",
        "params get",
    } <= set(COMMANDS)
    assert {
        "params set",
        "params save",
        "params load",
        "params list",
        "links",
        "record",
        "replay",
        "sim",
        "demo",
    } <= set(COMMANDS)


@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: words or "vencejo")
def test_help_has_an_example_that_can_be_run(words: str) -> None:
    text = COMMANDS[words].help or ""
    examples = re.findall(r"Example: vencejo ([^\n]+)", text)
    assert examples, f"vencejo {words} --help has no example"
    for example in examples:
        args = shlex.split(example)
        assert " ".join(args).startswith(words), example
        command, rest = COMMANDS[words], args[len(words.split()) :]
        while getattr(command, "commands", None) and rest:
            command, rest = command.commands[rest[0]], rest[1:]
        command.make_context("vencejo", rest, resilient_parsing=False)


@pytest.mark.parametrize("words", [words for words in COMMANDS if words != "sim"])
def test_help_is_shown(words: str) -> None:
    result = run(*words.split(), "--help")
    assert result.exit_code == 0, result.output
    assert "Example: vencejo" in result.output


def test_alone_it_shows_help() -> None:
    result = run()
    assert result.exit_code == 0
    assert "Usage: vencejo" in result.output
    assert "Exit codes" in result.output


def test_ctrl_c_while_it_starts_shows_no_traceback() -> None:
    program = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background ignores it
class Interrupting:
    def find_spec(self, name, *_):
        if name == "typer":
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Interrupting())
from vencejo.cli import main
main()
"""
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, timeout=60, check=False)
    assert (ended.returncode, ended.stderr) == (130, b"")


def test_version() -> None:
    result = run("--version")
    assert (result.exit_code, result.output) == (0, f"vencejo {vencejo.__version__}\n")


@pytest.mark.parametrize(
    "args",
    [
        ("nonsense",),
        ("links", "--nonsense"),
        ("params", "get"),
        ("params", "set", "WP_RADIUS", "many"),
        ("params", "set", "WP_RADIUS", "nan"),
        ("telemetry", "--rate", "1000"),
        ("telemetry", "--groups", "attitude,nonsense"),
        ("telemetry", "--groups", ","),
        ("mission", "download", "mission.txtx"),
        ("mission", "download", "plan.waypoints", "--kind", "all"),
        ("fly", str(demo_mission())),
    ],
    ids=" ".join,
)
def test_wrong_usage_ends_with_2_and_says_so(args: tuple[str, ...]) -> None:
    result = run(*args)
    assert result.exit_code == Exit.USAGE, result.output
    assert result.stderr.strip()
    assert "Traceback" not in result.stderr


def test_every_exception_has_an_exit_code() -> None:
    ours = {
        name
        for name, kind in inspect.getmembers(vencejo.errors, inspect.isclass)
        if issubclass(kind, vencejo.VencejoError)
    }
    assert len(ours) > 10
    assert set(EXIT_CODES) == ours
    for name in ours:
        code, text = describe_error(getattr(vencejo.errors, name)("what was wrong"))
        assert code is EXIT_CODES[name]
        assert text == "what was wrong"


def test_errors_tell_what_the_vehicle_said() -> None:
    told = ("Compass not healthy", "not armed")
    refused = vencejo.CommandRefused("not armed", reasons=told, remedies=("calibrate it",))
    assert describe_error(refused) == (Exit.FAILED, "not armed\n  Compass not healthy\n  To do: calibrate it")
    mismatch = vencejo.PlanMismatch("not verified", differences=("item 2: altitude 80, kept 79",))
    assert describe_error(mismatch)[1].endswith("\n  item 2: altitude 80, kept 79")
    assert describe_error(FileNotFoundError(2, "No such file", "x.param")) == (1, "x.param: No such file")
    assert "internal error" in describe_error(RuntimeError("oh"))[1]


@pytest.mark.parametrize("place", [0, 1, 2])
def test_debug_shows_the_traceback_wherever_it_stands(place: int) -> None:
    words = ["replay", "nothing.tlog"]
    plain = run(*words)
    assert plain.exit_code == 1
    assert plain.stderr == "Error: nothing.tlog: there is no such file\n"
    result = run(*words[:place], "--debug", *words[place:])
    assert result.exit_code == 1
    assert "Traceback" in result.stderr


def test_text_from_outside_cannot_steer_the_terminal() -> None:
    assert clean("a\x1b[31mb\rc\nd") == "a\ufffd[31mb\ufffdc\ufffdd"
    assert clean("a\nb", keep_lines=True) == "a\nb"


@pytest.mark.parametrize("fault", [BrokenPipeError(32, "Broken pipe"), OSError(5, "Input/output error"), ValueError()])
def test_those_who_serve_go_on_when_nobody_reads_what_they_say(
    fault: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    written: list[str] = []

    class Gone(io.StringIO):
        def write(self, text: str) -> int:
            written.append(text)
            raise fault

    for name in ("stderr", "stdout"):
        monkeypatch.setattr(sys, name, Gone())
    low = StorageProblem(what="maps", fault="low_space", text="maps are not kept")
    told = tell_storage([low], {})
    assert tell_storage([], told) == {}
    for as_json in (False, True):
        status: Any = SimpleNamespace(
            is_connected=False, holder=None, problem="no router", autopilot_silent_s=None, links=None
        )
        assert tell_status(status, None, json=as_json) == (False, None, frozenset({"no router"}), None)
    assert len(written) == 4


def test_a_silent_autopilot_is_told_on_board_once_and_when_it_changes(capsys: pytest.CaptureFixture[str]) -> None:
    told = None
    for silent_s, links in [
        (None, None),
        (5.2, "serial:/dev/ttyS0:57600 (not open: no such device)"),
        (6.2, "serial:/dev/ttyS0:57600 (not open: no such device)"),
        (9.0, "serial:/dev/ttyS0:57600 (open, no MAVLink in 90 bytes: another baud rate?)"),
        (10.0, "serial:/dev/ttyS0:57600 (open, no MAVLink in 900 bytes: another baud rate?)"),
        (None, None),
    ]:
        status: Any = SimpleNamespace(
            is_connected=False, holder=None, problem=None, autopilot_silent_s=silent_s, links=links
        )
        told = tell_status(status, told, json=False)
    assert capsys.readouterr().err.splitlines() == [
        "Not in the fleet yet",
        "Warning: no message of the autopilot for 5 s: serial:/dev/ttyS0:57600 (not open: no such device)",
        "Warning: no message of the autopilot for 9 s: serial:/dev/ttyS0:57600 (open, no MAVLink in 90 bytes: another baud rate?)",
        "The autopilot is heard.",
    ]


@pytest.mark.skipif(not KNOWS, reason="no locks that show that a program runs")
def test_the_doctor_on_board_knows_the_link_of_the_running_program(tmp_path: Path) -> None:
    path = tmp_path / "onboard.links"

    def found() -> tuple[bool, str]:
        (check,) = link_checks(path)
        return check.ok, check.message

    assert "is not running here" in found()[1]
    heard = PlaneLinks(name=None, links=("/dev/ttyS0,57600",), silent_since=None, states=None)
    started = time.time()
    with LinkNote(path) as note, pytest.MonkeyPatch.context() as clocks:
        clocks.setattr(time, "monotonic", lambda: 1_000.0)
        with (tmp_path / ".onboard.links.lock").open("w") as doctor:
            fcntl.flock(doctor, fcntl.LOCK_SH)  # one that looks at the start
            note.write([heard])
        note.write([heard])
        assert found() == (True, "the autopilot is heard on /dev/ttyS0,57600")
        silent: Any = SimpleNamespace(autopilot_silent_s=64.0, links="serial:/dev/ttyS0:57600 (open, nothing received)")
        seen: list[bool] = []

        def dumps(planes: Any, dumps: Any = json.dumps) -> Any:
            seen.append(found()[0])
            return dumps(planes)

        with clocks.context() as writing:
            writing.setattr(json, "dumps", dumps)
            note.write([PlaneLinks.of(None, heard.links, silent)])
        assert seen == [True], "the note is whole while another is written"
        # A computer without a battery for its clock gets the time from the network.
        clocks.setattr(time, "time", lambda: started + 2e8)
        assert found() == (False, f"no message of the autopilot for 64 s: {silent.links}")
        with LinkNote(path) as second:
            second.write([heard])
        assert not found()[0], "the first one has the file"
    assert "is not running here" in found()[1]


def test_a_link_that_cannot_be_read() -> None:
    result = run("params", "get", "WP_RADIUS", "--link", "bogus:1")
    assert result.exit_code == 2
    assert "bogus" in result.stderr
    assert "udpin:0.0.0.0:14550" in result.stderr


def test_a_refused_link_is_told_while_it_is_waited_for() -> None:
    with reserved_ports() as (port,), vencejo.Station(f"tcp:127.0.0.1:{port}", record=False) as station:
        wait_for(lambda: why_not_up(station) is not None, "the refusal")
        told = why_not_up(station)
    assert told is not None
    assert re.fullmatch(rf"tcp:127\.0\.0\.1:{port}: cannot connect .* refused .* It is tried again", told)


@pytest.mark.parametrize("args", [("signing", "keys"), ("fleet", "history"), ("maps", "list"), ("fleet", "status")])
def test_a_data_folder_that_is_a_file_is_named(args: tuple[str, ...], tmp_path: Path) -> None:
    file = tmp_path / "data"
    file.touch()
    result = CliRunner().invoke(app, [*args], env={"VENCEJO_DATA": str(file)})
    assert (result.exit_code, f"VENCEJO_DATA is {file}, a file" in result.stderr) == (2, True), result.output


def test_no_vehicle() -> None:
    result = run("params", "get", "WP_RADIUS", "--link", "udpin:127.0.0.1:0", "--timeout", "0.1")
    assert result.exit_code == 1
    assert "no vehicle was heard" in result.stderr


def test_links_lists_every_form() -> None:
    shown = run("links")
    assert shown.exit_code == 0
    told = json.loads(run("links", "--json").output)
    assert len(told["forms"]) >= 7
    for form in told["forms"]:
        assert form["example"] in shown.output
    assert isinstance(told["serial_ports"], list)


def test_a_silent_link_is_told() -> None:
    result = run("links", "--link", "udpin:127.0.0.1:0", "--once", "--timeout", "0.1", "--json")
    assert result.exit_code == 1
    assert json.loads(result.stdout)["links"][0]["frames_received"] == 0
    assert "nothing was heard within 0.1 s" in result.stderr


def test_mission_show_of_a_file() -> None:
    shown = run("mission", "show", str(demo_mission()))
    assert shown.exit_code == 0, shown.output
    assert "NAV_LAND" in shown.output
    told = json.loads(run("mission", "show", str(demo_mission()), "--json").output)
    assert [item["item"] for item in told["items"]] == list(range(1, len(told["items"]) + 1))
    assert told["items"][-1]["name"] == "NAV_LAND"
    assert told["items"][-1]["lat_deg"] == pytest.approx(40.3332)
    assert 8_000 < told["length_m"] < 14_000


def test_an_output_that_is_not_utf_8_ends_no_command() -> None:
    """On Windows what is redirected is cp1252, which has no arrow; a report of the vehicle must not end the flight's."""
    program = """
from vencejo.cli.common import take_any_character
from vencejo.cli.report import Reporter
take_any_character()
for json in (False, True):
    Reporter(json=json).step("mode", "mode AUTO → RTL 😀 é")
"""
    env = {**os.environ, "PYTHONIOENCODING": "cp1252"}
    shown = subprocess.run([sys.executable, "-c", program], env=env, capture_output=True, timeout=60, check=True)
    line, told = shown.stdout.decode("cp1252").splitlines()
    assert line == "mode AUTO \\u2192 RTL \\U0001f600 é"
    assert json.loads(told)["text"] == "mode AUTO → RTL 😀 é"
    with pytest.raises(UnicodeEncodeError) as caught:
        "→".encode("cp1252")
    assert describe_error(caught.value)[0] is Exit.FAILED, "which is no wrong usage"


def test_the_demo_mission_is_sound() -> None:
    plan = vencejo.Plan.load(demo_mission())
    assert plan.check(position=plan.home, on_ground=True) == ()
    commands = [item.command for item in plan.items]
    for wanted in ("NAV_TAKEOFF", "NAV_WAYPOINT", "NAV_LOITER_TURNS", "DO_CHANGE_SPEED", "NAV_LAND"):
        assert vencejo.Command[wanted] in commands


def test_a_mission_is_given_the_best_landing_of_a_runway(tmp_path: Path) -> None:
    mission, landed = demo_mission(), tmp_path / "landed.plan"
    asked = ("--runway", "40.3332,-3.7978,40.3332,-3.7943", "--wind", "6", "--wind-from", "250")
    shown = run("plan", "land", str(mission), *asked, "--write", str(landed))
    assert shown.exit_code == 0, shown.output
    first, *_ = [line for line in shown.output.splitlines() if "270°" in line]
    assert "good" in first
    assert "6 m/s of headwind" in first
    items = vencejo.Plan.load(landed).items
    assert [item.name for item in items[-3:]] == ["DO_LAND_START", "NAV_LOITER_TO_ALT", "NAV_LAND"]
    assert [item.name for item in items].count("NAV_LAND") == 1, "in place of the one that was there"
    found = json.loads(run("plan", "land", str(mission), *asked, "--json").stdout)
    assert [one["verdict"] for one in found] == ["good", "good", "doubtful", "doubtful"]
    for wrong in (("--runway", "1,2"), ("--at", "40,-3", "--runway", "1,2,3,4"), ("--choice", "99")):
        assert run("plan", "land", str(mission), *wrong).exit_code != 0, wrong


def test_offline_maps_around_a_plan_leave_out_what_is_not_flown_to(tmp_path: Path) -> None:
    home = vencejo.Home(40.33, -3.79, 600.0)
    items = (
        vencejo.MissionItem.takeoff(0.0, 0.0, alt_rel_home_m=40.0),
        vencejo.MissionItem.waypoint(40.34, -3.80, alt_rel_home_m=60.0),
        vencejo.MissionItem.land_start(0.0, 0.0, alt_rel_home_m=40.0),
    )
    file = tmp_path / "field.plan"
    vencejo.Plan(items=items, home=home).save(file)
    shape = _wanted("pnoa", "Field", file, 500.0, None, "8-17")["shape"]
    assert shape["points"] == [{"lat_deg": 40.33, "lon_deg": -3.79}, {"lat_deg": 40.34, "lon_deg": -3.80}]


def test_a_plan_that_cannot_be_read(tmp_path: Path) -> None:
    broken = tmp_path / "broken.waypoints"
    broken.write_text("QGC WPL 110\n1\t0\tthree\n", encoding="utf-8")
    for words in (["fly", "--yes"], ["mission", "show"], ["mission", "upload"]):
        result = run(*words, str(broken))
        assert result.exit_code == 1
        assert "line 2" in result.stderr, result.stderr
        assert "Traceback" not in result.stderr


def test_a_file_with_a_fence_alone_is_not_flown_and_says_how_it_is_sent(tmp_path: Path) -> None:
    fence = tmp_path / "fence.waypoints"
    fence.write_text("QGC WPL 110\n0 0 0 5003 500 0 0 0 40 -3 0 0\n", encoding="utf-8")
    for words in (["fly", "--yes"], ["mission", "upload"]):
        result = run(*words, str(fence), "--link", "udpin:127.0.0.1:0")
        assert result.exit_code == 1
        assert f"holds no mission: send its fence with `vencejo mission upload {fence} --kind fence`" in result.stderr


def test_a_plan_with_an_error_is_not_flown(tmp_path: Path) -> None:
    empty = tmp_path / "empty.waypoints"
    vencejo.Plan().save(empty)
    result = run("fly", str(empty), "--yes", "--json", "--link", "udpin:127.0.0.1:0")
    assert result.exit_code == 1, result.output
    assert "nothing was sent" in result.stderr
    assert json.loads(result.stdout.splitlines()[0])["event"] == "finding"


def test_files_are_not_overwritten(tmp_path: Path) -> None:
    for words, name in ((["params", "save"], "here.param"), (["mission", "download"], "here.plan")):
        file = tmp_path / name
        file.write_text("precious", encoding="utf-8")
        result = run(*words, str(file), "--link", "udpin:127.0.0.1:0")
        assert result.exit_code == 1
        assert "add --force" in result.stderr
        assert file.read_text(encoding="utf-8") == "precious"


def test_summary_of_a_recording() -> None:
    shown = run("replay", str(FLIGHT))
    assert shown.exit_code == 0, shown.output
    assert "ArduPilot plane" in shown.output
    assert "Throttle armed" in shown.output
    told = json.loads(run("replay", str(FLIGHT), "--json").output)
    assert sum(told["messages"].values()) == told["frames"] > 10_000
    assert told["duration_s"] == pytest.approx(302.85, abs=0.1)
    kinds = [event["kind"] for event in told["events"]]
    assert kinds.count("armed") == 1
    assert kinds.index("armed") < kinds.index("item_reached")


def test_what_no_command_takes() -> None:
    for args, said in [
        (("maps", "area", "estimate", "pnoa", "--box", "1,2,3,4", "--buffer", "inf"), "--buffer is inf, should be"),
        (("plan", "survey", "field.plan", "--height", "nan"), "--height is nan, should be"),
        (("params", "set", "WP_RADIUS", "nan"), "VALUE is nan, should be"),
        (("ask", "make-coffee"), "make-coffee"),
        (("ask", "speed", "kind=airspeed", "speed_m_s=fast"), "speed_m_s"),
        (("fleet", "history", "--folder", "/no/such"), "is not a folder"),
        (("camera", "\udcff.mp4"), ".mp4 is not UTF-8"),
        (("tokens",), "--new all"),
        (("plan", "land", str(demo_mission()), "--at", "40,-3", "--runway", "1,2,3,4"), "give one of them"),
        (("serve", "--fleet-listen", "tcp/127.0.0.1:0"), "are for --fleet ORG"),
        (("serve", "--listen", "everyone", "--link", "udpin:127.0.0.1:0"), "--listen is for the default link"),
        (("serve", "--no-record", "--link", "udpin:127.0.0.1:0", "--allow-origin", "*"), "'*' is no origin of a page"),
        (("serve", "--no-record", "--link", "udpin:127.0.0.1:0", "--allow-host", ""), "'' is no name of a machine"),
    ]:
        result = run(*args)
        assert result.exit_code == 2, result.output
        assert said in result.stderr


def test_what_takes_long_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    told = threading.Event()
    monkeypatch.setattr(common, "LONG_S", 0.0)
    monkeypatch.setattr(common, "say", lambda text: told.set() if text == "still here" else None)
    with common.told_when_long("still here"):
        assert told.wait(60.0)


def test_how_a_recording_goes_is_status(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys.modules[_watch_recording.__module__], "_every", lambda period_s: [None, None])
    _watch_recording(cast("vencejo.Station", FakeStation()), 0.0, json=False)
    shown = capsys.readouterr()
    assert (shown.out, shown.err) == ("", "nothing is recorded\n" * 2)


def test_what_is_no_recording(tmp_path: Path) -> None:
    noise = tmp_path / "noise.tlog"
    noise.write_bytes(bytes(range(256)) * 40)
    result = run("replay", str(noise))
    assert result.exit_code == 1
    assert "holds no MAVLink frame" in result.stderr


def test_what_is_there_and_no_file_is_not_said_to_be_missing(tmp_path: Path) -> None:
    assert run("replay", str(tmp_path)).stderr == f"Error: {tmp_path}: it is not a file\n"
    empty = tmp_path / "flight.mcap"
    empty.write_bytes(b"\x89MCAP0\r\n")
    result = run("replay", str(empty))
    assert (result.exit_code, "holds no record of an aircraft" in result.stderr) == (1, True), result.output


def test_no_key_is_made_of_an_empty_passphrase(tmp_path: Path) -> None:
    result = run("signing", "new-key", "club", "--passphrase", VENCEJO_DATA=str(tmp_path))
    assert (result.exit_code, "everybody knows" in result.stderr) == (2, True), result.output


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="Linux has it")
def test_an_endless_key_file_is_read_to_its_limit(tmp_path: Path) -> None:
    for words in (["signing", "new-key", "k"], ["fleet", "init", "acme", "--ca-cert", "/dev/null"]):
        option = "--file" if words[0] == "signing" else "--ca-key"
        result = run(*words, option, "/dev/zero", VENCEJO_DATA=str(tmp_path))
        assert (result.exit_code, "/dev/zero: it has more than" in result.stderr) == (1, True), result.output


NO_FLIGHT = "QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t40\t-3\t600\t1\n1\t0\t3\t16\t0\t0\t0\t0\t-40\t-3\t100\t1\n"
"""Its only item is out of reach."""


def run_alone(*arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run a command as a process whose output Python buffers, as it does by default."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    program = [sys.executable, "-c", "from vencejo.cli import main; main()", *arguments]
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
    return subprocess.run(program, text=True, timeout=60, check=False, env=environment, **streams)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="Linux has it")
@pytest.mark.parametrize("arguments", [("--help",), ("links", "--json"), ("plan", "check", "bad.waypoints")])
def test_a_full_disk_below_the_output_is_told(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    """Of help, of a command that is done, and of one that ends with a code of its own."""
    (tmp_path / "bad.waypoints").write_text(NO_FLIGHT)
    with Path("/dev/full").open("w") as full:
        ended = run_alone(*arguments, stdout=full, cwd=tmp_path)
    assert (ended.returncode, ended.stderr) == (1, "Error: the output: No space left on device\n")


@pytest.mark.skipif(os.name != "posix", reason="a closed descriptor")
def test_it_runs_without_an_output() -> None:
    """As a service manager or a script (``>&-``) may start it."""
    ended = run_alone("links", preexec_fn=lambda: os.close(1))
    assert (ended.returncode, ended.stderr) == (0, "")


def test_replay_to_a_station() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as station:
        station.bind(("127.0.0.1", 0))
        to = f"udpout:127.0.0.1:{station.getsockname()[1]}"
        file = CAPTURES / "mission-upload-items.tlog"
        result = run("replay", str(file), "--to", to, "--speed", "100", "--json")
        assert result.exit_code == 0, result.output
        told = json.loads(result.stdout)
        assert list(told["sent"]) == [to]
        assert told["sent"][to] == told["frames"], "both sides of the conversation"
        recorded = file.read_bytes()
        station.settimeout(5.0)
        first = station.recv(2048)
        assert first[0] == 0xFD
        assert first in recorded, "untouched"


def scripted_links(
    monkeypatch: pytest.MonkeyPatch, *looks: tuple[str, int], detail: str | None = None
) -> list[tuple[str, bool]]:
    """A station whose one link shows this state and these frames sent at each look; the looks taken."""
    left = iter(looks)
    states: list[tuple[str, bool]] = []

    class Scripted:
        def __init__(self, **_: Any) -> None:
            self.played = False

        def __enter__(self) -> Scripted:
            return self

        def __exit__(self, *_: object) -> None: ...

        def open_link(self, address: str, **_: Any) -> int:
            self.played = address.startswith("tlog:")
            return int(self.played)

        @property
        def links(self) -> list[Any]:
            state, sent = next(left)
            states.append((state, self.played))
            return [SimpleNamespace(id=0, address="udpout:there", state=state, detail=detail, frames_sent=sent)]

    monkeypatch.setattr(vencejo, "Station", Scripted)
    return states


def test_a_replay_to_a_link_that_does_not_open_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules[_watch_recording.__module__], "UP_WITHIN_S", 0.0)
    scripted_links(monkeypatch, ("connecting", 0), detail="connection refused")
    result = run("replay", str(CAPTURES / "mission-upload-items.tlog"), "--to", "udpout:there")
    assert result.exit_code == 1
    assert "udpout:there is not open: connection refused\n" in result.stderr
    assert "nothing could be sent to udpout:there" in result.stderr


def test_a_replay_begins_when_its_links_are_up_and_ends_when_the_last_frame_has_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    file = CAPTURES / "mission-upload-items.tlog"
    frames = summarize(file).frames
    # It comes up, and when the recording has ended its last frame is still to leave.
    looks = [("connecting", 0), ("up", 0), ("up", frames - 1), ("up", frames - 1), ("up", frames)]
    states = scripted_links(monkeypatch, *looks)
    told = json.loads(run("replay", str(file), "--to", "udpout:there", "--json").stdout)
    assert told["sent"] == {"udpout:there": frames}
    assert states[:3] == [("connecting", False), ("up", False), ("up", True)]


def test_same_value_in_a_file_and_on_a_vehicle() -> None:
    def is_same(value: float, wanted: float, kind: int = 9) -> bool:
        return same(Parameter("ANY", value, kind), wanted)

    assert is_same(0.10000000149011612, 0.1)
    assert is_same(943.2181, 943.21814)
    assert not is_same(50.0, 50.1)
    assert not is_same(0.0, 1e300)
    assert is_same(1_048_574.0, 1_048_572.0)
    assert not is_same(1_048_574.0, 1_048_572.0, kind=6), "one bit of a mask"
    assert is_same(16_777_216.0, 16_777_217.0, kind=6), "what a vehicle that tells it as a float makes of it"


@pytest.mark.parametrize("end", [None, vencejo.CommandTimeout("no answer"), KeyboardInterrupt()])
def test_a_file_of_parameters_tells_what_became_of_each(
    end: BaseException | None, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    has: dict[str, float] = {}

    def set_(name: str, value: float, confirm: str | None = None) -> None:
        if name == "FENCE_ENABLE" and confirm is None:
            raise vencejo.ConfirmationNeeded("it switches the fence off", "fence-off")
        if name == "NEVER":
            raise vencejo.ParameterError("the vehicle kept 3")
        if name == "ENDS" and end is not None:
            raise end
        has[name] = value

    monkeypatch.setattr("vencejo.cli.params.confirm", lambda question, *, yes: False)
    vehicle: Any = SimpleNamespace(params=SimpleNamespace(set=set_))
    names = ["A", "FENCE_ENABLE", "NEVER", "B", "ENDS", "LAST"]
    with contextlib.suppress(vencejo.CommandTimeout, KeyboardInterrupt):
        refused = write_all(vehicle, Path("x"), [Change(name, 1.0, 0.0) for name in names], yes=False, json=True)
        assert refused == ["FENCE_ENABLE", "NEVER"]
    said = capsys.readouterr()
    shown = {"file": "x", "written": len(has), "refused": ["FENCE_ENABLE", "NEVER"]}
    if end is None:
        assert list(has) == ["A", "B", "ENDS", "LAST"]
        assert json.loads(said.out) == {**shown, "unknown": None, "untried": []}
        return
    assert list(has) == ["A", "B"]
    assert json.loads(said.out) == {**shown, "unknown": "ENDS", "untried": ["LAST"]}
    assert "It ended while ENDS was being written" in said.err
    assert "Not tried: LAST" in said.err


def test_what_a_parameter_file_would_change() -> None:
    here = {
        name: vencejo.Parameter(name, value, 9) for name, value in {"A": 1.0, "B": 2.0, "STAT_RUNTIME": 5.0}.items()
    }
    changes, unknown = compare({"A": 1.0, "B": 3.0, "C": 4.0, "STAT_RUNTIME": 9.0}, here)
    assert [(change.name, change.present, change.wanted) for change in changes] == [("B", 2.0, 3.0)]
    assert unknown == ["C"]


def test_help_needs_neither_the_simulator_nor_the_terminal_library() -> None:
    code = "import sys, vencejo.cli; print([name for name in ('rich', 'pymavlink', 'jsbsim', 'numpy') if name in sys.modules])"
    shown = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert shown.stdout.strip() == "[]"
