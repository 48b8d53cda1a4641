"""Modes, commands and failsafes of the simulated plane, without a link."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import pytest
from vencejo.sim.autopilot.auto.names import Cmd
from vencejo.sim.autopilot.interface import (
    FenceBreach,
    HomeChanged,
    LandedState,
    MavResult,
    MissionState,
    Mode,
    RallyPoint,
    RepositionTarget,
    StatusText,
    StoredItem,
)
from vencejo.sim.autopilot.testing import item

from tests.sim.flying import (
    FRAME,
    HOME,
    SETTLED_S,
    Flight,
    airborne,
    at,
    fly_mission,
    make,
    mission,
    recorded_mission,
    recorded_texts,
    waypoint,
)

TWELVE = "mission-upload-items.tlog"


def bank_deg(flight: Flight) -> float:
    return math.degrees(flight.plane.est.roll_rad)


def test_it_refuses_modes_it_does_not_have() -> None:
    flight = make(settle=False)
    assert flight.plane.set_mode(99) is MavResult.FAILED
    (_, event), *_ = [(0.0, event) for event in flight.plane.events() if isinstance(event, StatusText)]
    assert event == StatusText(4, "No such mode 99")
    assert event.text in recorded_texts("arm-refused-and-modes.tlog")


def test_return_to_launch_does_not_arm() -> None:
    flight = make()
    assert flight.plane.set_mode(Mode.RTL) is MavResult.ACCEPTED
    assert flight.plane.arm() is MavResult.FAILED
    assert StatusText(2, "Arm: RTL mode not armable") in flight.plane.events()
    assert not flight.plane.armed


@pytest.mark.parametrize("mode", [Mode.LOITER, Mode.CIRCLE, Mode.GUIDED])
def test_the_other_automatic_modes_arm_on_the_ground(mode: Mode) -> None:
    """mode.h: of those flown here only RTL and INITIALISING override ``_pre_arm_checks``."""
    flight = make()
    flight.plane.set_mode(mode)
    assert flight.plane.arm() is MavResult.ACCEPTED
    flight.run(2)
    assert (flight.plane.armed, flight.plane.snapshot().throttle_pct) == (True, 0)


def test_prearm_checks_refuse_and_force_overrides() -> None:
    flight = make()
    flight.plane.prearm = lambda: ["Battery low"]
    assert flight.plane.arm() is MavResult.FAILED
    assert StatusText(2, "Arm: Battery low") in flight.plane.events()
    assert flight.plane.arm(force=True) is MavResult.ACCEPTED
    assert flight.plane.disarm() is MavResult.ACCEPTED


def test_it_does_not_disarm_in_flight() -> None:
    flight = airborne()
    assert flight.plane.disarm() is MavResult.FAILED
    assert flight.plane.armed
    assert flight.plane.disarm(force=True) is MavResult.ACCEPTED
    assert not flight.plane.armed


def test_takeoff_mode_climbs_and_circles_ahead() -> None:
    flight = make(heading_deg=90)
    flight.plane.set_mode(Mode.TAKEOFF)
    flight.plane.arm()
    flight.run(60)
    assert flight.said("Takeoff to 50m for 200.0m heading")
    assert flight.said("Takeoff level-off starting at")
    assert flight.plane.alt_rel_home_m == pytest.approx(50, abs=4)
    north, east = flight.position()
    assert math.hypot(north, east - 200) < 115.0


def test_manual_sticks_move_the_surfaces_both_ways() -> None:
    flight = make()
    flight.plane.rc_input({1: 2000, 2: 1000, 3: 1000, 4: 2000})
    flight.run(0.5)
    shot = flight.plane.snapshot()
    assert shot.servo_pwm_us[:4] == (1900, 1100, 1000, 1900)
    flight.plane.rc_input({1: None, 2: None, 4: None})
    flight.run(0.5)
    assert flight.plane.snapshot().servo_pwm_us[0] == 1500
    assert flight.plane.snapshot().throttle_pct == 0


@pytest.mark.parametrize("mode", [Mode.FBWA, Mode.STABILIZE])
def test_fbwa_and_stabilize_bank_with_the_stick_and_level_without(mode: Mode) -> None:
    flight = airborne()
    flight.plane.set_mode(mode)
    flight.plane.rc_input({1: 1700, 3: 1650})
    flight.run(3)
    assert 15 < bank_deg(flight) < 60
    flight.plane.rc_input({1: None})
    flight.run(3)
    assert abs(bank_deg(flight)) < 3


def test_manual_flies_with_the_sticks() -> None:
    flight = airborne()
    flight.plane.set_mode(Mode.MANUAL)
    flight.plane.rc_input({1: 1650, 3: 1600})
    flight.run(0.6)
    assert bank_deg(flight) > 25


def test_fbwb_holds_height_and_the_throttle_stick_sets_the_speed() -> None:
    flight = airborne()
    flight.plane.rc_input({3: 1600})
    flight.plane.set_mode(Mode.FBWB)
    start = flight.plane.est.alt_m
    flight.run(40)
    assert flight.plane.est.alt_m == pytest.approx(start, abs=2)
    wanted = 10 + 20 * flight.plane.rc.throttle()
    assert flight.plane.est.airspeed_m_s == pytest.approx(wanted, abs=0.7)
    flight.plane.rc_input({2: 2000})
    flight.run(10)
    start = flight.plane.est.alt_m
    flight.run(10)
    assert flight.plane.est.alt_m == pytest.approx(start + 20, abs=2), "FBWB_CLIMB_RATE is 2 m/s"


def test_cruise_holds_its_course_over_ground() -> None:
    flight = airborne(wind_m_s=5, wind_from_deg=0)
    flight.plane.rc_input({3: 1600})
    flight.plane.set_mode(Mode.CRUISE)
    flight.run(20)
    first = flight.position()
    flight.run(20)
    middle = flight.position()
    flight.run(20)
    last = flight.position()
    one = math.atan2(middle[1] - first[1], middle[0] - first[0])
    two = math.atan2(last[1] - middle[1], last[0] - middle[0])
    assert abs(math.degrees(one - two)) < 2


def test_circle_banks_a_third_and_loiter_stays_where_it_was() -> None:
    flight = airborne(wind_m_s=4, wind_from_deg=90)
    flight.plane.set_mode(Mode.CIRCLE)
    flight.run(10)
    assert bank_deg(flight) == pytest.approx(flight.plane.bank_limit_deg() / 3, abs=3)
    flight.plane.set_mode(Mode.LOITER)
    centre = flight.plane.nav.next.copy()
    flight.run(90)
    north, east = flight.position()
    radius = 80 * flight.plane.est.eas_to_tas**2
    assert math.hypot(north - centre.n_m, east - centre.e_m) == pytest.approx(radius, abs=15)


def test_guided_goes_there_and_circles_as_asked() -> None:
    flight = airborne()
    target = at(0, 16, 600, 300, 90)
    order = RepositionTarget(target.lat_deg, target.lon_deg, 90.0, 3, radius_m=-120.0)
    assert flight.plane.reposition(order) is MavResult.ACCEPTED
    assert flight.plane.mode.number is Mode.GUIDED
    assert flight.plane.change_speed(0, 18.0, -1.0) is MavResult.ACCEPTED
    flight.run(120)
    assert flight.reached == [0]
    assert "Set airspeed 18 m/s" in flight.texts
    north, east = flight.position()
    radius = 120 * flight.plane.est.eas_to_tas**2
    assert math.hypot(north - 600, east - 300) == pytest.approx(radius, abs=12)
    assert flight.plane.alt_rel_home_m == pytest.approx(90, abs=3)
    assert bank_deg(flight) < -5
    assert flight.plane.est.airspeed_m_s == pytest.approx(18, abs=0.8)


def test_guided_takes_height_heading_and_speed() -> None:
    flight = airborne()
    plane = flight.plane
    assert plane.change_guided_altitude(70, 3, 1.0) is MavResult.FAILED
    plane.set_mode(Mode.GUIDED)
    flight.run(10)
    start_m = plane.alt_rel_home_m
    # At a rate it hardly climbs: in ArduPlane 4.8-dev's own simulator 5 m in 15 s, for 10 m/s.
    assert plane.change_guided_altitude(80, 3, 10.0) is MavResult.ACCEPTED
    flight.run(15)
    assert plane.alt_rel_home_m == pytest.approx(start_m + 4.5, abs=3)
    assert plane.change_guided_altitude(80, 3, 0.0) is MavResult.ACCEPTED
    flight.run(30)
    assert plane.alt_rel_home_m == pytest.approx(80, abs=3)
    # Until GUIDED is left that altitude wins over those of a later point and of DO_CHANGE_ALTITUDE.
    plane.change_altitude(60, 3)
    plane.reposition(RepositionTarget(None, None, 50.0))
    flight.run(15)
    assert plane.alt_rel_home_m == pytest.approx(80, abs=3)
    assert plane.change_heading(1, 45.0, 4.0) is MavResult.ACCEPTED
    flight.run(30)
    assert math.degrees(plane.est.yaw_rad) == pytest.approx(45, abs=3)
    assert plane.change_speed(0, 16.0, -1.0) is MavResult.ACCEPTED
    assert plane.change_speed(0, 99.0, -1.0) is MavResult.FAILED
    assert plane.change_guided_speed(16.0, 0.0) is MavResult.ACCEPTED
    assert plane.change_speed(0, 25.0, -1.0) is MavResult.ACCEPTED, "and has no effect while the other is held"
    # Without losing height a glider-like frame needs half a minute to slow down by 6 m/s.
    flight.run(40)
    assert plane.est.airspeed_m_s == pytest.approx(16, abs=0.8)
    assert plane.change_heading(2, 0.0, 0.0) is MavResult.ACCEPTED


def test_guided_flies_an_attitude_for_three_seconds() -> None:
    """SET_ATTITUDE_TARGET counts for GUIDED_TIMEOUT (ModeGuided::update), then the point is flown to again."""
    flight = airborne()
    flight.plane.set_mode(Mode.GUIDED)
    flight.plane.force_attitude(math.radians(-30.0), None, 0.8)
    flight.run(2)
    assert bank_deg(flight) == pytest.approx(-30, abs=4)
    assert flight.plane.snapshot().throttle_pct == pytest.approx(80, abs=2)
    flight.run(3)
    assert abs(bank_deg(flight) + 30) > 10, "it circles again"
    before_m = flight.plane.nav.next.alt_m - flight.plane.home.alt_m
    flight.plane.raise_target(10.0)
    flight.run(0.1)
    assert flight.texts[-1] == f"Change alt to {before_m + 10.0:.1f}"


@pytest.mark.parametrize("speed_m_s", [20.0, 50.0, 100.0])
def test_a_dive_into_the_ground_ends_on_it(speed_m_s: float) -> None:
    """JSBSim's integration diverges in such an impact, to NaN."""
    flight = airborne()
    body = flight.plane.body
    lat_deg, lon_deg = body.lat_deg, body.lon_deg
    body.place(lat_deg, lon_deg, 0.0, height_m=10.0, pitch_rad=math.radians(-85.0), speed_m_s=speed_m_s)
    flight.plane.set_mode(Mode.MANUAL)
    flight.run(10)
    assert body.on_wheels
    assert (body.lat_deg, body.lon_deg) == pytest.approx((lat_deg, lon_deg), abs=1e-3)
    assert flight.plane.est.groundspeed_m_s < 1.0


@pytest.mark.parametrize("mode", [Mode.AUTO, Mode.LOITER, Mode.CIRCLE, Mode.RTL, Mode.GUIDED])
def test_the_altitude_can_be_changed_in_every_mode_that_navigates(mode: Mode) -> None:
    flight = airborne(mission(waypoint(0, 3000, 0, 60)))
    plane = flight.plane
    plane.set_mode(mode)
    flight.run(1)
    assert plane.change_altitude(75, 3) is MavResult.ACCEPTED
    flight.run(20)
    assert plane.mode.number is mode
    assert plane.alt_rel_home_m == pytest.approx(75, abs=3)


def test_an_altitude_change_during_a_landing_moves_the_landing_point() -> None:
    """GCS_MAVLINK_Plane::handle_change_alt_request ignores the flight stage: a point above the plane makes it flare."""
    flight = airborne(mission(item(0, 189), waypoint(0, 0, 900, 60), at(0, 21, 0, 60, 0)))
    plane = flight.plane
    assert plane.do_mission_command(item(0, 189)) is MavResult.ACCEPTED
    assert flight.run(200, lambda: plane.landing.active and plane.alt_rel_home_m < 40)
    assert plane.change_altitude(60, 3) is MavResult.ACCEPTED
    flight.run(2)
    assert any(text.startswith("Flare -") for text in flight.texts), flight.texts[-3:]
    assert (plane.alt_rel_home_m > 30, plane.snapshot().throttle_pct) == (True, 0)


@pytest.mark.parametrize(
    "target",
    [
        RepositionTarget(95.0, 0.0, 50.0),
        RepositionTarget(math.nan, 0.0, 50.0),
        RepositionTarget(40.0, -3.0, 50.0, frame=7),
        RepositionTarget(40.0, -3.0, 50.0, change_mode=False),
    ],
)
def test_nonsense_is_not_flown_to(target: RepositionTarget) -> None:
    flight = airborne()
    assert flight.plane.reposition(target) is MavResult.DENIED
    assert flight.plane.mode.number is Mode.TAKEOFF


def test_rtl_comes_home_at_its_height() -> None:
    flight = airborne()
    flight.plane.set_mode(Mode.RTL)
    flight.run(60)
    assert flight.plane.alt_rel_home_m == pytest.approx(100, abs=4)
    assert math.hypot(*flight.position()) < 115


def test_rtl_prefers_a_nearer_rally_point() -> None:
    near, far = at(0, 16, 0, -400, 0), at(0, 16, 3000, 0, 0)
    flight = airborne(
        rally=[RallyPoint(near.lat_deg, near.lon_deg, 70.0), RallyPoint(far.lat_deg, far.lon_deg, 70.0)],
    )
    flight.plane.set_mode(Mode.RTL)
    flight.run(60)
    north, east = flight.position()
    assert math.hypot(north, east + 400) < 115
    assert flight.plane.alt_rel_home_m == pytest.approx(70, abs=4)


@pytest.mark.parametrize("autoland", [1, 2])
def test_rtl_lands_when_it_may(autoland: int) -> None:
    flight = airborne(
        mission(waypoint(0, 0, -900, 60), item(0, 189), waypoint(0, 0, 700, 40), at(0, 21, 0, 60, 0)),
        params={"RTL_AUTOLAND": autoland},
    )
    flight.plane.set_mode(Mode.RTL)
    assert flight.run(400, lambda: not flight.plane.armed), flight.texts
    assert flight.said("Landing sequence start")
    assert flight.plane.mode.number is Mode.AUTO
    assert "Mission: 2 LandStart" in flight.texts
    assert math.hypot(flight.position()[0], flight.position()[1] - 60) < 20


def final(*abort: StoredItem, height_m: float = 20.0) -> Flight:
    """A plane on its final approach, with items behind the landing to abort it by."""
    flight = airborne(mission(item(0, 189), waypoint(0, 0, 900, 50), at(0, 21, 0, 60, 0), *abort))
    assert flight.plane.do_mission_command(item(0, 189)) is MavResult.ACCEPTED
    assert flight.run(200, lambda: flight.plane.landing.active and flight.plane.alt_rel_home_m < height_m)
    return flight


def test_a_landing_is_aborted_by_the_nearest_planned_pattern() -> None:
    """Plane::trigger_land_abort: before any climb, the mission goes on at its nearest DO_GO_AROUND."""
    far, near = at(0, 191, 3000, 0, 0), at(0, 191, 0, -200, 0)
    flight = final(far, waypoint(0, 3000, 500, 80), near, waypoint(0, 0, -700, 70))
    assert flight.plane.abort_landing(120.0) is MavResult.ACCEPTED
    flight.run(1)
    assert flight.plane.mission.current_seq == 7
    assert "Landing abort sequence start" in flight.texts
    assert not flight.said("Landing aborted")
    assert not flight.plane.mission.in_landing_sequence
    assert flight.run(120, lambda: flight.said("Reached waypoint #7"))


@pytest.mark.parametrize(("asked_m", "climbs_to"), [(0.0, "50m"), (120.0, "120m")])
def test_a_landing_without_such_a_pattern_is_aborted_straight_ahead(asked_m: float, climbs_to: str) -> None:
    flight = final()
    assert flight.plane.abort_landing(asked_m) is MavResult.ACCEPTED
    flight.run(0.2)
    assert "Unable to start find a landing abort sequence" in flight.texts
    assert f"Landing aborted, climbing to {climbs_to}" in flight.texts
    assert flight.plane.abort_landing(0.0) is MavResult.ACCEPTED, "it is aborting already"


def test_land_start_and_go_around_as_commands() -> None:
    flight = airborne(mission(waypoint(0, 0, -900, 60), item(0, 189), waypoint(0, 0, 800, 50), at(0, 21, 0, 60, 0)))
    plane = flight.plane
    assert plane.abort_landing(0.0) is MavResult.FAILED
    assert plane.do_mission_command(item(0, 189)) is MavResult.ACCEPTED
    assert flight.run(200, lambda: plane.landing.active and plane.alt_rel_home_m < 20)
    assert plane.abort_landing(0.0) is MavResult.ACCEPTED
    assert flight.run(60, lambda: plane.alt_rel_home_m > 40), flight.texts
    assert flight.said("Landing aborted, climbing to")
    assert flight.run(400, lambda: not plane.armed)
    assert flight.said("Restarted landing via DO_LAND_START: 2")
    assert math.hypot(flight.position()[0], flight.position()[1] - 60) < 20
    assert plane.do_mission_command(item(0, 186)) is MavResult.UNSUPPORTED


def test_the_return_path_is_joined_at_its_nearest_waypoint() -> None:
    path = mission(
        waypoint(0, 0, -2000, 60),
        item(0, 188),
        waypoint(0, 2000, 0, 60),
        waypoint(0, 400, 0, 60),
        item(0, 189),
        waypoint(0, 0, 800, 40),
        at(0, 21, 0, 60, 0),
    )
    flight = airborne(path, params={"RTL_AUTOLAND": 4})
    flight.plane.set_mode(Mode.RTL)
    flight.run(1)
    assert flight.said("Return path started")
    assert flight.plane.mission.current_seq == 4


def test_the_mission_can_be_left_resumed_and_moved() -> None:
    flight = make(recorded_mission(TWELVE))
    plane = flight.plane
    assert plane.mission_start() is MavResult.ACCEPTED
    plane.arm()
    flight.run(40)
    assert plane.snapshot().mission_current == 3
    plane.set_mode(Mode.LOITER)
    flight.run(20)
    assert plane.snapshot().mission_state is MissionState.NOT_STARTED
    plane.set_mode(Mode.AUTO)
    flight.run(2)
    assert plane.snapshot().mission_current == 3
    assert plane.set_mission_current(6) is MavResult.ACCEPTED
    assert plane.snapshot().mission_current == 6
    assert plane.set_mission_current(60) is MavResult.FAILED
    assert flight.run(120, lambda: flight.said("Reached waypoint #6"))


def test_the_end_of_a_mission_is_rtl() -> None:
    flight = make(mission(at(0, 22, 0, -300, 50, 12), waypoint(0, 0, -500, 60)))
    flight.plane.set_mode(Mode.AUTO)
    flight.plane.arm()
    assert flight.run(100, lambda: flight.said("Mission complete, changing mode to RTL"))
    assert flight.plane.mode.number is Mode.RTL
    assert flight.plane.snapshot().mission_state is MissionState.COMPLETE


@pytest.mark.parametrize(
    ("action", "mode", "after"),
    [
        (0, Mode.GUIDED, Mode.GUIDED),
        (1, Mode.GUIDED, Mode.RTL),
        (0, Mode.LOITER, Mode.RTL),
        (2, Mode.LOITER, Mode.FBWA),
    ],
)
def test_losing_the_ground_station(action: int, mode: Mode, after: Mode) -> None:
    flight = airborne(params={"FS_LONG_ACTN": action})
    flight.plane.set_mode(mode)
    flight.plane.failsafe_gcs(True)
    flight.run(0.2)
    assert flight.plane.mode.number is after
    assert f"GCS Failsafe On: switched to {after.full_name}" in flight.texts
    assert flight.plane.snapshot().gcs_failsafe
    flight.plane.failsafe_gcs(False)
    flight.run(0.2)
    assert "GCS Failsafe Cleared" in flight.texts


def test_no_failsafe_while_it_lands() -> None:
    flight = make(recorded_mission(TWELVE), params={"FS_LONG_ACTN": 1})
    flight.plane.set_mode(Mode.AUTO)
    flight.plane.arm()
    assert flight.run(300, lambda: flight.said("Landing glide slope"))
    flight.plane.failsafe_gcs(True)
    flight.run(1)
    assert flight.plane.mode.number is Mode.AUTO


def test_a_crossed_fence_sends_it_home() -> None:
    flight = airborne()
    flight.plane.fence_breached(FenceBreach.POLYGON)
    flight.run(0.2)
    assert "Polygon fence breached" in flight.texts
    assert flight.plane.mode.number is Mode.RTL
    assert flight.plane.set_mode(Mode.LOITER) is MavResult.FAILED
    flight.plane.fence_breached(None)
    flight.run(0.2)
    assert "Fence breach cleared" not in flight.texts, "it is still returning"
    assert "Mode change to Loiter denied, in fence recovery" in flight.texts
    assert flight.plane.set_mode(Mode.LOITER) is MavResult.ACCEPTED
    assert flight.texts.count("Manual recovery started") == 1, "the breach was over at the last mode change"
    flight.plane.fence_breached(FenceBreach.POLYGON)
    flight.run(0.2)
    mode = flight.plane.mode
    assert mode.number is Mode.LOITER, "for 10 s after a mode change during a breach"
    flight.run(10)
    flight.plane.fence_breached(None)
    flight.plane.fence_breached(FenceBreach.POLYGON)
    assert flight.plane.mode.number is Mode.RTL, "a second breach counts as the first"


def test_what_is_answered_while_it_returns_from_a_breach() -> None:
    """Plane::set_mode refuses; MISSION_START and DO_REPOSITION do not look at that, DO_LAND_START does."""
    flight = airborne(mission(waypoint(0, 0, -900, 60), item(0, 189), waypoint(0, 0, 700, 40), at(0, 21, 0, 60, 0)))
    plane = flight.plane
    plane.fence_breached(FenceBreach.POLYGON)
    target = plane.nav.next
    assert plane.do_mission_command(item(0, 189)) is MavResult.FAILED
    assert plane.mission_start() is MavResult.ACCEPTED
    flight.run(0.2)
    assert (plane.mode.number, plane.nav.next) == (Mode.RTL, target)
    assert flight.texts.count("Mode change to Auto denied, in fence recovery") == 2
    point = at(0, 16, 500, 500, 80)
    assert plane.reposition(RepositionTarget(point.lat_deg, point.lon_deg, 80.0)) is MavResult.ACCEPTED
    flight.run(0.2)
    assert (plane.mode.number, round(plane.nav.next.n_m), round(plane.nav.next.e_m)) == (Mode.RTL, 500, 500)


@pytest.mark.parametrize(("action", "after"), [(1.0, Mode.RTL), (6.0, Mode.LOITER)])
def test_a_fence_that_is_disabled_ends_the_return(action: float, after: Mode) -> None:
    """Plane::fence_check: modes may be changed again, and GUIDED gives way to the mode before it."""
    flight = airborne(params={"FENCE_ACTION": action})
    flight.plane.set_mode(Mode.LOITER)
    flight.plane.fence_breached(FenceBreach.POLYGON)
    assert flight.plane.set_mode(Mode.CIRCLE) is MavResult.FAILED
    flight.plane.fence_disabled()
    assert flight.plane.flight_mode is after
    assert flight.plane.set_mode(Mode.CIRCLE) is MavResult.ACCEPTED


def test_a_return_from_a_breach_may_land_by_rtl_autoland() -> None:
    flight = airborne(
        mission(waypoint(0, 0, -900, 60), item(0, 189), waypoint(0, 0, 700, 40), at(0, 21, 0, 60, 0)),
        params={"RTL_AUTOLAND": 2},
    )
    flight.plane.fence_breached(FenceBreach.POLYGON)
    flight.run(0.5)
    assert flight.plane.mode.number is Mode.AUTO
    assert flight.plane.set_mode(Mode.LOITER) is MavResult.FAILED


def test_fence_action_report_only() -> None:
    flight = airborne(params={"FENCE_ACTION": 0})
    flight.plane.fence_breached(FenceBreach.MAX_ALT)
    flight.plane.fence_breached(None)
    flight.run(0.2)
    assert [text for text in flight.texts if "reach" in text] == ["Max Alt fence breached", "Fence breach cleared"]
    assert flight.plane.mode.number is Mode.TAKEOFF


@pytest.mark.parametrize(
    ("params", "altitude_m"),
    [({}, 45), ({"FENCE_RET_ALT": 70}, 70), ({"FENCE_ALT_MAX": -10}, 100)],
    ids=["half way between floor and ceiling", "FENCE_RET_ALT", "RTL_ALTITUDE without room between them"],
)
def test_fence_action_guided_goes_to_the_return_point(params: dict[str, float], altitude_m: float) -> None:
    flight = airborne(params={"FENCE_ACTION": 6, **params})
    point = at(0, 16, 400, 300, 0)
    flight.plane.fence_breached(FenceBreach.POLYGON, (point.lat_deg, point.lon_deg))
    spot = flight.plane.nav.next
    assert flight.plane.mode.number is Mode.GUIDED
    assert (spot.n_m, spot.e_m, spot.alt_m) == pytest.approx((400, 300, 600 + altitude_m), abs=0.1)


def test_a_plane_in_the_hand_shows_its_attitude() -> None:
    flight = make()
    flight.plane.move_by_hand(math.radians(60), math.radians(-30), math.radians(123))
    flight.run(0.5)
    shot = flight.plane.snapshot()
    assert math.degrees(shot.roll_rad) == pytest.approx(60, abs=1)
    assert math.degrees(shot.pitch_rad) == pytest.approx(-30, abs=1)
    assert shot.heading_deg == pytest.approx(123, abs=2)
    x, y, z = shot.accel_m_s2
    assert (x, y, z) == pytest.approx((-4.9, -7.36, -4.25), abs=0.3)
    assert math.hypot(*shot.mag_mgauss) == pytest.approx(
        math.hypot(*make(settle=False).plane.snapshot().mag_mgauss), abs=15
    )
    flight.plane.put_down()
    flight.run(2)
    shot = flight.plane.snapshot()
    assert abs(math.degrees(shot.roll_rad)) < 1
    assert shot.heading_deg == pytest.approx(123, abs=3)


def homes(flight: Flight) -> list[tuple[float, HomeChanged]]:
    return [(time_s, event) for time_s, event in flight.events if isinstance(event, HomeChanged)]


def test_home_follows_a_disarmed_plane_every_six_seconds() -> None:
    """Plane::update_home; recorded at 9.9, 15.5 and 21.5 s after boot, and at once when it disarms."""
    flight = make(settle=False)
    flight.run(SETTLED_S)
    assert [round(time_s) for time_s, _ in homes(flight)] == [10, 16, 19, 22]
    assert {event for _, event in homes(flight)} == {HomeChanged(*HOME)}
    flight.plane.move_by_hand(0.0, 0.0, 0.0, offset_ned_m=(40.0, 0.0, 0.0))
    flight.plane.put_down()
    flight.run(6.5)
    assert FRAME.to_plane(*flight.plane._home_lat_lon) == pytest.approx((40.0, 0.0), abs=0.1)
    flight.plane.arm()
    flight.plane.events()
    flight.run(10.0)
    assert not any(time_s > flight.plane.time_s - 10.0 for time_s, _ in homes(flight)), "armed, it stays"


def test_home_is_at_the_landing_as_soon_as_it_disarms() -> None:
    flight = landed(land_start=True)
    flight.run(0.2)
    lat_deg, lon_deg = flight.plane._home_lat_lon
    assert flight.distance_to(lat_deg, lon_deg) < 0.1
    assert math.hypot(*flight.position()) > 1.0
    assert flight.plane.alt_rel_home_m == pytest.approx(0.0, abs=0.3)


def test_a_home_that_was_set_stays_until_the_next_boot() -> None:
    flight = make()
    plane, far = flight.plane, HomeChanged(40.36, -3.8, 700.0)
    assert plane.set_home(math.inf, -3.0, 700.0) is MavResult.DENIED
    assert plane.set_home(far.lat_deg, far.lon_deg, far.alt_amsl_m) is MavResult.ACCEPTED
    flight.run(7.0)
    plane.arm()
    flight.run(0.2)
    plane.disarm()
    flight.run(7.0)
    assert [event for _, event in homes(flight)] == [far]
    plane.reboot()
    flight.run(SETTLED_S)
    assert homes(flight)[-1][1] == HomeChanged(*HOME)


def test_a_new_home_turns_a_return_at_once() -> None:
    flight = airborne()
    flight.plane.set_mode(Mode.RTL)
    flight.run(2.0)
    new = at(0, 16, 3000, 0, 0)
    assert flight.plane.set_home(new.lat_deg, new.lon_deg, 620.0) is MavResult.ACCEPTED
    assert flight.plane.nav.next.n_m == pytest.approx(3000, abs=1)
    assert flight.plane.nav.next.alt_m == pytest.approx(720, abs=0.1)


def test_home_needs_a_fix_to_be_set_here() -> None:
    flight = make(settle=False)
    assert flight.plane.set_home(None, None, None) is MavResult.FAILED
    flight.run(SETTLED_S)
    assert flight.plane.set_home(None, None, None) is MavResult.ACCEPTED


def test_the_target_is_that_of_the_next_point_in_every_mode_but_manual() -> None:
    """GCS_MAVLINK_Plane::get_target_location; recorded: 640.1 m from the first moment of a leg that descends from 680."""
    flight = airborne(mission(waypoint(0, 0, -600, 90), waypoint(0, 2000, -600, 50)))
    plane = flight.plane
    plane.set_mode(Mode.AUTO)
    assert flight.run(120, lambda: plane.mission.current_seq == 2)
    shot = plane.snapshot()
    assert shot.target_alt_amsl_m == pytest.approx(650)
    assert shot.alt_rel_home_m > 60
    plane.set_mode(Mode.FBWA)
    assert plane.snapshot().target_alt_amsl_m == pytest.approx(650)
    plane.set_mode(Mode.MANUAL)
    assert plane.snapshot().target_alt_amsl_m is None


def test_what_telemetry_shows_on_the_ground_and_in_the_air() -> None:
    flight = make(settle=False)
    start = flight.plane.snapshot()
    assert start.gps_fix_type == 0
    assert start.ekf_flags == 1024
    flight.run(22)
    ground = flight.plane.snapshot()
    assert ground.landed_state is LandedState.ON_GROUND
    assert ground.mission_state is MissionState.NO_MISSION
    assert ground.static_pressure_pa == pytest.approx(94_320, abs=60)
    assert ground.accel_m_s2[2] == pytest.approx(-9.81, abs=0.3)
    assert ground.ekf_flags & 0x1F == 0x1F
    assert not any(math.isnan(value) for value in ground.accel_m_s2 + ground.gyro_rad_s)
    air = airborne(wind_m_s=5, wind_from_deg=70)
    air.run(60)
    shot = air.plane.snapshot()
    assert shot.landed_state is LandedState.IN_AIR
    assert shot.wind_speed_m_s == pytest.approx(5, abs=0.5)
    assert shot.wind_from_deg == pytest.approx(70, abs=5)
    assert shot.differential_pressure_pa == pytest.approx(0.6125 * shot.airspeed_m_s**2, abs=12)


def test_a_reboot_starts_again_where_it_stands() -> None:
    flight = fly_mission(recorded_mission(TWELVE))
    place, volts = flight.position(), flight.plane.battery.voltage_v
    away_m = flight.distance_to(*HOME[:2])
    assert away_m > 30.0
    flight.plane.reboot()
    shot = flight.plane.snapshot()
    assert shot.time_s == 0.0
    assert not shot.armed
    assert shot.mode is Mode.INITIALISING
    assert (shot.lat_deg, shot.lon_deg) == (0.0, 0.0)
    assert (shot.battery_consumed_mah, shot.battery_remaining_pct) == (0.0, 100), "the monitor counts from 0"
    flight.run(SETTLED_S)
    assert flight.position() == pytest.approx(place, abs=0.1)
    shot = flight.plane.snapshot()
    home = FRAME.to_plane(shot.home_lat_deg, shot.home_lon_deg)
    assert home == pytest.approx(place, abs=0.1)
    assert (shot.north_m, shot.east_m) == pytest.approx((0.0, 0.0), abs=1.0)
    assert shot.battery_voltage_v == pytest.approx(volts, abs=0.1), "and the pack is as empty as it was"
    assert shot.battery_voltage_v < 16.7


def test_parameters_are_taken_over_in_flight() -> None:
    flight = airborne()
    flight.params.set("AIRSPEED_CRUISE", 16.0)
    flight.run(40)
    assert flight.plane.est.airspeed_m_s == pytest.approx(16, abs=0.8)


def test_a_mission_cleared_in_flight_ends_in_rtl() -> None:
    flight = make(recorded_mission(TWELVE))
    flight.plane.set_mode(Mode.AUTO)
    flight.plane.arm()
    flight.run(40)
    remove_mission(flight)
    flight.run(30)
    assert flight.plane.armed
    assert flight.plane.est.alt_m > 630.0
    assert flight.plane.mode.number is Mode.RTL


def remove_mission(flight: Flight, following: Sequence[StoredItem] = ()) -> None:
    """Remove the mission, as MISSION_CLEAR_ALL and an upload as a file do."""
    flight.plan.mission = tuple(following)
    flight.plan.mission_clears += 1
    flight.plan.mission_revision += 1


def test_a_mission_that_replaces_another_can_be_started_at_once() -> None:
    """Within the 0.1 s between two updates of the mission: a fast link uploads, checks and starts one in less."""
    flight = airborne()
    plane = flight.plane
    plane.step()
    remove_mission(flight, mission(waypoint(1, 500, 0, 80.0), waypoint(2, 500, 500, 80.0)))
    assert plane.set_mission_current(1) is MavResult.ACCEPTED
    assert plane.set_mode(Mode.AUTO) is MavResult.ACCEPTED
    flight.run(1)
    assert (plane.mode.number, plane.mission.current_seq) == (Mode.AUTO, 1)


def landed(*, land_start: bool) -> Flight:
    """A plane that has flown its mission and disarmed itself in AUTO, at the landing."""
    approach = at(3, Cmd.DO_LAND_START, 0, 450, 40.0) if land_start else waypoint(3, 0, 450, 40.0)
    way = [at(1, Cmd.NAV_TAKEOFF, 0, -200, 40.0, 15.0), waypoint(2, 150, -200, 45.0), approach]
    flight = fly_mission(mission(*way, waypoint(4, 0, 400, 35.0), at(5, Cmd.NAV_LAND, 0, 0, 0.0)))
    assert "Auto disarmed" in flight.texts
    flight.events.clear()
    return flight


@pytest.mark.parametrize("land_start", [True, False], ids=["land start", "without"])
def test_after_a_landing_in_auto_it_stands_in_the_landing_sequence(land_start: bool) -> None:
    """AP_Arming_Plane::pre_arm_checks, Mode::enter, ModeAuto::_exit and update, AP_Mission::clear."""
    flight = landed(land_start=land_start)
    plane = flight.plane
    assert plane.snapshot().mission_in_landing
    # Armed by force it disarms at once: the landing is complete, and it has not flown since.
    assert plane.arm(force=True) is MavResult.ACCEPTED
    flight.run(0.2)
    assert (plane.armed, flight.texts[-2:]) == (False, ["Throttle disarmed", "Auto disarmed"])
    # When its mission is replaced AUTO has none to run, and RTL does not arm.
    again = tuple(flight.plan.mission)
    remove_mission(flight, again)
    flight.run(0.2)
    assert "Aircraft in auto without a running mission" in flight.texts
    assert (plane.mode.number, plane.snapshot().mission_current) == (Mode.RTL, 0)
    assert plane.snapshot().mission_state is MissionState.NOT_STARTED
    assert plane.arm() is MavResult.FAILED
    # MANUAL arms, and AUTO starts at the first item.
    plane.set_mode(Mode.MANUAL)
    assert "In landing sequence: mission reset" in [
        event.text for event in plane.events() if isinstance(event, StatusText)
    ]
    assert plane.arm() is MavResult.ACCEPTED
    plane.set_mode(Mode.AUTO)
    flight.run(30.0, lambda: plane.mission.current_seq == 2)
    assert (plane.mission.current_seq, plane.is_flying) == (2, True)


def test_a_stick_mode_leaves_the_landing_sequence_only_where_it_is_one() -> None:
    """Without DO_LAND_START the mission is at the waypoint before the landing, and would resume there."""
    for land_start, current in ((True, 0), (False, 4)):
        flight = landed(land_start=land_start)
        flight.plane.set_mode(Mode.FBWA)
        assert (flight.plane.mission.current_seq, flight.plane.snapshot().mission_in_landing) == (current, False)
        flight.plane.set_mission_current(0)
        assert flight.plane.mission.current_seq == 1


def test_events_are_bounded() -> None:
    flight = make(settle=False)
    for _ in range(5000):
        flight.plane.set_mode(99)
    assert len(flight.plane.events()) == 1024


def test_items_are_values() -> None:
    entry = item(3, 16, 40.0, -3.0, 50.0)
    assert replace(entry, seq=4).alt_m == 50.0
