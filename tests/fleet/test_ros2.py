"""A plane in ROS 2: types against rosbags, and a real router with a reader of Zenoh's own at it, in a process of its own."""

from __future__ import annotations

import dataclasses
import json
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from rosbags.typesys import Stores
from typer.testing import CliRunner
from vencejo import Plan, Station, Vehicle, _native
from vencejo.cli.commands import app
from vencejo.cli.common import Exit
from vencejo.errors import InvalidRequest, LinkError
from vencejo.fleet import has_fleet
from vencejo.ros2 import Gateway, Router, examine

from tests.fleet.programs import command
from tests.fleet.ros2_at_router import Witness, a_witness
from tests.fleet.ros2_lines import asked
from tests.fleet.ros2_offered import HEARD, MAVROS, NEWS, SERVICES, TOPICS, key, tokens, whole
from tests.fleet.ros2_types import Types, plain
from tests.plane import Plane, Truth, offset
from tests.support import HOME, reserved_ports, wait_for

pytestmark = pytest.mark.skipif(not has_fleet(), reason="this build has no fleets")

READS = "--ros2-role operator"
LOG = "rcl_interfaces/msg/Log"
LIST = "mavros_msgs/msg/WaypointList"
NOTHING: dict[str, Any] = {"structure_needs_at_least_one_member": 0}


def hashes() -> dict[str, str]:
    return dict(_native.ros2_types())


@pytest.mark.parametrize("store", [Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY, Stores.ROS2_KILTED])
def test_the_hash_of_each_type_is_that_of_its_definition(store: Stores) -> None:
    types = Types(store)
    assert len(hashes()) == 42
    assert {name: types.hash(name) for name in hashes()} == hashes()
    # As `std_srvs` 5.3.6 (Jazzy) and 5.5.1 (Kilted) have them in SetBool.json and Trigger.json.
    assert hashes()["std_srvs/srv/SetBool"].startswith("RIHS01_abe9e4bb6b41b40e")
    assert hashes()["std_srvs/srv/Trigger"].startswith("RIHS01_eeff2cd6fa5ad9d2")
    # As the design document of `rmw_zenoh_cpp` has them.
    assert hashes()["rcl_interfaces/srv/GetParameters"].startswith("RIHS01_bf9803d5c74cf989")
    assert hashes()["rcl_interfaces/srv/DescribeParameters"].startswith("RIHS01_845b484d71eb0673")


def test_what_cannot_be_is_refused_in_words() -> None:
    with Station(record=False, signing=False) as station:
        for bad, says in [
            ({"router": "tls/127.0.0.1:7447"}, "--ros2-ca"),
            ({"router": "tcp/0.0.0.0:7447"}, "host name"),
            ({"router": "tcp/192.0.2.1:7447"}, "--ros2-plain"),
            ({"domain": 233}, "232"),
            ({"names": "px4"}, "mavros or ap"),
            ({"namespace": "a b"}, "namespace"),
            ({"router": Router("tcp/192.0.2.1:7447", plain=True), "role": "operator"}, "could command the plane"),
        ]:
            with pytest.raises(InvalidRequest, match=says):
                Gateway(station, **bad)  # type: ignore[arg-type]
        onboard = ["onboard", "--link", "udpin:127.0.0.1:0", "--fleet", "acme", "--name", "plane7"]
        for options, code, says in [
            (["--ros2-ca", "ca.crt"], Exit.USAGE, "are for --ros2-router"),
            (["--ros2-router", "tls/robot.local:1", "--ros2-ca", "no.crt"], Exit.FAILED, "no.crt: it cannot be read"),
            (["--ros2-router", "tcp/192.0.2.1:7447"], Exit.USAGE, "--ros2-plain"),
        ]:
            for program in (["serve"], onboard):
                told = CliRunner().invoke(app, [*program, *options])
                assert (told.exit_code, says in told.stderr) == (code, True), told.stderr
        with reserved_ports() as [port], Gateway(station, router=f"tcp/127.0.0.1:{port}") as gateway:
            wait_for(lambda: gateway.status.problem is not None, "it to say that no router is there")
            assert "rmw_zenohd" in str(gateway.status.problem)
            with pytest.raises(LinkError, match="nobody listens there"):
                examine(f"tcp/127.0.0.1:{port}")
            told = CliRunner().invoke(app, ["ros", "doctor", "--ros2-router", f"tcp/127.0.0.1:{port}", "--json"])
            assert (told.exit_code, json.loads(told.stdout)["findings"][0]["code"]) == (1, "no-router")


@pytest.mark.e2e
def test_a_plane_is_seen_by_a_reader_of_ros_and_acts_for_an_operator_alone(tmp_path: Path) -> None:
    with (
        a_witness() as witness,
        Plane() as plane,
        command(
            tmp_path, "serve", "--port", "0", "--link", plane.link, "--ros2-router", witness.tls, "--ros2-ca", str(witness.ca),
        ) as serve,
    ):  # fmt: skip
        serve.line()
        plane.hold(30.0, 10.0, 90.0)
        at = "/vencejo_1/mavros"
        # Each key, hash and token is the one that it has to be, and there is no other.
        assert_tokens(witness, 0, MAVROS, at, "/vencejo_1/mavros")

        # Where it is, and when: by this machine's clock.
        (fix, first, _), (_, second, sent_ns) = witness.hear(
            f"{at}/global_position/global", "sensor_msgs/msg/NavSatFix", count=2
        )
        assert second == first + 1
        assert abs(sent_ns - time.time_ns()) < 60e9
        assert abs(fix.header.stamp.sec - time.time()) < 60
        assert fix.header.frame_id == "vencejo_1/base_link"
        assert fix.latitude == pytest.approx(HOME[0], abs=0.01)
        assert fix.longitude == pytest.approx(HOME[1], abs=0.01)
        # Above the ellipsoid, 51 m below the sea's level there.
        assert fix.altitude == pytest.approx(plane.truth().alt_rel_home_m + HOME[2] + 51.0, abs=20.0)
        assert fix.position_covariance_type == 1

        # A right bank of 30 degrees, nose 10 up, to the east: x forward, y left, z up; east, north, up.
        [(imu, _, _)] = witness.hear(f"{at}/imu/data", "sensor_msgs/msg/Imu")
        q = imu.orientation
        roll = math.degrees(math.atan2(2 * (q.w * q.x + q.y * q.z), 1 - 2 * (q.x**2 + q.y**2)))
        pitch = math.degrees(math.asin(2 * (q.w * q.y - q.z * q.x)))
        yaw = math.degrees(math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y**2 + q.z**2)))
        assert (roll, pitch, yaw) == pytest.approx((30.0, -10.0, 0.0), abs=2.5)
        force = imu.linear_acceleration
        assert force.z == pytest.approx(9.8 * math.cos(math.radians(30)) * math.cos(math.radians(10)), abs=0.5)
        assert force.y == pytest.approx(9.8 * math.sin(math.radians(30)) * math.cos(math.radians(10)), abs=0.5), (
            "the left wing is up"
        )
        [(battery, _, _)] = witness.hear(f"{at}/battery", "sensor_msgs/msg/BatteryState")
        assert battery.voltage > 5.0
        assert 0.0 <= battery.percentage <= 1.0
        [(odometry, _, _)] = witness.hear(f"{at}/local_position/odom", "nav_msgs/msg/Odometry")
        assert (odometry.header.frame_id, odometry.child_frame_id) == ("vencejo_1/map", "vencejo_1/base_link")
        assert abs(odometry.pose.pose.position.x) < 50
        [(tf, _, _)] = witness.hear("/tf", "tf2_msgs/msg/TFMessage")
        assert tf.transforms[0].child_frame_id == "vencejo_1/base_link"
        [(state, _, _)] = witness.hear(f"{at}/state", "mavros_msgs/msg/State")
        assert (state.connected, state.armed) == (True, False)
        [(health, _, _)] = witness.hear("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
        assert "vencejo_1: GPS" in {status.name for status in health.status}
        plane.release()

        # One that only reads refuses, in words where the answer has any.
        armed = witness.call(f"{at}/cmd/arming", "mavros_msgs/srv/CommandBool", value=True)
        assert armed.success is False
        told = witness.call(f"{at}/vencejo/arm", "std_srvs/srv/SetBool", data=True)
        assert told.success is False
        assert READS in told.message

        # The doctor says why others see nothing.
        assert examine(witness.router).findings == []
        assert examine(Router(witness.tls, ca=witness.ca)) == examine(witness.router)
        told = CliRunner().invoke(app, ["ros", "doctor", "--ros2-router", witness.tls.replace("tls", "tcp"), "--json"])
        assert (told.exit_code, json.loads(told.stdout)["findings"][0]["code"]) == (1, "tls-spoken")
        ours = "@ros2_lv/0/feed/0"
        imu_type, imu_hash = "sensor_msgs::msg::dds_::Imu_", hashes()["sensor_msgs/msg/Imu"]
        for number, (name, of_hash) in enumerate([("imu%data", "TypeHashNotSupported"), ("imu%dta", imu_hash)]):
            token = f"{ours}/{number}/MS/%/%/rviz/%vencejo_1%mavros%{name}/{imu_type}/{of_hash}/::,10:,:,:,,"
            witness.ask("declare", token=token)
        witness.ask("declare", token="@ros2_lv/5/feed/1/1/NN/%/%/far")
        told = CliRunner().invoke(app, ["ros", "doctor", "--ros2-router", witness.router, "--json"])
        assert told.exit_code == 1
        found = {finding["code"]: finding["text"] for finding in json.loads(told.stdout)["findings"]}
        assert found.keys() == {"humble", "near-name", "other-domain"}
        assert "/far is in domain 5, not in 0, and sees nothing of it: " in found["other-domain"]

        # An operator's gateway acts, by the station's lease.
        quiet: dict[str, Any] = {"record": False, "signing": False}
        with (
            Station(plane.link, operator="Ana", **quiet) as station,
            Gateway(station, router=witness.router, domain=7, namespace="/uas{system}", role="operator") as gateway,
        ):
            vehicle = station.wait_vehicle()
            wait_for(lambda: gateway.status.planes == {1: "/uas1/mavros"}, "the plane")
            there: dict[str, Any] = {"domain": 7}
            mode = witness.call(
                "/uas1/mavros/set_mode", "mavros_msgs/srv/SetMode", **there, base_mode=0, custom_mode="FBWA"
            )
            assert mode.mode_sent
            wait_for(lambda: vehicle.telemetry.mode == "FBWA", "the mode")
            armed = witness.call("/uas1/mavros/cmd/arming", "mavros_msgs/srv/CommandBool", **there, value=True)
            assert (armed.success, armed.result) == (True, 0)
            assert vehicle.telemetry.is_armed
            wrong = witness.call(
                "/uas1/mavros/set_mode", "mavros_msgs/srv/SetMode", **there, base_mode=0, custom_mode="NONSENSE"
            )
            assert not wrong.mode_sent
            missions(witness, vehicle)
            parameters(witness, vehicle)
            everything(witness, vehicle, gateway, plane)
            another(witness, vehicle, plane, tmp_path / "definitions")
            assert station.operator.request(), "it gives control to whoever asks"
            held = witness.call("/uas1/mavros/vencejo/arm", "std_srvs/srv/SetBool", **there, data=False)
            assert (held.success, "Ana holds control" in held.message) == (False, True), held.message
            assert vehicle.telemetry.is_armed


def waypoint(witness: Witness, frame: int, command: int, north_m: float, alt_m: float, **other: float) -> Any:
    """A waypoint as MAVROS has it."""
    lat, lon = offset(north_m, 0.0)
    fields = {"param1": 0.0, "param2": 0.0, "param3": 0.0, "param4": math.nan, "x_lat": lat, "y_long": lon} | other
    of = witness.types.kind("mavros_msgs/msg/Waypoint")
    return of(frame=frame, command=command, is_current=False, autocontinue=True, z_alt=alt_m, **fields)


def wait_for_line(witness: Witness, says: str) -> None:
    """Until the log says so."""
    wait_for(lambda: any(says in line.msg for line in witness.heard("/rosout", LOG, 7)), says)


def assert_tokens(witness: Witness, domain: int, names: str, at: str, node: str) -> None:
    """A domain has the tokens that it is to have, once as many are there, and no other."""
    wanted = tokens(witness.types, domain, names, at, node)
    wait_for(lambda: len(witness.offered(domain)) >= len(wanted), f"the tokens of domain {domain}")
    assert witness.offered(domain) == wanted


def missions(witness: Witness, vehicle: Vehicle) -> None:
    """Missions are pushed, checked, read back, pulled and removed, as with MAVROS: home is waypoint 0."""
    there: dict[str, Any] = {"domain": 7}
    at = "/uas1/mavros"

    def push(start_index: int, waypoints: list[Any]) -> tuple[bool, int]:
        of: dict[str, Any] = {"start_index": start_index, "waypoints": waypoints}
        pushed = witness.call(f"{at}/mission/push", "mavros_msgs/srv/WaypointPush", **there, **of)
        return pushed.success, pushed.wp_transfered

    def heights() -> list[float]:
        [(told, _, _)] = witness.hear(f"{at}/mission/waypoints", "mavros_msgs/msg/WaypointList", **there)
        return [waypoint.z_alt for waypoint in told.waypoints]

    def on_board() -> Plan:
        plan = vehicle.plan_on_board()
        assert plan is not None
        return plan

    witness.ask("listen", key="7/rosout/**")
    home = waypoint(witness, 0, 16, 0.0, HOME[2])
    plan = [
        home,
        waypoint(witness, 3, 22, 200.0, 60.0, param1=12.0),
        waypoint(witness, 3, 16, 500.0, 80.0),
        waypoint(witness, 3, 17, 800.0, 90.0),
    ]
    assert push(0, plan) == (True, 4)
    assert [item.alt_m for item in on_board().items] == [60.0, 80.0, 90.0]
    assert heights() == [pytest.approx(HOME[2], abs=50.0), 60.0, 80.0, 90.0]
    assert push(2, [waypoint(witness, 3, 16, 500.0, 100.0)]) == (True, 1)
    assert heights()[1:] == [60.0, 100.0, 90.0]
    before = on_board()
    for start, wrong, says in [
        (0, [*plan, waypoint(witness, 3, 177, 0.0, 0.0, param1=99.0)], "mission/push: the mission has 1 error"),
        (0, [home, waypoint(witness, 3, 16, 500.0, math.nan)], "z is NaN"),
        (0, plan[1:], "waypoint 0 is home on ArduPilot"),
        (4, plan[:1], "waypoints 4 to 4 are not all on board"),
        (0, [], "mission/clear removes the mission"),
    ]:
        assert push(start, wrong) == (False, 0)
        wait_for_line(witness, says)
    assert on_board() == before
    pulled = witness.call(f"{at}/mission/pull", "mavros_msgs/srv/WaypointPull", **there, **NOTHING)
    assert (pulled.success, pulled.wp_received) == (True, 4)


def parameters(witness: Witness, vehicle: Vehicle) -> None:
    """Parameters are those of a node, of the autopilot's own types."""
    at, there = "/uas1/mavros/param", {"domain": 7}

    def call(name: str, **request: Any) -> Any:
        return witness.call(f"{at}/{name}", SERVICES[MAVROS][f"param/{name}"], **there, **request)

    name, missing = "AIRSPEED_CRUISE", "NO_SUCH_PARAM"
    names = call("list_parameters", prefixes=[], depth=0).result.names
    assert name in names
    pulled = call("pull", force_pull=True)
    assert (pulled.success, pulled.param_received) == (True, len(names))
    value, unknown = call("get_parameters", names=[name, missing]).values
    assert (value.type, value.double_value, unknown.type) == (3, vehicle.params[name], 0)
    assert list(call("get_parameter_types", names=[name, "FENCE_ENABLE", missing]).types) == [3, 2, 0]
    assert [one.name for one in call("describe_parameters", names=[name, missing]).descriptors] == [name, missing]
    faster = dataclasses.replace(value, double_value=value.double_value + 1.0)
    written = call("set", force_set=False, param_id=name, value=faster)
    assert (written.success, written.value.double_value) == (True, faster.double_value)
    assert vehicle.params[name] == faster.double_value
    parameter = witness.types.kind("rcl_interfaces/msg/Parameter")
    off = dataclasses.replace(value, type=2, integer_value=0)
    text = dataclasses.replace(value, type=4, string_value="fast")
    many = [
        parameter(name=name, value=value),
        parameter(name=name, value=text),
        parameter(name="FENCE_ENABLE", value=off),
    ]
    results = call("set_parameters", parameters=many).results
    assert [one.successful for one in results] == [True, False, False]
    assert [one.reason.partition(":")[0] for one in results[1:]] == [
        "a parameter is a number",
        "it switches the fence off, which needs a confirmation, and ROS 2 has none",
    ]
    assert vehicle.params[name] == value.double_value
    assert call("set_parameters_atomically", parameters=many[:1]).result.successful
    assert not call("set_parameters_atomically", parameters=many).result.successful


def everything(witness: Witness, vehicle: Vehicle, gateway: Gateway, plane: Plane) -> None:
    """All topics by both families of names come under the keys of their definitions, and nothing else does; with values that are the plane's."""
    types = witness.types
    with Gateway(vehicle.station, router=witness.router, domain=8, names="ap") as other:
        wait_for(lambda: other.status.planes == {1: "/ap/v1"}, "the plane by ArduPilot's names")
        sets = [(7, MAVROS, "/uas1/mavros", "/uas1/mavros"), (8, "ap", "/ap/v1", "/ap/v1")]
        for domain, names, at, node in sets:
            assert_tokens(witness, domain, names, at, node)
            witness.ask("listen", key=f"{domain}/**")
        ready = witness.call("/ap/v1/prearm_check", "std_srvs/srv/Trigger", 8, **NOTHING)
        assert ready.success, ready.message
        said: dict[tuple[int, str], Any] = {}
        expected = set()
        for domain, names, at, _ in sets:
            for name, kind in TOPICS[names].items():
                expected.add(key(types, domain, whole(at, name), kind))
                if name not in NEWS:
                    [*_, said[domain, name]] = witness.heard(whole(at, name), kind, domain)
        news = {key(types, 7, whole("/uas1/mavros", name), TOPICS[MAVROS][name]) for name in NEWS}
        assert set(witness.ask("keys")) - news == expected - news
    truth = plane.truth()
    place = pytest.approx((truth.lat_deg, truth.lon_deg), abs=0.001)
    q = said[7, "imu/data"].orientation
    east = math.degrees(math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y**2 + q.z**2)))
    assert (90.0 - east) % 360.0 == pytest.approx(truth.heading_deg % 360.0, abs=5.0)
    for domain, name in [(7, "global_position/global"), (7, "global_position/raw/fix"), (8, "navsat")]:
        fix = said[domain, name]
        assert (fix.latitude, fix.longitude) == place
        assert fix.altitude == pytest.approx(HOME[2] + 51.0, abs=20.0)
        assert fix.status.status >= 0
    geopose = said[8, "geopose/filtered"].pose
    assert (geopose.position.latitude, geopose.position.longitude) == place
    assert geopose.position.altitude == pytest.approx(HOME[2] + 51.0, abs=20.0)
    for turned in (
        q,
        said[7, "local_position/pose"].pose.orientation,
        said[7, "local_position/odom"].pose.pose.orientation,
        said[7, "/tf"].transforms[0].transform.rotation,
        said[8, "imu/experimental/data"].orientation,
        said[8, "pose/filtered"].pose.orientation,
        geopose.orientation,
    ):
        assert abs(turned.w) == pytest.approx(abs(q.w), abs=0.01)
        assert turned.x**2 + turned.y**2 + turned.z**2 + turned.w**2 == pytest.approx(1.0)
    for position in (
        said[7, "local_position/pose"].pose.position,
        said[7, "local_position/odom"].pose.pose.position,
        said[7, "/tf"].transforms[0].transform.translation,
        said[8, "pose/filtered"].pose.position,
    ):
        assert math.hypot(position.x, position.y) < 50.0
        assert abs(position.z) < 10.0
    for speed in (
        said[7, "local_position/odom"].twist.twist.linear,
        said[7, "local_position/velocity_local"].twist.linear,
        said[8, "twist/filtered"].twist.linear,
    ):
        assert math.hypot(speed.x, speed.y, speed.z) < 3.0, "it stands"
    assert said[7, "global_position/compass_hdg"].data == pytest.approx(truth.heading_deg % 360.0, abs=5.0)
    assert abs(said[7, "global_position/rel_alt"].data) < 10.0
    for battery in (said[7, "battery"], said[8, "battery"]):
        assert battery.voltage > 5.0
        assert battery.present
    state = said[7, "state"]
    assert (state.connected, state.mode, state.header.frame_id) == (True, "FBWA", "uas1/base_link")
    home = said[7, "home_position/home"]
    assert (home.geo.latitude, home.geo.longitude) == pytest.approx(HOME[:2], abs=0.001)
    assert home.geo.altitude == pytest.approx(HOME[2] + 51.0, abs=20.0)
    assert home.header.frame_id == "uas1/map"
    assert (said[7, "extended_state"].landed_state, said[7, "extended_state"].vtol_state) == (1, 0)
    assert 900 <= min(said[7, "rc/in"].channels) <= max(said[7, "rc/in"].channels) <= 2100
    hud = said[7, "vfr_hud"]
    assert hud.groundspeed < 3.0
    assert 0.0 <= hud.throttle <= 1.0
    assert said[7, "wind_estimation"].header.frame_id == "uas1/map"
    for clock in (said[7, "time_reference"].time_ref, said[8, "time"]):
        assert clock.sec > 1_500_000_000
    assert [len(said[7, "mission/path"].poses), len(said[7, "mission/waypoints"].waypoints)] == [3, 4]
    assert [pose.pose.position.z for pose in said[7, "mission/path"].poses] == [60.0, 100.0, 90.0]
    for domain in (7, 8):
        assert {status.hardware_id for status in said[domain, "/diagnostics"].status}
    assert said[8, "/rosout"].name == "ap.v1"


def another(witness: Witness, vehicle: Vehicle, plane: Plane, definitions: Path) -> None:
    """A client of others, by keys, hashes and tokens of its own, lists the same, hears the same, and flies the plane."""
    at = "/uas1/mavros"
    topics = {whole(at, name): kind for name, kind in TOPICS[MAVROS].items()}
    wanted = {whole(at, name): kind for name, kind in HEARD[MAVROS].items()}
    services = {f"{at}/{name}": kind for name, kind in SERVICES[MAVROS].items()}
    kinds = {*topics.values(), *wanted.values(), *services.values(), "service_msgs/msg/ServiceEventInfo"}
    witness.types.files(definitions, *sorted(kinds))
    with asked("tests.fleet.ros2_sdk", witness.port, definitions) as peer:
        listed = [{name: [kind] for name, kind in offered.items()} for offered in (topics | wanted, services)]
        assert peer.ask("listed", domain=7) == listed
        peer.ask("listen", domain=7, topics=list(topics.items()))

        def call(name: str, **request: object) -> Any:
            return peer.ask("call", domain=7, name=f"{at}/{name}", kind=SERVICES[MAVROS][name], request=request)

        assert call("set_mode", base_mode=0, custom_mode="FBWB") == {"mode_sent": True}
        wait_for(lambda: vehicle.telemetry.mode == "FBWB", "the mode")
        for value in (False, True):
            assert call("cmd/arming", value=value) == {"success": True, "result": 0}
            assert vehicle.telemetry.is_armed is value
        [*_, told] = witness.heard(f"{at}/mission/waypoints", LIST, 7)
        assert call("mission/clear", **NOTHING) == {"success": False}, "it is armed"
        wait_for_line(witness, "mission/clear: the mission of a vehicle that is armed is not cleared from ROS 2")
        assert call("cmd/arming", value=False) == {"success": True, "result": 0}
        # What it pushes, to the last letter, is what is on board and is told.
        assert call("mission/clear", **NOTHING) == {"success": True}
        wait_for(lambda: not witness.heard(f"{at}/mission/waypoints", LIST, 7)[-1].waypoints, "the empty list")
        pushed = plain(told)["waypoints"]
        pushed[1]["z_alt"] = 70.0
        assert call("mission/push", start_index=0, waypoints=pushed) == {"success": True, "wp_transfered": 4}
        assert call("mission/pull", **NOTHING) == {"success": True, "wp_received": 4}
        wait_for(lambda: len(witness.heard(f"{at}/mission/waypoints", LIST, 7)[-1].waypoints) == 4, "the list")
        [*_, told] = witness.heard(f"{at}/mission/waypoints", LIST, 7)
        assert [(one["command"], one["z_alt"]) for one in plain(told)["waypoints"][1:]] == [
            (one["command"], one["z_alt"]) for one in pushed[1:]
        ]

        def fly_to(north_m: float, east_m: float, alt_amsl_m: float) -> None:
            lat, lon = offset(north_m, east_m)
            [(name, kind)] = wanted.items()
            position = {"latitude": lat, "longitude": lon, "altitude": alt_amsl_m}
            peer.ask("fly_to", domain=7, name=name, kind=kind, position=position)

        flight(witness, vehicle, plane, call, fly_to)
        # What it heard is what was said, each as the others read it.
        for name, message in peer.ask("heard", domain=7, names=list(topics)).items():
            text = json.dumps(message)
            wait_for(lambda: text in map(json.dumps, map(plain, witness.heard(name, topics[name], 7))), name)  # noqa: B023


def flight(
    witness: Witness,
    vehicle: Vehicle,
    plane: Plane,
    call: Callable[..., Any],
    fly_to: Callable[[float, float, float], None],
) -> None:
    """It takes off, flies to a position and in its mission, and says so."""
    at, done = "/uas1/mavros", {"success": True, "result": 0}
    nowhere = {"min_pitch": 0.0, "yaw": 0.0, "latitude": 0.0, "longitude": 0.0}
    assert call("cmd/takeoff", **nowhere, altitude=60.0) == done
    assert call("cmd/arming", value=True) == done
    plane.skip_to(lambda truth: truth.alt_rel_home_m > 50.0)
    # In another mode it flies to no position, and says which it is.
    fly_to(600.0, 600.0, HOME[2] + 80.0)
    wait_for_line(witness, "setpoint_position/global: it is in TAKEOFF, and flies to positions in GUIDED")
    assert call("set_mode", base_mode=0, custom_mode="GUIDED") == {"mode_sent": True}
    fly_to(600.0, 600.0, HOME[2] + 80.0)
    wait_for_line(witness, "setpoint_position/global: it flies to the position")

    def is_near(truth: Truth, north_m: float, east_m: float, alt_rel_home_m: float) -> bool:
        lat, lon = offset(north_m, east_m)
        off = math.hypot((truth.lat_deg - lat) * 111_050.0, (truth.lon_deg - lon) * 84_980.0)
        return off < 150.0 and abs(truth.alt_rel_home_m - alt_rel_home_m) < 5.0

    plane.skip_to(lambda truth: is_near(truth, 600.0, 600.0, 80.0))
    # A height above home given as one above the sea would be under the ground.
    fly_to(600.0, 600.0, 80.0)
    wait_for_line(witness, "at most 20 m below it")

    assert call("mission/set_current", wp_seq=0) == {"success": False}
    assert call("mission/set_current", wp_seq=2) == {"success": True}
    assert call("set_mode", base_mode=0, custom_mode="AUTO") == {"mode_sent": True}
    reached = "mavros_msgs/msg/WaypointReached"
    plane.skip_to(lambda truth: is_near(truth, 800.0, 0.0, 90.0))
    wait_for(
        lambda: 2 in [one.wp_seq for one in witness.heard(f"{at}/mission/reached", reached, 7)], "the waypoint reached"
    )
    texts = witness.heard(f"{at}/statustext/recv", "mavros_msgs/msg/StatusText", 7)
    assert {one.text for one in texts} <= {one.text for one in vehicle.texts}
    # Any command, but none that is dangerous.
    parameters = {f"param{number}": 0.0 for number in range(1, 8)}
    long: dict[str, Any] = {"broadcast": False, "confirmation": 0, **parameters}
    assert call("cmd/command", command=178, **{**long, "param2": 24.0, "param3": -1.0}) == done
    assert call("cmd/command", command=185, **{**long, "param1": 1.0}) == {"success": False, "result": 4}
    wait_for_line(witness, "needs a confirmation, and ROS 2 has none: use the web app, or Python")
