"""Modes flown by stick, with the sticks centred and moved, without a link.

What they do with centred sticks was seen in ArduPlane 4.8-dev's own simulator: level from a bank, no throttle.
"""

from __future__ import annotations

import math

import pytest
from vencejo.sim.autopilot.geo import bearing_rad
from vencejo.sim.autopilot.interface import MavResult, Mode

from tests.sim.flying import Flight, airborne, make


def bank_deg(flight: Flight) -> float:
    return math.degrees(flight.plane.est.roll_rad)


def circling(mode: Mode) -> Flight:
    """A plane in a bank of about 30° that has just been given a mode flown by stick."""
    flight = airborne()
    assert flight.run(20, lambda: 25 < bank_deg(flight) < 40)
    assert flight.plane.set_mode(mode) is MavResult.ACCEPTED
    return flight


@pytest.mark.parametrize("mode", [Mode.STABILIZE, Mode.FBWA, Mode.AUTOTUNE])
def test_centred_sticks_level_the_wings_and_close_the_throttle(mode: Mode) -> None:
    flight = circling(mode)
    height_m = flight.plane.alt_rel_home_m
    flight.run(6)
    assert abs(bank_deg(flight)) < 3
    assert flight.plane.snapshot().throttle_pct == 0
    assert flight.plane.est.airspeed_m_s < 18, "it glides"
    flight.run(6)
    assert flight.plane.alt_rel_home_m < height_m - 2


def test_acro_keeps_the_bank_that_it_has() -> None:
    """mode_acro.cpp, ACRO_LOCKING: without the stick the attitude is held; 47° stayed 47° for 6 s."""
    flight = circling(Mode.ACRO)
    at_first = bank_deg(flight)
    flight.run(5)
    assert bank_deg(flight) == pytest.approx(at_first, abs=6)
    flight.plane.rc_input({1: 1700})
    flight.run(1.5)
    assert bank_deg(flight) > at_first + 20
    flight.plane.rc_input({1: None})
    flight.run(1)
    held = bank_deg(flight)
    flight.run(2)
    assert bank_deg(flight) == pytest.approx(held, abs=8)


def test_training_lets_the_surfaces_go_within_its_limits() -> None:
    """mode_training.cpp: within the limits the sticks move the surfaces; the limit itself is held."""
    flight = circling(Mode.TRAINING)
    flight.run(0.5)
    assert flight.plane.snapshot().servo_pwm_us[0] == 1500
    flight.plane.rc_input({1: 1900, 3: 1700})
    limit = flight.plane.bank_limit_deg()
    flight.run(4)
    assert limit - 15 < bank_deg(flight) < limit + 15


def test_manual_with_centred_sticks_is_a_plane_let_go() -> None:
    flight = circling(Mode.MANUAL)
    flight.run(3)
    assert flight.plane.snapshot().servo_pwm_us[:4] == (1500, 1500, 1000, 1500)
    assert flight.plane.est.airspeed_m_s < 18


def test_fbwb_holds_its_height_and_cruise_its_course_too() -> None:
    """Throttle closed, both fly at AIRSPEED_MIN; CRUISE aims a kilometre ahead (mode_cruise.cpp)."""
    flight = circling(Mode.FBWB)
    height_m = flight.plane.alt_rel_home_m
    flight.run(12)
    assert flight.plane.alt_rel_home_m == pytest.approx(height_m, abs=5)
    flight.plane.set_mode(Mode.CRUISE)
    flight.run(3)
    course = flight.plane.est.yaw_rad
    flight.run(9)
    assert flight.plane.est.yaw_rad == pytest.approx(course, abs=0.05)
    assert flight.plane.snapshot().wp_distance_m == pytest.approx(1000, abs=10)


def test_autotune_is_announced_and_ended_by_the_next_mode() -> None:
    flight = make()
    flight.plane.set_mode(Mode.AUTOTUNE)
    flight.plane.set_mode(Mode.MANUAL)
    flight.run(0.1)
    assert flight.texts == ["Started autotune", "Autotuning roll pitch yaw", "Stopped autotune"]


def test_a_vertical_landing_is_refused_over_and_over() -> None:
    """LOITER_ALT_QLAND without Q_ENABLE (mode_LoiterAltQLand.cpp): accepted, "Q_ENABLE 0" ten times a second."""
    flight = make()
    assert flight.plane.set_mode(Mode.LOITER_ALT_QLAND) is MavResult.ACCEPTED
    flight.run(1.0)
    assert 9 <= flight.texts.count("Q_ENABLE 0") <= 12


@pytest.mark.parametrize("mode", [Mode.GUIDED, Mode.AVOID_ADSB, Mode.CRUISE])
def test_the_guidance_is_reported_in_every_mode_that_has_one(mode: Mode) -> None:
    """GCS_MAVLINK_Plane::send_nav_controller_output: not in those alone that navigate by themselves."""
    flight = airborne()
    flight.plane.set_mode(mode)
    flight.run(10)
    shot = flight.plane.snapshot()
    bearing = math.degrees(bearing_rad(flight.plane.here(), flight.plane.nav.next))
    assert shot.target_bearing_deg == pytest.approx(bearing, abs=3)
    assert shot.nav_bearing_deg != 0.0
    assert shot.xtrack_error_m != 0.0


@pytest.mark.parametrize("mode", [Mode.LOITER, Mode.CIRCLE])
def test_loiter_alt_qland_keeps_the_circle_that_is_flown(mode: Mode) -> None:
    """ModeLoiterAltQLand::_enter; CIRCLE is a bank, without a centre to keep."""
    flight = airborne()
    plane = flight.plane
    plane.set_mode(mode)
    flight.run(40)
    centre = plane.nav.next if mode is Mode.LOITER else plane.here()
    plane.set_mode(Mode.LOITER_ALT_QLAND)
    assert (plane.nav.next.n_m, plane.nav.next.e_m) == (centre.n_m, centre.e_m)
    assert plane.nav.next.alt_m - plane.home.alt_m == pytest.approx(15)


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (9, "No such mode 9"),
        (16, "Flight mode change failed"),
        (19, "Q_ENABLE 0"),
        (24, "Flight mode change failed"),
        (300, "No such mode 44"),
    ],
)
def test_modes_that_are_refused(number: int, text: str) -> None:
    """As answered by ArduPlane 4.8-dev; of a mode's number it keeps the low byte."""
    flight = make()
    assert flight.plane.set_mode(number) is MavResult.FAILED
    flight.run(0.1)
    assert flight.texts == [text]
    assert flight.plane.flight_mode is Mode.MANUAL


def test_modes_may_be_closed_to_ground_stations() -> None:
    """FLTMODE_GCSBLOCK (Plane::gcs_mode_enabled): bit 9 is AUTO, 13 GUIDED; RTL has none."""
    flight = make(params={"FLTMODE_GCSBLOCK": float(1 << 9 | 1 << 13)})
    for mode, result in ((Mode.AUTO, 4), (Mode.GUIDED, 4), (Mode.RTL, 0)):
        assert flight.plane.set_mode(mode) == result
    flight.run(0.1)
    assert flight.texts == [
        f"Mode change to {name} denied, GCS entry disabled (FLTMODE_GCSBLOCK)" for name in ("Auto", "Guided")
    ]
