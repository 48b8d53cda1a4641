"""How things end: closing, Ctrl-C, the end of the interpreter, a process that is forked, a station that nobody holds."""

from __future__ import annotations

import asyncio
import gc
import itertools
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import vencejo
from vencejo import aio, recording

from tests.faults.mock import MockPlane
from tests.support import ROOT, uncaught, wait_for

LIMIT_S = 120


@pytest.fixture
def mock() -> Iterator[MockPlane]:
    with MockPlane() as mock:
        yield mock


def run(program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a program that must end by itself."""
    return subprocess.run(
        [sys.executable, "-c", program, *arguments], capture_output=True, text=True, timeout=LIMIT_S, cwd=ROOT
    )


def callers() -> int:
    """How many threads call back."""
    return sum(thread.name == "vencejo-callback" for thread in threading.enumerate())


# Closing -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("wait", ["stream", "wait_until", "wait_vehicle", "request"])
def test_closing_ends_every_wait(mock: MockPlane, wait: str) -> None:
    mock.on_message = lambda message: [] if message.get_type() == "PARAM_REQUEST_READ" else None
    plane = vencejo.connect(mock.link, record=False)
    began = threading.Event()
    ended: list[BaseException | None] = []

    def use() -> None:
        try:
            began.set()
            if wait == "stream":
                for _ in plane.stream():
                    mock.heartbeats = False
            elif wait == "wait_until":
                plane.wait_until(lambda _: False, timeout_s=None)
            elif wait == "wait_vehicle":
                plane.station.wait_vehicle(77, timeout_s=None)
            else:
                plane.params.get("WP_RADIUS")
            ended.append(None)
        except Exception as error:  # noqa: BLE001
            ended.append(error)

    thread = threading.Thread(target=use)
    thread.start()
    began.wait()
    plane.close()
    thread.join(LIMIT_S)
    assert not thread.is_alive()
    assert isinstance(ended[0], vencejo.ClosedError), ended


@pytest.mark.parametrize("wait", ["stream", "wait_until", "wait_vehicle", "request"])
async def test_closing_ends_every_wait_of_asyncio(mock: MockPlane, wait: str) -> None:
    mock.on_message = lambda message: [] if message.get_type() == "PARAM_REQUEST_READ" else None
    plane = await aio.connect(mock.link, record=False)

    async def use() -> None:
        if wait == "stream":
            async for _ in plane.stream():
                mock.heartbeats = False
        elif wait == "wait_until":
            await plane.wait_until(lambda _: False, timeout_s=None)
        elif wait == "wait_vehicle":
            await aio.wait_vehicle(plane.station, 77, timeout_s=None)
        else:
            await plane.params.get("WP_RADIUS")

    task = asyncio.create_task(use())
    await asyncio.sleep(0)
    await plane.close()
    with pytest.raises(vencejo.ClosedError):
        await asyncio.wait_for(task, LIMIT_S)


async def test_a_stream_without_news_ends_in_time(mock: MockPlane) -> None:
    async with await aio.connect(mock.link, record=False) as plane:
        mock.heartbeats = False
        assert len([telemetry async for telemetry in plane.stream(rate_hz=50.0, timeout_s=0.6)]) >= 1
        sync = vencejo.Vehicle(plane._native, plane.station)
        assert len(list(sync.stream(rate_hz=50.0, timeout_s=0.1))) >= 1


def test_what_the_station_notes_is_no_news_of_the_vehicle(monkeypatch: pytest.MonkeyPatch, mock: MockPlane) -> None:
    """Such as that it is lost: a stream that waits for it ends nevertheless."""
    with vencejo.connect(mock.link, record=False) as plane:
        mock.heartbeats = False
        notes = itertools.count()
        monkeypatch.setattr(vencejo.Vehicle, "_wait_change", lambda *_: next(notes))
        assert len(list(itertools.islice(plane.stream(rate_hz=50.0, timeout_s=0.2), 100))) < 100


def test_nothing_is_missed_between_a_look_and_the_wait(mock: MockPlane) -> None:
    with vencejo.connect(mock.link, record=False) as plane:
        looks, done = 0, threading.Event()

        def beat_now() -> None:
            mock.say(*mock._beat())
            done.set()

        def after_news(telemetry: vencejo.Telemetry) -> bool:
            nonlocal looks
            looks += 1
            if looks == 1:
                # Arrives while we still look at the old snapshot.
                count = plane._native.change_count()
                mock.do(beat_now)
                assert done.wait(LIMIT_S)
                wait_for(lambda: plane._native.change_count() > count, "the news")
            return looks == 2

        mock.heartbeats = True
        plane.wait_until(after_news, timeout_s=LIMIT_S)
        assert looks == 2


def test_a_callback_may_close_everything(mock: MockPlane) -> None:
    plane = vencejo.connect(mock.link, record=False)
    done = threading.Event()

    def end(_: vencejo.MavlinkMessage) -> None:
        plane.close()
        done.set()

    plane.on_message(end, names=["HEARTBEAT"])
    assert done.wait(LIMIT_S)
    plane.close()


def test_an_error_in_a_callback_is_told_and_the_calls_go_on(mock: MockPlane, monkeypatch: pytest.MonkeyPatch) -> None:
    told = uncaught(monkeypatch)

    def fail(_: vencejo.MavlinkMessage) -> None:
        raise ValueError("as this test wants it")

    with vencejo.connect(mock.link, record=False) as plane, plane.on_message(fail) as subscription:
        wait_for(lambda: subscription.failed > 1, "two errors")
    wait_for(lambda: callers() == 0, "the thread's end: what it tells later belongs to no other test")
    assert [error.exc_type for error in told] == [ValueError], "told once"


def test_a_closed_subscription_calls_no_more(mock: MockPlane) -> None:
    with vencejo.connect(mock.link, record=False) as plane:
        called, go = threading.Event(), threading.Event()
        calls: list[int] = []

        def slow(message: vencejo.MavlinkMessage) -> None:
            calls.append(message.id)
            called.set()
            go.wait(LIMIT_S)

        with plane.on_message(slow, names=["SYSTEM_TIME"], capacity=64) as subscription:
            assert called.wait(LIMIT_S)
            before = plane.station.links[0].frames_received
            mock.do(lambda: mock.say(*(10 * mock._beat())))
            wait_for(lambda: plane.station.links[0].frames_received >= before + 20, "ten more")
        go.set()
        wait_for(lambda: callers() == 0, "the thread's end")
        assert len(calls) == 1
        assert subscription.get(timeout_s=0.0) is not None


def test_a_station_that_nobody_holds_ends(mock: MockPlane) -> None:
    plane = vencejo.connect(mock.link, record=False)
    plane.on_event(lambda event: None)
    plane.on_message(lambda message: None)
    assert callers() == 2
    del plane
    gc.collect()
    wait_for(lambda: not mock._peers, "the link's end")
    wait_for(lambda: callers() == 0, "the threads' end")


def test_one_vehicle_is_one_object(mock: MockPlane) -> None:
    with vencejo.connect(mock.link, record=False) as plane:
        assert plane.station.vehicles == [plane]
        assert plane.station.wait_vehicle(1) is plane


def test_what_is_given_out_cannot_be_changed(mock: MockPlane) -> None:
    with vencejo.connect(mock.link, record=False) as plane:
        events: list[vencejo.Event] = []
        messages: list[vencejo.MavlinkMessage] = []
        with plane.on_event(events.append), plane.on_message(messages.append, names=["HEARTBEAT"]):
            plane.set_mode("RTL")
            wait_for(lambda: bool(events) and bool(messages), "an event and a message")
        with pytest.raises(TypeError):
            events[0].detail["mode"] = "AUTO"  # type: ignore[index]
        with pytest.raises(TypeError):
            messages[0].fields["type"] = 2  # type: ignore[index]
        with pytest.raises(AttributeError):
            plane.telemetry.heartbeat.mode = "AUTO"  # type: ignore[union-attr, misc]


def fence_of_two_corners() -> vencejo.Plan:
    corners = (vencejo.GeoPoint(40.33, -3.80), vencejo.GeoPoint(40.34, -3.79))
    return vencejo.Plan(fence=vencejo.Fence(zones=(vencejo.Polygon(points=corners),)))


@pytest.mark.parametrize(
    "call",
    [
        lambda plane: plane.command(70_000),
        lambda plane: plane.command(-1),
        lambda plane: plane.command("DO_CHANGE_SPEED", 1e300),
        lambda plane: plane.command("DO_CHANGE_SPEED", float("inf")),
        lambda plane: plane.command("DO_CHANGE_SPEED", *range(8)),
        lambda plane: plane.command_int("DO_REPOSITION", frame=300),
        lambda plane: plane.command_int("DO_REPOSITION", 1, 2, 3, 4, 5, frame=3),
        lambda plane: plane.command_int("DO_REPOSITION", frame=3, x=2**31),
        lambda plane: plane.set_current_item(0),
        lambda plane: plane.set_current_item(-1),
        lambda plane: plane.start_mission(from_item=70_000),
        lambda plane: plane.send_message("ATTITUDE", roll="much"),
        lambda plane: plane.upload(fence_of_two_corners(), kind="fence", check=False),
        lambda plane: plane.set_message_rate("ATTITUDE", 1e9),
        lambda plane: plane.set_mode(""),
        lambda plane: plane.takeoff(alt_rel_home_m="high"),
        lambda plane: plane.ask("warp", {"factor": 9}),
        lambda plane: plane.ask("speed", {"kind": "airspeed"}),
        lambda plane: plane.ask("speed", {"kind": "airspeed", "speed_m_s": 18.0, "speed_kt": 35.0}),
        lambda plane: plane.ask("speed", {"kind": "airspeed", "speed_m_s": True}),
    ],
)
def test_what_cannot_be_sent_is_an_invalid_request(mock: MockPlane, call: object) -> None:
    with vencejo.connect(mock.link, record=False) as plane:
        with pytest.raises(vencejo.InvalidRequest):
            call(plane)  # type: ignore[operator]
        assert mock.acts() == []
    with pytest.raises(vencejo.InvalidRequest, match="255"):
        vencejo.Station(system_id=300, record=False)


# Ctrl-C ------------------------------------------------------------------------------------------------------------

SYNC = {
    "stream": "for _ in plane.stream(): say()",
    "messages": "for _ in plane.messages(): say()",
    "wait_until": "plane.wait_until(lambda _: say(), timeout_s=None)",
    "arm": "say(); plane.arm()",
    "upload": "plane.upload(PLAN, check=False, progress=lambda done, total: say())",
    "download": "say(); plane.download()",
    "params": "say(); plane.params.all(progress=lambda done, total: None)",
    "close": "say(); plane.close(); plane.station.wait_vehicle; time.sleep(60)",
}
ASYNC = {
    "stream": "async for _ in plane.stream(): say()",
    "messages": "async for _ in plane.messages(): say()",
    "wait_until": "await plane.wait_until(lambda _: say(), timeout_s=None)",
    "arm": "say(); await plane.arm()",
    "upload": "await plane.upload(PLAN, check=False, progress=lambda done, total: say())",
    "params": "say(); await plane.params.all(progress=lambda done, total: None)",
}
HEAD = """
import asyncio, sys, time
import vencejo
from vencejo import aio
PLAN = vencejo.Plan(items=tuple(vencejo.MissionItem.waypoint(40.3, -3.8, alt_rel_home_m=50.0) for _ in range(9)))
def say(told=[]):
    if not told: print("waiting", flush=True)
    told.append(1)
"""


@pytest.mark.parametrize("kind", [*(f"sync {name}" for name in SYNC), *(f"async {name}" for name in ASYNC)])
def test_ctrl_c_ends_every_call_that_waits(mock: MockPlane, kind: str) -> None:
    # The plane takes the first item and then answers nothing, so that everything waits.
    silent = {
        "COMMAND_LONG",
        "MISSION_ITEM_INT",
        "MISSION_REQUEST_LIST",
        "PARAM_REQUEST_LIST",
        "FILE_TRANSFER_PROTOCOL",
    }
    first: list[int] = []

    def hook(message: object) -> list[object] | None:
        name = message.get_type()  # type: ignore[attr-defined]
        if name == "MISSION_ITEM_INT" and not first:
            first.append(1)
            return None
        return [] if name in silent else None

    mock.on_message = hook
    how, name = kind.split()
    if how == "sync":
        program = f"{HEAD}\nplane = vencejo.connect(sys.argv[1], record=False)\n{SYNC[name]}"
    else:
        program = (
            f"{HEAD}\nasync def main():\n    plane = await aio.connect(sys.argv[1], record=False)\n    {ASYNC[name]}\n"
            "asyncio.run(main())"
        )
    with subprocess.Popen(
        [sys.executable, "-c", program, mock.link], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "waiting\n"
            os.kill(process.pid, signal.SIGINT)
            _, said = process.communicate(timeout=LIMIT_S)
        finally:
            process.kill()
    assert said.rstrip().endswith("KeyboardInterrupt"), said
    assert process.returncode in (-signal.SIGINT, 130, 1), process.returncode
    if name == "upload":
        cancels = [message for name, message in mock.received if name == "MISSION_ACK" and message.type != 0]
        assert cancels, "the plane is told that the upload is given up"


# The end of the interpreter ----------------------------------------------------------------------------------------

FORGETFUL = """
import sys, threading, time
import vencejo
plane = vencejo.connect(sys.argv[1], record=False)
busy = threading.Event()
def use(wait):
    busy.set()
    wait()
waits = {
    "nothing": [],
    "callbacks": [],
    "wait": [lambda: plane.station.wait_vehicle(9, timeout_s=None)],
    "stream": [lambda: [None for _ in plane.stream(rate_hz=50)]],
    "slow callbacks": [],
    "request": [lambda: plane.params.get("AIRSPEED_CRUISE")],
}[sys.argv[2]]
for wait in waits:
    threading.Thread(target=use, args=(wait,), daemon=True).start()
if sys.argv[2] == "callbacks":
    plane.on_message(lambda message: (busy.set(), sum(range(3000)), time.sleep(0.001)))
    plane.on_event(lambda event: None)
    busy.wait()
elif sys.argv[2] == "slow callbacks":
    plane.on_message(lambda message: (busy.set(), time.sleep(1)))
    busy.wait()
elif waits:
    busy.wait()
print("end", flush=True)
"""


@pytest.mark.parametrize("left_open", ["nothing", "callbacks", "slow callbacks", "wait", "stream", "request"])
def test_a_program_that_closes_nothing_ends_in_silence(mock: MockPlane, left_open: str) -> None:
    mock.on_message = lambda message: [] if message.get_type() == "PARAM_REQUEST_READ" else None
    done = run(FORGETFUL, mock.link, left_open)
    assert (done.returncode, done.stdout, done.stderr) == (0, "end\n", "")


def test_what_was_recorded_is_whole_when_nothing_is_closed(mock: MockPlane, tmp_path: Path) -> None:
    program = """
import sys, vencejo
plane = vencejo.connect(sys.argv[1], record=sys.argv[2])
plane.params.get("WP_RADIUS")
"""
    done = run(program, mock.link, str(tmp_path))
    assert (done.returncode, done.stderr) == (0, "")
    (log,) = tmp_path.glob("*.tlog")
    assert b"WP_RADIUS" in log.read_bytes()
    assert recording.summarize(log).skipped_bytes == 0


# Forking and importing again ---------------------------------------------------------------------------------------


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
def test_a_forked_process_says_so_and_can_connect_for_itself(mock: MockPlane) -> None:
    program = """
import os, sys, threading, time, warnings
warnings.simplefilter("ignore")
import vencejo
from vencejo import _native
with vencejo.connect(sys.argv[1], record=False) as plane:
    # A thread of the parent is called back from native code meanwhile: the child's end does not wait for it.
    called, go_on = threading.Event(), threading.Event()
    plane._native.param_read("WP_RADIUS").on_done(lambda: called.set() or go_on.wait())
    assert called.wait(10)
    pending, messages = plane._native.param_read("WP_RADIUS"), plane.on_message(lambda message: None)
    child = os.fork()
    if child == 0:
        for call in (
            plane.arm,
            lambda: plane.telemetry,
            lambda: next(plane.stream()),
            lambda: plane.station.links,
            lambda: messages.get(None),
            lambda: pending.wait(None),
            lambda: pending.wait_progress(0),
            lambda: pending.on_done(lambda: None),
        ):
            try:
                call()
            except vencejo.ClosedError as error:
                assert "forked" in str(error), error
            else:
                print("not refused", call, flush=True)
        pending.cancel()
        plane.close()
        with vencejo.connect(sys.argv[1], record=False) as own:
            print("child", own.params["WP_RADIUS"], flush=True)
        began = time.monotonic()
        _native.end_waits()
        if time.monotonic() - began > 1:
            print("waited for a thread of the parent", flush=True)
        sys.exit(0)
    _, status = os.waitpid(child, 0)
    go_on.set()
    print("parent", plane.params["WP_RADIUS"], status)
"""
    done = run(program, mock.link)
    assert (done.returncode, done.stdout, done.stderr) == (0, "child 50.0\nparent 50.0 0\n", "")
    assert mock.acts() == []


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
def test_a_forked_process_leaves_the_server_of_its_parent_alone() -> None:
    program = """
import os, sys, warnings
warnings.simplefilter("ignore")
import vencejo
from vencejo.serve import Server
# Those that are closed come first, and keep nothing from those after them.
with vencejo.Station(record=False) as closed_station, Server(closed_station, port=0) as closed_server:
    closed_operator = closed_station.operator
with vencejo.Station(record=False) as station, Server(station, port=0) as server:
    operator, child = station.operator, os.fork()
    if child == 0:
        for call in (operator.take, lambda: server.clients, lambda: station.operator):
            try:
                call()
            except vencejo.ClosedError as error:
                assert "forked" in str(error), error
            else:
                print("not refused", call, flush=True)
        sys.exit(0)
    _, status = os.waitpid(child, 0)
    print("parent", server.port > 0, status)
"""
    done = run(program, "")
    assert (done.returncode, done.stdout, done.stderr) == (0, "parent True 0\n", "")


def test_importing_again_is_the_same_core(mock: MockPlane) -> None:
    program = """
import importlib, sys
import vencejo
plane = vencejo.connect(sys.argv[1], record=False)
for name in [name for name in sys.modules if name.startswith("vencejo")]:
    del sys.modules[name]
import vencejo as again
assert again is not vencejo
other = again.connect(sys.argv[1], record=False)
try:
    other.params["NOT_THERE"]
except again.ParameterError:
    print(plane.params["WP_RADIUS"], other.params["WP_RADIUS"])
"""
    mock.on_message = lambda message: (
        [] if message.get_type() == "PARAM_REQUEST_READ" and message.param_id == "NOT_THERE" else None
    )
    done = run(program, mock.link)
    assert (done.returncode, done.stdout, done.stderr) == (0, "50.0 50.0\n", "")


def test_the_time_between_two_snapshots_follows_the_rate(mock: MockPlane) -> None:
    with vencejo.connect(mock.link, record=False) as plane:
        snapshots = plane.stream(rate_hz=2.0)
        began = time.monotonic()
        for _ in range(3):
            next(snapshots)
        assert time.monotonic() - began >= 0.95, "no faster than asked for"
