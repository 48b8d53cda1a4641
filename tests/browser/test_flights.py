"""Flights E1 to E5 as a person flies them in the page: composed by clicks, sent, armed, started and followed."""

from __future__ import annotations

import math
import re

import pytest
from playwright.async_api import expect
from pymavlink import mavutil
from vencejo import MissionItem, Plan, _native

from tests.browser.conftest import OpenStation, Serve
from tests.browser.station_page import FLIGHT_MS, MapScale, StationPage, is_same_view
from tests.flights.rival import load_with_pymavlink
from tests.plane import Plane, Truth, offset

POSITION_TOLERANCE_M = 6.0
"""What the plane flies between two messages of its position, and the error of its GPS."""
ANGLE_TOLERANCE_DEG = 5.0
BANKED_DEG = 15.0
"""In a turn, or in the circle at the end."""
LANDING_TOLERANCE_M = 20.0
AWAY_M = 150.0
"""Farther than a view of the runway shows."""


def angle_between(a_deg: float, b_deg: float) -> float:
    return abs((a_deg - b_deg + 180.0) % 360.0 - 180.0)


async def see_truth(station: StationPage, truth: Truth) -> None:
    """The numbers come to show the truth."""

    async def is_true() -> bool:
        away_m = _native.distance_m(*await station.where(), truth.lat_deg, truth.lon_deg)
        height_m = await station.figure(station.number("number.altHome"))
        angles = [
            angle_between(await station.figure(station.number(key)), true_deg)
            for key, true_deg in (
                ("number.roll", truth.roll_deg),
                ("number.pitch", truth.pitch_deg),
                ("number.heading", truth.heading_deg),
            )
        ]
        return (
            away_m <= POSITION_TOLERANCE_M
            and abs(height_m - truth.alt_rel_home_m) <= POSITION_TOLERANCE_M
            and max(angles) <= ANGLE_TOLERANCE_DEG
        )

    await station.eventually(is_true, f"the numbers show {truth}")


async def test_e1_a_mission_that_another_program_loaded_is_followed(open_station: OpenStation, serve: Serve) -> None:
    plan = Plan(
        items=(
            MissionItem.takeoff(*offset(0, -200), alt_rel_home_m=40.0, pitch_deg=15.0),
            MissionItem.waypoint(*offset(250, -350), alt_rel_home_m=60.0),
            MissionItem.waypoint(*offset(250, 150), alt_rel_home_m=60.0),
            MissionItem.return_to_launch(),
        )
    )
    with Plane() as plane:
        served = serve("--link", plane.link, "--rate", "20")
        async with open_station(served.url) as station:
            await station.open_panel("numbers")
            await expect(station.page.get_by_text(station.text("fly.ready"), exact=True)).to_be_visible()
            rival = mavutil.mavlink_connection(plane.link, source_system=250, source_component=190)
            try:
                assert rival.wait_heartbeat(timeout=120) is not None
                load_with_pymavlink(rival, plan)
                rival.mav.command_long_send(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0)
                await expect(station.bar("bar.motors")).to_contain_text("Armed")
                rival.set_mode_auto()
                await station.see_mode("AUTO")
                for number in (2, 3, 4):
                    plane.hurry()
                    await station.see_item(number)
                    plane.calm()
                    with plane.frozen(lambda truth: abs(truth.roll_deg) > BANKED_DEG) as truth:
                        await see_truth(station, truth)
                # What is on board was found out without a word, and is shown as the vehicle's.
                await station.open_panel("plan")
                await expect(station.items).to_have_count(len(plan))
                await expect(station.plan_state).to_have_text(station.text("plan.state.verified"))
                await expect(station.items.nth(1)).to_contain_text(station.text("plan.reached"))
            finally:
                rival.close()


async def test_e2_a_mission_is_sent_to_a_plane_in_the_air(open_station: OpenStation, serve: Serve) -> None:
    with Plane() as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url) as station:
            await station.set_mode("TAKEOFF")
            await station.arm()
            await station.open_panel("numbers")
            plane.skip_to(lambda truth: truth.alt_rel_home_m > 40.0)

            async def has_climbed() -> bool:
                return await station.figure(station.number("number.altHome")) > 35.0

            await station.eventually(has_climbed, "climbing")
            await station.open_panel("plan")
            await station.leave_view_alone()
            await station.show_plane()
            await station.click_map(offset(150, -150), offset(150, 150), offset(-80, 80))
            await expect(station.items).to_have_count(3)
            await station.send_plan()
            await expect(station.bar("bar.mode")).to_have_text(re.compile(r"^\s*TAKEOFF"))
            await station.start_mission()
            plane.hurry()
            await station.see_item(3)
            for row in (0, 1):
                await expect(station.items.nth(row)).to_contain_text(station.text("plan.reached"))


async def test_e3_take_off_and_waypoints_from_the_ground(open_station: OpenStation, serve: Serve) -> None:
    with Plane() as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url) as station:
            panel = await station.open_panel("plan")
            await station.type_into(station.field(panel, "plan.defaultAlt"), "60")
            await station.show_plane()
            places = [offset(0, -220), offset(200, -250), offset(200, 150), offset(-80, 80)]
            await station.choose_tool("kind.takeoff")
            await station.click_map(places[0])
            await station.click_map(*places[1:])
            await station.add_kind("return_to_launch")
            await expect(station.items).to_have_count(5)
            for row, kind in enumerate(("takeoff", "waypoint", "waypoint", "waypoint", "return_to_launch")):
                await expect(station.items.nth(row)).to_contain_text(station.text(f"kind.{kind}"))
            for row, place in enumerate(places):
                await station.item(row + 1).click()
                details = panel.get_by_role("group", name=station.text("plan.details", number=row + 1))
                lat_deg, lon_deg = [
                    float(await station.field(details, key).input_value())
                    for key in ("plan.latitude", "plan.longitude")
                ]
                assert _native.distance_m(lat_deg, lon_deg, *place) < 4.0, "a click is where the pointer says"
            await expect(station.plan_state).to_have_text(station.text("plan.state.not-sent"))
            await station.send_plan()
            await station.arm()
            await expect(station.bar("bar.mode")).not_to_have_text(re.compile("AUTO"))
            await station.start_mission()
            await expect(station.page.locator(".ahead")).to_contain_text(station.text("rehearsal.ending.returned"))
            plane.hurry()
            await station.see_item(5)
            for row in range(4):
                await expect(station.items.nth(row)).to_contain_text(station.text("plan.reached"))


async def test_e4_take_off_and_landing(open_station: OpenStation, serve: Serve) -> None:
    with Plane(params={"RTL_AUTOLAND": 2}) as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url) as station:
            panel = await station.open_panel("plan")
            await station.show_plane()
            await station.choose_tool("kind.takeoff")
            await station.click_map(offset(0, -200))
            await station.click_map(offset(180, -200))
            await station.choose_tool("kind.land")
            await station.click_map(offset(0, 0))
            # The approach is laid out by itself: a circle down to the height of the final leg, which a return finds too.
            await expect(station.items).to_have_count(5)
            await expect(station.items.last).to_contain_text(station.text("kind.land"))
            await expect(panel.get_by_text(station.text("plan.checks.ok"), exact=True)).to_be_visible()
            await station.send_plan()
            await station.arm()
            await station.start_mission()
            plane.hurry()
            await station.see_item(5)
            await expect(station.bar("bar.motors")).to_contain_text(station.text("bar.disarmed"), timeout=FLIGHT_MS)
            await station.open_panel("numbers")
            shown_m = _native.distance_m(*await station.where(), *offset(0, 0))
            truth = plane.truth()
            true_m = _native.distance_m(truth.lat_deg, truth.lon_deg, *offset(0, 0))
            assert max(shown_m, true_m) <= LANDING_TOLERANCE_M
            # Where it stands it does not arm, and the page says what cures that.
            await station.refuse_to_arm("refusal.landing-sequence", cure="MANUAL")
            await fly_again(station, plane)
        served.process.terminate()
        served.process.wait(20)
        # A server that starts anew finds the plane where the second flight ended, with the mission on board.
        served = serve("--link", plane.link)
        async with open_station(served.url) as station:
            await station.have_control()
            await fly_again(station, plane)


async def fly_again(station: StationPage, plane: Plane) -> None:
    """The mission on board, once more, from where the last flight ended."""
    plane.calm()
    await station.prepare_flight(from_mode="AUTO")
    await station.arm()
    await station.start_mission()
    plane.hurry()
    await station.see_item(5)
    await expect(station.bar("bar.motors")).to_contain_text(station.text("bar.disarmed"), timeout=FLIGHT_MS)
    truth = plane.truth()
    assert _native.distance_m(truth.lat_deg, truth.lon_deg, *offset(0, 0)) <= LANDING_TOLERANCE_M


async def test_e5_the_view_follows_a_plane_that_leaves_the_map(open_station: OpenStation, serve: Serve) -> None:
    with Plane() as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url) as station:
            await station.open_panel("numbers")
            await station.set_mode("TAKEOFF")
            await station.leave_view_alone()
            whole = await station.map_scale()
            # pressed in one go, while the map still moves: it comes to rest where all of them together say
            presses = [station.button(f"map.{key}") for key in ("showPlane", "zoomIn", "zoomIn")]
            handles = [await button.element_handle() for button in presses]
            await station.page.evaluate("(buttons) => buttons.forEach((button) => button.click())", handles)
            before = await station.map_scale()
            assert before.x_per_deg == pytest.approx(4.0 * whole.x_per_deg, rel=1e-3)
            x, y = before.pixel(*await station.where())
            left, top, right, bottom = await station.free_map()
            assert math.hypot(x - (left + right) / 2, y - (top + bottom) / 2) < 40.0, "the plane is in the middle"
            await station.arm()
            plane.skip_to(lambda truth: _native.distance_m(truth.lat_deg, truth.lon_deg, *offset(0, 0)) > AWAY_M)

            async def has_left() -> bool:
                x, y = before.pixel(*await station.where())
                left, top, right, bottom = await station.free_map()
                return not (left < x < right and top < y < bottom)

            await station.eventually(has_left, "leaving the map")
            assert is_same_view(await station.map_scale(), before), "a view that was to be left alone has moved"
            await station.keep_in_sight()

            async def is_in_sight() -> bool:
                scale = await station.map_scale()
                x, y = scale.pixel(*await station.where())
                left, top, right, bottom = await station.free_map()
                return left < x < right and top < y < bottom and wider(before, scale)

            await station.eventually(is_in_sight, "being in sight again")


def wider(before: MapScale, after: MapScale) -> bool:
    return math.fabs(after.x_per_deg) < math.fabs(before.x_per_deg) * 0.8
