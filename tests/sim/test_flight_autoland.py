"""AUTOLAND, and the wait of a hand launch, without a link."""

from __future__ import annotations

import math

import pytest
from vencejo.sim.autopilot.geo import distance_m
from vencejo.sim.autopilot.interface import LandedState, MavResult, Mode

from tests.sim.flying import Flight, airborne, make, mission, story, waypoint
from tests.sim.test_flight_commands import TAKEOFF


def test_autoland_lands_at_home_in_the_direction_of_the_take_off() -> None:
    """The same story as ArduPlane 4.8-dev's own simulator told (mode_autoland.cpp)."""
    flight = airborne(heading_deg=200, params={"LAND_DISARMDELAY": 20.0})
    plane = flight.plane
    assert plane.takeoff_course_rad is not None
    assert math.degrees(plane.takeoff_course_rad) % 360 == pytest.approx(200, abs=3)
    assert plane.set_mode(Mode.AUTOLAND) is MavResult.ACCEPTED
    assert plane.abort_landing(0.0) is MavResult.FAILED, "a landing is aborted in AUTO only"
    assert flight.run(240, lambda: plane.snapshot().landed_state is LandedState.LANDING)
    assert math.degrees(plane.est.yaw_rad) % 360 == pytest.approx(200, abs=45)
    assert flight.run(120, lambda: not plane.armed)
    assert distance_m(plane.here(), plane.home) < 60
    assert flight.plane.takeoff_course_rad is None
    assert story(flight.texts) == [
        "Loiter to alt complete",
        "Landing approach start at Nm",
        "Landing glide slope N degrees",
        "Flare Nm sink=N speed=N dist=N",
        "Throttle disarmed",
        "Auto disarmed",
        "Distance from LAND point=Nm",
    ]
    # It may be armed where it stands, and disarms at once.
    assert plane.arm() is MavResult.ACCEPTED
    assert flight.run(1, lambda: not plane.armed)


def test_autoland_is_refused_on_the_ground_and_without_a_direction() -> None:
    """A refused mode loses what a station commanded in GUIDED, which Mode::enter resets first."""
    flight = make()
    assert flight.plane.set_mode(Mode.AUTOLAND) is MavResult.FAILED
    flight.run(0.1)
    assert flight.texts == ["Must already be flying!", "Flight mode change failed"]
    flight = airborne()
    flight.plane.takeoff_course_rad = None
    flight.plane.set_mode(Mode.GUIDED)
    flight.plane.change_speed(0, 15.0, -1.0)
    flight.events.clear()
    assert flight.plane.set_mode(Mode.AUTOLAND) is MavResult.FAILED
    flight.run(0.1)
    assert flight.texts[-2:] == ["Takeoff initial direction not set", "Flight mode change failed"]
    assert flight.plane.flight_mode is Mode.GUIDED
    assert flight.plane.energy.airspeed_m_s() == 22
    plane = flight.plane
    point = plane.nav.next
    assert plane.change_guided_speed(15.0, 0.0) is MavResult.ACCEPTED
    assert plane.change_guided_altitude(300.0, 3, 0.0) is MavResult.ACCEPTED
    assert plane.change_heading(1, 45.0, 4.0) is MavResult.ACCEPTED
    plane.force_attitude(0.3, 0.2, 0.9)
    flight.run(1)
    assert plane.set_mode(Mode.AUTOLAND) is MavResult.FAILED
    assert plane.energy.airspeed_m_s() == 22
    flight.run(30)
    assert plane.nav.on_circle, "it circles its point"
    assert plane.nav.next is point
    assert plane.nav.target_alt_m == point.alt_m
    assert plane.snapshot().throttle_pct < 90


def test_autoland_climbs_first_when_asked() -> None:
    """AUTOLAND_CLIMB: with LEVEL_ROLL_LIMIT until 10 m above it."""
    flight = airborne(params={"AUTOLAND_CLIMB": 80.0})
    flight.plane.set_mode(Mode.AUTOLAND)
    assert flight.run(60, lambda: flight.plane.alt_rel_home_m > 79)


class Plateau:
    """Terrain 30 m above home, everywhere."""

    def __init__(self, home_alt_amsl_m: float) -> None:
        self._alt_m = home_alt_amsl_m + 30.0

    def height_m(self, _lat_deg: float, _lon_deg: float) -> float:
        return self._alt_m

    below_m = height_m


@pytest.mark.parametrize(("terrain_follow", "above_m"), [(0, 0.0), (1, 30.0), (1 << 12, 30.0)])
def test_autoland_counts_its_altitudes_from_the_terrain_when_asked(terrain_follow: int, above_m: float) -> None:
    """TERRAIN_FOLLOW: all modes, or bit 12; the climb and the circle, not the point of the final approach."""
    flight = airborne(params={"TERRAIN_FOLLOW": terrain_follow, "AUTOLAND_CLIMB": 60.0, "AUTOLAND_WP_ALT": 40.0})
    plane = flight.plane
    plane.ground = Plateau(plane.home.alt_m)
    plane.set_mode(Mode.AUTOLAND)
    assert plane.nav.next.alt_m - plane.home.alt_m == pytest.approx(60.0 + above_m + 10.0)
    assert flight.run(300, flight.saying("Loiter to alt complete"))
    assert plane.alt_rel_home_m == pytest.approx(40.0 + above_m, abs=6)
    assert plane.nav.previous.alt_m - plane.home.alt_m == pytest.approx(40.0)


@pytest.mark.parametrize("has_direction", [True, False])
def test_failsafes_that_end_in_autoland(has_direction: bool) -> None:
    """FS_LONG_ACTN 5 (events.cpp): AUTOLAND, or RTL where that is refused."""
    flight = airborne(params={"FS_LONG_ACTN": 5.0})
    if not has_direction:
        flight.plane.takeoff_course_rad = None
    flight.plane.failsafe_gcs(True)
    flight.run(0.1)
    name = "Autoland" if has_direction else "RTL"
    assert flight.texts[-1] == f"GCS Failsafe On: switched to {name}"


def launch(**options: object) -> Flight:
    flight = make(mission(TAKEOFF, waypoint(0, 0, 300, 60), waypoint(0, 300, 300, 60)), **options)  # type: ignore[arg-type]
    flight.plane.set_mode(Mode.AUTO)
    assert flight.plane.arm() is MavResult.ACCEPTED
    return flight


def test_a_motor_that_waits_for_the_throw_waits_without_a_word() -> None:
    """Plane::auto_takeoff_check: nothing is told, the motor is off, until TKOFF_THR_MINACC is felt."""
    flight = launch(params={"TKOFF_THR_MINACC": 12.0})
    flight.run(12)
    assert flight.texts == ["Mission: 1 Takeoff", "Throttle armed"]
    shot = flight.plane.snapshot()
    assert (shot.throttle_pct, shot.landed_state) == (0, LandedState.ON_GROUND)


def test_a_hand_launch_is_felt() -> None:
    flight = launch(params={"TKOFF_THR_MINACC": 12.0, "TKOFF_THR_MINSPD": 4.0}, launch="hand")
    assert flight.run(8, flight.saying("Armed AUTO"))
    assert flight.texts[-1].startswith("Armed AUTO, xaccel = 25.0 m/s/s, waiting 0.2 sec")
    assert flight.plane.time_s > 22 + 3.9
    assert flight.run(20, flight.saying("Takeoff complete"))
    assert flight.said("Triggered AUTO. GPS speed = ")


def test_a_launch_that_stays_slow_is_armed_again_and_again() -> None:
    """Without TKOFF_THR_MINACC, but with a speed that is not reached: the same text every two seconds."""
    flight = launch(params={"TKOFF_THR_MINSPD": 4.0})
    flight.run(8.5)
    assert sum(text.startswith("Armed AUTO") for text in flight.texts) == 5
    assert flight.plane.snapshot().throttle_pct == 0
