"""The plan panel: edited, undone, saved, loaded, sent, compared, read and cleared."""

from __future__ import annotations

import re
from pathlib import Path

from playwright.async_api import Locator, expect
from vencejo import Plan

from tests.browser.conftest import OpenStation, Serve
from tests.browser.plane import Plane, offset
from tests.browser.station_page import StationPage
from tests.support import ROOT

DEMO = ROOT / "python" / "vencejo" / "data" / "demo.waypoints"


def height_of(station: StationPage, number: int) -> Locator:
    """The height of an item in the table."""
    name = f"{station.text('plan.number', number=number)}: {station.text('plan.height')}"
    return station.panel("plan").get_by_role("textbox", name=name, exact=True)


async def heights(station: StationPage) -> list[str]:
    count = await station.items.count()
    return [await height_of(station, number).input_value() for number in range(1, count + 1)]


async def open_file(station: StationPage, path: Path) -> None:
    """Choose a file as a person does."""
    async with station.page.expect_file_chooser() as choosing:
        await station.panel("plan").get_by_role("button", name=station.text("plan.open"), exact=True).click()
    await (await choosing.value).set_files(path)


async def save_as(station: StationPage, kind: str, folder: Path) -> Path:
    """Save to a file as a person does."""
    async with station.page.expect_download() as loading:
        await (
            station.panel("plan")
            .get_by_role("button", name=station.text("plan.saveAs", format=kind), exact=True)
            .click()
        )
    download = await loading.value
    assert download.suggested_filename.endswith(kind)
    path = folder / f"saved{kind}"
    await download.save_as(path)
    return path


async def test_a_plan_is_edited_undone_and_kept(open_station: OpenStation, serve: Serve) -> None:
    with Plane(speedup=20.0) as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url) as station:
            await expect(station.bar("bar.gps")).to_contain_text("RTK")
            panel = await station.open_panel("plan")
            await station.leave_view_alone()
            await station.show_plane()
            await station.click_map(offset(120, -120), offset(120, 60), offset(-60, 60))
            await expect(station.items).to_have_count(3)
            assert await heights(station) == ["80", "80", "80"]
            undo, redo = station.button("plan.undo"), station.button("plan.redo")

            # Values of one item: in the table, and in its details.
            await station.type_into(height_of(station, 2), "95")
            await station.item(3).click()
            details = panel.get_by_role("group", name=station.text("plan.details", number=3))
            await station.type_into(station.field(details, "plan.latitude"), "40.3311111")
            await station.choice(details, "plan.command").select_option(label=station.text("kind.loiter_turns"))
            await station.type_into(station.field(details, "param.turns"), "3")
            await expect(station.items.nth(2)).to_contain_text(station.text("kind.loiter_turns"))
            await station.type_into(height_of(station, 1), "nonsense")
            assert await heights(station) == ["80", "95", "80"], "what is no number is not taken"
            for _ in range(4):
                await undo.click()
            assert await heights(station) == ["80", "80", "80"]
            await expect(station.items.nth(2)).to_contain_text(station.text("kind.waypoint"))
            for _ in range(4):
                await redo.click()
            await expect(redo).to_be_disabled()
            assert await heights(station) == ["80", "95", "80"]
            await expect(station.items.nth(2)).to_contain_text(station.text("kind.loiter_turns"))

            # Order: by keys, by the details' buttons, by the handle.
            await station.item(3).click()
            await station.page.keyboard.press("Alt+ArrowUp")
            await expect(station.items.nth(1)).to_contain_text(station.text("kind.loiter_turns"))
            await details_button(station, 2, "plan.up").click()
            await expect(station.items.nth(0)).to_contain_text(station.text("kind.loiter_turns"))
            await drag_to(station, 1, 3)
            await expect(station.items.nth(2)).to_contain_text(station.text("kind.loiter_turns"))

            # Several at once.
            await station.item(1).click()
            await station.item(2).click(modifiers=["Shift"])
            await expect(panel.get_by_text(station.text("plan.selected", count=2), exact=True)).to_be_visible()
            await station.type_into(station.field(panel, "plan.setAlt"), "70")
            assert await heights(station) == ["70", "70", "80"]
            await station.button("plan.deleteMany", count=2).click()
            await expect(station.items).to_have_count(1)
            await station.page.keyboard.press("Control+z")
            await expect(station.items).to_have_count(3)

            # The draft survives the page.
            await station.page.reload()
            await expect(station.items).to_have_count(3)
            assert await heights(station) == ["70", "70", "80"]


def details_button(station: StationPage, number: int, key: str) -> Locator:
    details = station.panel("plan").get_by_role("group", name=station.text("plan.details", number=number))
    return details.get_by_role("button", name=station.text(key), exact=True)


async def drag_to(station: StationPage, number: int, to: int) -> None:
    """Drag an item by its handle below another."""
    grip = station.button("plan.dragItem", number=number)
    box = await station.items.nth(to - 1).bounding_box()
    assert box is not None
    await grip.hover()
    await station.page.mouse.down()
    await station.page.mouse.move(box["x"] + 20, box["y"] + box["height"] / 2, steps=5)
    # the rows move while one is dragged: aim again
    box = await station.items.nth(to - 1).bounding_box()
    assert box is not None
    await station.page.mouse.move(box["x"] + 20, box["y"] + box["height"] - 2, steps=5)
    await station.page.mouse.up()


async def test_a_plan_goes_to_files_and_to_the_vehicle_and_back(
    open_station: OpenStation, serve: Serve, tmp_path: Path
) -> None:
    demo = Plan.load(DEMO)
    with Plane(speedup=20.0) as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url) as station:
            panel = await station.open_panel("plan")
            await expect(station.bar("bar.gps")).to_contain_text("RTK")
            await expect(station.plan_state).to_have_text(station.text("plan.state.empty"))

            await open_file(station, DEMO)
            await expect(station.items).to_have_count(len(demo))
            for kind in (".plan", ".waypoints"):
                saved = await save_as(station, kind, tmp_path)
                assert Plan.load(saved).items == demo.items
            bad = tmp_path / "bad.plan"
            bad.write_text("{}")
            await open_file(station, bad)
            fault = panel.get_by_role("alert")
            await expect(fault).to_be_visible()
            await fault.get_by_role("button", name=station.text("answer.dismiss")).click()
            await expect(fault).to_have_count(0)
            await expect(station.items).to_have_count(len(demo))

            await station.send_plan()
            await expect(station.bar("bar.item")).to_contain_text(re.compile(rf"of {len(demo)}|–"))
            await station.type_into(height_of(station, 3), "111")
            await expect(station.plan_state).to_have_text(station.text("plan.state.differs"))
            await panel.get_by_text(station.text("plan.diff", count=1), exact=True).click()
            told = station.text("plan.diff.height", was="100.0 m")
            await expect(panel.get_by_text(station.text("plan.diff.changed", draft=3, fields=told))).to_be_visible()
            await station.button("plan.undo").click()
            await expect(station.plan_state).to_have_text(station.text("plan.state.verified"))

            await panel.get_by_role("button", name=station.text("plan.clear.mission"), exact=True).click()
            await expect(panel.get_by_text(station.text("plan.noItems"), exact=True)).to_be_visible()
            await expect(station.plan_state).to_have_text(station.text("plan.state.differs"))
            await panel.get_by_role("button", name=station.text("plan.read"), exact=True).click()
            await expect(station.items).to_have_count(len(demo))
            await expect(station.plan_state).to_have_text(station.text("plan.state.verified"))

            await station.hold(
                panel.get_by_role("button", name=station.text("plan.clearVehicle.mission"), exact=True),
                until=panel.get_by_text(station.text("plan.state.not-sent"), exact=True),
            )
            await expect(station.items).to_have_count(len(demo))
