"""Many vehicles in one browser: the list, group actions, and the marks on the map."""

from __future__ import annotations

import re

from playwright.async_api import expect

from tests.browser.conftest import OpenStation, Serve
from tests.plane import Plane
from tests.support import wait_for


async def test_a_fleet_is_found_marked_and_told_together(open_station: OpenStation, serve: Serve) -> None:
    with Plane(planes=3) as plane:
        served = serve("--link", plane.link)
        before = served.client(name="before")
        wait_for(lambda: len(before.done("GET", "vehicles")) == 3, "three planes")
        for number in (1, 2):
            before.done("POST", f"vehicles/{number}/arm")
        before.done("POST", "control/release")
        async with open_station(served.url) as station:
            panel = await station.open_panel("fleet")
            rows = panel.get_by_role("grid", name=station.text("fleet.list")).get_by_role("row")
            await expect(rows).to_have_count(3)

            search = panel.get_by_role("searchbox")
            await search.fill("PLANE 2")
            await expect(rows).to_have_count(1)
            await search.fill("")
            await expect(rows).to_have_count(3)

            # By keys alone: to the last row, show it, mark it, and all.
            await rows.get_by_role("button", name=re.compile("Plane 1")).focus()
            await station.page.keyboard.press("End")
            await station.page.keyboard.press("Enter")
            await expect(rows.nth(2).get_by_role("button")).to_have_attribute("aria-current", "true")
            await station.page.keyboard.press("Space")
            await expect(rows.nth(2)).to_have_attribute("aria-selected", "true")
            await expect(panel.get_by_text(station.text("fleet.marked", count=1), exact=True).first).to_be_visible()
            await station.button("fleet.markAll").click()

            name = f"{station.text('command.loiter')}: {station.text('fleet.marked', count=3)}"
            answers = panel.get_by_role("list", name=station.text("fleet.answers", act=station.text("command.loiter")))
            await station.hold(panel.get_by_role("button", name=name, exact=True), until=answers)
            done = station.text("fleet.state.done")
            await expect(answers.get_by_role("listitem").filter(has_text=done)).to_have_count(2)
            refused = answers.get_by_role("listitem").filter(has_text="Plane 3")
            await expect(refused).to_contain_text(station.text("fleet.isDisarmed"))
            await expect(rows.filter(has_text="LOITER")).to_have_count(2)
            assert [vehicle["mode"] for vehicle in before.done("GET", "vehicles")] == ["LOITER", "LOITER", "MANUAL"]

            await panel.get_by_role("textbox", name=station.text("fleet.groupName")).fill("north")
            await station.button("fleet.keepGroup").click()
            await expect(station.choice(panel, "fleet.group")).to_have_value("north")
