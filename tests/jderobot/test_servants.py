"""Servants one by one over a real connection, with a camera and a hovering vehicle that the test holds in its hand."""

from __future__ import annotations

import hashlib
import math
import os
import subprocess
import sys
import threading
import time
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import vencejo
from numpy.typing import NDArray
from vencejo import VencejoError, _native, errors
from vencejo.jderobot import IceServer, IceSettings
from vencejo.jderobot.access import Gate
from vencejo.jderobot.camera import Camera
from vencejo.jderobot.cmdvel import CMDVel
from vencejo.jderobot.extra import Extra
from vencejo.jderobot.faults import Faults
from vencejo.jderobot.feed import Feed
from vencejo.jderobot.marks import Marks, Taken
from vencejo.jderobot.mission import Mission, MissionOfPoses
from vencejo.jderobot.navdata import Navdata, State, state_of
from vencejo.jderobot.pose import Pose3D
from vencejo.jderobot.precise import Control, Missions, TelemetryServant
from vencejo.jderobot.runtime import load
from vencejo.jderobot.settings import MissionPolicy
from vencejo.jderobot.stamp import age_text, stamped
from vencejo.jderobot.states import States
from vencejo.jderobot.subject import Subject
from vencejo.jderobot.workers import Workers
from vencejo.serve import Tokens

from tests.faults.mock import MockPlane
from tests.jderobot.support import ANY_PORT, Client, client_of
from tests.support import ROOT, wait_for


@dataclass
class Picture:
    rgb: NDArray[np.uint8]
    captured_unix_s: float
    width: int = 0
    height: int = 0


@dataclass
class Source:
    """A camera."""

    name: str
    picture: Picture | None = None
    fault: str | None = None
    recording: list[bool] = field(default_factory=list)

    def latest(self) -> Picture | None:
        if self.fault is not None:
            raise VencejoError(self.fault)
        return self.picture

    def record(self, wanted: bool) -> None:
        self.recording.append(wanted)


def picture(columns: int = 64, rows: int = 48) -> Picture:
    rgb = np.zeros((rows, columns, 3), np.uint8)
    rgb[0, 0], rgb[-1, -1] = (255, 128, 1), (2, 3, 4)
    return Picture(rgb, time.time(), columns, rows)


@pytest.fixture
def cameras() -> list[Source]:
    return [Source("nose"), Source("tail")]


@pytest.fixture
def client(cameras: list[Source]) -> Iterator[Client]:
    settings = IceSettings(camera_width=64, camera_height=48, camera_rate_hz=10.0)
    settings = settings.with_settings(ANY_PORT, where="here")
    with (
        vencejo.Station(record=False) as station,
        IceServer(station, settings, cameras=cameras, jpeg=lambda rgb: b"\xff\xd8" + rgb.tobytes()[:8]) as server,
        client_of(server.proxies) as client,
    ):
        yield client


def test_pictures_come_as_they_are_deflated_or_as_jpeg(client: Client, cameras: list[Source]) -> None:
    camera = client.camera
    assert camera.getImageFormat() == ["RGB8", "RGB8_Z", "JPEG"]
    cameras[0].picture = taken = picture()
    data = camera.getImageData("RGB8")
    raw = taken.rgb.tobytes()
    assert bytes(data.pixelData) == raw
    assert (data.description.width, data.description.height, data.description.size) == (64, 48, len(raw))
    assert data.description.md5sum == hashlib.md5(raw).hexdigest()
    assert data.timeStamp.seconds + data.timeStamp.useconds / 1e6 == pytest.approx(taken.captured_unix_s, abs=1e-5)
    assert zlib.decompress(bytes(camera.getImageData("RGB8_Z").pixelData)) == raw
    assert bytes(camera.getImageData("JPEG").pixelData).startswith(b"\xff\xd8")
    assert camera.getImageData("").description.format == "RGB8"
    assert camera.getImageDescription().size == len(raw)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
def test_a_forked_process_leaves_the_interfaces_of_its_parent_alone() -> None:
    program = """
import os, socket, sys, warnings
warnings.simplefilter("ignore")
import vencejo
from vencejo.jderobot import IceServer, IceSettings
from tests.jderobot.support import ANY_PORT
settings = IceSettings().with_settings(ANY_PORT, where="here")
with vencejo.Station(record=False) as station, IceServer(station, settings) as server:
    child = os.fork()
    if child == 0:
        for call in (lambda: server.endpoints, lambda: server.proxies):
            try:
                call()
            except vencejo.ClosedError as error:
                assert "forked" in str(error), error
            else:
                print("not refused", flush=True)
        server.close()
        sys.exit(0)
    _, status = os.waitpid(child, 0)
    port = int(server.endpoints["Pose3D"].split("-p ")[1].split()[0])
    with socket.create_connection(("127.0.0.1", port), timeout=60) as client:
        print("parent", client.recv(4), status)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120, cwd=ROOT)
    assert (done.returncode, done.stdout) == (0, "parent b'IceP' 0\n"), done.stderr
    assert "selector" not in done.stderr


def test_a_large_picture_is_given_at_the_size_that_is_set(client: Client, cameras: list[Source]) -> None:
    cameras[0].picture = picture(640, 480)
    description = client.camera.getImageData("RGB8").description
    assert (description.width, description.height, description.size) == (64, 48, 64 * 48 * 3)


def test_pictures_come_no_faster_than_the_rate_that_is_set(client: Client, cameras: list[Source]) -> None:
    first = cameras[0].picture = picture()
    shown = client.camera.getImageData("RGB8").timeStamp
    cameras[0].picture = Picture(first.rgb, first.captured_unix_s + 0.05)
    assert client.camera.getImageData("RGB8").timeStamp == shown, "ten a second"
    cameras[0].picture = Picture(first.rgb, first.captured_unix_s + 0.1)
    assert client.camera.getImageData("RGB8").timeStamp != shown


def test_viewers_of_a_camera_that_is_slow_hold_up_no_command(
    client: Client, cameras: list[Source], monkeypatch: pytest.MonkeyPatch
) -> None:
    gate = threading.Event()
    monkeypatch.setattr(cameras[0], "latest", lambda: gate.wait(30.0) and None)
    waiting = [client.camera.getImageDataAsync("RGB8") for _ in range(20)]
    assert client.pose.setPose3DData(client.jderobot.Pose3DData(x=40.0, y=-3.0, z=700.0)) == 2, "no vehicle is heard"
    assert not any(call.done() for call in waiting), "the viewers still wait"
    gate.set()


def test_no_picture_and_a_dead_camera_are_told_apart(client: Client, cameras: list[Source]) -> None:
    missing, dead = client.jderobot.DataNotExistException, client.jderobot.HardwareFailedException
    with pytest.raises(missing) as caught:
        client.camera.getImageData("RGB8")
    assert caught.value.what == "camera nose has given no picture yet"
    with pytest.raises(missing) as caught:
        client.camera.getImageData("GIF")
    assert "the formats are RGB8, RGB8_Z, JPEG" in caught.value.what
    cameras[0].fault = "the cable is out"
    with pytest.raises(dead) as caught:
        client.camera.getImageData("RGB8")
    assert caught.value.what == "the cable is out"
    assert client.camera.getImageDescription().width == 0
    cameras[0].fault = None
    cameras[0].picture = picture()
    assert client.camera.getImageData("RGB8").description.width == 64, "and back again"


def test_an_old_picture_is_given_with_its_age_in_it_or_not_at_all() -> None:
    """An exception ends the thread of viewers in use for good; a setting chooses."""
    slices, workers = load(), Workers()
    now = [1000.0]

    def camera_of(settings: IceSettings, source: Source) -> Callable[[], Any]:
        servant = Camera(slices, [source], settings, workers, clock=lambda: now[0])
        return lambda: servant.getImageData("RGB8").result(30.0)

    def shown(data: Any) -> NDArray[np.uint8]:
        rgb = np.frombuffer(bytes(data.pixelData), np.uint8)
        assert data.description.md5sum == hashlib.md5(bytes(data.pixelData)).hexdigest()
        return rgb.reshape(data.description.height, data.description.width, 3)

    source = Source("nose")
    get = camera_of(IceSettings(), source)
    with pytest.raises(slices.jderobot.DataNotExistException):
        get()
    source.fault = "the cable is out"
    with pytest.raises(slices.jderobot.HardwareFailedException):
        get()
    source.fault, source.picture = None, Picture(np.full((48, 64, 3), 90, np.uint8), 1000.0)
    now[0] = 1003.4
    assert (shown(get()) == 90).all(), "fresh"
    now[0] = 1012.0
    data = get()
    marked = shown(data)
    assert (marked == stamped(source.picture.rgb, "OLD 12 s")).all()
    assert data.timeStamp.seconds == 1000, "it says when it was taken"
    assert {tuple(pixel) for row in marked for pixel in row} == {(90, 90, 90), (0, 0, 0), (255, 220, 0)}
    now[0], source.fault = 1013.0, "the cable is out"
    assert (shown(get()) == stamped(source.picture.rgb, "OLD 13 s")).all(), "it fails, and the viewers live"
    now[0] = 1001.0
    assert (shown(get()) == stamped(source.picture.rgb, "OLD 1 s")).all(), "also at once"
    source.fault, source.picture = None, Picture(source.picture.rgb, 1013.5)
    now[0] = 1014.0
    assert (shown(get()) == 90).all(), "and back again"
    assert [age_text(age_s) for age_s in (-1.0, 119.9, 120.0, 7199.0, 7200.0, 1e9)] == [
        "OLD 0 s", "OLD 119 s", "OLD 2 m", "OLD 119 m", "OLD 2 h", "OLD 99 h"
    ]  # fmt: skip
    assert stamped(np.zeros((3, 4, 3), np.uint8), "OLD 1 s").shape == (3, 4, 3), "however small"

    get = camera_of(IceSettings(old_pictures="raise"), source)
    get()
    now[0] = 1023.5
    with pytest.raises(slices.jderobot.HardwareFailedException) as caught:
        get()
    assert "no picture for 10 s" in caught.value.what
    source.fault = "the cable is out"
    with pytest.raises(slices.jderobot.HardwareFailedException):
        get()
    workers.close()


def test_the_next_camera_and_its_recording(client: Client, cameras: list[Source]) -> None:
    cameras[0].picture = cameras[1].picture = picture()
    assert client.camera.getCameraDescription().name == "nose"
    client.extra.toggleCam()
    assert client.camera.getCameraDescription().name == "tail"
    client.extra.recordOnUsb(True)
    wait_for(lambda: cameras[1].recording == [True], "recording")
    client.camera.reset()
    assert client.camera.getCameraDescription().name == "nose"


def test_an_operation_under_way_does_not_hold_up_the_end() -> None:
    """As an upload to a vehicle that is out of reach would: Ice waits for every answer before it ends."""
    asked, go = threading.Event(), threading.Event()

    class Slow(Source):
        def latest(self) -> Picture | None:
            asked.set()
            go.wait(60.0)
            return None

    settings = IceSettings().with_settings(ANY_PORT, where="here")
    ended = threading.Event()
    with vencejo.Station(record=False) as station:
        server = IceServer(station, settings, cameras=[Slow("slow")])
        try:
            with client_of(server.proxies) as client:
                pending = client.camera.getImageDataAsync("RGB8")
                assert asked.wait(30.0)

                def close() -> None:
                    server.close()
                    ended.set()

                closing = threading.Thread(target=close)
                closing.start()
                assert ended.wait(30.0), "the end waits for the operation"
                closing.join()
                # The servant says so, when it gets to; else the connection is gone.
                no_data = client.jderobot.DataNotExistException
                with pytest.raises((no_data, client.ice.UnknownException, client.ice.LocalException)):
                    pending.result(30.0)
        finally:
            go.set()
            server.close()


def test_before_a_vehicle_is_heard_there_are_zeros_where_no_exception_is(client: Client) -> None:
    pose, navdata = client.pose.getPose3DData(), client.navdata.getNavdata()
    assert (pose.x, pose.y, pose.z, pose.q0) == (0.0, 0.0, 0.0, 1.0)
    assert (navdata.state, navdata.batteryPercent, navdata.tm) == (0, 0.0, 0.0)
    assert client.velocity.setCMDVelData(client.jderobot.CMDVelData()) == 2
    assert client.mission.setMissionData(client.mission_data((40.0, -3.0, 50.0))) == 2
    assert client.mission.getMissionData().mission == []
    with pytest.raises(client.precise.NoVehicle):
        client.telemetry.getPose(0)
    assert client.telemetry.vehicles() == []


# Values ------------------------------------------------------------------------------------------------------------


def measured() -> SimpleNamespace:
    """What a vehicle measures, in the package's units; no two values are the same."""
    return SimpleNamespace(
        heartbeat=SimpleNamespace(mav_type=1),
        mode="AUTO",
        extended=SimpleNamespace(landed="in air"),
        sys_status=SimpleNamespace(battery_remaining_pct=63.0),
        imu=SimpleNamespace(mag_gauss=(0.211, -0.045, 0.432), acc_g=(0.125, -0.25, -1.0625)),
        pressure=SimpleNamespace(absolute_pa=94_312.4, temperature_c=-7.3),
        wind=SimpleNamespace(speed_m_s=4.5, from_deg=350.0),
        attitude=SimpleNamespace(
            roll_rad=math.radians(30.0), pitch_rad=math.radians(-10.0), yaw_rad=math.radians(-135.0)
        ),
        position=SimpleNamespace(
            lat_deg=40.25,
            lon_deg=-3.75,
            alt_amsl_m=712.5,
            alt_rel_home_m=112.5,
            velocity_north_m_s=-12.25,
            velocity_east_m_s=11.0,
            velocity_down_m_s=-1.5,
        ),
        system_time=SimpleNamespace(boot_ms=65_000, age_s=0.5),
    )


SILENT = dict.fromkeys(vars(measured()))


def test_navdata_has_the_units_that_are_documented_and_keeps_the_last_values() -> None:
    slices = load()
    vehicle = SimpleNamespace(telemetry=measured())
    navdata = Navdata(slices, cast("Subject", SimpleNamespace(find=lambda: vehicle)))
    data = navdata.getNavdata()
    values = {
        "vehicle": 1,
        "state": State.TO_POINT,
        "batteryPercent": 63.0,
        "magX": 211,
        "magY": -45,
        "magZ": 432,
        "pressure": 94_312,
        "temp": -7,
        "windSpeed": 4.5,
        "windAngle": 350.0,
        "windCompAngle": 125.0,  # from 350 degrees, with the nose at 225: from the right, behind
        "rotX": 30.0,
        "rotY": -10.0,
        "rotZ": -135.0,
        "altd": 112_500,
        "vx": -12_250.0,
        "vy": 11_000.0,
        "vz": -1_500.0,
        "ax": 0.125,
        "ay": -0.25,
        "az": -1.0625,
        "tagsCount": 0,
        "tm": 65.5,
    }
    assert {name: getattr(data, name) for name in values} == pytest.approx(values)
    tags = {name for name in vars(data) if name.startswith("tags")} - {"tagsCount"}
    assert all(getattr(data, name) == [] for name in tags)
    assert set(values) | tags == set(vars(slices.jderobot.NavdataData())), "every member is there"

    vehicle.telemetry = SimpleNamespace(**SILENT)
    again = navdata.getNavdata()
    assert again.state == State.UNKNOWN, "what it does now is not what it did"
    assert {name: getattr(again, name) for name in values if name != "state"} == pytest.approx(
        {name: value for name, value in values.items() if name != "state"}
    )
    vehicle.telemetry = SimpleNamespace(**{**SILENT, "system_time": SimpleNamespace(boot_ms=65_000, age_s=600.0)})
    assert navdata.getNavdata().tm == pytest.approx(65.0 + 3.5), "a vehicle that is not heard stands still in time"


def test_what_comes_too_much_at_once_is_an_answer_of_the_interface() -> None:
    slices, workers = load(), Workers()
    workers.close()
    subject = TheOne(None)
    assert Pose3D(slices, cast("Subject", subject), workers).setPose3DData(None) == 3
    assert "setPose3DData" in subject.said[-1]
    camera = Camera(slices, [], IceSettings(), workers)
    assert camera.getImageDescription().width == 0
    with pytest.raises(slices.jderobot.DataNotExistException):
        camera.getImageData("RGB8")


def test_pose_has_both_heights_above_the_sea_and_the_pitch_turned_round() -> None:
    slices, workers = load(), Workers()
    vehicle = SimpleNamespace(telemetry=measured())
    pose3d = Pose3D(slices, cast("Subject", SimpleNamespace(find=lambda: vehicle)), workers)
    pose = pose3d.getPose3DData()
    assert (pose.x, pose.y, pose.z, pose.h) == (40.25, -3.75, 712.5, 712.5)
    # What existing viewers make of it (Diebel 2006, eq. 290).
    w, x, y, z = pose.q0, pose.q1, pose.q2, pose.q3
    assert math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)) == pytest.approx(math.radians(30.0))
    assert math.asin(2 * (w * y - z * x)) == pytest.approx(math.radians(10.0)), "minus the pitch"
    assert math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)) == pytest.approx(math.radians(-135.0))
    vehicle.telemetry = SimpleNamespace(**SILENT)
    assert vars(pose3d.getPose3DData()) == vars(pose)
    workers.close()


# Missions ----------------------------------------------------------------------------------------------------------


class Flier:
    """Stands in for `vencejo.Vehicle`: a plane on the ground that keeps what it is told, and fails at a step."""

    def __init__(self, fails_at: str = "", error: VencejoError | None = None) -> None:
        self.told: list[str] = []
        self.fails_at, self.error = fails_at, error
        self.go = threading.Event()
        self.go.set()
        self.at: dict[str, Callable[[], None]] = {}
        self.plan: vencejo.Plan | None = None
        self.params = {"RTL_AUTOLAND": 0.0}
        self.telemetry = SimpleNamespace(
            heartbeat=SimpleNamespace(mav_type=1, autopilot=3, freshness="fresh"),
            is_on_ground=None,
            is_armed=False,
            home=None,
            wind=None,
            position=None,
        )

    def _do(self, what: str) -> None:
        self.told.append(what)
        self.go.wait(30.0)
        self.at.get(what, lambda: None)()
        if what == self.fails_at:
            assert self.error is not None
            raise self.error

    def _require_sound(self, plan: vencejo.Plan) -> None:
        plan.require_sound()

    def upload(self, plan: vencejo.Plan, *, while_heard: bool) -> Any:
        assert while_heard, "one that comes back must not get what has failed"
        self.plan = plan
        self._do("upload")
        return SimpleNamespace(hash="h")

    def prepare_flight(self, *, despite_mixed_plan: bool) -> None:
        self._act("prepare", despite_mixed_plan)

    def arm(self, *, despite_mixed_plan: bool) -> None:
        self._act("arm", despite_mixed_plan)

    def disarm(self) -> None:
        self._do("disarm")

    def start_mission(self, *, from_item: int, despite_mixed_plan: bool) -> None:
        assert from_item == 1
        self._act("start", despite_mixed_plan)

    def _act(self, what: str, despite_mixed_plan: bool) -> None:
        self._do(f"{what} despite" if despite_mixed_plan else what)


def poses(*heights: float) -> Any:
    rest = {"y": -3.0, "z": 7.5, "q0": 0.25, "q1": 0.0, "q2": 0.0, "q3": -0.5}
    mission = [SimpleNamespace(x=40.0 + 0.003 * number, h=height, **rest) for number, height in enumerate(heights)]
    return SimpleNamespace(mission=mission)


def mission_servant(
    vehicle: Flier, marks: Marks | None = None, policy: MissionPolicy = "fly"
) -> tuple[Mission, TheOne, Workers]:
    subject, workers = TheOne(vehicle), Workers()
    return Mission(load(), cast("Subject", subject), workers, marks or Marks(5.0), policy), subject, workers


@pytest.mark.parametrize(
    ("fails_at", "error", "answer", "told", "says"),
    [
        ("", None, 0, ["upload", "prepare", "arm", "start"], "is being flown"),
        ("upload", errors.PlanMismatch("item 2 differs", ()), 4, ["upload"], "was not sent: item 2 differs"),
        ("upload", errors.Busy("a transfer runs"), 3, ["upload"], "was not sent: a transfer runs"),
        ("upload", errors.VehicleLost("silent"), 2, ["upload"], "was not sent: silent"),
        ("upload", errors.Cancelled("by itself"), 2, ["upload"], "was not sent: the vehicle was lost meanwhile"),
        (
            "arm",
            errors.CommandRefused("no", "ARM", "DENIED", ("no GPS",)),
            5,
            ["upload", "prepare", "arm"],
            "was not armed for: no",
        ),
        ("prepare", errors.NotPossibleNow("in the air"), 4, ["upload", "prepare"], "was not armed for: in the air"),
        (
            "start",
            errors.CommandTimeout("?", "AUTO", ()),
            6,
            ["upload", "prepare", "arm", "start"],
            "and the vehicle is armed",
        ),
    ],
    ids=["flies", "mismatch", "busy", "lost", "lost meanwhile", "not armed", "not prepared", "not started"],
)
def test_each_step_of_a_mission_and_what_its_failure_answers(
    fails_at: str, error: VencejoError | None, answer: int, told: list[str], says: str
) -> None:
    vehicle, marks = Flier(fails_at, error), Marks(5.0)
    servant, subject, workers = mission_servant(vehicle, marks)
    marks.mark(0.0, takeoff=True, land=True)
    assert servant.setMissionData(poses(50.0, 60.0, 0.0)).result(30.0) == answer
    assert vehicle.told == told
    assert any(says in text for text in subject.said), subject.said
    assert marks.due_s is None, "the marks are used up, whatever came of it"
    assert vehicle.plan is not None
    assert [item.command for item in vehicle.plan] == [22, 16, 31, 21], (
        "RTL_AUTOLAND is 0: it arms without DO_LAND_START"
    )
    assert any("RTL_AUTOLAND is 0" in text for text in subject.said)
    workers.close()


DESPITE: Any = SimpleNamespace(ctx={"despite_mixed_plan": "true"})
"""A request whose context says that a mission that may be mixed is to be flown."""
NOT_DESPITE: Any = SimpleNamespace(ctx={"despite_mixed_plan": "yes", "token": "true"})


def test_a_mission_that_may_be_mixed_is_flown_only_when_the_context_says_so() -> None:
    marks = Marks(5.0)
    for current, leave in ((DESPITE, " despite"), (NOT_DESPITE, ""), (None, "")):
        vehicle = Flier()
        servant, _, workers = mission_servant(vehicle, marks)
        for setter, data in (
            (servant.setMissionData, poses(50.0, 60.0)),
            (MissionOfPoses(servant).setMissionData, poses(50.0, 60.0).mission),
        ):
            vehicle.told.clear()
            marks.mark(0.0, takeoff=True)
            assert setter(data, current).result(30.0) == 0
            assert vehicle.told == ["upload", *(f"{act}{leave}" for act in ("prepare", "arm", "start"))]
        workers.close()


def test_each_precise_act_takes_the_leave_from_its_context() -> None:
    slices, workers, vehicle = load(), Workers(), Hoverer()
    subject = cast("Subject", TheOne(vehicle))
    faults = Faults(slices, workers)
    missions, control = Missions(slices, subject, faults), Control(subject, faults)
    acts: list[tuple[Callable[..., Any], tuple[Any, ...]]] = [
        (missions.prepareFlight, ()),
        (missions.start, (3,)),
        (missions.resume, ()),
        (missions.setCurrentItem, (3,)),
        (control.arm, ()),
        (control.setMode, ("AUTO",)),
        (control.land, ()),
        (control.command, (400, [1.0])),
    ]
    for current, leave in ((DESPITE, True), (NOT_DESPITE, False)):
        for act, arguments in acts:
            seen: list[bool] = []

            def tell(*_: Any, despite_mixed_plan: bool, seen: list[bool] = seen, **__: Any) -> None:
                seen.append(despite_mixed_plan)

            names = ("prepare_flight", "start_mission", "resume_mission", "set_current_item", "arm", "set_mode", "land")
            vehicle.__dict__.update(dict.fromkeys((*names, "command"), tell))
            act(0, *arguments, current).result(30.0)
            assert seen == [leave], act.__name__
    workers.close()


def test_a_vehicle_that_is_asked_for_by_its_id_does_not_become_the_default() -> None:
    station = cast(
        "vencejo.Station", SimpleNamespace(vehicles=[SimpleNamespace(system_id=1), SimpleNamespace(system_id=2)])
    )
    subject = Subject(station)
    assert [subject.need(2).system_id, subject.need().system_id, subject.need(2).system_id] == [2, 1, 2]
    chosen = Subject(station, 2)
    assert [chosen.need(1).system_id, chosen.need().system_id] == [1, 2]


def test_a_lost_vehicle_is_answered_at_once_and_gets_nothing() -> None:
    vehicle, workers, clock = Flier(), Workers(), Clock()
    vehicle.__dict__["system_id"] = 1
    vehicle.__dict__["note"] = lambda text, severity: None
    vehicle.telemetry.heartbeat = SimpleNamespace(freshness="lost", age_s=7.2)
    station = cast("vencejo.Station", SimpleNamespace(vehicles=[vehicle]))
    subject, slices = Subject(station), load()
    marks = Marks(5.0)
    mission = Mission(slices, subject, workers, marks, "fly")
    extra = Extra(subject, workers, marks, IceSettings(), cast("Any", SimpleNamespace()), clock=clock)
    try:
        marks.mark(0.0, takeoff=True)
        assert mission.setMissionData(poses(50.0, 60.0)).result(30.0) == 2
        pose = slices.jderobot.Pose3DData(x=40.0, y=-3.0, z=700.0)
        assert Pose3D(slices, subject, workers).setPose3DData(pose).result(30.0) == 2
        extra.act_alone(Taken(takeoff=True))
        extra.act_alone(Taken(land=True))
        with pytest.raises(errors.VehicleLost, match="has not been heard for 7 s; nothing was sent"):
            subject.hear()
    finally:
        extra.close()
        workers.close()
    assert vehicle.told == []


@pytest.mark.parametrize(
    ("ends_at", "fails_at", "told", "says"),
    [
        ("upload", "", [], "not armed for: the driver is ending"),
        ("prepare", "", ["prepare"], "not armed for: the driver is ending"),
        ("arm", "", ["prepare", "arm", "disarm"], "not started: the driver is ending"),
        (
            "arm",
            "disarm",
            ["prepare", "arm", "disarm"],
            "not started: the driver is ending, and THE VEHICLE IS STILL ARM",
        ),
    ],
)
def test_a_driver_that_ends_begins_no_further_act_of_a_mission(
    ends_at: str, fails_at: str, told: list[str], says: str
) -> None:
    """Its sender was told that it failed: nothing is armed or started after that."""
    vehicle, marks = Flier(fails_at, errors.CommandRefused("in the air")), Marks(5.0)
    servant, subject, workers = mission_servant(vehicle, marks)
    vehicle.at[ends_at] = workers.close
    marks.mark(0.0, takeoff=True)
    with pytest.raises(errors.Busy, match="the driver is ending"):
        servant.setMissionData(poses(50.0, 60.0)).result(30.0)
    wait_for(lambda: says in subject.said[-1], "the mission's end")
    assert vehicle.told == ["upload", *told]


def test_a_vehicle_that_comes_back_gets_nothing_of_a_mission_that_was_answered_as_lost() -> None:
    """It restarts in the middle of an upload and says nothing for a while: the answer is 2, and nothing follows it."""
    with MockPlane() as mock, vencejo.connect(mock.link, record=False) as plane:
        subject, workers, marks = TheOne(plane), Workers(), Marks(5.0)
        mission = Mission(load(), cast("Subject", subject), workers, marks, "upload")

        def die(message: Any) -> list[Any] | None:
            if message.get_type() == "MISSION_COUNT":
                mock.heartbeats = False
            return [] if not mock.heartbeats else None

        mock.on_message = die
        assert mission.setMissionData(poses(50.0, 60.0)).result(60.0) == 2
        assert "lost meanwhile" in subject.said[-1]
        sent = [name for name, _ in mock.received].count("MISSION_COUNT")
        assert sent > 0

        def return_() -> None:
            mock.on_message, mock.heartbeats = None, True
            mock.reboot()

        mock.do(return_)
        wait_for(lambda: plane.telemetry.heartbeat is not None and plane.telemetry.heartbeat.freshness == "fresh", "it")
        plane.set_mode("MANUAL")
        assert [name for name, _ in mock.received].count("MISSION_COUNT") == sent
        assert mock.items[0] == [], "nothing of it is on board"
        assert not [name for name, _ in mock.received if name == "MISSION_ITEM_INT"]
        workers.close()


def test_only_one_mission_at_a_time_and_none_from_the_ground_without_take_off() -> None:
    vehicle = Flier()
    vehicle.telemetry.is_on_ground = False
    servant, subject, workers = mission_servant(vehicle)
    vehicle.go.clear()
    first = servant.setMissionData(poses(60.0))
    wait_for(lambda: vehicle.told == ["upload"], "the first mission on its way")
    assert servant.setMissionData(poses(60.0)).result(30.0) == 3
    vehicle.go.set()
    assert first.result(30.0) == 0
    vehicle.telemetry.is_on_ground, told = None, list(vehicle.told)
    assert servant.setMissionData(poses(60.0)).result(30.0) == 1, "disarmed, and it does not say where: it stands"
    assert "call takeoff()" in subject.said[-1]
    assert vehicle.told == told, "nothing was sent"
    assert servant.setMissionData(poses(math.nan)).result(30.0) == 1
    assert servant.setMissionData(SimpleNamespace(mission=[None])).result(30.0) == 1
    assert vehicle.told == told
    workers.close()
    servant, _, workers = mission_servant(vehicle, policy="upload")
    assert servant.setMissionData(poses(60.0)).result(30.0) == 0
    assert vehicle.told == [*told, "upload"], "it stops before arming"
    workers.close()
    assert servant.setMissionData(poses(60.0)) == 3, "the driver is ending"
    last = servant.getMissionData().mission
    assert [(one.z, one.h, one.q0, one.q3) for one in last] == [(7.5, 60.0, 0.25, -0.5)], (
        "what was sent last, as it was sent"
    )
    assert [vars(one) for one in MissionOfPoses(servant).getMissionData()] == [vars(one) for one in last]


# A vehicle that hovers ----------------------------------------------------------------------------------------------


@dataclass
class Hoverer:
    """Stands in for `vencejo.Vehicle`: a copter that keeps what it is told."""

    mode: str = "GUIDED"
    is_on_ground: bool = False
    is_armed: bool = True
    told: list[tuple[str, Any]] = field(default_factory=list)

    @property
    def telemetry(self) -> Any:
        heartbeat = SimpleNamespace(mode=self.mode, mav_type=2, freshness="fresh", is_armed=self.is_armed)
        return SimpleNamespace(
            heartbeat=heartbeat,
            mode=self.mode,
            is_on_ground=self.is_on_ground,
            is_armed=self.is_armed,
            extended=SimpleNamespace(landed="on ground" if self.is_on_ground else "in air"),
        )

    def __getattr__(self, name: str) -> Any:
        def tell(*arguments: Any, despite_mixed_plan: bool = False, **named: Any) -> None:
            leave = {"despite_mixed_plan": True} if despite_mixed_plan else {}
            self.told.append((name, arguments or {**named, **leave}))

        return tell


class TheOne:
    """Stands in for `Subject`."""

    def __init__(self, vehicle: Any) -> None:
        self.vehicle = vehicle
        self.said: list[str] = []

    def find(self, system_id: int = 0) -> Any:
        return self.vehicle

    need = hear = find

    def tell(self, text: str, *, is_problem: bool = True) -> None:
        self.said.append(text)


class Clock:
    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def velocity(forward: float, left: float = 0.0, up: float = 0.0, turn: float = 0.0) -> Any:
    return SimpleNamespace(linearX=forward, linearY=left, linearZ=up, angularX=9.0, angularY=9.0, angularZ=turn)


def test_what_hovers_follows_velocities_and_stops_when_none_comes_any_more() -> None:
    vehicle, clock = Hoverer(), Clock()
    servant = CMDVel(cast("Subject", TheOne(vehicle)), 0.5, clock=clock)
    try:
        assert servant.setCMDVelData(velocity(2.0, 1.0, 0.5, 0.25)) == 0
        wanted = {"forward_m_s": 2.0, "right_m_s": -1.0, "down_m_s": -0.5, "yaw_rate_rad_s": -0.25}
        wait_for(lambda: ("set_velocity", wanted) in vehicle.told, "the velocity in MAVLink's axes")
        still = dict.fromkeys(wanted, 0.0)
        count = len(vehicle.told)
        wait_for(lambda: len(vehicle.told) > count, "it is repeated while it holds")
        assert ("set_velocity", still) not in vehicle.told
        clock.now_s += 0.5
        wait_for(lambda: vehicle.told[-1] == ("set_velocity", still), "the stop")
        vehicle.mode = "LOITER"
        assert servant.setCMDVelData(velocity(1.0)) == 7
    finally:
        servant.close()
    assert vehicle.told[-1] == ("set_velocity", still)


class Turner(Hoverer):
    """A plane in GUIDED that flies north and takes no speed."""

    @property
    def telemetry(self) -> Any:
        seen = super().telemetry
        seen.heartbeat.mav_type = 1
        # A hair west of north: one remainder makes 360 degrees of it, which is no course.
        seen.position = SimpleNamespace(velocity_north_m_s=20.0, velocity_east_m_s=-1e-17, alt_amsl_m=700.0)
        return seen

    def set_airspeed(self, airspeed_m_s: float) -> None:
        raise errors.InvalidRequest("no such speed")


def test_a_turn_that_was_flown_is_not_answered_as_if_nothing_was_sent() -> None:
    vehicle, clock = Turner(), Clock()
    servant = CMDVel(cast("Subject", TheOne(vehicle)), 5.0, clock=clock)
    try:
        assert servant.setCMDVelData(velocity(30.0, up=1.0, turn=0.2)) == 0
        wait_for(
            lambda: [name for name, _ in vehicle.told] == ["fly_course", "climb_to"], "turn and climb, all the same"
        )
        assert servant.setCMDVelData(velocity(30.0, turn=0.2)) == 8, "it was sent, but for the speed"
        assert servant.setCMDVelData(velocity(51.0)) == 1, "nothing was"
        vehicle.told.clear()
    finally:
        servant.close()
    course = next(what for name, what in vehicle.told if name == "fly_course")
    assert course == (0.0,), "straight on to the north"


def test_what_hovers_is_stopped_when_the_driver_ends() -> None:
    vehicle = Hoverer()
    servant = CMDVel(cast("Subject", TheOne(vehicle)), 5.0, clock=Clock())
    assert servant.setCMDVelData(velocity(2.0)) == 0
    servant.close()
    assert vehicle.told[-1][1]["forward_m_s"] == 0.0


def test_a_pilot_who_takes_over_is_left_alone() -> None:
    vehicle, clock = Hoverer(), Clock()
    servant = CMDVel(cast("Subject", TheOne(vehicle)), 0.5, clock=clock)
    try:
        assert servant.setCMDVelData(velocity(2.0)) == 0
        wait_for(lambda: bool(vehicle.told), "the velocity")
        vehicle.mode = "STABILIZE"
        clock.now_s += 1.0
        seen = len(vehicle.told)
        wait_for(lambda: servant._newest is None, "the watchdog")
        assert len(vehicle.told) <= seen + 1, "nothing is sent to the pilot's mode"
    finally:
        servant.close()


@pytest.fixture
def extra() -> Iterator[tuple[Extra, Hoverer, TheOne, Clock]]:
    vehicle, clock = Hoverer(), Clock()
    subject = TheOne(vehicle)
    servant = Extra(
        cast("Subject", subject), Workers(), Marks(5.0), IceSettings(), cast("Any", SimpleNamespace()), clock=clock
    )
    yield servant, vehicle, subject, clock
    servant.close()


def test_take_off_and_landing_alone_of_what_hovers(extra: tuple[Extra, Hoverer, TheOne, Clock]) -> None:
    servant, vehicle, subject, _ = extra
    vehicle.is_on_ground = True
    servant.act_alone(Taken(takeoff=True))
    assert [name for name, _ in vehicle.told] == ["set_mode", "arm", "takeoff"]
    vehicle.told.clear()
    vehicle.is_armed = False
    servant.act_alone(Taken(takeoff=True))
    assert [name for name, _ in vehicle.told] == ["prepare_flight", "set_mode", "arm", "takeoff"], (
        "where it landed last"
    )
    vehicle.told.clear()
    servant.act_alone(Taken(land=True))
    assert vehicle.told == [], "it is on the ground"
    vehicle.is_on_ground = False
    servant.act_alone(Taken(land=True))
    assert [name for name, _ in vehicle.told] == ["land"]
    servant.act_alone(Taken(takeoff=True))
    assert [name for name, _ in vehicle.told] == ["land"], "it is in the air"
    servant.act_alone(Taken(takeoff=True, land=True))
    assert "nothing was done" in subject.said[-1]


def test_a_landing_alone_flies_the_one_that_the_mission_has(extra: tuple[Extra, Hoverer, TheOne, Clock]) -> None:
    """An ArduPlane with RTL_AUTOLAND 0 has it without DO_LAND_START, and does not find it by itself."""
    servant, vehicle, subject, _ = extra
    way = vencejo.MissionItem.waypoint(40.0, -3.0, alt_rel_home_m=60.0)
    down = vencejo.MissionItem.loiter_to_altitude(40.01, -3.0, alt_rel_home_m=40.0)
    land = vencejo.MissionItem.land(40.02, -3.0)

    def refuse(*, despite_mixed_plan: bool) -> None:
        raise errors.CommandRefused("no DO_LAND_START", "DO_LAND_START", "FAILED", ())

    vehicle.__dict__["land"] = refuse
    for items, done in (
        ((way, down, land), ("start_mission", {"from_item": 2})),
        ((way, vencejo.MissionItem.change_airspeed(14.0), land), ("start_mission", {"from_item": 1})),
        ((vencejo.MissionItem.takeoff(40.0, -3.0, alt_rel_home_m=50.0), land), ("start_mission", {"from_item": 2})),
        ((way, way), ("return_to_launch", {})),
    ):
        vehicle.told.clear()
        vehicle.__dict__["download"] = lambda items=items: vencejo.Plan(items=items)
        servant.act_alone(Taken(land=True))
        assert vehicle.told == [done], subject.said[-1]

    def fail() -> None:
        raise errors.TransferError("it does not answer")

    vehicle.__dict__["download"] = fail
    servant.act_alone(Taken(land=True))
    assert vehicle.told[-1][0] == "return_to_launch", "it comes home all the same"


def test_a_take_off_that_is_refused_leaves_the_mode_as_it_was(extra: tuple[Extra, Hoverer, TheOne, Clock]) -> None:
    """Whoever arms later by radio must not find the plane in a mode that begins to roll."""
    servant, vehicle, subject, _ = extra
    vehicle.is_on_ground, vehicle.mode = True, "MANUAL"

    def refuse(*, despite_mixed_plan: bool) -> None:
        raise errors.CommandRefused("no GPS", "ARM", "DENIED", ())

    vehicle.__dict__["arm"] = refuse
    servant.act_alone(Taken(takeoff=True))
    assert vehicle.told == [("set_mode", ("GUIDED",)), ("set_mode", ("MANUAL",))]
    assert "take-off: no GPS" in subject.said[-1]


def test_a_driver_that_ends_begins_no_further_act_of_a_take_off(extra: tuple[Extra, Hoverer, TheOne, Clock]) -> None:
    servant, vehicle, subject, _ = extra

    def tell(*what: Any) -> None:
        vehicle.told.append(what)
        if what[0] == last:
            servant._workers.close()

    vehicle.mode = "STABILIZE"
    vehicle.__dict__["prepare_flight"] = lambda **_: tell("prepare")
    vehicle.__dict__["set_mode"] = lambda mode: tell("mode", mode)
    vehicle.__dict__["arm"] = lambda **_: tell("arm")
    modes = [("mode", "GUIDED"), ("mode", "STABILIZE")]
    for act, is_armed, told in (
        ("arm", True, [modes[0], ("arm",)]),  # it was armed before
        ("arm", False, [("prepare",), modes[0], ("arm",), ("disarm", {})]),
        ("mode", False, [("prepare",), *modes]),
        ("prepare", False, [("prepare",)]),
    ):
        vehicle.told.clear()
        last, servant._workers = act, Workers()
        vehicle.is_on_ground, vehicle.is_armed = True, is_armed
        servant.act_alone(Taken(takeoff=True))
        assert vehicle.told == told
        assert subject.said[-1] == "take-off: the driver is ending"


def test_marks_act_alone_after_the_wait_and_not_before(extra: tuple[Extra, Hoverer, TheOne, Clock]) -> None:
    servant, vehicle, _, clock = extra
    servant.land()
    clock.now_s += 4.9
    servant.land()
    clock.now_s += 4.9
    with servant._changed:
        servant._changed.notify_all()
    assert vehicle.told == []
    clock.now_s += 0.1
    with servant._changed:
        servant._changed.notify_all()
    wait_for(lambda: [name for name, _ in vehicle.told] == ["land"], "landing alone")


def test_a_mark_that_acts_alone_keeps_the_leave_of_its_request(extra: tuple[Extra, Hoverer, TheOne, Clock]) -> None:
    servant, vehicle, _, clock = extra
    for current, named in ((DESPITE, {"despite_mixed_plan": True}), (NOT_DESPITE, {})):
        vehicle.told.clear()
        servant.land(current)
        clock.now_s += 5.0
        with servant._changed:
            servant._changed.notify_all()
        wait_for(lambda: bool(vehicle.told), "landing alone")
        assert vehicle.told == [("land", named)]


def test_flat_trim_only_when_disarmed(extra: tuple[Extra, Hoverer, TheOne, Clock]) -> None:
    servant, vehicle, subject, _ = extra
    servant.flatTrim()
    wait_for(lambda: any("disarmed" in text for text in subject.said), "the refusal")
    vehicle.is_armed = False
    servant.flatTrim()
    wait_for(lambda: bool(vehicle.told), "levelling")
    assert vehicle.told == [("command", ("PREFLIGHT_CALIBRATION", 0.0, 0.0, 0.0, 0.0, 2.0))]


def telemetry(landed: str | None, mode: str) -> Any:
    return SimpleNamespace(extended=None if landed is None else SimpleNamespace(landed=landed), mode=mode)


@pytest.mark.parametrize(
    ("landed", "mode", "state"),
    [
        (None, "AUTO", State.UNKNOWN),
        ("undefined", "AUTO", State.UNKNOWN),
        ("on ground", "AUTO", State.LANDED),
        ("taking off", "AUTO", State.TAKING_OFF),
        ("in air", "TAKEOFF", State.TAKING_OFF),
        ("in air", "AUTO", State.TO_POINT),
        ("in air", "LOITER", State.HOVERING),
        ("in air", "FBWA", State.FLYING),
        ("in air", "AUTO_TAKEOFF", State.TAKING_OFF),
        ("in air", "AUTO_MISSION", State.TO_POINT),
        ("in air", "AUTO_RTL", State.TO_POINT),
        ("in air", "AUTO_LOITER", State.HOVERING),
        ("landing", "AUTO", State.LANDING),
    ],
)
def test_states(landed: str | None, mode: str, state: State) -> None:
    assert state_of(telemetry(landed, mode)) is state


# Errors and pushes -------------------------------------------------------------------------------------------------


def test_every_error_of_the_package_reaches_a_client_with_what_it_holds() -> None:
    slices, workers = load(), Workers()
    faults = Faults(slices, workers)
    count = 0
    for _, error in _native.error_examples():
        if isinstance(error, VencejoError):
            fault: Any = faults.fault(error)
            assert isinstance(fault, slices.precise.VencejoException)
            assert fault.what == str(error)
            count += 1
    assert count > 10
    refused: Any = faults.fault(errors.CommandRefused("no", "ARM", "DENIED", ("no GPS", "no compass")))
    assert (refused.command, refused.result, refused.reasons) == ("ARM", "DENIED", ["no GPS", "no compass"])
    mismatch: Any = faults.fault(errors.PlanMismatch("differs", ("item 2: z",)))
    assert mismatch.differences == ["item 2: z"]
    assert isinstance(mismatch, slices.precise.TransferFailed)
    workers.close()


class Call:
    """A call to an observer."""

    def __init__(self, error: Exception | None = None) -> None:
        self._error = error

    def is_sent(self) -> bool:
        return self._error is None

    def done(self) -> bool:
        return True

    def exception(self) -> Exception | None:
        return self._error


def test_a_subscription_ends_with_its_observer() -> None:
    slices = load()
    calls: list[str] = []

    class Observer:
        def movedAsync(self, pose: str, navigation: str) -> Call:
            calls.append(pose + navigation)
            return Call(None if len(calls) < 3 else slices.ice.ConnectionLostException())

    watch = SimpleNamespace(closed=threading.Event())
    watch.close = watch.closed.set
    vehicle = SimpleNamespace(change_count=0, telemetry=None, on_event=lambda _: watch)
    states = SimpleNamespace(pose=lambda *_: "pose", navigation=lambda *_: " and more")
    clock = iter(range(1000))
    feed = Feed(slices, cast("States", states), clock=lambda: float(next(clock)) * 5.0)
    feed._add(cast("vencejo.Vehicle", vehicle), Observer(), 50.0, lambda: None)
    assert watch.closed.wait(30.0), "the third call found nobody"
    assert calls == ["pose and more"] * 3
    assert not feed._subscribers
    feed.close()
    assert not feed._thread.is_alive()


def test_a_subscription_ends_with_the_token_that_it_was_asked_for_with() -> None:
    """One call every ten seconds is due at most, and yet it is over within one."""
    told = iter([None, None, None, "the token was replaced"])
    calls: list[str] = []

    class Observer:
        def movedAsync(self, pose: None, navigation: None) -> Call:
            calls.append("moved")
            return Call()

    watch = SimpleNamespace(closed=threading.Event())
    watch.close = watch.closed.set
    vehicle = SimpleNamespace(change_count=0, telemetry=None, on_event=lambda _: watch)
    states = SimpleNamespace(pose=lambda *_: None, navigation=lambda *_: None)
    clock = iter(range(1000))
    feed = Feed(load(), cast("States", states), clock=lambda: float(next(clock)))
    feed._add(cast("vencejo.Vehicle", vehicle), Observer(), 0.1, lambda: next(told))
    assert watch.closed.wait(30.0), "it is over"
    assert next(clock) < 10, "before the next call was due"
    assert calls == ["moved"]
    assert not feed._subscribers
    feed.close()


def test_a_subscription_is_held_against_the_token_of_its_own_request() -> None:
    tokens = [Tokens(viewer="v" * 32, operator="o" * 32)]
    refusals: list[Callable[[], str | None]] = []
    feed = SimpleNamespace(
        subscribe=lambda *asked: refusals.append(asked[-1]), subscribe_here=lambda *asked: refusals.append(asked[-1])
    )
    faults, subject = SimpleNamespace(at_once=lambda work: work()), SimpleNamespace(need=lambda _: None)
    gate = Gate(lambda: tokens[0])
    servant = TelemetryServant(
        cast("Subject", subject), cast("States", None), cast("Faults", faults), cast("Feed", feed), gate
    )
    peer = SimpleNamespace(remoteAddress="203.0.113.1", remotePort=1)
    current = SimpleNamespace(con=SimpleNamespace(getInfo=lambda: peer), ctx={"token": "v" * 32})
    servant.subscribe(0, None, 1.0, current)
    servant.subscribeHere(0, "me", 1.0, current)
    assert [refusal() for refusal in refusals] == [None, None]
    tokens[0] = Tokens(viewer="n" * 32, operator="o" * 32)
    assert all("demands a token" in (refusal() or "") for refusal in refusals)
    assert len(refusals) == 2


def test_too_many_operations_at_once_are_refused() -> None:
    workers, go = Workers(), threading.Event()
    futures = [workers.later(lambda: go.wait(30.0)) for _ in range(64)]
    with pytest.raises(vencejo.Busy):
        workers.later(lambda: None)
    go.set()
    assert all(future.result(30.0) for future in futures)
    wait_for(lambda: workers.later(lambda: 1).result(30.0) == 1, "room again")
    workers.close()
    with pytest.raises(vencejo.Busy, match="ending"):
        workers.later(lambda: None)
