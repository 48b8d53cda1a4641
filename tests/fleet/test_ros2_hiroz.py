"""A plane in ROS 2, read and asked by an implementation in Rust that is not ours: `ros2_hiroz`, which `make ros` builds."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from vencejo import MissionItem, Plan, Station
from vencejo.fleet import has_fleet
from vencejo.ros2 import Gateway

from tests.fleet.ros2_at_router import a_witness
from tests.fleet.ros2_lines import started
from tests.fleet.ros2_offered import HEARD, MAVROS, NEWS, SERVICES, TOPICS, whole
from tests.fleet.ros2_types import plain
from tests.plane import Plane, offset
from tests.support import ROOT, wait_for

READER = ROOT / ".cache/ros2-hiroz/debug/ros2-hiroz"

pytestmark = [
    pytest.mark.soak,
    pytest.mark.skipif(not has_fleet(), reason="this build has no fleets"),
    pytest.mark.skipif(not READER.exists(), reason="no reader: `scripts/setup.sh ros` builds it"),
]


def without_nan(value: Any) -> Any:
    """A message as JSON has it, where a number that is none is null."""
    if isinstance(value, dict):
        return {name: without_nan(each) for name, each in value.items()}
    if isinstance(value, list):
        return [without_nan(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def test_it_lists_reads_and_is_answered_the_same(tmp_path: Path) -> None:
    quiet: dict[str, Any] = {"record": False, "signing": False}
    with (
        a_witness() as witness,
        Plane() as plane,
        Station(plane.link, **quiet) as station,
        Gateway(station, router=witness.router, domain=7, role="operator") as gateway,
        Gateway(station, router=witness.router, domain=8, names="ap") as other,
        started([READER, witness.port], HIROZ_MSG_PATH=str(tmp_path)) as hiroz,
    ):
        wait_for(lambda: bool(gateway.status.planes and other.status.planes), "the plane")
        vehicle = station.wait_vehicle()
        there = offset(500.0, 0.0)
        up, on = MissionItem.takeoff(*there, alt_rel_home_m=60.0), MissionItem.waypoint(*there, alt_rel_home_m=80.0)
        vehicle.upload(Plan((up, on)), check=False)
        station.operator.release()
        sets = [(7, MAVROS, "/vencejo_1/mavros"), (8, "ap", "/ap/v1")]
        for domain, names, at in sets:
            topics = {whole(at, name): kind for name, kind in TOPICS[names].items()}
            services = {f"{at}/{name}": kind for name, kind in SERVICES[names].items()}
            witness.types.files(tmp_path, *topics.values())
            listed = [topics | {whole(at, name): kind for name, kind in HEARD[names].items()}, services]
            wait_for(lambda: hiroz.ask("listed", domain=domain) == listed, f"domain {domain}")  # noqa: B023
            witness.ask("listen", key=f"{domain}/**")
            heard = {whole(at, name): kind for name, kind in TOPICS[names].items() if name not in NEWS}
            hiroz.ask("listen", domain=domain, topics=heard)

        def call(domain: int, name: str, kind: str, **request: object) -> Any:
            return hiroz.ask("call", domain=domain, name=name, kind=kind, request=request)

        armed = call(7, "/vencejo_1/mavros/vencejo/arm", "std_srvs/srv/SetBool", data=True)
        assert armed["success"], armed
        assert vehicle.telemetry.is_armed
        ready = call(8, "/ap/v1/prearm_check", "std_srvs/srv/Trigger")
        assert ready["success"], ready

        # What it heard is what was said, to the last digit.
        compared = 0
        for domain, names, at in sets:
            kinds = {whole(at, name): kind for name, kind in TOPICS[names].items() if name not in NEWS}
            for topic, message in hiroz.ask("heard", domain=domain, names=list(kinds)).items():

                def said(topic: str = topic, kind: str = kinds[topic], of: int = domain, wanted: Any = message) -> bool:
                    return any(without_nan(plain(one)) == wanted for one in witness.heard(topic, kind, of))

                wait_for(said, f"{topic}: {message}", 10.0)
                compared += 1
        assert compared == 30
