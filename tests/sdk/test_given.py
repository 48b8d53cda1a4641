"""What is given in another type than belongs there is told where it is given, not when it is sent."""

from __future__ import annotations

import asyncio
import math
import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
import vencejo
import vencejo.aio
import vencejo.landing
from vencejo._calling_back import call_back

# as a program without type checks uses them
Circle: Any = vencejo.Circle
Fence: Any = vencejo.Fence
Floors: Any = vencejo.Floors
GeoPoint: Any = vencejo.GeoPoint
Home: Any = vencejo.Home
MissionItem: Any = vencejo.MissionItem
Plan: Any = vencejo.Plan
PlanSettings: Any = vencejo.PlanSettings
Polygon: Any = vencejo.Polygon
RallyPoint: Any = vencejo.RallyPoint
Wind: Any = vencejo.landing.Wind
design_landing: Any = vencejo.landing.design_landing
save_params: Any = vencejo.save_params

Parameters: Any = vencejo.Parameters

HERE = GeoPoint(40.3, -3.8)
VEHICLE: Any = SimpleNamespace(_wait=None, _native=SimpleNamespace(param_set=None))
"""Nothing is asked of it."""
ITEM = MissionItem.waypoint(40.3, -3.8, alt_rel_home_m=50.0)

WRONG: list[tuple[Callable[[], object], str]] = [
    (lambda: Plan(fence=None), "Plan.fence is None: give a Fence"),
    (lambda: Plan(settings=None), "Plan.settings is None: give a PlanSettings"),
    (lambda: Plan(items=None), "Plan.items is None: give a tuple of a MissionItem"),
    (
        lambda: Plan(items=(ITEM, HERE)),
        "Plan.items[1] is GeoPoint(lat_deg=40.3, lon_deg=-3.8) (GeoPoint): give a MissionItem",
    ),
    (lambda: Plan(items=ITEM), "Plan.items is MissionItem("),
    (lambda: Plan(home=HERE), "Plan.home is GeoPoint("),
    (lambda: Plan(rally=(HERE,)), "Plan.rally[0] is GeoPoint("),
    (lambda: Fence(zones=(HERE,)), "Fence.zones[0] is GeoPoint("),
    (lambda: Fence(return_point=HERE), "Fence.return_point is GeoPoint("),
    (lambda: Polygon(((40.3, -3.8),)), "Polygon.points[0] is (40.3, -3.8) (tuple): give a GeoPoint"),
    (lambda: Circle(HERE, None), "Circle.radius_m is None: give a number"),
    (lambda: Circle(HERE, 50.0, inclusion=None), "Circle.inclusion is None: give True or False"),
    (lambda: GeoPoint("40.3", -3.8), "GeoPoint.lat_deg is '40.3' (str): give a number"),
    (lambda: Home(40.3, -3.8, None), "Home.alt_amsl_m is None: give a number"),
    (lambda: RallyPoint(40.3, -3.8, True), "RallyPoint.alt_m is True (bool): give a number"),
    (lambda: MissionItem("NAV_LAND", 3, (0.0,) * 7), "MissionItem.command is 'NAV_LAND' (str): give a whole number"),
    (
        lambda: MissionItem(16, 3, (0.0,) * 6 + ("high",)),
        "MissionItem.params[6] is 'high' (str): give a number or None",
    ),
    (lambda: MissionItem.waypoint(40.3, None, alt_rel_home_m="50"), "MissionItem.params[6] is '50' (str)"),
    (lambda: PlanSettings(vehicle_type=1.5), "PlanSettings.vehicle_type is 1.5 (float): give a whole number or None"),
    (lambda: Wind(None, 3.0), "Wind.from_deg is None: give a number"),
    (lambda: Parameters(VEHICLE).set("WP_RADIUS", "5"), "value is '5' (str): give a number"),
    (lambda: Parameters(VEHICLE).set("WP_RADIUS", True), "value is True (bool): give a number"),
    (lambda: call_back(VEHICLE, cast("Any", 5)), "the callback is 5 (int): give a function"),
    (lambda: design_landing((40.3, -3.7)), "at is (40.3, -3.7) (tuple): give a GeoPoint or a Runway"),
    (lambda: design_landing(HERE, wind=(270, 5)), "wind is (270, 5) (tuple): give a Wind or None"),
    (lambda: save_params({}, "all.param"), "params is a str: give a dict"),
    (lambda: Floors(maps_mb=2e3), "Floors.maps_mb is 2000.0 (float): give a whole number"),
]


@pytest.mark.parametrize(("make", "said"), WRONG, ids=[said.split(" ", 1)[0] for _, said in WRONG])
def test_a_wrong_type_is_told_where_it_is_given(make: Callable[[], object], said: str) -> None:
    with pytest.raises(TypeError, match=f"^{re.escape(said)}"):
        make()


def test_numbers_that_mavlink_does_not_have_are_told_too() -> None:
    with pytest.raises(ValueError, match="command 70000, frame 3: a MAV_CMD is 0 to 65535"):
        MissionItem(70_000, 3, (0.0,) * 7)
    with pytest.raises(ValueError, match="frame 300: a MAV_FRAME is 0 to 255"):
        RallyPoint(40.3, -3.8, 50.0, 300)


@pytest.mark.parametrize("timeout_s", [math.nan, -1.0])
def test_a_time_limit_that_is_none_is_told(timeout_s: float) -> None:
    async def connects() -> None:
        await vencejo.aio.connect("udpin:127.0.0.1:0", record=False, timeout_s=timeout_s)

    with vencejo.Station(record=False) as station:
        for wait in (
            lambda: vencejo.connect("udpin:127.0.0.1:0", record=False, timeout_s=timeout_s),
            lambda: asyncio.run(connects()),
            lambda: station.on_message(print).get(timeout_s),
            lambda: next(vencejo.Vehicle.stream(VEHICLE, timeout_s=timeout_s)),
            lambda: vencejo.Vehicle.wait_until(VEHICLE, bool, timeout_s=timeout_s),
        ):
            with pytest.raises(vencejo.InvalidRequest, match=r"timeout_s is (nan|NaN|-1(\.0)?), should be 0 s or more"):
                wait()


@pytest.mark.parametrize(("name", "value"), [("A", math.nan), ("A", math.inf), ("A,1", 2.0), ("", 1.0)])
def test_a_file_of_parameters_that_could_not_be_read_is_not_written(name: str, value: float, tmp_path: Path) -> None:
    with pytest.raises(vencejo.InvalidRequest, match="line 1"):
        vencejo.save_params(tmp_path / "x.param", {name: value})
    assert not list(tmp_path.iterdir())


def test_what_was_taken_before_is_taken() -> None:
    numpy = pytest.importorskip("numpy")
    point = GeoPoint(numpy.float32(40.5), 3)
    plan = Plan(items=[MissionItem(numpy.int64(16), 3, [0, None, 0.0, 0.0, 40.3, -3.8, 50])], rally=[], home=None)
    assert plan.check()
    assert Fence(zones=[Polygon([point, HERE, HERE])]).zones[0] == Polygon((point, HERE, HERE))


@pytest.mark.parametrize(
    ("home", "said"),
    [
        ((math.nan, -3.8, 600.0), "the plan's home: latitude NaN, longitude -3.8 is not a position on Earth"),
        ((95.0, -3.8, 600.0), "the plan's home: latitude 95, longitude -3.8 is not a position on Earth"),
        ((40.3, -3.8, math.inf), "the plan's home: "),
    ],
)
def test_a_home_that_is_no_position_is_told_by_the_check(home: tuple[float, float, float], said: str) -> None:
    with pytest.raises(vencejo.InvalidRequest, match=re.escape(said)):
        Plan(home=Home(*home), items=(ITEM,)).check()
