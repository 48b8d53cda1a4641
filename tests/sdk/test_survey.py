"""Surveys from Python: the core has the formulas and their tests; here is what Python gives it and gets back, and the command."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner
from vencejo import Fence, GeoPoint, Home, InvalidRequest, MissionItem, Plan, Polygon
from vencejo.cli.commands import app
from vencejo.landing import Wind
from vencejo.plan import ComplexItem
from vencejo.plan import MissionItem as Item
from vencejo.survey import CAMERAS, Camera, Survey, design_corridor, design_survey, redesign

FIELD = (GeoPoint(40.33, -3.80), GeoPoint(40.33, -3.79), GeoPoint(40.337, -3.79), GeoPoint(40.337, -3.80))
HOME = Home(40.328, -3.802, alt_amsl_m=600.0)
SONY = CAMERAS["Sony a6000 16mm"]


def laid(**given: object) -> Survey:
    asked = {"camera": SONY, "gsd_m": 0.03, "wind": Wind(0.0, 5.0), "home": HOME, "ground_rel_home_m": 0.0} | given
    return design_survey(FIELD, **asked)  # type: ignore[arg-type]


def test_every_figure_comes_back() -> None:
    survey = laid(airspeed_m_s=18.0, parameters={"ROLL_LIMIT_DEG": 30.0})
    assert (survey.course_from, survey.course_deg % 180.0) == ("across-wind", 90.0)
    assert survey.footprint_m is not None
    assert survey.footprint_m == pytest.approx((180.0, 119.5), abs=1.0)
    assert survey.gsd_m == pytest.approx(0.03)
    assert survey.trigger_m == pytest.approx(0.25 * survey.footprint_m[1])
    assert survey.items[0] == MissionItem.change_airspeed(18.0)
    assert survey.turn_radius_m > laid(airspeed_m_s=18.0).turn_radius_m, "less bank, wider turns"
    assert survey.lead_in_m > 100.0
    assert survey.groundspeed_m_s[0] == pytest.approx(survey.groundspeed_m_s[1])
    flown = survey.flown
    assert len(flown.photos) == pytest.approx(survey.photos, abs=len(survey.lines))
    assert len(flown.lines) == len(survey.lines)
    assert not any(line.is_missed for line in flown.lines)
    assert (flown.covered, flown.holes, flown.findings) == (1.0, (), ())
    photo = flown.photos[0]
    assert photo.shows is not None
    assert len(photo.shows) == 4
    assert photo.alt_rel_home_m == pytest.approx(survey.height_m, abs=5.0)


def test_what_cannot_be_is_told() -> None:
    bow = (FIELD[0], FIELD[2], FIELD[1], FIELD[3])
    with pytest.raises(InvalidRequest, match="the side from corner 1 crosses the side from corner 3"):
        design_survey(bow, camera=SONY, gsd_m=0.03)
    with pytest.raises(InvalidRequest, match="give either the ground sample distance or the height"):
        design_survey(FIELD, camera=SONY)
    with pytest.raises(InvalidRequest, match="the vehicle holds 99"):
        laid(max_items=100)
    with pytest.raises(TypeError, match=r"Camera\.focal_length_mm"):
        Camera(13.2, 8.8, 5472, 3648, None)  # type: ignore[arg-type]


def test_a_survey_goes_into_a_plan_and_through_its_file(tmp_path: Path) -> None:
    survey = laid()
    there = MissionItem.waypoint(40.33, -3.80, alt_rel_home_m=60.0)
    jump = Item(177, 2, (2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    plan = Plan(items=(there, there, jump, MissionItem.return_to_launch()), home=HOME)
    whole = survey.placed_in(plan, before=2)
    assert whole.items[1 : 1 + len(survey.items)] == survey.items
    assert whole.items[-2].params[0] == 2.0 + len(survey.items), "it still leads to the same item"
    assert whole.edited_complex_items == ()
    file = tmp_path / "survey.plan"
    whole.save(file)
    kinds = [item.get("complexItemType") for item in json.loads(file.read_text())["mission"]["items"]]
    assert kinds == [None, "survey", None, None, None]
    assert Plan.load(file).items == whole.items
    changed = survey.placed_in(Plan(), before=None)
    changed = Plan(items=changed.items[1:], settings=changed.settings)
    assert [item.kind for item in changed.edited_complex_items] == ["survey"]
    changed.save(file)
    assert Plan.load(file).items == changed.items


def test_a_corridor_follows_its_line() -> None:
    corridor = design_corridor(FIELD[:3], 60.0, camera=SONY, height_m=120.0, home=HOME)
    assert (corridor.course_from, len(corridor.lines), corridor.complex_item.kind) == ("corridor", 2, "CorridorScan")
    assert corridor.flown.covered == pytest.approx(1.0, abs=1e-3)


def test_the_command_lays_out_what_a_file_holds(tmp_path: Path) -> None:
    field, out = tmp_path / "field.plan", tmp_path / "out.plan"
    Plan(fence=Fence((Polygon(FIELD),)), home=HOME).save(field)

    def run(*words: str) -> tuple[int, str]:
        result = CliRunner().invoke(app, ["plan", "survey", *words])
        return result.exit_code, result.output

    camera = ("--camera", "sony a6000 16mm", "--gsd", "3", "--wind", "5")
    code, shown = run(str(field), *camera, "-o", str(out))
    assert code == 0, shown
    assert "lines across the wind" in shown
    assert "100.0% of the area" in shown
    plan = Plan.load(out)
    assert (plan.home, [item.kind for item in plan.settings.complex_items]) == (HOME, ["survey"])
    code, shown = run(str(field), *camera, "-o", str(out))
    assert (code, "add --force" in shown) == (1, True)
    places = " ".join(f"{point.lat_deg},{point.lon_deg}" for point in FIELD[:3])
    code, shown = run("--area", places, "--width", "40", "--spacing", "50", "--height", "100", "--json")
    assert (code, json.loads(shown)["course_from"]) == (0, "corridor")
    code, shown = run("--camera", "list", "--json")
    assert json.loads(shown)["Sony a6000 16mm"]["focal_length_mm"] == 16.0
    code, shown = run("--area", "40.33;-3.80", "--gsd", "3", "--camera", "13.2x8.8,5472x3648,10.4")
    assert (code, "is not a position" in shown) == (2, True)
    code, shown = run("--area", places, "--gsd", "3", "--camera", "nobody's")
    assert (code, "is not a known camera" in shown) == (2, True)


def test_a_survey_of_a_plan_is_laid_out_again_in_its_place() -> None:
    first = MissionItem.takeoff(HOME.lat_deg, HOME.lon_deg, alt_rel_home_m=50.0)
    back = MissionItem.return_to_launch()
    survey = laid()
    plan = survey.placed_in(Plan(items=(first, back), home=HOME), before=2)
    [old] = plan.settings.complex_items
    assert redesign(old, home=HOME).items == survey.items, "all that it was laid out from is kept"
    wider = redesign(old, home=HOME, side_overlap=0.3)
    assert len(wider.lines) < len(survey.lines)
    again = wider.placed_in(plan, replacing=old)
    assert again.items == (first, *wider.items, back)
    assert again.settings.complex_items == (wider.complex_item,)
    with pytest.raises(InvalidRequest, match="no survey with its items"):
        survey.placed_in(again, replacing=old)
    road = design_corridor(FIELD[:2], 60.0, camera=SONY, height_m=120.0)
    assert redesign(road.complex_item, width_m=200.0, gsd_m=0.02).height_m < 90.0
    with pytest.raises(InvalidRequest, match="fwLandingPattern"):
        redesign(ComplexItem("fwLandingPattern", "{}"))
    with pytest.raises(TypeError, match="hight_m"):
        redesign(old, hight_m=3.0)
