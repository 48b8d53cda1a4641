"""Landing design from Python: the core has the formulas and their tests; here is what Python gives it and gets back."""

from __future__ import annotations

import math

import pytest
from vencejo import Command, GeoPoint, Home, InvalidRequest, MissionItem, Plan
from vencejo.geodesy import bearing_deg, destination, distance_m
from vencejo.landing import Runway, Wind, design_landing, landing_alternatives, move_landing

FIELD = GeoPoint(40.3332, -3.7978)


def test_every_option_has_its_effect() -> None:
    landing = design_landing(
        FIELD,
        course_deg=45.0,
        coming_from=destination(FIELD, bearing_deg=0.0, distance_m=900.0),
        wind=Wind(45.0, 4.0),
        ground_rel_home_m=-12.0,
        airspeed_m_s=15.0,
        slope=0.05,
        final_height_m=30.0,
        radius_m=60.0,
        is_clockwise=False,
        has_land_start=False,
    )
    assert (landing.direction, landing.course_deg, landing.cautions) == ("course", 45.0, ())
    assert (landing.final_m, landing.slope, landing.radius_m) == pytest.approx((600.0, 0.05, 60.0))
    assert (landing.headwind_m_s, landing.groundspeed_m_s) == pytest.approx((4.0, 11.0))
    circle, land = landing.items
    assert (circle.command, circle.params[1], circle.alt_m) == (Command.NAV_LOITER_TO_ALT, -60.0, 18.0)
    assert (land.command, land.lat_deg, land.lon_deg, land.alt_m) == (
        Command.NAV_LAND,
        FIELD.lat_deg,
        FIELD.lon_deg,
        -12.0,
    )
    assert landing.leaves_alt_rel_home_m == 18.0
    assert distance_m(landing.leaves, FIELD) == pytest.approx(600.0)
    assert bearing_deg(landing.leaves, FIELD) == pytest.approx(45.0, abs=0.01)
    assert circle.lat_deg is not None
    assert circle.lon_deg is not None
    centre = GeoPoint(circle.lat_deg, circle.lon_deg)
    assert distance_m(centre, FIELD) == pytest.approx(math.hypot(600.0, 60.0), abs=0.1)
    assert bearing_deg(landing.leaves, centre) == pytest.approx(315.0, abs=0.01), "to the left"


def test_a_plan_that_ends_with_it_is_sound() -> None:
    landing = design_landing(FIELD, coming_from=destination(FIELD, bearing_deg=270.0, distance_m=2000.0))
    takeoff = MissionItem.takeoff(FIELD.lat_deg, FIELD.lon_deg - 0.003, alt_rel_home_m=50.0)
    assert Plan(items=(takeoff, *landing.items)).require_sound(position=FIELD, on_ground=True) == ()
    assert [(caution.code, caution.message[:38]) for caution in landing.cautions] == [
        ("ground-not-known", "the height of the ground at the landin")
    ]


@pytest.mark.parametrize(
    ("at", "options", "says"),
    [
        (FIELD, {}, "nothing says in which direction"),
        (FIELD, {"wind": Wind(0.0, 0.9)}, "nothing says in which direction"),
        (FIELD, {"course_deg": 0.0, "slope": 0.5}, "slope is 0.5, should be 0.02 to 0.25"),
        (FIELD, {"course_deg": math.nan}, "course_deg is NaN"),
        (GeoPoint(91.0, 0.0), {"course_deg": 0.0}, "not a position on Earth"),
        (FIELD, {"coming_from": GeoPoint(0.0, 181.0)}, "not a position on Earth"),
    ],
)
def test_what_cannot_be_is_refused(at: GeoPoint, options: dict[str, object], says: str) -> None:
    with pytest.raises(InvalidRequest, match=says):
        design_landing(at, **options)  # type: ignore[arg-type]


def test_wind_is_calm_as_the_core_says() -> None:
    assert Wind(90.0, 0.9).is_calm
    assert repr(Wind(90, 7)) == "Wind(from_deg=90.0, speed_m_s=7.0)", "whole numbers too"
    assert not Wind(90.0, 1.0).is_calm
    assert design_landing(FIELD, wind=Wind(90.0, 1.0)).direction == "into-wind"


def test_the_landings_of_a_runway_are_ranked_for_the_wind() -> None:
    strip = Runway(FIELD, destination(FIELD, bearing_deg=90.0, distance_m=240.0))
    assert (strip.length_m, strip.course_deg) == pytest.approx((240.0, 90.0))
    assert distance_m(strip.aim, FIELD) == pytest.approx(120.0), "in the middle"
    found = landing_alternatives(strip, wind=Wind(250.0, 6.0), home=Home(FIELD.lat_deg, FIELD.lon_deg, 600.0))
    best, last = found[0], found[-1]
    assert [round(one.landing.course_deg) for one in found] == [270, 270, 90, 90]
    assert (best.verdict, last.verdict, best.ending) == ("good", "doubtful", "landed")
    assert best.crosswind_m_s == pytest.approx(-2.05, abs=0.01)
    assert best.reasons[0].message == "6 m/s of headwind"
    assert last.reasons[0].code == "tailwind"
    assert design_landing(strip, wind=Wind(250.0, 6.0)).course_deg == pytest.approx(270.0, abs=0.01)


def test_a_landing_is_laid_out_for_the_planes_parameters() -> None:
    own = {"WP_LOITER_RAD": -120.0, "TECS_LAND_ARSPD": 12.0, "RTL_AUTOLAND": 2.0}
    circle = design_landing(FIELD, course_deg=0.0, parameters=own).items[1]
    assert circle.params[1] == -120.0
    assert len(design_landing(FIELD, course_deg=0.0, parameters={}).items) == 2, "a return does not look for it"


def test_a_landing_follows_the_part_that_is_moved() -> None:
    landing = design_landing(FIELD, course_deg=30.0)
    there = destination(FIELD, bearing_deg=45.0, distance_m=300.0)
    moved = move_landing(landing.items, "point", there)
    assert (moved.items[-1].lat_deg, moved.items[-1].lon_deg) == (there.lat_deg, there.lon_deg)
    assert (moved.course_deg, moved.slope) == pytest.approx((landing.course_deg, landing.slope), abs=1e-3)
    turned = move_landing(landing.items, "final-leg", destination(FIELD, bearing_deg=90.0, distance_m=700.0))
    assert (turned.course_deg, turned.final_m) == pytest.approx((270.0, 700.0), abs=0.05)
    with pytest.raises(InvalidRequest, match="no part"):
        move_landing(landing.items, "flare", there)  # type: ignore[arg-type]
    with pytest.raises(InvalidRequest, match="circle down"):
        move_landing(landing.items[:1], "point", there)


def test_ground_before_a_landing_lowers_it() -> None:
    """A ridge of 35 m, 300 m south of the point, where the wind from the north would have the plane come from."""
    home = Home(FIELD.lat_deg, FIELD.lon_deg, alt_amsl_m=600.0)
    south = (
        destination(FIELD, bearing_deg=180.0, distance_m=500.0),
        destination(FIELD, bearing_deg=180.0, distance_m=200.0),
    )

    def ridge(lat_deg: float, _lon_deg: float) -> float:
        return 635.0 if south[0].lat_deg < lat_deg < south[1].lat_deg else 600.0

    wind = Wind(0.0, 4.0)
    assert landing_alternatives(FIELD, wind=wind, home=home)[0].landing.course_deg == pytest.approx(0.0)
    over = landing_alternatives(FIELD, wind=wind, home=home, ground=ridge)
    north = [one for one in over if abs(one.landing.course_deg) < 1.0]
    assert [(one.verdict, "ground-near" in [reason.code for reason in one.reasons]) for one in north] == [
        ("bad", True)
    ] * 2
    assert over[0].verdict != "bad"
    landing = design_landing(FIELD, course_deg=0.0, home=home, ground=ridge)
    assert [caution.code for caution in landing.cautions] == ["ground-near"]
