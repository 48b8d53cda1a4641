"""A vehicle asks the served station for the ground's heights; pymavlink is the vehicle and the witness of the bytes."""

from __future__ import annotations

import contextlib
import math
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pymavlink import mavextra
from pymavlink.dialects.v20 import ardupilotmega as dialect
from vencejo.sim import SimOptions, SimulatedPlane
from vencejo.sim.autopilot.interface import Snapshot
from vencejo.sim.world import World

from tests.server.client import Client, WebSocket, serving
from tests.support import wait_for

pytestmark = pytest.mark.e2e

SIDE = 1201
CORNER_E7 = (403_000_000, -38_500_000)
SPACING_M = 100


class Plane:
    """Says heartbeats over TCP and keeps the TERRAIN_DATA that it hears."""

    def __init__(self, server: socket.socket) -> None:
        self._server = server
        self._mav = dialect.MAVLink(self, srcSystem=1, srcComponent=1)
        self._ended = threading.Event()
        self._stream: socket.socket | None = None
        self.blocks: dict[int, Any] = {}
        self.heard = 0
        self._thread = threading.Thread(target=self._fly)
        self._thread.start()

    def write(self, data: bytes) -> None:
        assert self._stream is not None
        self._stream.sendall(data)

    def say(self, message: Any) -> None:
        self._mav.send(message)

    def ask(self, mask: int, lat_e7: int, lon_e7: int) -> None:
        self.say(dialect.MAVLink_terrain_request_message(lat_e7, lon_e7, SPACING_M, mask))

    def close(self) -> None:
        self._ended.set()
        self._thread.join()

    def _fly(self) -> None:
        self._stream, _ = self._server.accept()
        self._stream.settimeout(0.1)
        reader = dialect.MAVLink(None)
        # The station closes the link when it ends.
        with self._stream, contextlib.suppress(ConnectionError):
            while not self._ended.is_set():
                self.say(dialect.MAVLink_heartbeat_message(1, 3, 0, 0, 3, 3))
                try:
                    data = self._stream.recv(4096)
                except TimeoutError:
                    continue
                for message in reader.parse_buffer(data) or []:
                    if message.get_type() == "TERRAIN_DATA":
                        self.heard += 1
                        self.blocks[message.gridbit] = message


@pytest.fixture(name="plane")
def _plane() -> Iterator[tuple[Plane, str]]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        plane = Plane(server)
        yield plane, f"tcp:127.0.0.1:{server.getsockname()[1]}"
        plane.close()


def ground_m(lat_deg: float, lon_deg: float) -> float:
    """What the test's heights are: a plane, so that what lies between two of them is known too."""
    return (41 - lat_deg) * 1200 + 2 * (lon_deg + 4) * 1200


def summary(client: Client) -> Any:
    (vehicle,) = client.done("GET", "vehicles")
    return vehicle


def test_a_vehicle_is_given_the_ground_that_the_maps_know(plane: tuple[Plane, str], tmp_path: Path) -> None:
    vehicle, link = plane
    with serving("--link", link, data=tmp_path) as served, WebSocket(served.client(name="pilot")) as news:
        client = served.client(name="other")
        # The first list may be older than the server's listening to the vehicle; the one after it is not.
        for _ in range(2):
            while not news.until("vehicles")["vehicles"]:
                pass

        # Without a map nothing is sent, and it is said once. One block: of two the second might find the map.
        vehicle.ask(0b1, *CORNER_E7)
        assert news.until("event", kind="terrain_unknown")["vehicle"] == 1
        assert summary(client)["lacks_terrain"] is True

        heights = (np.arange(SIDE)[:, None] + 2 * np.arange(SIDE)[None, :]).astype(">i2")
        taken = client.done("POST", "maps/files?name=N40W004.hgt", heights.tobytes())
        client.done("PUT", f"maps/sources/{taken['settings']['id']}", taken["settings"])
        vehicle.ask((1 << 56) - 1, *CORNER_E7)
        wait_for(lambda: len(vehicle.blocks) == 56, "a whole grid")
        assert news.until("event", kind="terrain_known")["vehicle"] == 1
        assert summary(client)["lacks_terrain"] is False
        assert vehicle.heard == 56, "each block once"

        worst_m = 0.0
        for bit, block in vehicle.blocks.items():
            assert (block.lat, block.lon, block.grid_spacing) == (*CORNER_E7, SPACING_M)
            for index, height_m in enumerate(block.data):
                north_m = (bit // 8 * 4 + index // 4) * SPACING_M
                east_m = (bit % 8 * 4 + index % 4) * SPACING_M
                place = mavextra.gps_offset(CORNER_E7[0] * 1e-7, CORNER_E7[1] * 1e-7, east_m, north_m)
                worst_m = max(worst_m, abs(height_m - ground_m(*place)))
        # Half a metre of rounding; the great circle of the witness differs by a metre or two on the ground at the far corner.
        assert 0.4 < worst_m < 0.55, worst_m

        rehearsed_over_the_maps(client)

        # Over the edge of what is known nothing is invented.
        vehicle.blocks.clear()
        vehicle.ask(0b11, 409_970_000, -38_500_000)
        vehicle.ask(1 << 48, 409_970_000, -38_500_000)
        vehicle.ask(1 << 3, *CORNER_E7)
        wait_for(lambda: 3 in vehicle.blocks, "the block that is known")
        assert 48 not in vehicle.blocks

        vehicle.say(dialect.MAVLink_terrain_report_message(*CORNER_E7, SPACING_M, 512.5, 90.25, 4, 52))
        report = news_of_terrain(client)
        assert (report["ground_amsl_m"], report["alt_terrain_m"]) == (512.5, 90.25)
        assert (report["pending"], report["loaded"]) == (4, 52)


def item(command: int, lat_deg: float, lon_deg: float, alt_m: float, frame: int = 3) -> dict[str, Any]:
    return {"command": command, "frame": frame, "params": [0, 0, 0, 0, lat_deg, lon_deg, alt_m]}


def rehearsed_over_the_maps(client: Client) -> None:
    """The maps' ground is below a rehearsal: waited for by HTTP, and at hand for the WebSocket from then on."""
    home, far = (40.35, -3.8), (40.37, -3.78)
    flown = [item(22, *home, 60.0), item(16, *far, 80.0, frame=10), item(16, 40.36, -3.78, 80.0, frame=10)]
    at_home = {"lat_deg": home[0], "lon_deg": home[1], "alt_amsl_m": round(ground_m(*home))}
    asked = {"plan": {"home": at_home, "items": flown}}
    rehearsal = client.done("POST", "plan/rehearse", asked)
    track = rehearsal["track"]
    assert rehearsal["is_ground_pending"] is False
    for lat, lon, below_m in zip(track["lat_deg"], track["lon_deg"], track["ground_m"], strict=True):
        assert below_m == pytest.approx(ground_m(lat, lon) - ground_m(*home), abs=0.6)
    over = [h - g for h, g, i in zip(track["height_m"], track["ground_m"], track["item"], strict=True) if i == 2]
    assert over[-1] == pytest.approx(80.0, abs=6.0), "it follows the ground, 24 m higher there"
    codes = [finding["code"] for finding in rehearsal["findings"]]
    assert "ground-not-known" not in codes
    low = client.done("POST", "plan/rehearse", {**asked, "clearance_m": 200.0})
    assert "near-ground" in [finding["code"] for finding in low["findings"]]
    # One that is read at once: it answers pings only then, and what goes before takes longer than their 6 s on a busy machine.
    with WebSocket(client) as socket:
        socket.say(type="assess_plan", seq=1, plan=asked["plan"], rehearse_in={"from_deg": 0, "speed_m_s": 0})
        told = socket.until("assessment", seq=1)["rehearsal"]
    assert told["track"]["ground_m"] == track["ground_m"]
    landing = client.done("POST", "plan/landing", {"at": {"lat_deg": far[0], "lon_deg": far[1]}, "course_deg": 90,
                                                  "home": {"lat_deg": home[0], "lon_deg": home[1]}})  # fmt: skip
    assert landing["items"][-1]["params"][6] == pytest.approx(ground_m(*far) - ground_m(*home), abs=0.6)
    assert landing["cautions"] == []


def news_of_terrain(client: Client) -> Any:
    found: list[Any] = []

    def is_told() -> bool:
        found[:] = [client.done("GET", "vehicles/1")["telemetry"].get("terrain")]
        return found[0] is not None

    wait_for(is_told, "a report")
    return found[0]


def hill_m(lat_deg: float) -> float:
    """A round hill of 120 m, 1.5 km north of home and 2 km wide."""
    north_m = (lat_deg - HILL_HOME[0]) * 111_195.0
    return 600.0 + 60.0 * (1.0 + math.cos(math.pi * min(1.0, max(-1.0, (north_m - 1500.0) / 1000.0))))


HILL_HOME = (40.0459, -3.9300)
"""300 m north-east of the corner of a grid of ``HILL_SPACING_M``, so that four grids are enough for all of the flight."""
HILL_SPACING_M = 200


def test_a_plane_follows_the_ground_that_it_is_given_over_a_hill(tmp_path: Path) -> None:
    lat, lon = HILL_HOME
    params = {"TERRAIN_SPACING": HILL_SPACING_M, "RTL_AUTOLAND": 2}
    options = SimOptions(home_lat_deg=lat, home_lon_deg=lon, heading_deg=0.0, links=("tcp:127.0.0.1:0",), params=params)
    with SimulatedPlane(options) as sim, serving("--link", sim.link, data=tmp_path) as served:
        pilot = served.client(name="pilot")
        wait_for(lambda: pilot.done("GET", "vehicles") != [], "the vehicle")
        way = [item(22, lat, lon, 40.0), *(item(16, lat + north_deg, lon, 60.0, 10) for north_deg in (0.004, 0.0205))]
        home = {"lat_deg": lat, "lon_deg": lon, "alt_amsl_m": 600.0}
        plan = {"home": home, "items": [*way, item(17, lat + 0.0205, lon, 60.0, 10)]}
        pilot.operation("PUT", "vehicles/1/plan/mission", plan)

        def telemetry() -> Any:
            return pilot.done("GET", "vehicles/1")["telemetry"]

        wait_for(lambda: telemetry().get("home") is not None, "home, without which no mission is started")
        pilot.done("POST", "vehicles/1/mode", {"mode": "AUTO"})
        wait_for(lambda: summary(pilot)["lacks_terrain"], "asking for the ground")
        refused = pilot.ask("POST", "vehicles/1/arm")
        assert refused.status == 409, refused.body
        assert any("waiting for terrain data" in reason for reason in refused.json["reasons"]), refused.json

        rows = np.array([hill_m(41.0 - row / (SIDE - 1)) for row in range(SIDE)])
        heights = np.broadcast_to(np.round(rows)[:, None], (SIDE, SIDE)).astype(">i2")
        taken = pilot.done("POST", "maps/files?name=N40W004.hgt", heights.tobytes())
        pilot.done("PUT", f"maps/sources/{taken['settings']['id']}", taken["settings"])
        wait_for(lambda: (telemetry().get("sys_status") or {}).get("is_ready_to_arm") is True, "the ground")
        wait_for(lambda: telemetry()["terrain"]["pending"] == 0, "telling that it has all of it")
        assert telemetry()["terrain"]["ground_amsl_m"] == 600.0

        pilot.done("POST", "vehicles/1/arm")
        above: list[tuple[float, float]] = []

        def fly(world: World) -> Snapshot:
            """From look to look, however long a look takes."""
            world.advance(0.5)
            return world.planes[0].snapshot()

        def is_there() -> bool:
            now = sim.call(fly, timeout_s=120.0)
            if now.mission_current >= 3:
                above.append((now.lat_deg, now.alt_amsl_m - hill_m(now.lat_deg)))
            return bool(now.mission_current >= 4)

        wait_for(is_there, "the way over the hill")
        assert len(above) > 30, "there was something to look at"
        lowest = min(above_m for _, above_m in above)
        # 60 m, and what TECS is behind a slope of up to 1 in 5: 4 s of climbing and sinking, some 10 m, and later on the way down.
        assert 46.0 < lowest < 60.0, above
        assert max(above_m for _, above_m in above) < 85.0, above
        assert above[-1][1] == pytest.approx(60.0, abs=16.0)
