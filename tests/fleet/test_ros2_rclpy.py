"""A plane in ROS 2, read and asked by ROS 2 itself: `rclpy`'s own serialisation, of unofficial wheels that `make soak` installs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from vencejo import Station, _native
from vencejo.fleet import has_fleet
from vencejo.ros2 import Gateway

from tests.fleet.ros2_at_router import a_witness
from tests.fleet.ros2_lines import asked
from tests.fleet.ros2_offered import MAVROS, TOPICS, whole
from tests.fleet.ros2_types import plain
from tests.plane import Plane
from tests.support import wait_for

ROOT = Path(__file__).parents[2]
PYTHON = ROOT / ".cache/ros/bin/python"

pytestmark = [
    pytest.mark.soak,
    pytest.mark.skipif(not has_fleet(), reason="this build has no fleets"),
    pytest.mark.skipif(
        not PYTHON.exists(), reason="no rclpy: `scripts/setup.sh soak` installs it, for CPython 3.11 alone"
    ),
]

BESIDE = {"geographic_msgs", "mavros_msgs", "tf2_msgs"}
"""Packages that have no wheel."""


def test_ros_itself_has_the_same_hashes_reads_what_is_said_and_is_answered() -> None:
    quiet: dict[str, Any] = {"record": False, "signing": False}
    with (
        asked("tests.fleet.ros2_rclpy", python=str(PYTHON)) as ros,
        a_witness() as witness,
        Plane() as plane,
        Station(plane.link, **quiet) as station,
        Gateway(station, router=witness.router, domain=7) as gateway,
        Gateway(station, router=witness.router, domain=8, names="ap") as other,
    ):
        ours = dict(_native.ros2_types())
        theirs = {name: ros.ask("hash", name=name) for name in ours}
        assert {name.partition("/")[0] for name, found in theirs.items() if found is None} == BESIDE
        assert {name: found for name, found in theirs.items() if found} == {
            name: found for name, found in ours.items() if theirs[name]
        }

        for domain in (7, 8):
            witness.ask("listen", key=f"{domain}/**")
        wait_for(lambda: bool(gateway.status.planes and other.status.planes), "the plane")
        read = set()
        for domain, names, at in [(7, MAVROS, "/vencejo_1/mavros"), (8, "ap", "/ap/v1")]:
            for name, kind in TOPICS[names].items():
                # Nothing is logged while nothing is done.
                if name == "/rosout" or theirs[kind] is None:
                    continue
                payload = witness.said(whole(at, name), kind, domain)
                message = ros.ask("read", name=kind, payload=payload.hex())
                assert json.dumps(message) == json.dumps(plain(witness.types.read(payload, kind))), kind
                read.add(kind)
        assert len(read) == 12

        for kind, name, domain, fields in [
            ("std_srvs/srv/SetBool", "/vencejo_1/mavros/vencejo/arm", 7, {"data": True}),
            ("std_srvs/srv/Trigger", "/ap/v1/prearm_check", 8, {}),
        ]:
            request = bytes.fromhex(ros.ask("write", name=f"{kind}_Request", fields=fields))
            answer = witness.answer(name, kind, domain, request)
            told = ros.ask("read", name=f"{kind}_Response", payload=answer.hex())
            assert told == plain(witness.types.read(answer, f"{kind}_Response"))
            assert told["success"] is (domain == 8), "one that only reads arms nothing"
            assert told["message"]
