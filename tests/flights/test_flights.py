"""Flights E1 to E4, driven through the Python package over a real link, without wind and with 5 m/s from every side."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import pytest
import vencejo
from pymavlink import mavutil
from vencejo import MissionItem, Plan

from tests.flights.rival import load_with_pymavlink
from tests.flights.track import Flight, assert_waypoints_passed, landing_error_m
from tests.support import HOME, simulated_plane, wait_for

pytestmark = pytest.mark.e2e

IN_FLIGHT = 60.0
"""Simulated seconds per second where it only has to fly. Where programs talk with it, whose patience is by its own clock, they are as long as others."""
FLIGHT_TIMEOUT_S = 300.0
LANDING_TOLERANCE_M = 20.0
WINDS = {"calm": (0, 0), "north": (5, 0), "east": (5, 90), "south": (5, 180), "west": (5, 270)}
LAT, LON, _ = HOME


def offset(north_m: float, east_m: float) -> tuple[float, float]:
    """Degrees of a point that lies so far from home, as fine as a vehicle keeps them. Exact enough to lay out a plan."""
    return round(LAT + north_m / 111_050.0, 7), round(LON + east_m / 84_980.0, 7)


CIRCUIT = [offset(0, -500), offset(450, -600), offset(600, 0), offset(450, 600)]


def waypoints() -> list[MissionItem]:
    return [waypoint(place, 80.0) for place in CIRCUIT]


def waypoint(place: tuple[float, float], alt_rel_home_m: float) -> MissionItem:
    """With a radius of its own: the vehicle widens its WP_RADIUS by the thinness of the air."""
    return MissionItem.waypoint(*place, alt_rel_home_m=alt_rel_home_m, acceptance_radius_m=50.0)


def takeoff() -> MissionItem:
    return MissionItem.takeoff(*offset(0, -250), alt_rel_home_m=50.0, pitch_deg=15.0)


def landing() -> list[MissionItem]:
    """A straight approach from the east onto the place of take-off, gentle enough to be flown with the wind behind.

    An ArduPlane asks for no lower height while its throttle is closed: on a steep slope and with a tail wind it lands long.
    """
    return [
        MissionItem.land_start(*offset(0, 1100), alt_rel_home_m=60.0),
        waypoint(offset(0, 1100), 60.0),
        waypoint(offset(0, 650), 35.0),
        MissionItem.land(*offset(0, 0)),
    ]


@pytest.fixture(params=WINDS, ids=str)
def plane(request: pytest.FixtureRequest) -> Iterator[vencejo.Vehicle]:
    speed_m_s, from_deg = WINDS[request.param]
    options = ["--wind", str(speed_m_s), "--wind-from", str(from_deg), "--seed", "7"]
    with (
        simulated_plane(*options, "--param", "RTL_AUTOLAND=2") as link,
        vencejo.connect(link, record=False) as vehicle,
    ):
        yield vehicle


def ready(plane: vencejo.Vehicle) -> None:
    """Wait until the vehicle's own checks pass, as a person does before arming."""
    plane.wait_until(
        lambda telemetry: telemetry.sys_status is not None and telemetry.sys_status.is_ready_to_arm is True,
        timeout_s=FLIGHT_TIMEOUT_S,
        what="passing the pre-arm checks",
    )


def hurry(plane: vencejo.Vehicle) -> None:
    """Have simulated time go faster from now on."""
    plane.params["SIM_SPEEDUP"] = IN_FLIGHT


def calm(plane: vencejo.Vehicle) -> None:
    """Have simulated time go as it does for people."""
    plane.params["SIM_SPEEDUP"] = 1.0


def test_e1_a_mission_that_another_program_loaded_is_followed(plane: vencejo.Vehicle) -> None:
    """Another station loads and starts the mission; ours only watches, and sees attitude and position truly."""
    plan = Plan(items=(takeoff(), *waypoints(), MissionItem.return_to_launch()))
    ready(plane)
    link = plane.station.links[0].address
    rival = mavutil.mavlink_connection(link, source_system=250, source_component=190)
    try:
        assert rival.wait_heartbeat(timeout=120) is not None
        load_with_pymavlink(rival, plan)
        rival.mav.command_long_send(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0)
        plane.wait_until(
            lambda telemetry: telemetry.is_armed is True, timeout_s=FLIGHT_TIMEOUT_S, what="arming by the other station"
        )

        def is_noticed() -> bool:
            known = plane.plan_on_board()
            return plane.plan_state().state == "unknown" or (known is not None and known.items[1:5] == plan.items[1:5])

        # What a station does not know it reads by itself: for the first time maybe only when the other has loaded it.
        wait_for(is_noticed, "another station's change of the mission")
        with Flight(plane) as flight:
            rival.set_mode_auto()
            rival.param_set_send("SIM_SPEEDUP", IN_FLIGHT)
            plane.wait_until(
                lambda telemetry: len(flight.reached) >= len(CIRCUIT) + 1,
                timeout_s=FLIGHT_TIMEOUT_S,
                what="the mission",
            )
            telemetry = plane.wait_until(
                lambda telemetry: telemetry.attitude is not None and telemetry.attitude.freshness == "fresh",
                timeout_s=FLIGHT_TIMEOUT_S,
                what="an attitude of this moment",
            )
            flight.fly_on()
        assert [item for item, _ in itertools.groupby(flight.reached)] == list(range(1, len(CIRCUIT) + 2))
        assert_waypoints_passed(flight, plan)
        assert plane.download().items[1:5] == plan.items[1:5]
        # In a steady banked turn the horizon, the heading and the track agree: see that they are the plane's, and fresh.
        assert telemetry.attitude is not None
        assert telemetry.attitude.roll_rad is not None
        assert abs(telemetry.attitude.roll_rad) < 1.3
    finally:
        rival.close()


def test_e2_a_mission_is_sent_to_a_plane_in_the_air(plane: vencejo.Vehicle) -> None:
    ready(plane)
    plane.takeoff(alt_rel_home_m=60.0)
    plane.arm()
    hurry(plane)
    plane.wait_until(
        lambda telemetry: telemetry.position is not None and (telemetry.position.alt_rel_home_m or 0.0) > 50.0,
        timeout_s=FLIGHT_TIMEOUT_S,
        what="climbing to where it circles",
    )
    calm(plane)
    plan = Plan(items=(*waypoints(), MissionItem.loiter(*offset(300, 0), alt_rel_home_m=80.0)))
    state = plane.upload(plan)
    assert (state.state, state.count) == ("verified", len(plan))
    assert plane.telemetry.mode == "TAKEOFF", "an upload changes no mode"
    with Flight(plane) as flight:
        plane.start_mission()
        hurry(plane)
        plane.wait_until(
            lambda telemetry: plane.mission_progress.item == len(plan), timeout_s=FLIGHT_TIMEOUT_S, what="the last item"
        )
        flight.fly_on()
        wait_for(lambda: len(flight.reached) >= len(CIRCUIT), "word of all waypoints")
    assert flight.reached[: len(CIRCUIT)] == list(range(1, len(CIRCUIT) + 1))
    assert_waypoints_passed(flight, plan)


def test_e3_take_off_and_waypoints_from_the_ground(plane: vencejo.Vehicle) -> None:
    plan = Plan(items=(takeoff(), *waypoints(), MissionItem.return_to_launch()))
    assert plane.upload(plan).state == "verified"
    ready(plane)
    with Flight(plane) as flight:
        plane.arm()
        plane.start_mission()
        hurry(plane)
        plane.wait_until(
            lambda telemetry: telemetry.mode == "RTL" or plane.mission_progress.item == len(plan),
            timeout_s=FLIGHT_TIMEOUT_S,
            what="the way home",
        )
        flight.fly_on()
        wait_for(lambda: len(flight.reached) >= 5, "word of all items")
    assert flight.reached[:5] == [1, 2, 3, 4, 5]
    assert_waypoints_passed(flight, plan)


def test_e4_take_off_and_landing(plane: vencejo.Vehicle) -> None:
    plan = Plan(items=(takeoff(), *waypoints(), *landing()))
    assert [finding for finding in plane.check_plan(plan) if finding.severity == "error"] == []
    assert plane.upload(plan).state == "verified"
    ready(plane)
    with Flight(plane) as flight:
        plane.arm()
        plane.start_mission()
        hurry(plane)
        telemetry = flight.fly_to_the_end(FLIGHT_TIMEOUT_S)
    assert_waypoints_passed(flight, plan)
    assert landing_error_m(telemetry, plan) <= LANDING_TOLERANCE_M
    assert set(flight.modes) <= {"AUTO"}, "nobody changed the mode on the way"


def test_three_flights_in_a_row() -> None:
    """Each begins where the last one ended: on the ground in AUTO, at the landing; the third with a station of its own."""
    around = [waypoint(offset(150, -250), 45.0), MissionItem.jump(2, repeats=1), waypoint(offset(150, 150), 45.0)]
    final = [MissionItem.land_start(*offset(0, 500), alt_rel_home_m=40.0), waypoint(offset(0, 450), 40.0)]
    first = MissionItem.takeoff(*offset(0, -200), alt_rel_home_m=40.0, pitch_deg=15.0)
    plan = Plan(items=(first, *around, *final, MissionItem.land(*offset(0, 0))))
    told = []
    with simulated_plane("--seed", "7", "--param", "RTL_AUTOLAND=2") as link:
        for flights in (2, 1):
            with vencejo.connect(link, record=False) as plane:
                for _ in range(flights):
                    preparation = plane.flight_preparation
                    assert preparation is not None
                    told.append((preparation.from_mode, preparation.mode, preparation.is_needed))
                    if not preparation.is_needed:
                        ready(plane)
                    with Flight(plane) as flight:
                        plane.send_and_fly(plan)
                        hurry(plane)
                        telemetry = flight.fly_to_the_end(FLIGHT_TIMEOUT_S)
                    assert_waypoints_passed(flight, plan)
                    assert flight.reached.count(2) == 2, "the jump is flown each time"
                    assert landing_error_m(telemetry, plan) <= LANDING_TOLERANCE_M
                    assert telemetry.mode == "AUTO"
                    calm(plane)
                with pytest.raises(vencejo.CommandRefused, match="In landing sequence") as refused:
                    plane.arm()
                assert refused.value.cure_mode == "MANUAL"
    assert told == [("MANUAL", None, False), ("AUTO", "MANUAL", True), ("AUTO", "MANUAL", True)]
