"""Two ground stations that are linked routers, programs of their own: what is at the one is seen and commanded at the other, and again once either was killed."""

from __future__ import annotations

import contextlib
from pathlib import Path

import pytest
from vencejo.fleet import has_fleet

from tests.fleet.programs import far_plane, ground_station
from tests.server.client import Client
from tests.support import Metronome, reserved_ports, wait_for

pytestmark = pytest.mark.skipif(not has_fleet(), reason="this build has no fleets")

BACK_S = 6.0
"""So soon after a router is there again everybody sees everything (a thousand aircraft, bench/README.md: far_restart); dialling backs off to 4 s."""


def hears(client: Client) -> bool:
    """Whether the plane is in a ground station's list, and was heard just now."""
    for each in client.done("GET", "vehicles"):
        if each["remote_name"] == "plane7":
            heartbeat = client.done("GET", f"vehicles/{each['system_id']}")["telemetry"].get("heartbeat")
            return heartbeat is not None and heartbeat["age_s"] < 2.0
    return False


@pytest.mark.e2e
def test_linked_ground_stations_see_each_others_plane_and_again_once_either_was_killed(tmp_path: Path) -> None:
    with reserved_ports(2) as (near, far), contextlib.ExitStack() as stack:
        # Each dials the other, and is there before it.
        hill, told = stack.enter_context(ground_station(tmp_path / "hill", far, near))
        luis = Client(told["url"])
        luis.open_session(name="Luis")
        plane = stack.enter_context(far_plane(tmp_path, "--trust", told["fleet"]["key"], listen=near, router=far))
        wait_for(lambda: hears(luis), "the plane on the hill")

        # The plane's own router goes, and with it what the hill hears.
        plane.ground.process.kill()
        plane.ground.process.wait()
        wait_for(lambda: not hears(luis), "silence on the hill")
        stack.enter_context(ground_station(tmp_path / "ground", near, far))
        with Metronome() as clock:
            wait_for(lambda: hears(luis), "the plane on the hill again")
            assert clock.now_s < BACK_S
        [at] = [f"vehicles/{each['system_id']}" for each in luis.done("GET", "vehicles")]
        luis.done("POST", "control/take")
        luis.done("POST", f"{at}/mode", {"mode": "FBWA"})
        plane.board.until(holder="Luis")

        # The hill goes; the plane's router goes on, and tells the next one there.
        hill.process.kill()
        hill.process.wait()
        _, told = stack.enter_context(ground_station(tmp_path / "hill", far, near))
        luis = Client(told["url"])
        luis.open_session(name="Luis")
        with Metronome() as clock:
            wait_for(lambda: hears(luis), "the plane at the one that was started again")
            assert clock.now_s < BACK_S
