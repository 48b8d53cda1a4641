"""Several browsers on one vehicle, and several vehicles in one browser."""

from __future__ import annotations

import re

from playwright.async_api import expect

from tests.browser.conftest import OpenStation, Serve
from tests.plane import Plane


async def test_one_has_control_and_another_asks_for_it(open_station: OpenStation, serve: Serve) -> None:
    with Plane() as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url) as first, open_station(served.url) as second:
            arm = [
                one.panel("fly").get_by_role("button", name=one.text("fly.arm"), exact=True) for one in (first, second)
            ]
            await expect(arm[0]).to_be_enabled()
            await expect(arm[1]).to_be_disabled()
            await expect(second.panel("fly").get_by_text(second.text("fly.needControl"), exact=True)).to_be_visible()
            await expect(second.page.get_by_text(second.like("control.other")).first).to_be_visible()

            await second.button("control.ask").click()
            await expect(first.page.get_by_text(first.like("control.wanted"))).to_be_visible()
            await expect(arm[1]).to_be_disabled()
            await first.button("control.give").click()
            # Given back: the one who asked takes it, or has it at once.
            take = second.button("control.take")
            await expect(
                take.or_(second.panel("fly").get_by_text(second.text("fly.ready"), exact=True))
            ).to_be_visible()
            if await take.count() > 0:
                await take.click()
            await expect(arm[1]).to_be_enabled()
            await expect(arm[0]).to_be_disabled()
            await second.arm()
            # Both see the same plane.
            await expect(first.bar("bar.motors")).to_contain_text(first.text("bar.armed"))


async def test_control_comes_free_when_its_holder_goes(open_station: OpenStation, serve: Serve) -> None:
    with Plane() as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url) as watcher_first, open_station(served.url) as second:
            await expect(second.page.get_by_text(second.like("control.other")).first).to_be_visible()
            await watcher_first.page.close()
            await second.button("control.take").click()
            await expect(
                second.panel("fly").get_by_role("button", name=second.text("fly.arm"), exact=True)
            ).to_be_enabled()


async def test_two_vehicles_are_told_apart(open_station: OpenStation, serve: Serve) -> None:
    with Plane(planes=2) as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url) as station:
            chosen = station.page.get_by_role("combobox", name=station.text("bar.selectVehicle"))
            await expect(chosen.get_by_role("option")).to_have_count(2)
            await expect(station.on_map.get_by_role("listitem")).to_have_count(2)
            await expect(station.on_map).to_contain_text(re.compile("Plane 1: .*Plane 2: ", re.DOTALL))
            await chosen.select_option(label="Plane 2")
            await station.set_mode("CIRCLE")
            await station.page.keyboard.press("Escape")
            await chosen.select_option(label="Plane 1")
            await expect(station.bar("bar.mode")).to_have_text(re.compile(r"^\s*MANUAL"))
            await station.page.locator("body").click(position={"x": 700, "y": 400})
            await station.page.keyboard.press("v")
            await expect(station.bar("bar.mode")).to_have_text(re.compile(r"^\s*CIRCLE"))
