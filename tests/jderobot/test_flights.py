"""Flights E1 to E4 of an existing JdeRobot program, through Ice alone; what ArDroneExtra and CMDVel do alone; and E9: cut off, and back.

The plane is the simulated one. The client knows only the Slice files.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from pymavlink import mavutil
from vencejo import MissionItem, Plan

from tests.flights.rival import load_with_pymavlink
from tests.jderobot.support import INTERFACES, Client, Relay, address_of, client_of, driver, example
from tests.plane import Plane
from tests.support import HOME, reserved_ports, simulated_plane, wait_for

pytestmark = pytest.mark.e2e

LAT, LON, _ = HOME
FLIGHT_S = 300.0
LOOK_S = 0.5
"""Of the plane's time between two looks, and what they take: so that none of its turns falls between them."""
AUTOLAND = {"RTL_AUTOLAND": 2}
"""A plane whose return finds the landing of its mission. Without it, as it leaves the works, DO_LAND_START is not armed."""
EARTH_M = 6_371_008.8


def place(north_m: float, east_m: float) -> tuple[float, float]:
    return LAT + north_m / 111_050.0, LON + east_m / 84_980.0


def pose(north_m: float, east_m: float, height_m: float) -> tuple[float, float, float]:
    return (*place(north_m, east_m), height_m)


CIRCUIT = [pose(0, -500, 80), pose(450, -600, 80), pose(600, 0, 80), pose(450, 600, 80)]


def distance_m(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Haversine: exact enough for some hundred metres, and nothing of ours."""
    lat1, lon1, lat2, lon2 = map(math.radians, (*a, *b))
    half = math.sin((lat2 - lat1) / 2) ** 2 + math.cos(lat1) * math.cos(lat2) * math.sin((lon2 - lon1) / 2) ** 2
    return 2 * EARTH_M * math.asin(math.sqrt(half))


def nearest_on(begin: tuple[float, float], end: tuple[float, float], point: tuple[float, float]) -> tuple[float, float]:
    """The point of a line of some hundred metres that is nearest to another; flat, which is exact enough for so little."""
    east = math.cos(math.radians(point[0]))
    along = (end[0] - begin[0], (end[1] - begin[1]) * east)
    towards = (point[0] - begin[0], (point[1] - begin[1]) * east)
    length = along[0] ** 2 + along[1] ** 2
    share = 0.0 if length == 0 else max(0.0, min(1.0, (along[0] * towards[0] + along[1] * towards[1]) / length))
    return begin[0] + share * (end[0] - begin[0]), begin[1] + share * (end[1] - begin[1])


class Follower:
    """Polls Pose3D and Navdata as a viewer does, and keeps the track. The plane flies on from look to look."""

    def __init__(self, plane: Plane, client: Client) -> None:
        self._plane = plane
        self._pose, self._navdata = client.pose, client.navdata
        self.track: list[tuple[float, float]] = []
        self.roll_deg: list[float] = []
        self.states: list[int] = []

    def look(self) -> Any:
        self._plane.fly(LOOK_S)
        data, navdata = self._pose.getPose3DData(), self._navdata.getNavdata()
        self.track.append((data.x, data.y))
        self.roll_deg.append(navdata.rotX)
        if not self.states or self.states[-1] != navdata.state:
            self.states.append(navdata.state)
        return navdata

    def until(self, condition: Any, what: str) -> None:
        wait_for(lambda: condition(self.look()), what, FLIGHT_S)

    def passed_m(self, where: tuple[float, ...]) -> float:
        """How near it came, also between two looks."""
        point = (where[0], where[1])
        return min(
            distance_m(nearest_on(seen, after, point), point)
            for seen, after in pairwise((*self.track[:1], *self.track))
        )

    def fly_past(self, poses: list[tuple[float, float, float]], within_m: float = 60.0) -> None:
        for where in poses:
            self.until(lambda _, where=where: self.passed_m(where) <= within_m, f"passing {where}")


@pytest.fixture
def flight(tmp_path: Path) -> Iterator[tuple[Plane, Client]]:
    """A plane and a driver; gives the plane and a client."""
    with (
        Plane() as plane,
        driver(plane.link, "--ice-set", "AloneAfter=2", data=tmp_path) as served,
        client_of(served.said["ice"]) as client,
    ):
        client.wait_ready()
        yield plane, client


def wait_true_at_rest(client: Client, rival: Any) -> None:
    """Position and attitude come to be what another program hears of the plane itself, while it stands.

    Its estimate of the heading wanders by two degrees while it stands, so both have to be of the same moment.
    """
    rival.mav.request_data_stream_send(1, 1, 0, 10, 1)

    def newest(name: str) -> Any:
        message = rival.recv_match(type=name, blocking=True, timeout=120)
        assert message is not None, name
        while (newer := rival.recv_match(type=name)) is not None:
            message = newer
        return message

    def is_true() -> bool:
        truth, lies = newest("GLOBAL_POSITION_INT"), newest("ATTITUDE")
        seen, navdata = client.pose.getPose3DData(), client.navdata.getNavdata()
        # The quaternion's own angles, with the pitch's sign turned (Diebel 2006, eq. 290).
        w, x, y, z = seen.q0, seen.q1, seen.q2, seen.q3
        return bool(
            distance_m((truth.lat / 1e7, truth.lon / 1e7), (seen.x, seen.y)) < 2.0
            and seen.z == pytest.approx(truth.alt / 1e3, abs=2.0)
            and (navdata.rotX, navdata.rotY, navdata.rotZ)
            == pytest.approx(tuple(map(math.degrees, (lies.roll, lies.pitch, lies.yaw))), abs=2.0)
            and math.asin(2 * (w * y - z * x)) == pytest.approx(-lies.pitch, abs=0.03)
            and math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)) == pytest.approx(lies.roll, abs=0.03)
        )

    wait_for(is_true, "the driver's position and attitude as another program hears them")


def test_e1_a_mission_that_another_program_loaded_is_followed(flight: tuple[Plane, Client]) -> None:
    plane, client = flight
    circuit = [MissionItem.waypoint(lat, lon, alt_rel_home_m=alt) for lat, lon, alt in CIRCUIT[:2]]
    plan = Plan(items=(MissionItem.takeoff(*place(0, -250), alt_rel_home_m=50.0), *circuit))
    rival = mavutil.mavlink_connection(plane.link, source_system=250, source_component=190)
    try:
        assert rival.wait_heartbeat(timeout=120) is not None
        load_with_pymavlink(rival, plan)
        wait_true_at_rest(client, rival)
        rival.mav.command_long_send(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0)
        wait_for(lambda: client.telemetry.getNavigation(0).isArmed is True, "arming by the other program")
        rival.set_mode_auto()
        follower = Follower(plane, client)
        follower.fly_past(CIRCUIT[:2])
        on_board = client.mission.getMissionData().mission
        assert [round(one.h) for one in on_board] == [50, 80, 80]
        assert [(one.x, one.y) for one in on_board[1:]] == [
            (pytest.approx(lat, abs=1e-5), pytest.approx(lon, abs=1e-5)) for lat, lon, _ in CIRCUIT[:2]
        ]
        assert max(map(abs, follower.roll_deg)) > 15.0, "it banked in its turns"
        assert follower.states[0] == 2
        assert 7 in follower.states
    finally:
        rival.close()


def test_e2_a_mission_is_sent_to_a_plane_in_the_air(flight: tuple[Plane, Client]) -> None:
    """Take-off by ArDroneExtra alone, after the wait for a mission; then a mission, which needs no take-off."""
    plane, client = flight
    follower = Follower(plane, client)
    client.extra.takeoff()
    wait_for(lambda: follower.look().state != 2, "taking off", FLIGHT_S)
    follower.until(lambda navdata: navdata.altd > 40_000, "climbing to the height that is set")
    assert client.mission.setMissionData(client.mission_data(*CIRCUIT[2:])) == 0
    follower.fly_past(CIRCUIT[2:])
    # Landing alone: this mission has no landing, so the plane returns home, and that is said.
    client.extra.land()
    wait_for(lambda: client.telemetry.getNavigation(0).mode == "RTL", "returning instead of landing")
    # With a landing, which this plane has without DO_LAND_START (RTL_AUTOLAND is 0), it flies that one.
    client.extra.land()
    assert client.mission.setMissionData(client.mission_data(*CIRCUIT[:2], pose(0, 0, 80))) == 0
    wait_for(lambda: client.missions.getProgress(0).item in (1, 2), "the vehicle's word that it began at the beginning")
    client.extra.land()
    wait_for(lambda: client.missions.getProgress(0).item == 3, "the circle down, before the landing")
    assert client.telemetry.getNavigation(0).mode == "AUTO"


@pytest.mark.parametrize(
    "setting", [{}, {"params": AUTOLAND, "wind_m_s": 5.0, "wind_from_deg": 240.0}], ids=["calm", "wind, autoland"]
)
def test_e3_e4_from_take_off_to_landing_near_the_point(setting: dict[str, Any], tmp_path: Path) -> None:
    """The last pose is where it lands, whatever heights the poses before have: they are not tuned."""
    landing = pose(0, 0, 80)
    poses = [pose(0, -250, 50), *CIRCUIT, pose(100, 700, 110), landing]
    with (
        Plane(**setting) as plane,
        driver(plane.link, data=tmp_path) as served,
        client_of(served.said["ice"]) as client,
    ):
        client.wait_ready()

        def is_answered() -> bool:
            client.extra.takeoff()
            client.extra.land()
            answer = client.mission.setMissionData(client.mission_data(*poses))
            assert answer in (0, 5)
            return bool(answer == 0)

        wait_for(is_answered, "the mission to be taken by a plane that is ready")
        follower = Follower(plane, client)
        follower.fly_past(poses[1:-1], within_m=90.0)
        follower.until(lambda navdata: navdata.state == 2, "landing")
        follower.until(lambda _: client.telemetry.getNavigation(0).isArmed is False, "disarming after the landing")
        rest = client.telemetry.getPose(0)
        assert distance_m((rest.latDeg, rest.lonDeg), place(0, 0)) <= 20.0
        assert {6, 7, 8} <= set(follower.states), "taking off, flying, landing"
        on_board = client.mission.getMissionData().mission
        assert [one.h for one in on_board] == [height for *_, height in poses], "as it was sent"


def test_a_second_mission_and_a_third_after_the_drivers_restart(tmp_path: Path) -> None:
    """Each from where the last one ended: on the ground in AUTO, at the landing. The program does nothing else for it."""
    poses = [pose(0, -250, 40), pose(150, -250, 45), pose(0, 500, 45), pose(0, 0, 40)]
    with Plane(params=AUTOLAND) as plane:
        for missions in (2, 1):
            with driver(plane.link, data=tmp_path) as served, client_of(served.said["ice"]) as client:
                wait_for(lambda: 1 in client.telemetry.vehicles(), "a vehicle")
                for number in range(missions):
                    if missions == 2 and number == 0:
                        client.wait_ready()
                    client.extra.takeoff()
                    client.extra.land()
                    assert client.mission.setMissionData(client.mission_data(*poses)) == 0
                    follower = Follower(plane, client)
                    follower.fly_past(poses[1:2], within_m=90.0)
                    follower.until(lambda _: client.telemetry.getNavigation(0).isArmed is False, "landing")
                    rest = client.telemetry.getPose(0)
                    assert distance_m((rest.latDeg, rest.lonDeg), place(0, 0)) <= 20.0
                navigation = client.telemetry.getNavigation(0)
                assert navigation.mode == "AUTO"
                # The precise interfaces have the same acts, one by one.
                with pytest.raises(client.precise.CommandRefused, match="change to mode MANUAL"):
                    client.control.arm(0)
                if missions == 1:
                    client.missions.prepareFlight(0)
                    assert client.telemetry.getNavigation(0).mode == "MANUAL"
                    assert client.missions.getProgress(0).item in (client.ice.Unset, 1)


def test_missions_that_are_only_sent(tmp_path: Path) -> None:
    with (
        simulated_plane("--param", "RTL_AUTOLAND=2") as link,
        driver(link, "--ice-missions", "upload", "--ice-set", "AloneAfter=2", data=tmp_path) as served,
        client_of(served.said["ice"]) as client,
    ):
        client.wait_ready()
        client.extra.takeoff()
        assert client.mission.setMissionData(client.mission_data(pose(0, -250, 50), *CIRCUIT)) == 0
        navigation = client.telemetry.getNavigation(0)
        assert (navigation.isArmed, navigation.mode) == (False, "MANUAL")
        assert client.missions.download(0, client.precise.PlanKind.MissionPlan).items[0].command == 22
        for language in ("python", "javascript"):
            # Taken up by the examples, on board afterwards.
            done = example(language, client.proxies, tmp_path, "--fly")
            assert (done.returncode, done.stdout.splitlines()[-1:]) == (0, ["it flies"]), done.stderr
            sent = client.missions.download(0, client.precise.PlanKind.MissionPlan).items
            assert [item.command for item in sent] == [22, 16, 16, 16, 189, 31, 21], language
            client.missions.clear(0, client.precise.PlanKind.MissionPlan, {"confirm": "clear-mission"})
        assert client.extra.takeoff() is None
        browser = served.client(name="onlooker")
        browser.done("POST", "control/release")
        wait_for(
            lambda: "nothing is armed over these interfaces" in str(browser.done("GET", "vehicles/1/texts")),
            "the reason in the station",
        )
        assert client.telemetry.getNavigation(0).isArmed is False


def test_velocities_steer_a_plane_in_guided(flight: tuple[Plane, Client]) -> None:
    plane, client = flight
    data = client.jderobot.CMDVelData
    control, velocity, follower = client.control, client.velocity, Follower(plane, client)
    control.takeoff(0, 60.0)
    wait_for(lambda: armed(client), "arming", FLIGHT_S)
    follower.until(lambda navdata: navdata.altd > 50_000, "climbing")
    control.goTo(0, *place(800, 0), 80.0, True)

    def steer(condition: Any, what: str, **linear: float) -> None:
        def step() -> bool:
            assert velocity.setCMDVelData(data(**linear)) in (0, 6)
            return bool(condition(follower.look()))

        wait_for(step, what, FLIGHT_S)

    steer(lambda navdata: navdata.rotX < -8.0, "a bank to the left", linearX=18.0, angularZ=0.3)
    steer(lambda navdata: navdata.rotX > 8.0, "a bank to the right", linearX=18.0, angularZ=-0.3)
    height = follower.look().altd
    steer(lambda navdata: navdata.altd > height + 15_000, "a climb", linearX=18.0, linearZ=2.0)
    # Without new commands it flies straight and level.
    follower.until(lambda navdata: abs(navdata.rotX) < 5.0 and abs(navdata.vz) < 700.0, "straight and level")
    assert client.telemetry.getNavigation(0).mode == "GUIDED"
    control.setMode(0, "LOITER")
    assert velocity.setCMDVelData(data(linearX=18.0)) == 7, "no velocity changes the mode"


def armed(client: Client) -> bool:
    """Whether it is armed now; its own checks may not pass yet."""
    try:
        client.control.arm(0)
    except client.precise.CommandRefused:
        return False
    return True


# E9 ----------------------------------------------------------------------------------------------------------------


def test_e9_client_and_driver_and_plane_are_cut_off_and_all_resumes(tmp_path: Path) -> None:
    with (
        simulated_plane() as link,
        Relay(address_of(link)) as to_plane,
        reserved_ports(len(INTERFACES)) as ports_of_ice,
    ):
        places = zip(INTERFACES, ports_of_ice, strict=True)
        ports = {f"{name}.Endpoints": f"tcp -h 127.0.0.1 -p {port}" for name, port in places}
        with driver(f"tcp:127.0.0.1:{to_plane.port}", data=tmp_path, ports=ports) as served:
            proxies = dict(served.said["ice"])
            with Relay(address_of(proxies["Pose3D"])) as to_driver:
                through = f"ardrone_pose3d:tcp -h 127.0.0.1 -p {to_driver.port}"
                with client_of({**proxies, "Pose3D": through}) as client:
                    client.wait_ready()
                    one = client.pose
                    before = one.getPose3DData()
                    # The client's network goes, and comes back: the same proxy goes on.
                    to_driver.cut()
                    with pytest.raises(client.ice.LocalException):
                        one.getPose3DData()
                    to_driver.restore()
                    assert one.getPose3DData().x == pytest.approx(before.x, abs=1e-4)
                    # The plane's link goes: the last value stays, the precise interface tells its age, and commands fail in time.
                    to_plane.cut()
                    wait_for(lambda: client.telemetry.getPose(0).positionAgeS > 5.0, "an old position")
                    assert one.getPose3DData().x == pytest.approx(before.x, abs=1e-4)
                    poses = client.mission_data(pose(0, -250, 50))
                    client.extra.takeoff()
                    assert client.mission.setMissionData(poses) in (2, 4, 6)
                    to_plane.restore()
                    wait_for(lambda: client.telemetry.getPose(0).positionAgeS < 2.0, "new positions")
        # The driver ends and starts again at the same ports: the old proxies reach the new one.
        with client_of(proxies) as client:
            pose3d = client.jderobot.Pose3DPrx.uncheckedCast(client.communicator.stringToProxy(proxies["Pose3D"]))
            with pytest.raises(client.ice.LocalException):
                pose3d.getPose3DData()
            with driver(f"tcp:127.0.0.1:{to_plane.port}", data=tmp_path, ports=ports):
                wait_for(lambda: pose3d.getPose3DData().x != 0.0, "the plane through the new driver")
