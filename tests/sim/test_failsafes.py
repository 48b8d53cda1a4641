"""Failsafes of battery, remote control and ground station, on the ground and in the air."""

from __future__ import annotations

import math
from collections.abc import Mapping

import pytest
from vencejo import Home, MissionItem, Plan, load_params
from vencejo.sim.autopilot.interface import MavResult, Mode, StatusText, SystemState
from vencejo.what_if import what_if

from tests.sim.flying import CAPTURES, FRAME, HOME, Flight, at, make, mission, off_track, waypoint

ALL_MAH = 3300.0
"""A threshold that is crossed as soon as any charge is drawn."""


def armed(mode: Mode = Mode.MANUAL, *, params: Mapping[str, float] | None = None) -> Flight:
    """An armed plane on the ground, which is enough for its failsafes."""
    flight = make(
        mission(waypoint(1, 900.0, 0.0, 60.0), at(2, 189, 0.0, 0.0, 0.0), at(3, 21, 0.0, 0.0, 0.0)), params=params
    )
    assert flight.plane.arm(force=True) is MavResult.ACCEPTED
    assert flight.plane.set_mode(mode) is MavResult.ACCEPTED
    flight.run(0.1)
    flight.events.clear()
    return flight


def warnings(flight: Flight) -> list[str]:
    """Its texts of severity WARNING."""
    return [event.text for _, event in flight.events if isinstance(event, StatusText) and event.severity == 4]


@pytest.mark.parametrize(
    ("act", "mode", "after", "says"),
    [
        (0, Mode.CRUISE, Mode.CRUISE, None),
        (1, Mode.CRUISE, Mode.RTL, None),
        (2, Mode.CRUISE, Mode.AUTO, "Landing sequence start"),
        (6, Mode.CRUISE, Mode.AUTO, "Landing sequence start"),
        (3, Mode.CRUISE, Mode.CRUISE, "AFS not enabled, can't terminate the vehicle"),
        (5, Mode.CRUISE, Mode.CRUISE, None),
    ],
)
def test_a_battery_at_its_mark(act: int, mode: Mode, after: Mode, says: str | None) -> None:
    flight = armed(mode, params={"BATT_FS_LOW_ACT": act})
    before = flight.plane.snapshot()
    assert (before.battery_failsafe, before.system_state) == (0, SystemState.STANDBY)
    flight.params.set("BATT_LOW_MAH", ALL_MAH)
    flight.run(0.3)
    shot = flight.plane.snapshot()
    assert warnings(flight) == [
        f"Battery 1 is low {shot.battery_voltage_v:.2f}V used {shot.battery_consumed_mah:.0f} mAh"
    ]
    assert (shot.mode, shot.battery_failsafe, shot.system_state) == (after, 1, SystemState.CRITICAL)
    assert says is None or flight.said(says)


def test_a_second_mark_is_told_and_does_nothing_less_grave() -> None:
    flight = armed(Mode.CRUISE, params={"BATT_FS_LOW_ACT": 2, "BATT_FS_CRT_ACT": 1})
    flight.params.set("BATT_LOW_MAH", ALL_MAH)
    flight.run(0.3)
    flight.plane.set_mode(Mode.CRUISE)
    flight.params.set("BATT_CRT_MAH", ALL_MAH)
    flight.run(0.3)
    assert [text.split()[3] for text in warnings(flight)] == ["low", "critical"]
    assert (flight.plane.flight_mode, flight.plane.snapshot().battery_failsafe) == (Mode.CRUISE, 2)
    flight.params.set("BATT_LOW_MAH", 0.0)
    flight.params.set("BATT_CRT_MAH", 0.0)
    flight.run(0.3)
    assert flight.plane.snapshot().battery_failsafe == 2, "until it is switched on anew"


def test_a_voltage_has_to_stay_low_and_counts_in_flight_alone() -> None:
    flight = make(params={"BATT_LOW_VOLT": 20.0, "BATT_LOW_TIMER": 3.0, "BATT_FS_LOW_ACT": 1})
    flight.run(5.0)
    assert warnings(flight) == []
    flight.plane.arm(force=True)
    flight.run(2.9)
    assert warnings(flight) == []
    flight.run(0.3)
    assert len(warnings(flight)) == 1
    assert flight.plane.flight_mode is Mode.RTL
    # Without the sag of the load the voltage is above its threshold.
    pack = flight.plane.battery
    resting = armed(params={"BATT_LOW_VOLT": pack.voltage_v + 0.005, "BATT_LOW_TIMER": 1.0, "BATT_FS_VOLTSRC": 1})
    resting.run(2.0)
    assert warnings(resting) == []


@pytest.mark.parametrize(
    ("short", "long", "mode", "at_short", "at_long"),
    [
        (0, 0, Mode.MANUAL, Mode.CIRCLE, Mode.RTL),
        (2, 2, Mode.MANUAL, Mode.FBWA, Mode.FBWA),
        (4, 4, Mode.CRUISE, Mode.FBWB, Mode.AUTO),
        (0, 0, Mode.AUTO, Mode.AUTO, Mode.AUTO),
        (1, 0, Mode.AUTO, Mode.CIRCLE, Mode.RTL),
        (0, 1, Mode.AUTO, Mode.AUTO, Mode.RTL),
        (1, 1, Mode.RTL, Mode.RTL, Mode.RTL),
    ],
)
def test_a_remote_control_that_falls_silent(short: int, long: int, mode: Mode, at_short: Mode, at_long: Mode) -> None:
    flight = armed(mode, params={"FS_SHORT_ACTN": short, "FS_LONG_ACTN": long})
    flight.params.set("SIM_RC_FAIL", 1)
    flight.run(1.0)
    assert warnings(flight) == []
    flight.run(0.4)
    switched = "RC Short Failsafe On" if at_short is mode else f"RC Short Failsafe: switched to {at_short.full_name}"
    assert warnings(flight) == ["Throttle failsafe on", switched]
    shot = flight.plane.snapshot()
    assert (shot.mode, shot.radio_lost, shot.system_state) == (at_short, True, SystemState.CRITICAL)
    flight.run(3.4)  # FS_LONG_TIMEOUT counts from the last valid frame, not from the short failsafe
    assert flight.plane.flight_mode is at_short
    flight.run(0.4)
    assert flight.plane.flight_mode is at_long
    assert warnings(flight)[2:] == [f"RC Long Failsafe On: switched to {at_long.full_name}"]
    flight.params.set("SIM_RC_FAIL", 0)
    flight.run(0.2)
    assert warnings(flight)[3:] == ["Throttle failsafe off", "RC Long Failsafe Cleared"]
    shot = flight.plane.snapshot()
    assert (shot.mode, shot.radio_lost, shot.system_state) == (at_long, False, SystemState.STANDBY)


def test_a_remote_control_that_comes_back_soon_gets_its_mode_back() -> None:
    flight = armed(Mode.FBWB)
    flight.params.set("SIM_RC_FAIL", 2)  # the throttle drops below THR_FS_VALUE: there is no time-out
    flight.run(0.4)
    shot = flight.plane.snapshot()
    assert (shot.mode, shot.rc_pwm_us[2]) == (Mode.CIRCLE, 950)
    flight.params.set("SIM_RC_FAIL", 0)
    flight.run(0.2)
    assert flight.plane.flight_mode is Mode.FBWB
    assert flight.texts[-3:] == [
        "Throttle failsafe off",
        "RC Short Failsafe Cleared",
        "Flight mode FBWB restored",
    ]


@pytest.mark.parametrize(
    ("params", "after"),
    [
        ({"THR_FAILSAFE": 0}, Mode.MANUAL),
        ({"THR_FAILSAFE": 2}, Mode.MANUAL),
        ({"FS_SHORT_ACTN": 3, "FS_LONG_TIMEOUT": 3.0}, Mode.RTL),
    ],
)
def test_a_remote_control_that_nobody_waits_for(params: Mapping[str, float], after: Mode) -> None:
    flight = armed(params=params)
    flight.params.set("SIM_RC_FAIL", 1)
    flight.run(2.8)
    assert flight.plane.flight_mode is Mode.MANUAL
    flight.run(0.5)  # without a short failsafe too, the long one counts from the last valid frame
    assert flight.plane.flight_mode is after


def test_a_receiver_that_was_never_heard_keeps_it_from_arming_even_by_force() -> None:
    """AP_Arming_Plane::rc_received_if_enabled_check is mandatory; before the first frame there is no failsafe."""
    flight = make(params={"SIM_RC_FAIL": 1})
    assert warnings(flight) == []
    for force in (False, True):
        assert flight.plane.arm(force=force) is MavResult.FAILED
        assert flight.plane.events()[-1] == StatusText(2, "Arm: Waiting for RC")
    assert flight.plane.snapshot().waits_for_radio
    flight.params.set("THR_FAILSAFE", 0)
    flight.run(0.2)
    assert flight.plane.arm(force=True) is MavResult.ACCEPTED


def test_overrides_are_heard_without_a_transmitter() -> None:
    flight = armed()
    flight.plane.rc_input({1: 1700, 3: 1500})
    flight.params.set("SIM_RC_FAIL", 1)
    flight.run(3.0)
    assert (flight.plane.flight_mode, warnings(flight)) == (Mode.MANUAL, [])
    flight.plane.rc_input({3: 900})
    flight.run(0.1)
    assert (flight.plane.rc.stick(1), flight.plane.rc.throttle()) == (0.0, 0.0), "it is not believed any more"
    flight.run(0.3)
    assert flight.plane.flight_mode is Mode.CIRCLE


def test_a_landing_is_not_broken_off() -> None:
    marks = {"BATT_FS_LOW_ACT": 1.0, "FS_LONG_ACTN": 1.0}
    flight = armed(Mode.AUTO, params=marks)
    flight.plane.set_mission_current(2)
    flight.run(0.2)
    flight.params.set("BATT_LOW_MAH", ALL_MAH)
    flight.params.set("SIM_RC_FAIL", 1)
    flight.run(8.0)
    assert len(warnings(flight)) >= 1
    assert flight.plane.flight_mode is Mode.AUTO


def test_a_battery_failsafe_flies_as_the_what_if_says() -> None:
    """North, then east, and from there home by RTL: both tools say the same of the same parameters."""
    parameters = {**load_params(CAPTURES / "arduplane-params.parm"), "SIM_RATE_HZ": 100.0, "BATT_FS_LOW_ACT": 1.0}
    legs = [(700.0, 0.0), (700.0, 2000.0)]
    flight = make(
        mission(at(1, 22, 0.0, 0.0, 50.0, 10.0), *(waypoint(1, *leg, 80.0) for leg in legs)),
        params={**parameters, "BATT_LOW_MAH": 0.0},
        heading_deg=0.0,
    )
    flight.plane.set_mode(Mode.AUTO)
    assert flight.plane.arm() is MavResult.ACCEPTED
    assert flight.run(120.0, lambda: flight.position()[1] > 800.0)
    east = flight.position()[1]
    flight.track.clear()
    flight.params.set("BATT_LOW_MAH", ALL_MAH)
    flight.run(60.0)
    assert flight.plane.flight_mode is Mode.RTL

    items = [MissionItem.takeoff(*HOME[:2], alt_rel_home_m=50.0, pitch_deg=10.0)]
    items += [MissionItem.waypoint(*FRAME.to_earth(*leg), alt_rel_home_m=80.0) for leg in legs]
    plan = Plan(home=Home(*HOME[:2], alt_amsl_m=HOME[2]), items=tuple(items))
    moments = [0.5 * half for half in range(110, 170)]
    told = what_if(plan, moments, ["battery-low"], parameters={**parameters, "BATT_LOW_MAH": 1.0}, heading_deg=0.0)
    same = next(one for one in told if FRAME.to_plane(one.at.lat_deg, one.at.lon_deg)[1] > east)
    assert same.reaction == "returns"
    assert same.decisions[0].time_s == same.at.time_s
    assert same.flown is not None
    way = [
        FRAME.to_plane(moment.lat_deg, moment.lon_deg) for moment in same.flown.track if moment.time_s >= same.at.time_s
    ]
    flown = [(north, east) for _, north, east, _ in flight.track]
    across = [off_track(point, way) for point in flown[::10]]
    assert max(across) < 12.0, across
    assert math.dist(flown[-1], way[round(5 * 60.0)]) < 20.0
