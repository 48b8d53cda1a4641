"""Several browsers on one vehicle, and several vehicles in one browser."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from playwright.async_api import expect
from vencejo.enrolment import Organisation
from vencejo.fleet import has_fleet

from tests.browser.conftest import OpenStation, Serve
from tests.fleet.programs import command
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


@pytest.mark.skipif(not has_fleet(), reason="this build has no fleets")
async def test_a_plane_of_a_fleet_is_handed_from_one_ground_station_to_another(
    open_station: OpenStation, tmp_path: Path
) -> None:
    organisation = Organisation("acme", folder=tmp_path / "ground" / "fleet")
    organisation.init(hosts=["127.0.0.1"])
    serve = ("serve", "--port", "0", "--link", "udpin:127.0.0.1:0")
    as_router = ("--fleet", "acme", "--fleet-listen", "tls/127.0.0.1:0", "--fleet-door", "127.0.0.1:0")
    with Plane() as plane, command(tmp_path / "ground", *serve, *as_router) as first:
        at_ground = first.line()["url"]
        token = organisation.enrol_station("tower").text
        with (
            command(tmp_path / "tower", *serve, "--join", token) as second,
            command(
                tmp_path / "board", "onboard", "--join", organisation.enrol("plane7").text, "--link", plane.link
            ) as aircraft,
        ):
            at_tower = second.line()["url"]
            aircraft.until(is_connected=True, holder=None)
            async with open_station(at_ground) as ground, open_station(at_tower) as tower:
                await ground.arm()
                theirs = tower.panel("fly")
                disarm = theirs.get_by_role("button", name=tower.text("fly.disarm"), exact=True)
                held = theirs.get_by_text(tower.like("control.vehicle.other"))
                await expect(held).to_contain_text("ground · station")
                await expect(disarm).to_be_disabled()
                await tower.button("control.ask").click()
                wanted = ground.page.get_by_text(ground.like("control.vehicle.wanted"))
                await expect(wanted).to_contain_text("tower · station")
                await ground.button("control.keep").click()
                await expect(theirs.get_by_text(tower.like("control.vehicle.declined"))).to_be_visible()
                await tower.button("control.askAgain").click()
                await ground.button("control.give").click()
                await expect(disarm).to_be_enabled()
                await expect(ground.panel("fly").get_by_text(ground.like("control.vehicle.other"))).to_be_visible()
                release = tower.button("control.vehicle.release", vehicle="plane7")
                await release.click()
                await expect(release).to_have_count(0)


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
