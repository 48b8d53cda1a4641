"""Flights E7 and E9: links that weaken and break, on the vehicle's, the server's and the browser's side."""

from __future__ import annotations

import contextlib
import os
import re
from pathlib import Path

from playwright.async_api import expect

from tests.browser.conftest import OpenStation, Serve
from tests.browser.relay import LossyRelay, TcpRelay
from tests.browser.station_page import StationPage
from tests.plane import Plane
from tests.server.client import Served, serving
from tests.support import reserved_ports


async def take_off(station: StationPage, plane: Plane) -> None:
    """Have a plane in the air, some way from where it stood."""
    await station.set_mode("TAKEOFF")
    await station.arm()
    await station.open_panel("numbers")
    plane.skip_to(lambda truth: truth.alt_rel_home_m > 25.0)

    async def flies() -> bool:
        return await station.figure(station.number("number.altHome")) > 20.0

    await station.eventually(flies, "flying")


async def draw_two_waypoints(station: StationPage) -> None:
    """Have a draft that is only in this browser."""
    await station.open_panel("plan")
    await station.leave_view_alone()
    await station.show_plane()
    await station.map_scale()
    left, top, right, bottom = await station.free_map()
    for part in (0.3, 0.7):
        await station.page.mouse.click(left + (right - left) * part, top + (bottom - top) * 0.25)
    await expect(station.items).to_have_count(2)


async def flown_m(station: StationPage) -> float:
    """Length of the first plane's trail."""
    told = re.search(r"([\d.]+) (k?m) flown", await station.on_map.inner_text())
    return 0.0 if told is None else float(told[1]) * (1000.0 if told[2] == "km" else 1.0)


async def see_all_resumed(station: StationPage, before_m: float, *, mode: str = "LOITER") -> None:
    """Telemetry flows, commands work, and nothing that a person made or saw is gone."""
    await expect(station.lost).to_have_count(0)
    await expect(station.on_map).not_to_contain_text("estimated")

    async def flies_on() -> bool:
        return await flown_m(station) > before_m

    await station.eventually(flies_on, "a trail that goes on from what it was")
    await expect(station.items).to_have_count(2)
    await station.set_mode(mode)


async def test_e7_a_link_is_weakened_until_it_breaks(open_station: OpenStation, serve: Serve) -> None:
    with LossyRelay(seed=7) as relay, Plane(link=relay.plane_link) as plane:
        served = serve("--link", relay.driver_link)
        async with open_station(served.url) as station:
            await take_off(station, plane)
            loss, rate, age, trip = (
                station.number(f"number.{name}") for name in ("linkLoss", "linkRate", "lastHeard", "roundTrip")
            )

            async def is_well() -> bool:
                return await station.figure(loss) < 1.0 and await station.figure(rate) > 50.0

            await station.eventually(is_well, "a good link")

            async def is_young() -> bool:
                return await station.figure(age) < 1.0 and await station.figure(trip) >= 0.0

            await station.eventually(is_young, "a link that was just heard, and its round trip")
            await expect(station.bar("bar.link")).to_contain_text("0.0 % lost")
            full_rate = await station.figure(rate)

            relay.loss = 0.4

            async def is_weak() -> bool:
                shown = await station.figure(station.bar("bar.link"))
                return 25.0 <= shown <= 55.0 and 25.0 <= await station.figure(loss) <= 55.0

            await station.eventually(is_weak, "the loss of a weak link")

            async def is_slow() -> bool:
                return 0.3 * full_rate <= await station.figure(rate) <= 0.85 * full_rate

            await station.eventually(is_slow, "the rate of a weak link")

            colour = "bar => getComputedStyle(bar).backgroundColor"
            calm = await station.state_bar.evaluate(colour)
            relay.loss = 1.0
            await expect(station.lost).to_contain_text(station.like("bar.lostDetail"))

            async def has_turned() -> bool:
                return bool(await station.state_bar.evaluate(colour) != calm)

            # On a busy machine what the relay had taken before may still arrive, and interrupt the silence.
            await station.eventually(has_turned, "the bar turns")
            await expect(station.bar("bar.link")).to_contain_text(station.text("bar.linkLost"))
            await expect(station.number("number.airspeed")).to_contain_text(station.like("bar.ago"))
            # The plane goes on as a ghost, marked as estimated, along its path.
            await expect(station.on_map).to_contain_text(station.like("map.estimated"))
            estimate = await station.on_map.inner_text()
            await expect(station.on_map).not_to_contain_text(place_of(estimate))
            await expect(station.on_map).to_contain_text(station.like("map.estimated"))
            # Nothing is allowed to pop up over what a pilot looks at.
            assert await station.page.get_by_role("dialog").count() == 0

            relay.loss = 0.0
            await expect(station.lost).to_have_count(0)
            await expect(station.on_map).not_to_contain_text("estimated")
            await station.eventually(is_well, "a good link again")

            async def is_calm() -> bool:
                return bool(await station.state_bar.evaluate(colour) == calm)

            # Of a link that loses two fifths each way it may have been said that it works in one direction only, and that it
            # does in both again is told with the next list of vehicles.
            await station.eventually(is_calm, "the bar turns back")


async def test_a_serial_port_that_is_plugged_in_is_offered_and_opened(open_station: OpenStation, serve: Serve) -> None:
    plane_end, port_end = os.openpty()
    device = os.ttyname(port_end)
    plugged: list[dict[str, object]] = []
    locked = {"device": "/dev/ttyUSB0", "lasting_path": None, "description": None, "usual_baud": 57_600}
    cube = {"device": device, "lasting_path": None, "description": "Hex CubeOrange", "usual_baud": 115_200}
    free: dict[str, object] = {"link": None, "is_in_use": False, "is_allowed": True}
    served = serve("--link", "udpin:127.0.0.1:0")
    try:
        async with open_station(served.url) as station:
            page = station.page
            await page.route("**/api/v1/serial-ports", lambda route: route.fulfill(json=plugged))
            await page.locator("summary", has_text=station.text("welcome.addLink")).click()
            await expect(page.get_by_text(station.text("link.port.none"))).to_be_visible()
            plugged.append(locked | free | {"is_allowed": False})
            await expect(page.get_by_text(station.text("link.fault.no_serial_permission"))).to_be_visible()
            plugged.append(cube | free)
            port, baud = (station.choice(page.locator("form"), key) for key in ("link.device", "link.baud"))
            await expect(port).to_have_value(device)
            await expect(baud).to_have_value("115200")
            await expect(page.get_by_text(station.text("link.port.new"))).to_be_visible()
            await page.get_by_role("button", name=station.text("setting.add"), exact=True).click()
            added = page.get_by_role("listitem").filter(has_text="Hex CubeOrange")
            await expect(added).to_contain_text(station.text("link.up"))
            # What a person has chosen stays chosen.
            await port.select_option("/dev/ttyUSB0")
            plugged.append(cube | free | {"device": "/dev/ttyACM9"})
            await expect(port.get_by_role("option")).to_have_count(4)
            await expect(port).to_have_value("/dev/ttyUSB0")
    finally:
        os.close(plane_end)
        os.close(port_end)


def place_of(told: str) -> str:
    found = re.search(r"-?\d+\.\d+, -?\d+\.\d+", told)
    assert found is not None, told
    return found[0]


async def test_e9_the_network_is_cut_on_the_browsers_side(open_station: OpenStation, serve: Serve) -> None:
    with Plane() as plane:
        served = serve("--link", plane.link)
        with TcpRelay(port_of(served)) as relay:
            async with open_station(f"http://127.0.0.1:{relay.port}") as station:
                await take_off(station, plane)
                await draw_two_waypoints(station)
                before_m = await flown_m(station)
                relay.silence()
                await expect(station.lost).to_contain_text(station.like("bar.serverAwayDetail"))
                await expect(station.items).to_have_count(2)
                relay.restore()
                await see_all_resumed(station, before_m)
                # The rest of what a person has made survives even the page.
                before_m = await flown_m(station)
                await station.page.reload()
                await see_all_resumed(station, before_m, mode="CIRCLE")


async def test_e9_the_server_is_killed_and_comes_back(open_station: OpenStation, tmp_path: Path) -> None:
    with Plane() as plane, reserved_ports() as (port,), contextlib.ExitStack() as first:
        served = first.enter_context(serving("--link", plane.link, f"--port={port}", data=tmp_path))
        async with open_station(served.url) as station:
            await take_off(station, plane)
            await draw_two_waypoints(station)
            before_m = await flown_m(station)
            served.process.kill()
            first.close()
            await expect(station.lost).to_contain_text(station.like("bar.serverAwayDetail"))
            with serving("--link", plane.link, f"--port={port}", data=tmp_path):
                await see_all_resumed(station, before_m)


async def test_e9_the_network_is_cut_on_the_vehicles_side(open_station: OpenStation, serve: Serve) -> None:
    with Plane() as plane, TcpRelay(plane.port) as relay:
        served = serve("--link", f"tcp:127.0.0.1:{relay.port}")
        async with open_station(served.url) as station:
            await take_off(station, plane)
            await draw_two_waypoints(station)
            before_m = await flown_m(station)
            relay.hang_up()
            await expect(station.lost).to_contain_text(station.like("bar.lostDetail"))
            await expect(station.on_map).to_contain_text(station.like("map.estimated"))
            relay.restore()
            await see_all_resumed(station, before_m)


def port_of(served: Served) -> int:
    return int(served.url.rpartition(":")[2])
