"""The parts that need no Ice: marks, missions of poses, approaches, velocities, settings, who may, and tables of errors."""

from __future__ import annotations

import ipaddress
import math
import random
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from vencejo import Command, GeoPoint, InvalidRequest, MissionItem, Plan, _native, errors
from vencejo.control import Operator
from vencejo.geodesy import bearing_deg
from vencejo.jderobot import IceSettings, read_cfg, read_config, runtime
from vencejo.jderobot.access import READS, Gate, Presence
from vencejo.jderobot.answers import ANSWERS, answer_of
from vencejo.jderobot.camera import _shrunk
from vencejo.jderobot.cmdvel import PlaneTargets, Targets, Velocity
from vencejo.jderobot.faults import FAULTS
from vencejo.jderobot.marks import Marks, Taken
from vencejo.jderobot.mission import MAX_POSES, Situation, check_poses, mission_of, poses_of
from vencejo.jderobot.pose import quaternion
from vencejo.jderobot.settings import INTERFACES, setting_names
from vencejo.landing import Wind
from vencejo.serve import Tokens

from tests.jderobot.support import SLICE, operations
from tests.support import HOME, ROOT

LAT, LON, _ = HOME
PLACES = [(LAT + 0.002 * number, LON, 60.0) for number in range(4)]


# Contracts ---------------------------------------------------------------------------------------------------------

CONTRACTS = {
    "Pose3DData": "float x, float y, float z, float h, float q0, float q1, float q2, float q3",
    "NavdataData": "int vehicle, int state, float batteryPercent, int magX, int magY, int magZ, int pressure, int temp,"
    " float windSpeed, float windAngle, float windCompAngle, float rotX, float rotY, float rotZ, int altd, float vx, float vy,"
    " float vz, float ax, float ay, float az, int tagsCount, arrayInt tagsType, arrayInt tagsXc, arrayInt tagsYc,"
    " arrayInt tagsWidth, arrayInt tagsHeight, arrayFloat tagsOrientation, arrayFloat tagsDistance, float tm",
    "CMDVelData": "float linearX, float linearY, float linearZ, float angularX, float angularY, float angularZ",
    "MissionData": "PoseSequence mission",
    "CameraDescription": "string name, string shortDescription, string streamingUri, float fdistx, float fdisty, float u0,"
    " float v0, float skew, float posx, float posy, float posz, float foax, float foay, float foaz, float roll",
    "ImageDescription": "int width, int height, int size, string format, string md5sum",
    "ImageData": "Time timeStamp, ImageDescription description, ByteSeq pixelData",
    "Time": "long seconds, long useconds",
    "JderobotException": "string what",
    "DataNotExistException": "",
    "HardwareFailedException": "",
    "Pose3D": "idempotent Pose3DData getPose3DData(), int setPose3DData(Pose3DData data)",
    "Navdata": "idempotent NavdataData getNavdata()",
    "ArDroneExtra": "void toggleCam(), void land(), void takeoff(), void reset(), void recordOnUsb(bool record),"
    " void ledAnimation(int type, float duration, float req), void flightAnimation(int type, float duration),"
    " void flatTrim()",
    "CMDVel": "int setCMDVelData(CMDVelData data)",
    "Mission": "idempotent MissionData getMissionData(), int setMissionData(MissionData data)",
    "Mission (sequence)": "idempotent PoseSequence getMissionData(), int setMissionData(PoseSequence data)",
    "ImageProvider": "idempotent ImageDescription getImageDescription(), idempotent ImageFormat getImageFormat(),"
    ' ["amd"] idempotent ImageData getImageData(string format)'
    " throws DataNotExistException, HardwareFailedException",
    "Camera": "idempotent CameraDescription getCameraDescription(),"
    " int setCameraDescription(CameraDescription description), string startCameraStreaming(),"
    " void stopCameraStreaming(), void reset()",
}
"""What programs of the JdeRobot platform were compiled with: a changed order or type is read as garbage by them."""
SEQUENCES = {
    "ByteSeq": "byte",
    "arrayInt": "int",
    "arrayFloat": "float",
    "ImageFormat": "string",
    "PoseSequence": "Pose3DData",
}
BASES = {
    "Camera": "ImageProvider",
    "DataNotExistException": "JderobotException",
    "HardwareFailedException": "JderobotException",
}


def test_the_slice_files_are_what_existing_programs_have() -> None:
    found: dict[str, str] = {}
    sequences: dict[str, str] = {}
    bases: dict[str, str] = {}
    for path in sorted((SLICE / "jderobot").glob("*.ice")):
        text = re.sub(r"/\*.*?\*/|//[^\n]*|#[^\n]*", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        assert "module jderobot" in text
        sequences |= {name: of for of, name in re.findall(r"sequence<(\w+)> (\w+);", text)}
        for kind, name, base, body in re.findall(
            r"(class|struct|exception|interface) (\w+)(?: extends (\w+))?\s*\{(.*?)\}", text, re.DOTALL
        ):
            if base:
                bases[name] = base
            key = f"{name} (sequence)" if "sequence" in path.name and kind == "interface" else name
            found[key] = ", ".join(" ".join(part.split()) for part in body.split(";") if part.strip())
    assert found == CONTRACTS
    assert sequences == SEQUENCES
    assert bases == BASES


# Marks -------------------------------------------------------------------------------------------------------------


def test_marks_are_used_up_by_a_mission_or_act_alone() -> None:
    marks = Marks(5.0)
    assert marks.take() == Taken()
    marks.mark(0.0, takeoff=True)
    marks.mark(3.0, land=True)
    assert marks.due_s == 8.0, "the wait begins anew with each mark"
    assert marks.take_due(7.9) == Taken()
    assert marks.take() == Taken(takeoff=True, land=True)
    assert marks.take() == Taken()
    assert marks.take_due(100.0) == Taken(), "a mission used them up"
    marks.mark(100.0, land=True)
    assert marks.take_due(105.0) == Taken(land=True)
    assert marks.due_s is None


# Missions of poses -------------------------------------------------------------------------------------------------


def test_poses_become_a_mission_as_the_marks_say() -> None:
    plain, _ = mission_of(PLACES, Taken())
    assert [item.command for item in plain] == [Command.NAV_WAYPOINT] * 4
    both, cautions = mission_of(PLACES, Taken(takeoff=True, land=True))
    commands = [item.command for item in both]
    assert commands == [
        Command.NAV_TAKEOFF,
        Command.NAV_WAYPOINT,
        Command.NAV_WAYPOINT,
        Command.DO_LAND_START,
        Command.NAV_LOITER_TO_ALT,
        Command.NAV_LAND,
    ]
    assert (both.items[0].lat_deg, both.items[0].alt_m) == (LAT, 60.0)
    assert (both.items[-1].lat_deg, both.items[-1].alt_m) == (PLACES[-1][0], 0.0), "a landing is at home's height"
    assert not [finding for finding in both.check(on_ground=True) if finding.severity == "error"]
    assert [caution.code for caution in cautions] == ["ground-not-known"]


@pytest.mark.parametrize(
    ("poses", "marks", "says"),
    [
        ([], Taken(), "no pose"),
        ([(math.nan, LON, 60.0)], Taken(), "pose 1 of 1: x, y and h must be numbers"),
        ([(LAT, math.inf, 60.0)], Taken(), "must be numbers"),
        ([PLACES[0], (91.0, LON, 60.0)], Taken(), "pose 2 of 2: .* off the globe"),
        ([(LAT, 180.5, 60.0)], Taken(), "off the globe"),
        ([(0.0, 0.0, 60.0)], Taken(), "not a chosen position"),
        ([(LAT, LON, 1e6)], Taken(), "h is 1e.06 m"),
        ([(LAT, LON, -5.0)], Taken(), "h is -5 m"),
        ([(LAT, LON, 0.0)], Taken(takeoff=True), "h is 0 m"),
        ([PLACES[0], (LAT, LON, -2e4)], Taken(land=True), "h is -20000 m"),
        ([PLACES[0]], Taken(takeoff=True, land=True), "both take-off and landing"),
        ([PLACES[0]] * (MAX_POSES + 1), Taken(), "701 poses"),
    ],
)  # fmt: skip
def test_bad_missions_are_refused(poses: list[Any], marks: Taken, says: str) -> None:
    with pytest.raises(InvalidRequest, match=says):
        check_poses(poses, marks)
    with pytest.raises(InvalidRequest, match=says):
        mission_of(poses, marks)


def test_what_hovers_lands_without_an_approach() -> None:
    plan, _ = mission_of(PLACES, Taken(takeoff=True, land=True), Situation(hovers=True))
    assert [item.command for item in plan][-2:] == [Command.NAV_WAYPOINT, Command.NAV_LAND]


def test_a_landing_below_home_or_with_any_height_is_taken() -> None:
    plan, _ = mission_of([PLACES[1], (LAT, LON, -30.0)], Taken(land=True))
    assert plan.items[-1].alt_m == 0.0


def test_poses_of_a_mission_are_its_places_above_home() -> None:
    plan = Plan(
        items=(
            MissionItem.takeoff(LAT, LON, alt_rel_home_m=50.0),
            MissionItem(Command.NAV_WAYPOINT, 0, (0.0, 0.0, 0.0, 0.0, LAT, LON, 700.0)),
            MissionItem(Command.NAV_WAYPOINT, 10, (0.0, 0.0, 0.0, 0.0, LAT, LON, 70.0)),
            MissionItem.change_airspeed(18.0),
            MissionItem.land_start(LAT, LON, alt_rel_home_m=40.0),
            MissionItem.land(LAT, LON),
        )
    )
    assert poses_of(plan, 600.0) == [(LAT, LON, 50.0), (LAT, LON, 100.0), (LAT, LON, 0.0)]
    assert poses_of(plan, None) == [(LAT, LON, 50.0), (LAT, LON, 0.0)], "without home nobody knows what 700 m are"


def final_leg(plan: Plan) -> float:
    """Course of the last leg: where it begins stands in DO_LAND_START."""
    start, land = plan.items[-3], plan.items[-1]
    assert (start.command, land.command) == (Command.DO_LAND_START, Command.NAV_LAND)
    assert start.lat_deg is not None
    assert start.lon_deg is not None
    assert land.lat_deg is not None
    assert land.lon_deg is not None
    return bearing_deg(GeoPoint(start.lat_deg, start.lon_deg), GeoPoint(land.lat_deg, land.lon_deg))


def test_the_poses_choose_the_direction_of_the_landing_then_the_wind_then_the_vehicle() -> None:
    land, there = Taken(land=True), (LAT, LON, 60.0)
    from_west, near = (LAT, LON - 0.01, 60.0), (LAT + 0.0001, LON, 60.0)
    wind, position = Wind(135.0, 4.0), GeoPoint(LAT + 0.01, LON)
    every = Situation(position=position, wind=wind)
    assert final_leg(mission_of([from_west, there], land, every)[0]) == pytest.approx(90.0, abs=0.1)
    assert final_leg(mission_of([from_west, near, there], land, every)[0]) == pytest.approx(90.0, abs=0.1), (
        "11 m are none"
    )
    assert final_leg(mission_of([near, there], land, every)[0]) == pytest.approx(135.0, abs=0.1)
    assert final_leg(mission_of([there], land, Situation(position=position))[0]) == pytest.approx(180.0, abs=0.1)
    calm = Situation(position=position, wind=Wind(135.0, 0.5))
    assert final_leg(mission_of([there], land, calm)[0]) == pytest.approx(180.0, abs=0.1)
    with pytest.raises(InvalidRequest, match="nothing says in which direction to land"):
        mission_of([there], land)
    tail = Situation(wind=Wind(270.0, 6.0))
    assert [one.code for one in mission_of([from_west, there], land, tail)[1]] == ["ground-not-known", "tailwind"]


def test_a_landing_without_land_start_for_a_vehicle_that_does_not_arm_with_one() -> None:
    plan, _ = mission_of(PLACES, Taken(land=True), Situation(has_land_start=False))
    assert [item.command for item in plan][-2:] == [Command.NAV_LOITER_TO_ALT, Command.NAV_LAND]
    assert Command.DO_LAND_START not in [item.command for item in plan]


def test_the_station_that_jderobot_had_sends_its_first_pose_twice() -> None:
    """UAV Commander did so for its own driver, which lost the first: it is flown over once more, and harms nobody."""
    plan, _ = mission_of([PLACES[0], *PLACES], Taken(takeoff=True, land=True))
    assert [item.command for item in plan][:3] == [Command.NAV_TAKEOFF, Command.NAV_WAYPOINT, Command.NAV_WAYPOINT]
    assert not [finding for finding in plan.check(on_ground=True) if finding.severity == "error"]


# Poses and pictures ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("angles", "expected"),
    [
        ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)),
        ((math.pi / 2, 0.0, 0.0), (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)),
        ((0.0, math.pi / 2, 0.0), (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)),
        ((0.0, 0.0, math.pi / 2), (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))),
        ((0.1, -0.2, 3.0), None),
    ],
)
def test_quaternions(angles: tuple[float, float, float], expected: tuple[float, ...] | None) -> None:
    w, x, y, z = quaternion(*angles)
    assert w * w + x * x + y * y + z * z == pytest.approx(1.0)
    if expected is not None:
        assert (w, x, y, z) == pytest.approx(expected)
    # Back again (Diebel 2006, eq. 290): the same turns in the other direction.
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    if abs(angles[1]) < 1.5:
        assert (roll, pitch, yaw) == pytest.approx(angles)


def test_pictures_shrink_to_the_limit_and_keep_their_shape() -> None:
    rgb = np.arange(720 * 1280 * 3, dtype=np.uint32).astype(np.uint8).reshape(720, 1280, 3)
    assert _shrunk(rgb, 640, 480).shape == (360, 640, 3)
    assert _shrunk(rgb, 1280, 720) is rgb
    assert _shrunk(rgb, 1, 1).shape[2] == 3


# Velocities --------------------------------------------------------------------------------------------------------

FLYING = {"course_rad": math.radians(90.0), "groundspeed_m_s": 20.0, "alt_amsl_m": 700.0}


def test_a_plane_turns_and_climbs_by_leading_targets_and_flies_straight_and_level_without_commands() -> None:
    plane = PlaneTargets()
    first = plane.targets(Velocity(18.0, 0.0, 2.0, 0.25), 0.0, **FLYING)
    assert first.airspeed_m_s == 18.0
    assert first.course is not None
    assert first.course[0] == pytest.approx(90.0 - math.degrees(1.0)), "to the left, a fourth of a radian a second"
    assert first.course[1] == 5.0
    assert first.alt_amsl_m == 701.0
    again = plane.targets(Velocity(18.0, 0.0, 2.0, 0.25), 0.1, **FLYING)
    assert again == Targets(), "nothing is sent ten times a second"
    assert plane.targets(Velocity(18.0, 0.0, 2.0, 0.25), 0.6, **FLYING).course is not None
    over = plane.targets(None, 0.7, **FLYING)
    assert over.course == (90.0, 5.0)
    assert over.alt_amsl_m == 700.0
    assert plane.targets(None, 5.0, **FLYING).course is None, "once is enough"


def test_a_climb_goes_on_from_where_it_began_whatever_the_plane_makes_of_it() -> None:
    plane = PlaneTargets()
    lags = FLYING | {"alt_amsl_m": 699.0}

    def told(up_m_s: float, now_s: float) -> float | None:
        return plane.targets(Velocity(18.0, 0.0, up_m_s), now_s, **(lags if now_s else FLYING)).alt_amsl_m

    heights = [told(2.0, half / 2.0) for half in range(9)]
    assert heights == [701.0, 702.0, 703.0, 704.0, 705.0, 706.0, 707.0, 708.0, 708.0]
    assert told(-2.0, 5.0) == 698.0, "down from where it is"
    assert told(0.0, 5.1) == 699.0
    assert told(0.0, 6.0) is None
    assert told(2.0, 7.0) == 700.0


def test_a_plane_told_to_turn_hard_never_turns_the_other_way() -> None:
    course = PlaneTargets().targets(Velocity(left_rad_s=-3.0), 0.0, **FLYING).course
    assert course is not None
    turn = (course[0] - 90.0 + 540.0) % 360.0 - 180.0
    assert 0.0 < turn < 180.0
    assert course[1] == 20.0, "as steep as a command may be"


@pytest.mark.parametrize("bad", [Velocity(math.nan), Velocity(0.0, 51.0), Velocity(left_rad_s=math.inf)])
def test_velocities_that_cannot_be(bad: Velocity) -> None:
    assert not bad.is_possible
    assert Velocity(20.0, 0.0, -3.0, 0.5).is_possible


# Settings ----------------------------------------------------------------------------------------------------------


def test_defaults_are_the_ports_and_identities_of_existing_configurations() -> None:
    settings = IceSettings()
    assert {name: (entry.identity, entry.port) for name, entry in INTERFACES.items() if name != "Precise"} == {
        "Camera": ("cameraA", 9999),
        "Pose3D": ("ardrone_pose3d", 9998),
        "Navdata": ("ardrone_navdata", 9996),
        "CMDVel": ("ardrone_cmdvel", 9995),
        "Extra": ("ardrone_extra", 9994),
        "Mission": ("ardrone_mission", 10008),
    }
    assert settings.endpoint("Camera") == "tcp -h 127.0.0.1 -p 9999"
    assert not settings.lets_others_in


@pytest.mark.parametrize(
    ("endpoint", "lets_in"),
    [
        ("tcp -h 127.0.0.1 -p 1", False),
        ("tcp -h ::1 -p 1:ws -h localhost -p 2", False),
        ('tcp -h "::1" -p 1', False),
        ("tcp -h 127.0.0.1 -p 1:ssl -h 10.0.0.1 -p 2", True),
        ("default -p 9998", True),
        ("tcp -h 0.0.0.0 -p 1", True),
        ("", False),
    ],
)
def test_endpoints_that_let_others_in(endpoint: str, lets_in: bool) -> None:
    assert IceSettings(endpoints={"Pose3D": endpoint}).lets_others_in is lets_in


def test_a_cfg_file_of_an_older_driver_is_understood(tmp_path: Path) -> None:
    path = tmp_path / "ardrone.cfg"
    path.write_text(
        "# An older driver's\nArDrone.Camera.Endpoints=default -h 0.0.0.0 -p 9999\nArDrone.Camera.Name=ardrone_camera\n"
        "ArDrone.RemoteConfig.Name=ardrone_remoteConfig\n\nVencejo.Missions = upload # stop there\nIce.Trace.Network=1\n"
        "UavViewer.Mission.Proxy=ardrone_mission:default -h 0.0.0.0 -p 10008\nIceSSL.Password=a\\#b\\=c\n"
    )
    settings = read_cfg(path, IceSettings(host="10.0.0.1"))
    assert settings.endpoint("Camera") == "default -h 0.0.0.0 -p 9999"
    assert settings.identity("Camera") == "ardrone_camera"
    assert settings.endpoint("Pose3D") == "tcp -h 10.0.0.1 -p 9998"
    assert settings.identities("Camera") == ("ardrone_camera",)
    assert IceSettings().identities("Camera") == ("cameraA", "ardrone_camera")
    assert settings.missions == "upload"
    assert settings.properties == {
        "Ice.Trace.Network": "1",
        "UavViewer.Mission.Proxy": "ardrone_mission:default -h 0.0.0.0 -p 10008",
        "IceSSL.Password": "a#b=c",
    }, "a client's own settings do no harm"


def test_vencejos_own_configuration_is_read(tmp_path: Path) -> None:
    path = tmp_path / "config.toml"
    path.write_text(
        '[ice]\nHost = "192.168.1.2"\nAloneAfter = 8\nAllow = ["192.168.1.0/24", "::1"]\n'
        '[ice.Mission]\nName = "m"\n[ice.Camera]\nRate = 5\nEndpoints = ""\n[other]\nx = 1\n'
    )
    settings = read_config(path, IceSettings())
    assert settings.alone_after_s == 8.0
    assert settings.identity("Mission") == "m"
    assert settings.camera_rate_hz == 5.0
    assert settings.endpoint("Camera") == "", "an empty one switches it off"
    assert settings.allow == (ipaddress.ip_network("192.168.1.0/24"), ipaddress.ip_network("::1"))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[ice]\nNoSuch = 1", r"\[ice\]: 'NoSuch' is not a setting; they are Host, "),
        ("[ice.Mission]\nProxy = 'ardrone_mission:tcp -p 10008'", "a client's setting; a driver has Mission.Endpoints"),
        ("[ice]\nAloneAfter = 'soon'", "AloneAfter is 'soon'"),
        ("[ice]\nAloneAfter = 0.1", "alone_after_s is 0.1, should be 0.5 to 600"),
        ("[ice]\nMissions = 'hover'", "it is fly or upload"),
        ("[ice]\nAllow = 'everybody'", "Allow is 'everybody'"),
        ("ice = 3", "ice is a table"),
        ("[ice", "config.toml: "),
    ],
)
def test_mistakes_in_settings_are_named(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "config.toml"
    path.write_text(text)
    with pytest.raises(InvalidRequest, match=says):
        read_config(path, IceSettings())


def test_mistakes_in_a_cfg_file_are_named(tmp_path: Path) -> None:
    path = tmp_path / "vencejo.cfg"
    path.write_text("Vencejo.Pose3D.Endpoints tcp\n")
    with pytest.raises(InvalidRequest, match=r"vencejo.cfg, line 1: write NAME=VALUE"):
        read_cfg(path, IceSettings())
    with pytest.raises(InvalidRequest, match="No such file"):
        read_cfg(tmp_path / "none.cfg", IceSettings())


def test_the_documentation_names_every_setting_and_answer() -> None:
    page = (ROOT / "docs" / "jderobot.md").read_text(encoding="utf-8")
    for name in setting_names():
        interface, _, what = name.rpartition(".")
        named = f"`{what}`" if interface and what in ("Endpoints", "Name") else f"`{name}`"
        assert named in page or f".{what}`" in page, f"docs/jderobot.md does not name {name}"
    for answer in ANSWERS.values():
        assert f"| {int(answer)} |" in page, f"docs/jderobot.md does not name answer {answer!r}"


# Who may -----------------------------------------------------------------------------------------------------------


def test_others_need_a_token_of_their_role_or_a_network_that_is_let_in() -> None:
    gate = Gate(lambda: Tokens(viewer="v" * 32, operator="o" * 32), [ipaddress.ip_network("192.168.1.0/24")])
    assert Gate(None).refusal("203.0.113.1", "", "arm") is None
    assert gate.refusal("192.168.1.7", "", "setMissionData") is None
    assert gate.refusal("::ffff:192.168.1.7", "", "setMissionData") is None
    assert gate.refusal("203.0.113.1", "o" * 32, "setMissionData") is None
    assert gate.refusal("203.0.113.1", "v" * 32, "getPose3DData") is None
    page, other = "http://192.168.1.7:8080", "https://example.org"
    assert gate.refusal("192.168.1.7", "", "setMissionData", page) is None
    assert gate.refusal("192.168.1.7", "", "setMissionData", other), (
        "a page of somewhere else in a browser that is let in"
    )
    assert gate.refusal("192.168.1.7", "o" * 32, "setMissionData", other) is None
    for origin in ("http://localhost:3000", "http://127.0.0.1", "http://[::1]:80", None):
        assert Gate(None).refusal("127.0.0.1", "", "arm", origin) is None
    for origin in (other, page, "null", "http://[", ""):
        assert Gate(None).refusal("127.0.0.1", "", "arm", origin), origin
    for remote, token, operation in (
        ("203.0.113.1", "", "getPose3DData"),
        ("203.0.113.1", "v" * 32, "setMissionData"),
        ("203.0.113.1", "o" * 31, "ice_ping"),
        (None, "ö", "ice_ping"),
    ):
        assert gate.refusal(remote, token, operation), (remote, token, operation)


def test_a_token_that_was_replaced_is_refused_from_then_on_and_the_new_one_is_taken() -> None:
    held: list[Tokens | None] = [Tokens(viewer="v" * 32, operator="o" * 32)]
    gate = Gate(lambda: held[0])

    def may(token: str) -> bool:
        return gate.refusal("203.0.113.1", token, "setMissionData") is None

    assert [may("o" * 32), may("n" * 32)] == [True, False]
    held[0] = Tokens(viewer="v" * 32, operator="n" * 32)
    assert [may("o" * 32), may("n" * 32)] == [False, True]
    held[0] = None
    assert not may("n" * 32), "without tokens nobody else is let in"


def test_a_connection_whose_token_was_replaced_no_longer_keeps_control() -> None:
    held = [Tokens(viewer="v" * 32, operator="o" * 32)]
    gate, counts = Gate(lambda: held[0]), [0]

    class Present:
        def attach(self) -> None:
            counts[0] += 1

        def detach(self) -> None:
            counts[0] -= 1

    class Connection:
        def getInfo(self) -> object:
            return SimpleNamespace(remoteAddress="203.0.113.1", remotePort=1)

        def setCloseCallback(self, call: Callable[[object], None]) -> None:
            closing.append(call)

    closing: list[Callable[[object], None]] = []
    connection = Connection()
    presence = Presence(cast("Operator", Present()))
    try:
        presence.acts(connection, gate.standing(connection, "setMissionData", "o" * 32))
        presence.recheck()
        assert counts == [1]
        held[0] = Tokens(viewer="v" * 32, operator="n" * 32)
        presence.recheck()
        assert counts == [0]
        presence.acts(connection, gate.standing(connection, "setMissionData", "n" * 32))
        presence.recheck()
        assert counts == [1], "with the new token it is there again"
        closing[-1](connection)
        closing[0](connection)
        assert counts == [0], "and leaves once"
    finally:
        presence.close()


@pytest.mark.fault(44, figure="what a viewer may call over Ice commands nothing")
def test_what_a_viewer_may_call_exists_and_commands_nothing() -> None:
    names = {name.partition(".")[2] for name in operations()}
    assert len(names) > 40
    builtin = {name for name in READS if name.startswith("ice_")}
    assert builtin < READS
    assert READS - builtin <= names
    # Whatever changes the vehicle, the driver or what others see is the operator's.
    assert not {name for name in READS if re.match(r"set|clear|upload|start$|arm|land|take|go|fly|climb|command", name)}


@pytest.mark.fault(51, figure="100 damaged installations: a clear error each", seeds=100)
def test_a_damaged_slice_file_is_told_and_ends_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A hundred installations with a file cut off, changed or missing. Over some of them Ice's compiler ends the process."""
    assert runtime.digest(SLICE) == runtime.SLICE_DIGEST, "a Slice file has changed: put this into runtime.py"
    for seed in range(100):
        chance, folder = random.Random(seed), tmp_path / str(seed)
        shutil.copytree(SLICE, folder)
        path = chance.choice(sorted(folder.rglob("*.ice")))
        data = bytearray(path.read_bytes())
        at = chance.randrange(len(data))
        if seed % 4 == 0:
            del data[at:]
        else:
            data[at] ^= chance.randrange(1, 256)
        path.write_bytes(data)
        if seed % 10 == 0:
            path.unlink()
        monkeypatch.setattr(runtime, "SLICE_DIR", folder)
        with pytest.raises(errors.VencejoError, match="not those of this version; install Vencejo again"):
            runtime._load()


WRITES = frozenset(
    {
        "abortLanding", "arm", "clear", "climbTo", "command", "disarm", "flatTrim", "flightAnimation",
        "flyCourse", "goTo", "land", "ledAnimation", "loiter", "pause", "prepareFlight", "recordOnUsb", "reset", "resume",
        "returnToLaunch", "setAirspeed", "setAltitude", "setCMDVelData", "setCameraDescription",
        "setCurrentItem", "setMissionData", "setMode", "setPose3DData", "setVelocity", "start", "takeoff",
        "toggleCam", "upload",
    }
)  # fmt: skip
"""Operations for operators alone; each operation of the Slice files is here or in `READS`."""


def test_every_role_at_every_operation() -> None:
    names = {name.partition(".")[2] for name in operations()}
    builtin = {name for name in READS if name.startswith("ice_")}
    assert (READS - builtin) | WRITES == names, "say who may call a new operation"
    assert not READS & WRITES
    gate = Gate(lambda: Tokens(viewer="v" * 32, operator="o" * 32))
    for name in names | builtin:
        may = [gate.refusal("203.0.113.1", token, name) is None for token in ("", "v" * 32, "o" * 32)]
        assert may == [False, name in READS, True], name


def test_what_ice_needs_never_holds_up_the_demonstration() -> None:
    """`make demo` neither installs nor compiles ZeroC Ice, and no part that it runs imports it."""
    plan = {
        target: subprocess.run(["make", "-n", target], cwd=ROOT, capture_output=True, text=True, timeout=60, check=True)
        for target in ("demo", "test")
    }
    assert "vencejo demo" in plan["demo"].stdout
    assert "setup.sh ice" not in plan["demo"].stdout
    assert "dev-env" in plan["test"].stdout
    assert "scripts/setup.sh ice" in (ROOT / "Makefile").read_text(encoding="utf-8").partition("dev-env:\n")[2]


# Errors ------------------------------------------------------------------------------------------------------------


def test_every_error_has_an_answer_and_an_exception_of_the_slice_file() -> None:
    kinds = {kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, errors.VencejoError)}
    assert len(kinds) > 10
    assert set(ANSWERS) == kinds
    assert set(FAULTS) == kinds
    slice_file = (SLICE / "vencejo" / "vencejo.ice").read_text(encoding="utf-8")
    declared = set(re.findall(r"^\s*exception (\w+)", slice_file, re.MULTILINE))
    assert set(FAULTS.values()) == declared

    class Newer(errors.Busy):
        pass

    assert answer_of(Newer("a subclass has its base's")) == answer_of(errors.Busy("x")) == 3
    walked = {answer_of(error) for _, error in _native.error_examples() if isinstance(error, errors.VencejoError)}
    assert len(walked) > 4
    assert 0 not in walked
