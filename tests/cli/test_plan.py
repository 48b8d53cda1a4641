"""The commands `vencejo plan …` and what they write: no vehicle, no network."""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result
from vencejo import Fence, FileFormatError, GeoPoint, Home, MissionItem, Plan, Polygon, RallyPoint
from vencejo._report_texts import TEXTS, Texts
from vencejo.cli.commands import app
from vencejo.cli.demo import demo_mission
from vencejo.findings import Finding
from vencejo.landing import Wind
from vencejo.rehearsal import rehearse
from vencejo.report import plan_report

ROOT = Path(__file__).resolve().parents[2]
HOME = Home(40.3332, -3.7978, 690.0)
ITEMS = (
    MissionItem.takeoff(40.3332, -3.8010, alt_rel_home_m=50.0),
    MissionItem.waypoint(40.3402, -3.8010, alt_rel_home_m=80.0),
    MissionItem.waypoint(40.3402, -3.7900, alt_rel_home_m=80.0),
)
AREA = tuple(GeoPoint(lat, lon) for lat, lon in ((40.32, -3.82), (40.35, -3.82), (40.35, -3.78)))
KML = (
    "<kml><Placemark><name>Path</name><LineString><coordinates>-3.801,40.3332 -3.801,40.3402 -3.79,40.3402</coordinates>"
    "</LineString></Placemark></kml>"
)


def run(*args: str | Path) -> Result:
    return CliRunner().invoke(app, ["plan", *map(str, args)])


@pytest.fixture
def plan() -> Plan:
    return Plan(ITEMS, HOME, Fence((Polygon(AREA),)), (RallyPoint(40.3340, -3.8, 60.0),))


@pytest.fixture
def file(plan: Plan, tmp_path: Path) -> Path:
    path = tmp_path / "field.plan"
    plan.save(path)
    return path


def test_check_tells_what_lines_and_flight_show(file: Path) -> None:
    told = json.loads(run("check", file, "--json").stdout)
    assert told["ending"] is not None
    assert "no-landing" in [finding["code"] for finding in told["findings"]]
    without_home = Plan(ITEMS)
    without_home.save(file)
    result = run("check", file)
    assert "not rehearsed" in result.stderr
    assert result.stdout.endswith("errors: 0, warnings: 1\n"), result.stdout
    Plan((MissionItem.waypoint(0.0, 0.0, alt_rel_home_m=50.0),), HOME).save(file)
    assert run("check", file).exit_code == 1


def test_the_checks_know_the_parameters_of_a_file(file: Path, tmp_path: Path) -> None:
    params = tmp_path / "plane.param"
    params.write_text("AIRSPEED_MAX,20\n")
    Plan((ITEMS[0], MissionItem.action(178, 0.0, 25.0, -1.0), *ITEMS[1:]), HOME).save(file)
    found = [
        {finding["code"] for finding in json.loads(run("check", file, "--json", *given).stdout)["findings"]}
        for given in ((), ("--params", params))
    ]
    assert found[1] - found[0] == {"speed-not-taken"}


def test_rehearse_flies_the_demo() -> None:
    result = run("rehearse", demo_mission(), "--wind", "5", "--wind-from", "240")
    assert (result.exit_code, "Landed, at rest" in result.stdout) == (0, True), result.output
    calm = run("rehearse", demo_mission(), "--wind-from", "240")
    assert (calm.exit_code, "add --wind M_S" in calm.stderr) == (2, True), calm.output
    assert run("check", demo_mission(), "--wind", "0", "--wind-from", "240").exit_code == 0


def test_a_plan_without_a_home_is_given_one(tmp_path: Path) -> None:
    homeless = tmp_path / "homeless.plan"
    dataclasses.replace(Plan.load(demo_mission()), home=None).save(homeless)
    refused = run("rehearse", homeless)
    assert (refused.exit_code, "give one with --home LAT,LON,ALT" in refused.stderr) == (2, True), refused.output
    checked = run("check", homeless)
    assert "the plan has none; give one with --home" in checked.stderr, checked.output
    home = ("--home", "40.3332,-3.7978,690")
    assert "Landed, at rest" in run("rehearse", homeless, *home).stdout
    assert "not rehearsed" not in run("check", homeless, *home).stderr
    swapped = run("convert", homeless, tmp_path / "swapped.plan", "--home", "-3.7978,40.3332,690")
    assert swapped.stderr.count("latitude and longitude are swapped?") == 1, swapped.output


def test_land_shows_the_choice_and_writes_one(file: Path, tmp_path: Path) -> None:
    runway = ("--runway", "40.3332,-3.8020,40.3332,-3.7978", "--wind", "6", "--wind-from", "270")
    told = json.loads(run("land", file, *runway, "--json").stdout)
    assert told[0]["landing"]["course_deg"] == pytest.approx(270.0, abs=0.1)
    out = tmp_path / "landing.kml"
    assert "note: heights above home are drawn" in run("land", file, *runway, "--write", out).stderr
    landed = Plan.load(out)
    assert landed.items[:3] == ITEMS
    assert (landed.items[-1].name, len(landed.rally)) == ("NAV_LAND", 1)


def test_convert_says_what_is_assumed_and_what_is_lost(plan: Plan, file: Path, tmp_path: Path) -> None:
    for ending in ("kml", "kmz", "geojson", "csv"):
        out = tmp_path / f"out.{ending}"
        assert run("convert", file, out).exit_code == 0
        assert Plan.load(out) == Plan(plan.items, plan.home, plan.fence, plan.rally, Plan.load(out).settings)
    gpx = run("convert", file, tmp_path / "out.gpx")
    assert gpx.exit_code == 0
    assert "note: parts of the fence were not written (1)" in gpx.stderr
    path = tmp_path / "path.kml"
    path.write_text(KML)
    told = json.loads(run("convert", path, tmp_path / "a.plan", "--json").stdout)
    assert [note["code"] for note in told["read"]] == ["heights-missing", "names-not-kept"]
    result = run("convert", path, tmp_path / "b.plan", "--alt", "80", "--home", "40.3332,-3.7978,690")
    assert "height" not in result.stderr
    made = Plan.load(tmp_path / "b.plan")
    assert ([item.alt_m for item in made], made.home) == ([80.0, 80.0, 80.0], HOME)
    assert run("convert", path, tmp_path / "b.plan").exit_code == 1  # it is there
    equator = tmp_path / "equator.csv"
    equator.write_text("lat,lon\n0,0.02\n0,0.01\n0.01,0\n")
    assert run("convert", equator, tmp_path / "equator.plan", "--alt", "80", "--home", "0,0.02,10").exit_code == 0
    assert [item.alt_m for item in Plan.load(tmp_path / "equator.plan")] == [80.0, 80.0, 80.0]
    corridor = ("survey", tmp_path / "equator.plan", "--width", "100", "--height", "100", "--spacing", "60", "--json")
    assert json.loads(run(*corridor).stdout)["length_m"] > 2_000.0
    assert run("convert", path, tmp_path / "b.doc").exit_code == 2


def test_a_plan_carries_what_its_file_left_to_say_and_is_the_same_without(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "path.kml"
    path.write_text(KML)
    read = Plan.load(path)
    assert str(read.notes[0]) == "places have no height; set it before the plan is sent (3)"
    assert read == Plan(read.items)
    assert [note.code for note in plan.save(tmp_path / "x.waypoints")] == ["fence-not-written", "rally-not-written"]
    with pytest.raises(FileFormatError, match=r'x\.doc: a plan is saved as \.plan, .*not as "\.doc"'):
        plan.save(tmp_path / "x.doc")


class Page(HTMLParser):
    """Checks that elements are closed in their order, and gathers the text."""

    EMPTY = frozenset({"meta"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.addresses: list[str] = []
        self.said = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in self.EMPTY:
            self.open.append(tag)
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href", "xlink:href")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        pass

    def handle_data(self, data: str) -> None:
        self.said += data


SURVEY = ("survey", "--area", "40.33,-3.8 40.34,-3.8 40.34,-3.79", "--height", "100", "-o", "OUT")


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (("convert", "FILE", "OUT", "--home", "nan,nan,nan"), "latitude NaN, longitude NaN is not a position on Earth"),
        (("convert", "FILE", "OUT", "--home", "91,0,0"), "latitude 91, longitude 0 is not a position on Earth"),
        (("convert", "FILE", "OUT", "--home", "40,-3,1e308"), "home lies 1e308 m above the sea"),
        (("convert", "MAP", "OUT", "--alt", "1e308"), "item 1 (NAV_WAYPOINT): z is 1e308"),
        ((*SURVEY, "--camera", "-1x-1,-1x-1,-1"), "survey: image_width_px is -1, should be 16 to 100000"),
        ((*SURVEY, "--camera", "9x9,9999999999999999999x9,9"), "image_width_px is 9999999999999999999, should be"),
        ((*SURVEY, "--spacing", "1e308"), "survey: spacing_m is 1e308, should be 1 to 10000"),
    ],
)
def test_what_cannot_be_is_refused_in_a_line_and_nothing_is_written(
    file: Path, tmp_path: Path, args: tuple[str, ...], says: str
) -> None:
    drawn, out = tmp_path / "path.kml", tmp_path / "out.plan"
    drawn.write_text(KML)
    names = {"FILE": file, "MAP": drawn, "OUT": out}
    result = run(*(names.get(arg, arg) for arg in args))
    assert result.exit_code in (1, 2)
    assert says in result.stderr
    assert "internal error" not in result.stderr
    assert len(result.stderr) < 300
    assert not out.exists()


def test_a_report_draws_the_180th_meridian_as_any_other() -> None:
    def route(lon_deg: float) -> str:
        home = Home(10.0, lon_deg, 0.0)
        east = (lon_deg + 0.01 + 180.0) % 360.0 - 180.0
        items = (
            MissionItem.takeoff(10.0, lon_deg, alt_rel_home_m=50.0),
            MissionItem.waypoint(10.01, east, alt_rel_home_m=80.0),
        )
        plan = Plan(items, home)
        found = re.search(r'class="route" points="([^"]+)"', plan_report(plan, rehearse(plan), title="x"))
        assert found
        return found[1]

    assert route(179.995) == route(100.0)


@pytest.mark.parametrize("language", ["en", "es"])
def test_a_report_is_one_whole_page_that_asks_no_network(plan: Plan, file: Path, language: Any) -> None:
    out = file.with_suffix(".html")
    title = "<script>alert('x')</script> & more"
    result = run("report", file, "-o", out, "--title", title, "--wind", "6", "--language", language)
    assert result.exit_code == 0, result.output
    page, text = Page(), out.read_text(encoding="utf-8")
    page.feed(text)
    assert page.open == []
    assert page.addresses == []
    assert "<script" not in text
    assert "http" not in text
    assert title in page.said
    assert ("Waypoint" if language == "en" else "Punto de paso") in page.said
    assert all(f"\n{number}" not in page.said for number in ("nan", "inf"))
    numbers = re.findall(r'points="([^"]+)"', text)
    assert len(numbers) >= 4
    assert not re.search(r"nan|inf|None", " ".join(numbers))
    assert plan_report(plan, rehearse(plan), title="x", language=language) == plan_report(
        plan, rehearse(plan), title="x", language=language
    )


def test_a_report_of_a_flight_that_ends_badly_says_so() -> None:
    plan = Plan((MissionItem.waypoint(40.3402, -3.8010, alt_rel_home_m=80.0),), HOME)
    held = rehearse(plan, wind=Wind(0.0, 30.0))
    assert held.ending == "held"
    page = plan_report(plan, held, title="Storm", wind=Wind(0.0, 30.0))
    assert '<p class="verdict bad">Is held by the wind</p>' in page


def test_spanish_texts_are_those_of_the_page() -> None:
    spec = importlib.util.spec_from_file_location("report_texts", ROOT / "scripts" / "report_texts.py")
    assert spec is not None
    assert spec.loader is not None
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    kept = (ROOT / "python" / "vencejo" / "data" / "texts.es.json").read_text(encoding="utf-8")
    assert kept == made.texts(), "run scripts/report_texts.py"
    assert len(json.loads(kept)["findings"]) > 100


def test_findings_are_said_in_spanish_with_their_figures() -> None:
    texts = Texts("es")
    plan = Plan(ITEMS)
    low = Finding("warning", "height-not-reached", 2, "low", "climb", {"difference_m": 12.5, "is_low": True})
    said, remedy = texts.finding(low, plan)
    assert said == "En el punto 2 (Punto de paso) el avión está 12,5 m demasiado bajo."
    assert remedy == "Alarga el tramo, cambia la altura o asciende en círculo."
    unknown = Finding("warning", "of-tomorrow", None, "New.", "Look.")
    assert texts.finding(unknown, plan) == ("New.", "Look.")
    for english, spanish in TEXTS.values():
        assert re.findall(r"\{\w+\}", english) == re.findall(r"\{\w+\}", spanish)
