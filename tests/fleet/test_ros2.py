"""A plane in ROS 2: types against rosbags, and a real router with a reader of Zenoh's own at it, in a process of its own."""

from __future__ import annotations

import contextlib
import itertools
import json
import math
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from rosbags.typesys import Stores
from typer.testing import CliRunner
from vencejo import Station, _native
from vencejo.cli import app
from vencejo.errors import InvalidRequest, LinkError
from vencejo.fleet import has_fleet
from vencejo.ros2 import Gateway, examine

from tests.fleet.programs import command
from tests.fleet.ros2_types import Types
from tests.plane import Plane
from tests.support import HOME, reserved_ports, wait_for

pytestmark = pytest.mark.skipif(not has_fleet(), reason="this build has no fleets")

READS = "--ros2-role operator"


def hashes() -> dict[str, str]:
    return dict(_native.ros2_types())


@pytest.mark.parametrize("store", [Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY, Stores.ROS2_KILTED])
def test_the_hash_of_each_type_is_that_of_its_definition(store: Stores) -> None:
    types = Types(store)
    assert len(hashes()) == 23
    assert {name: types.hash(name) for name in hashes()} == hashes()
    # As `std_srvs` 5.3.6 (Jazzy) and 5.5.1 (Kilted) have them in SetBool.json and Trigger.json.
    assert hashes()["std_srvs/srv/SetBool"].startswith("RIHS01_abe9e4bb6b41b40e")
    assert hashes()["std_srvs/srv/Trigger"].startswith("RIHS01_eeff2cd6fa5ad9d2")


def test_what_cannot_be_is_refused_in_words() -> None:
    with Station(record=False, signing=False) as station:
        for bad, says in [
            ({"router": "tls/127.0.0.1:7447"}, "tcp/127.0.0.1:7447"),
            ({"router": "tcp/0.0.0.0:7447"}, "host name"),
            ({"domain": 233}, "232"),
            ({"names": "px4"}, "mavros or ap"),
            ({"namespace": "a b"}, "namespace"),
            ({"router": "tcp/192.0.2.1:7447", "role": "operator"}, "could command the plane"),
        ]:
            with pytest.raises(InvalidRequest, match=says):
                Gateway(station, **bad)  # type: ignore[arg-type]
        with reserved_ports() as [port], Gateway(station, router=f"tcp/127.0.0.1:{port}") as gateway:
            wait_for(lambda: gateway.status.problem is not None, "it to say that no router is there")
            assert "rmw_zenohd" in str(gateway.status.problem)
            with pytest.raises(LinkError, match="no router is there"):
                examine(f"tcp/127.0.0.1:{port}")
            told = CliRunner().invoke(app, ["ros", "doctor", "--ros2-router", f"tcp/127.0.0.1:{port}", "--json"])
            assert (told.exit_code, json.loads(told.stdout)["findings"][0]["code"]) == (1, "no-router")


class Witness:
    """A router, and somebody at it."""

    def __init__(self, process: subprocess.Popen[str], port: int) -> None:
        self._process = process
        self.router = f"tcp/127.0.0.1:{port}"
        self.types = Types()
        self._numbers = itertools.count(1)

    def ask(self, do: str, **of: object) -> Any:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps({"do": do, **of}) + "\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        assert line, "the witness ended"
        return json.loads(line)

    def key(self, name: str, kind: str, domain: int = 0) -> str:
        path, _, last = kind.rpartition("/")
        return f"{domain}/{name.strip('/')}/{path.replace('/', '::')}::dds_::{last}_/{self.types.hash(kind)}"

    def hear(self, name: str, kind: str, domain: int = 0, count: int = 1) -> list[tuple[Any, int, int]]:
        """Messages, each with its number and when it was sent, ns."""
        found = []
        for sample in self.ask("hear", key=self.key(name, kind, domain), count=count):
            number, sent_ns, length, _gid = struct.unpack("<qqB16s", bytes.fromhex(sample["attachment"]))
            assert length == 16
            found.append((self.types.read(bytes.fromhex(sample["payload"]), kind), number, sent_ns))
        return found

    def call(self, name: str, kind: str, domain: int = 0, **request: object) -> Any:
        """The one answer of a service."""
        payload = self.types.write(f"{kind}_Request", **request)
        number, gid = next(self._numbers), bytes(range(16))
        attachment = struct.pack("<qqB", number, time.time_ns(), 16) + gid
        [reply] = self.ask("call", key=self.key(name, kind, domain), payload=payload.hex(), attachment=attachment.hex())
        echoed = struct.unpack("<qqB16s", bytes.fromhex(reply["attachment"]))
        assert (echoed[0], echoed[2:]) == (number, (16, gid))
        return self.types.read(bytes.fromhex(reply["payload"]), f"{kind}_Response")


@contextlib.contextmanager
def a_witness() -> Iterator[Witness]:
    with (
        reserved_ports() as [port],
        subprocess.Popen(
            [sys.executable, "-m", "tests.fleet.ros2_witness", str(port)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        ) as process,
    ):
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == '"ready"\n'
            yield Witness(process, port)
        finally:
            process.kill()


@pytest.mark.e2e
def test_a_plane_is_seen_by_a_reader_of_ros_and_acts_for_an_operator_alone(tmp_path: Path) -> None:
    with (
        a_witness() as witness,
        Plane() as plane,
        command(
            tmp_path, "serve", "--port", "0", "--link", plane.link, "--ros2-router", witness.router,
        ) as serve,
    ):  # fmt: skip
        serve.line()
        plane.hold(30.0, 10.0, 90.0)
        at = "/vencejo_1/mavros"
        wait_for(lambda: any(f"{at.replace('/', '%')}%imu%data/" in token for token in witness.ask("tokens")), "tokens")
        tokens = witness.ask("tokens")
        assert sum("/NN/%/%vencejo_1/mavros" in token for token in tokens) == 1
        [token] = [token for token in tokens if "%global_position%global/" in token]
        assert token.endswith(
            f"/sensor_msgs::msg::dds_::NavSatFix_/{hashes()['sensor_msgs/msg/NavSatFix']}/::,10:,:,:,,"
        )

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
        # The simulated receiver's geoid is its ellipsoid, as that of ArduPilot's simulator.
        assert fix.altitude == pytest.approx(plane.truth().alt_rel_home_m + HOME[2], abs=20.0)
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
        assert "/far is in domain 5" in found["other-domain"]

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
            assert station.operator.request(), "it gives control to whoever asks"
            held = witness.call("/uas1/mavros/vencejo/arm", "std_srvs/srv/SetBool", **there, data=False)
            assert (held.success, "Ana holds control" in held.message) == (False, True), held.message
            assert vehicle.telemetry.is_armed
