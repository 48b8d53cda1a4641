"""Every operation of every interface, from Python, on a plane that stands; and what a client may do wrong."""

from __future__ import annotations

import contextlib
import json
import math
import queue
import socket
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from vencejo.serve import renew_tokens

from tests.jderobot.support import (
    EMPTY,
    INTERFACES,
    MALFORMED,
    NODE,
    SLICE,
    Client,
    address_of,
    client_of,
    driver,
    example,
    javascript,
    many_files,
    operations,
    raw,
)
from tests.server.client import Served
from tests.support import HOME, simulated_plane, wait_for

LAT, LON, ALT = HOME
PLACES = [(LAT + 0.003 * number, LON, 60.0) for number in range(1, 4)]

JSCLIENT = Path(__file__).with_name("operations.js")


class Recorder:
    """Calls operations by name and keeps which ones were called."""

    def __init__(self, client: Client) -> None:
        self.client = client
        self.called: set[str] = set()

    def __call__(self, interface: str, operation: str, *arguments: Any, of: str | None = None) -> Any:
        proxies = {"ArDroneExtra": "Extra", "ImageProvider": "Camera"}
        precise = interface in ("Telemetry", "Missions", "Control")
        proxy = self.client.proxy("Precise" if precise else proxies.get(interface, interface), interface)
        self.called.add(f"{interface}.{operation}")
        return getattr(proxy, operation)(*arguments)

    def refused(self, kind: Any, interface: str, operation: str, *arguments: Any) -> Any:
        """Call one that must fail with this exception; gives it back."""
        with pytest.raises(kind) as caught:
            self(interface, operation, *arguments)
        return caught.value


def test_every_operation_from_python(client: Client) -> None:
    call, precise, jderobot = Recorder(client), client.precise, client.jderobot

    pose = call("Pose3D", "getPose3DData")
    assert (pose.x, pose.y) == pytest.approx((LAT, LON), abs=1e-4)
    assert pose.z == pose.h == pytest.approx(ALT, abs=5.0)
    assert pose.q0**2 + pose.q1**2 + pose.q2**2 + pose.q3**2 == pytest.approx(1.0, abs=1e-5)
    assert call("Pose3D", "setPose3DData", pose) == 7, "it is not in GUIDED, and stays where it is"
    assert call("Pose3D", "setPose3DData", jderobot.Pose3DData(x=math.nan)) == 1

    navdata = call("Navdata", "getNavdata")
    assert (navdata.vehicle, navdata.state, navdata.tagsCount) == (1, 2, 0)
    assert navdata.tagsType == navdata.tagsDistance == []
    assert 90_000 < navdata.pressure < 105_000
    assert navdata.batteryPercent > 50
    assert navdata.az == pytest.approx(-1.0, abs=0.1)
    assert -180.0 <= navdata.rotZ <= 180.0
    assert navdata.rotZ % 360.0 == pytest.approx(270.0, abs=5.0), "it looks west"
    assert 200 < math.hypot(navdata.magX, navdata.magY, navdata.magZ) < 700, "milligauss"
    assert abs(navdata.altd) < 5_000
    assert navdata.tm > 0

    assert call("CMDVel", "setCMDVelData", jderobot.CMDVelData(linearX=1.0)) == 7, "it is not in GUIDED"
    assert call("CMDVel", "setCMDVelData", jderobot.CMDVelData(linearX=math.inf)) == 1
    assert call("CMDVel", "setCMDVelData", None) == 1

    for operation, arguments in (
        ("takeoff", ()),
        ("land", ()),
        ("toggleCam", ()),
        ("recordOnUsb", (True,)),
        ("ledAnimation", (1, 2.0, 3.0)),
        ("flightAnimation", (1, 2.0)),
        ("flatTrim", ()),
        ("reset", ()),
    ):
        assert call("ArDroneExtra", operation, *arguments) is None

    assert call("Mission", "getMissionData").mission == []
    assert call("Mission", "setMissionData", client.mission_data()) == 1
    assert call("Mission", "setMissionData", None) == 1
    assert call("Mission", "setMissionData", client.mission_data(*PLACES)) == 1, "it stands, and no take-off was marked"
    assert call("Missions", "getPlanState", 0, precise.PlanKind.MissionPlan).state in ("unknown", "empty")

    assert call("ImageProvider", "getImageFormat")[0] == "RGB8"
    assert call("ImageProvider", "getImageDescription").width == 0
    no_camera = call.refused(jderobot.DataNotExistException, "ImageProvider", "getImageData", "RGB8")
    assert "there is no camera" in no_camera.what
    description = call("Camera", "getCameraDescription")
    description.streamingUri = "rtsp://192.0.2.1/plane"
    assert call("Camera", "setCameraDescription", description) == 0
    assert call("Camera", "startCameraStreaming") == "rtsp://192.0.2.1/plane"
    assert call("Camera", "stopCameraStreaming") is None
    assert call("Camera", "reset") is None
    assert call("Camera", "startCameraStreaming") == ""

    assert call("Telemetry", "vehicles") == [1]
    fine = call("Telemetry", "getPose", 0)
    assert (fine.latDeg, fine.lonDeg) == pytest.approx((LAT, LON), abs=1e-4)
    assert abs(fine.latDeg * 1e7 - round(fine.latDeg * 1e7)) < 1e-3, "as fine as the vehicle tells it"
    assert 0.0 <= fine.positionAgeS < 5.0
    assert fine.at.bootS > 0
    navigation = call("Telemetry", "getNavigation", 1)
    assert (navigation.mode, navigation.isArmed, navigation.landed) == ("MANUAL", False, "on ground")
    assert navigation.homeAltAmslM == pytest.approx(ALT, abs=5.0)
    assert call.refused(precise.NoVehicle, "Telemetry", "getPose", 99).what.startswith("vehicle 99 has not been heard")
    call.refused(precise.InvalidRequest, "Telemetry", "subscribeHere", 0, "me", 1000.0)
    unreachable = client.communicator.stringToProxy("me:tcp -h 192.0.2.1 -p 9")
    observer = precise.ObserverPrx.uncheckedCast(unreachable)
    elsewhere = call.refused(precise.InvalidRequest, "Telemetry", "subscribe", 0, observer, 1.0)
    assert "no endpoint at 127.0.0.1" in elsewhere.what, "nobody aims the driver at others"
    assert call("Telemetry", "unsubscribe", 12345) is None

    item = precise.MissionItem(command=16, frame=3, param2=25.0, x=LAT + 0.0035121, y=LON, z=60.5)
    start = precise.MissionItem(command=22, frame=3, param1=15.0, x=LAT, y=LON, z=50.0)
    plan = precise.Plan([start, item], client.ice.Unset, [], client.ice.Unset, [])
    assert [finding.code for finding in call("Missions", "check", 0, plan) if finding.isError] == []
    nowhere = precise.Plan([precise.MissionItem(command=16, frame=3, x=95.0, y=LON, z=60.0)], fence=[], rally=[])
    refused = call.refused(precise.PlanRefused, "Missions", "upload", 0, precise.PlanKind.MissionPlan, nowhere)
    assert refused.findings[0].isError
    assert refused.findings[0].item == 1
    call.refused(precise.InvalidRequest, "Missions", "upload", 0, precise.PlanKind.MissionPlan, None)
    for odd in ({"command": 70_000, "frame": 3}, {"command": -1, "frame": 3}, {"command": 16, "frame": 300}):
        impossible = precise.Plan([precise.MissionItem(**odd, x=LAT, y=LON, z=60.0)], fence=[], rally=[])
        call.refused(precise.InvalidRequest, "Missions", "upload", 0, precise.PlanKind.MissionPlan, impossible)
        call.refused(precise.InvalidRequest, "Missions", "check", 0, impossible)
    lost = precise.Plan(items=[], fence=[], rally=[precise.RallyPoint(LAT, LON, 70.0, 300)])
    call.refused(precise.InvalidRequest, "Missions", "upload", 0, precise.PlanKind.RallyPlan, lost)
    state = call("Missions", "upload", 0, precise.PlanKind.MissionPlan, plan)
    assert (state.state, state.count) == ("verified", 2)
    assert call("Missions", "getPlanState", 0, precise.PlanKind.MissionPlan).hash == state.hash
    back = call("Missions", "download", 0, precise.PlanKind.MissionPlan)
    assert [(one.command, one.frame) for one in back.items] == [(22, 3), (16, 3)]
    assert (back.items[1].x, back.items[1].z) == (round(item.x, 7), 60.5), "a double, to the vehicle's own digit"
    assert call("Mission", "getMissionData").mission[1].h == 60.5, "the other interface shows it too"
    zone = precise.Zone(True, [precise.GeoPoint(LAT, LON)], 900.0)
    fence = precise.Plan(items=[], fence=[zone], rally=[precise.RallyPoint(LAT, LON, 70.0)])
    assert call("Missions", "upload", 0, precise.PlanKind.FencePlan, fence).state == "verified"
    assert call("Missions", "download", 0, precise.PlanKind.FencePlan).fence[0].radiusM == 900.0
    assert call("Missions", "upload", 0, precise.PlanKind.RallyPlan, fence).count == 1
    assert call("Missions", "download", 0, precise.PlanKind.RallyPlan).rally[0].altM == 70.0
    for kind, act in ((precise.PlanKind.FencePlan, "clear-fence"), (precise.PlanKind.RallyPlan, "clear-rally")):
        assert call("Missions", "clear", 0, kind, {"confirm": act}) is None
    assert call("Missions", "setCurrentItem", 0, 2) is None
    wait_for(lambda: call("Missions", "getProgress", 0).item == 2, "the item in execution")
    assert call("Missions", "getProgress", 0).total == 2
    assert call("Missions", "prepareFlight", 0) is None
    # Disarmed it goes through the modes and stays where it is.
    assert call("Missions", "start", 0, 1) is None
    assert call("Missions", "pause", 0) is None
    assert call("Telemetry", "getNavigation", 0).mode == "LOITER"
    assert call("Missions", "resume", 0) is None
    assert call("Telemetry", "getNavigation", 0).mode == "AUTO"

    assert "AUTO" in call("Control", "modes", 0)
    assert call("Control", "setMode", 0, "fbwa") is None
    assert "did you mean" in call.refused(precise.InvalidRequest, "Control", "setMode", 0, "AUTOO").what.lower()
    assert call("Control", "arm", 0) is None
    assert call("Telemetry", "getNavigation", 0).isArmed is True
    no_landing = call.refused(precise.CommandRefused, "Control", "land", 0)
    assert (no_landing.command, no_landing.result) == ("DO_LAND_START", "FAILED")
    assert call("Control", "disarm", 0) is None
    call.refused(precise.InvalidRequest, "Control", "land", 0)
    assert call("Control", "goTo", 0, LAT + 0.001, LON, 60.0, True) is None
    assert call("Telemetry", "getNavigation", 0).mode == "GUIDED"
    assert call("Control", "flyCourse", 0, 90.0, 5.0) is None
    assert call("Control", "climbTo", 0, ALT + 80.0, 2.0) is None
    assert call("Control", "setAirspeed", 0, 18.0) is None
    assert call("Control", "setAltitude", 0, 70.0) is None
    call.refused(precise.InvalidRequest, "Control", "setVelocity", 0, 1.0, 0.0, 0.0, 0.0)
    assert call("Pose3D", "setPose3DData", jderobot.Pose3DData(x=LAT, y=LON, z=ALT + 60.0)) == 0, "in GUIDED it goes"
    for x, y, z in (
        (95.0, LON, ALT),
        (LAT, 181.0, ALT),
        (LAT, LON, 1e30),
        (math.inf, LON, ALT),
        (LON, LAT, ALT),
        (LAT, LON, 60.0),
    ):
        assert call("Pose3D", "setPose3DData", jderobot.Pose3DData(x=x, y=y, z=z)) == 1, (x, y, z)
    valley = jderobot.Pose3DData(x=LAT, y=LON, z=ALT - 60.0)
    assert call("Pose3D", "setPose3DData", valley, {"below_home": "true"}) == 0
    assert call("Pose3D", "setPose3DData", None) == 1
    assert call("CMDVel", "setCMDVelData", jderobot.CMDVelData(linearX=18.0)) == 0
    assert call("Control", "loiter", 0) is None
    assert call("Control", "returnToLaunch", 0) is None
    assert call("Control", "takeoff", 0, 60.0) is None
    assert call("Telemetry", "getNavigation", 0).mode == "TAKEOFF"
    call.refused(precise.VencejoException, "Control", "abortLanding", 0)
    assert call("Control", "command", 0, 410, []) == 0, "GET_HOME_POSITION"
    assert call.refused(precise.CommandRefused, "Control", "command", 0, 31_000, [1.0]).result == "UNSUPPORTED"
    call.refused(precise.InvalidRequest, "Control", "command", 0, 410, [0.0] * 8)
    assert call("Control", "setMode", 0, "MANUAL") is None
    assert call("Missions", "clear", 0, precise.PlanKind.MissionPlan, {"confirm": "clear-mission"}) is None

    assert {name.replace("Camera.", "Camera.") for name in call.called} == operations()


def test_every_operation_from_javascript(grounded: Served, client: Client, tmp_path: Path) -> None:
    """A Node.js client of npm's `ice`: it has its types from slice2js and the same Slice files, and nothing else of ours."""
    javascript(tmp_path)
    script = tmp_path / "operations.js"
    script.write_text(JSCLIENT.read_text(encoding="utf-8"), encoding="utf-8")
    proxies = [f"{name}={grounded.said['ice'][name]}" for name in INTERFACES]
    done = subprocess.run(
        ["node", str(script), *proxies], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr + done.stdout
    called = {line.removeprefix("called ") for line in done.stdout.splitlines() if line.startswith("called ")}
    assert called == operations()
    assert "pushed: moved happened" in done.stdout


def observer_of(client: Client, calls: queue.Queue[tuple[str, Any]]) -> Any:
    """An observer that puts what it is told into a queue."""

    def moved(_: Any, pose: Any, navigation: Any, current: Any = None) -> None:
        calls.put(("moved", (pose, navigation)))

    def happened(_: Any, event: Any, current: Any = None) -> None:
        calls.put(("happened", event))

    return type("Observer", (client.precise.Observer,), {"moved": moved, "happened": happened})()


@pytest.mark.parametrize("way", ["over its connection", "to its own endpoint"])
def test_telemetry_and_events_are_pushed(client: Client, way: str) -> None:
    calls: queue.Queue[tuple[str, Any]] = queue.Queue()
    identity = client.ice.stringToIdentity("watcher")
    telemetry = client.telemetry
    if way == "over its connection":
        adapter = client.communicator.createObjectAdapter("")
        adapter.add(observer_of(client, calls), identity)
        adapter.activate()
        telemetry.ice_getConnection().setAdapter(adapter)
        number = telemetry.subscribeHere(0, "watcher", 20.0)
    else:
        adapter = client.communicator.createObjectAdapterWithEndpoints("watcher", "tcp -h 127.0.0.1 -p 0")
        proxy = client.precise.ObserverPrx.uncheckedCast(adapter.add(observer_of(client, calls), identity))
        adapter.activate()
        number = telemetry.subscribe(0, proxy, 20.0)

    def next_of(kind: str, wanted: Callable[[Any], bool] = lambda _: True) -> Any:
        while True:
            found, value = calls.get(timeout=120)
            if found == kind and wanted(value):
                return value

    first, navigation = next_of("moved")
    assert first.systemId == navigation.systemId == 1
    second, _ = next_of("moved")
    assert second.at.utcS > first.at.utcS
    client.control.setMode(0, "STABILIZE")
    event = next_of("happened", lambda event: event.kind == "mode")
    assert json.loads(event.detail)["mode"] == "STABILIZE"
    telemetry.unsubscribe(number)
    client.control.setMode(0, "MANUAL")


def test_what_was_refused_is_said_in_the_station_too(grounded: Served, client: Client) -> None:
    browser = grounded.client(name="onlooker")
    browser.done("POST", "control/release")
    assert client.mission.setMissionData(client.mission_data((91.0, LON, 60.0))) == 1
    texts = browser.done("GET", "vehicles/1/texts")
    assert [text["severity"] for text in texts if "a mission was refused: pose 1 of 1" in text["text"]], texts


def test_control_is_one_for_the_page_and_for_ice(grounded: Served, client: Client) -> None:
    page = grounded.client(name="Ana")
    assert page.done("POST", "control/request")["has_control"] is True, "whoever held it over Ice gives way"
    with pytest.raises(client.precise.Busy, match="Ana holds control"):
        client.control.setMode(0, "STABILIZE")
    client.extra.takeoff()
    assert client.mission.setMissionData(client.mission_data((LAT, LON, 50.0), *PLACES)) == 5
    assert page.done("GET", "session")["requested_by"] == "JdeRobot"
    assert client.telemetry.getPose(0).systemId == 1, "to look needs no control"
    page.done("POST", "control/release")
    client.control.setMode(0, "STABILIZE")
    assert page.done("GET", "session")["holder"] == "JdeRobot"
    assert page.ask("POST", "vehicles/1/loiter").status == 423
    with pytest.raises(client.precise.InvalidRequest, match="confirm='clear-mission'"):
        client.missions.clear(0, client.precise.PlanKind.MissionPlan)
    client.missions.clear(0, client.precise.PlanKind.MissionPlan, {"confirm": "clear-mission"})
    client.control.setMode(0, "MANUAL")


@pytest.mark.parametrize("language", ["python", "javascript"])
def test_the_examples(client: Client, language: str, tmp_path: Path) -> None:
    """They show where the plane is. What --fly does is tried where nothing takes off (test_flights)."""
    done = example(language, client.proxies, tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("at 40.333"), done.stdout
    assert "battery" in done.stdout
    body = (NODE / ("client.py" if language == "python" else "client.js")).read_text(encoding="utf-8")
    assert len(body.splitlines()) <= 45, "thirty lines and what stands around them"


# Faults ------------------------------------------------------------------------------------------------------------


def hangs_up(connection: socket.socket) -> bool:
    """Whether the server ends the connection, with or without a message first."""
    with contextlib.suppress(ConnectionError):
        while connection.recv(4096):
            pass
    return True


@pytest.mark.fault(52, figure="bad magic and too large: that connection alone ends")
@pytest.mark.parametrize("bytes_", MALFORMED.values(), ids=MALFORMED)
def test_malformed_and_oversize_requests_end_their_connection_alone(client: Client, bytes_: bytes) -> None:
    pose = client.pose
    address = address_of(client.proxies["Pose3D"])
    with raw(address) as connection:
        with contextlib.suppress(OSError):  # it may have hung up before all was said
            connection.sendall(bytes_)
            connection.shutdown(socket.SHUT_WR)
        assert hangs_up(connection)
    assert pose.getPose3DData().x != 0, "others are served as before"


def test_objects_that_cannot_be_read_are_refused(client: Client) -> None:
    """A parameter of garbage, an unknown object, an unknown operation: each an answer, no end."""
    mission = client.mission
    with pytest.raises(client.ice.UnknownLocalException):
        mission.ice_invoke("setMissionData", client.ice.OperationMode.Normal, b"\x06\x00\x00\x00\x01\x01"[:6] + b"")
    stranger = client.communicator.stringToProxy(client.proxies["Mission"].replace("ardrone_mission", "nobody"))
    with pytest.raises(client.ice.ObjectNotExistException):
        stranger.ice_ping()
    with pytest.raises(client.ice.OperationNotExistException):
        mission.ice_invoke("fly", client.ice.OperationMode.Normal, EMPTY)
    assert mission.getMissionData() is not None


@pytest.mark.fault(52, figure="1,000 connections: others and newcomers are served")
def test_a_thousand_idle_connections_leave_it_serving(client: Client) -> None:
    addresses = [address_of(client.proxies[name]) for name in ("Pose3D", "Navdata", "Mission", "Precise")]
    with many_files(2048), contextlib.ExitStack() as idle:
        for number in range(1000):
            idle.enter_context(raw(addresses[number % len(addresses)]))
        for _ in range(20):
            assert client.pose.getPose3DData().x != 0
            assert client.telemetry.getNavigation(0).mode
        with client_of(client.proxies) as another:
            assert another.navdata.getNavdata().vehicle == 1, "and lets newcomers in"


def test_connections_beyond_the_limit_are_closed_and_the_others_served(tmp_path: Path) -> None:
    with (
        driver("udpin:127.0.0.1:0", "--ice-set", "MaxConnections=20", data=tmp_path) as served,
        client_of(served.said["ice"]) as client,
        contextlib.ExitStack() as idle,
    ):
        pose = client.pose
        address = address_of(client.proxies["Pose3D"])
        connections = [idle.enter_context(raw(address)) for _ in range(40)]
        for connection in connections[19:]:
            assert hangs_up(connection), "the newest are closed"
        for connection in connections[:19]:
            connection.settimeout(0.01)
            with pytest.raises(TimeoutError):
                connection.recv(1)
        assert pose.getPose3DData().x == 0.0, "nothing was heard, and this interface has no word for that"
        with pytest.raises(client.precise.NoVehicle):
            client.telemetry.getPose(0)


# How it is started -------------------------------------------------------------------------------------------------


def test_others_need_a_token_where_they_are_let_in(tmp_path: Path) -> None:
    """The interfaces listen beyond loopback, on this machine's port 0: the token in the context, or a network."""
    ports = {f"{name}.Endpoints": "tcp -h 0.0.0.0 -p 0" for name in INTERFACES}
    with driver("udpin:127.0.0.1:0", data=tmp_path, ports=ports) as served:
        local = {name: proxy.replace("-h 0.0.0.0", "-h 127.0.0.1") for name, proxy in served.said["ice"].items()}
        local = {
            name: proxy.partition(":tcp")[0] + f":tcp -h 127.0.0.1 -p {address_of(proxy)[1]}"
            for name, proxy in local.items()
        }
        with client_of(local) as client:
            text = client.communicator.stringToProxy(local["Mission"])
            with pytest.raises(client.ice.UnknownException) as refused:
                text.ice_ping()
            assert "demands a token" in refused.value.unknown
            viewer, operator = ({"token": served.token(role)} for role in ("viewer", "operator"))
            mission = client.jderobot.MissionPrx.uncheckedCast(text)
            assert mission.getMissionData(viewer).mission == []
            with pytest.raises(client.ice.UnknownException) as refused:
                mission.setMissionData(client.mission_data(), viewer)
            assert "operator's token" in refused.value.unknown
            assert mission.setMissionData(client.mission_data(), operator) == 1, "let in, and an empty mission is none"
            new = {"token": renew_tokens(tmp_path / "server-tokens.json").operator}

            def is_refused(token: dict[str, str]) -> bool:
                with contextlib.suppress(client.ice.UnknownException):
                    mission.ice_ping(token)
                    return False
                return True

            wait_for(lambda: is_refused(operator), "the replaced token is refused")
            assert not is_refused(new)


def test_settings_come_from_the_command_line_a_cfg_file_and_the_configuration(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = tmp_path / "config.toml"
    config.write_text(
        '[ice.Pose3D]\nName = "from_config"\n[ice.Navdata]\nName = "from_config"\n[ice.Extra]\nName = "e"\n'
    )
    cfg = tmp_path / "vencejo.cfg"
    cfg.write_text("Vencejo.Navdata.Name=from_cfg\nVencejo.Extra.Name=from_cfg\nIce.Warn.Connections=1\n")
    monkeypatch.setenv("VENCEJO_CONFIG", str(config))
    with driver(
        "udpin:127.0.0.1:0", "--ice-config", str(cfg), "--ice-set", "Extra.Name=from_line", data=tmp_path
    ) as served:
        names = {name: proxy.partition(":")[0].partition(" ")[0] for name, proxy in served.said["ice"].items()}
    assert (names["Pose3D"], names["Navdata"], names["Extra"]) == ("from_config", "from_cfg", "from_line")
    assert names["Mission"] == "ardrone_mission"


def run_serve(*options: str, code: str = "") -> subprocess.CompletedProcess[str]:
    command = [
        sys.executable,
        "-c",
        f"{code}\nfrom vencejo.cli import main; main()",
        "serve",
        "--port",
        "0",
        "--no-record",
    ]
    return subprocess.run(
        [*command, "--link", "udpin:127.0.0.1:0", *options], capture_output=True, text=True, timeout=60, check=False
    )


def test_without_ice_it_says_how_to_install_it() -> None:
    done = run_serve("--ice", code="import sys; sys.modules['Ice'] = None")
    assert done.returncode == 1
    assert "pip install 'vencejo[ice]'" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--ice-missions", "upload"], "need --ice"),
        (["--ice", "--ice-set", "Pose3D.Endpoints"], "write NAME=VALUE"),
        (["--ice", "--ice-set", "Nothing=1"], "'Nothing' is not a setting"),
        (["--ice", "--ice-set", "Pose3D.Endpoints=carrier -p pigeon"], "Pose3D.Endpoints is"),
        (["--ice", "--ice-host", "203.0.113.77"], "cannot listen"),
    ],
)
def test_mistakes_on_the_command_line_are_named(options: list[str], says: str) -> None:
    done = run_serve(*options)
    assert done.returncode in (1, 2)
    assert says in done.stderr
    assert "Traceback" not in done.stderr


def test_the_other_dialect_of_missions(tmp_path: Path) -> None:
    """A client of mission_sequence.ice, in a process of its own: both files give the same names to different types."""
    with (
        simulated_plane() as link,
        driver(link, "--ice-missions", "upload", data=tmp_path) as served,
    ):
        done = subprocess.run(
            [
                sys.executable,
                str(Path(__file__).with_name("sequence_client.py")),
                str(SLICE),
                served.said["ice"]["Mission"].replace(":", " -f sequence:", 1),
            ],
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
    assert done.stdout.split() == ["[]", "1", "0", "[60.0,", "70.0]"], done.stderr
