"""The plan panel: edited, undone, saved, loaded, sent, compared, read and cleared."""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.async_api import Locator, expect
from vencejo import Plan

from tests.browser.conftest import OpenStation, Serve
from tests.browser.station_page import StationPage
from tests.plane import Plane, offset
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
    await station.panel("plan").get_by_label(station.text("file.format")).select_option(kind.removeprefix("."))
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


def is_way_of_two(payload: str | bytes) -> bool:
    """Whether it is the answer about a plan of two items."""
    answer = json.loads(payload)
    return answer["type"] == "way" and len(answer["stops"]) == 2


async def test_a_newcomer_draws_a_plan_before_there_is_a_plane(open_station: OpenStation, serve: Serve) -> None:
    served = serve("--link", "udpin:127.0.0.1:0")
    async with open_station(served.url) as station:
        told: asyncio.Future[Any] = asyncio.get_running_loop().create_future()

        def hear(payload: str | bytes) -> None:
            if is_way_of_two(payload) and not told.done():
                told.set_result(json.loads(payload))

        # Over whichever connection it comes: that of the page before may be told of late, and one may be opened anew.
        station.page.on("websocket", lambda socket: socket.on("framereceived", hear))
        await station.page.reload()
        draw = station.button("welcome.plan")
        await draw.click()
        await expect(draw, "nothing lies over what is drawn").to_have_count(0)
        await station.close_panel("plan")
        await expect(draw, "nor afterwards").to_have_count(0)
        await station.open_panel("plan")
        boxes = [
            station.page.get_by_role("region", name=station.text(key)) for key in ("rehearsal.box", "plan.profile")
        ]
        for box in boxes:
            await expect(box, "there is nothing to show in it").to_have_count(0)
        left, top, right, bottom = await station.free_map()
        y = (top + bottom) / 2
        await station.page.mouse.click(left + 0.3 * (right - left), y)
        await expect(station.items).to_have_count(1)
        await station.page.mouse.click(left + 0.6 * (right - left), y)
        # the way between them is the core's
        second = (await asyncio.wait_for(told, 120))["stops"][1]
        assert (second["item"], second["leg"]["from_item"], second["leg"]["kind"]) == (2, 1, "flown")
        await expect(station.items.nth(1)).to_contain_text(f"{round(second['leg']['course_deg']):03}°")

        # A plan that is opened comes into view, wherever it lies.
        await open_file(station, DEMO)
        await expect(station.items).to_have_count(len(Plan.load(DEMO)))
        for box in boxes:
            await expect(box).to_be_visible()
        scale = await station.map_scale()
        left, top, right, bottom = await station.free_map()
        seen = [scale.pixel(item.lat_deg, item.lon_deg) for item in Plan.load(DEMO) if item.lat_deg and item.lon_deg]
        assert all(left < x < right and top < y < bottom for x, y in seen)
        assert max(x for x, _ in seen) - min(x for x, _ in seen) > 50


async def test_a_plan_is_edited_undone_and_kept(open_station: OpenStation, serve: Serve) -> None:
    with Plane() as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url) as station:
            await expect(station.bar("bar.gps")).to_contain_text("RTK")
            panel = await station.open_panel("plan")
            await station.leave_view_alone()
            await station.show_plane()
            await station.click_map(offset(120, -120), offset(120, 60), offset(-60, 60))
            await expect(station.items).to_have_count(3)
            await expect(station.page.get_by_role("region", name=station.text("plan.profile"))).to_be_visible()
            free = await station.free_map()
            assert await heights(station) == ["80", "80", "80"]
            undo, redo = station.button("plan.undo"), station.button("plan.redo")

            await follow_the_rehearsal(station)
            assert await station.free_map() == free, "what is rehearsed does not move what lies under the pointer"

            # Values of one item: in the table, and in its details.
            await station.type_into(height_of(station, 2), "95")
            await station.item(3).click()
            details = panel.get_by_role("group", name=station.text("plan.details", number=3))
            await station.type_into(station.field(details, "plan.latitude"), "40.3311111")
            await station.choice(details, "plan.command").select_option(label=station.text("kind.loiter_turns"))
            await station.type_into(station.field(details, "param.turns"), "3")
            await expect(station.items.nth(2)).to_contain_text(station.text("kind.loiter_turns"))
            await station.type_into(height_of(station, 1), "nonsense")
            await expect(panel.get_by_role("alert")).to_have_text(station.text("plan.invalid"))
            assert await heights(station) == ["nonsense", "95", "80"], "it stays until it is corrected"
            await height_of(station, 1).press("Escape")
            assert await heights(station) == ["80", "95", "80"], "what is not a number is not taken"
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


async def test_a_survey_is_drawn_changed_saved_and_opened(
    open_station: OpenStation, serve: Serve, tmp_path: Path
) -> None:
    with Plane() as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url) as station:
            await expect(station.bar("bar.gps")).to_contain_text("RTK")
            panel = await station.open_panel("plan")
            await station.leave_view_alone()
            await station.show_plane()
            await station.add_kind("survey")
            corners = [offset(240, -240), offset(240, 240), offset(-40, 240), offset(60, -240)]
            # The first again closes it.
            await station.click_map(*corners, corners[0])
            survey = panel.get_by_role("region", name=station.text("survey.ofArea"), exact=True)
            area = survey.locator(f"dt:text-is({station.text('survey.area')!r}) + dd")
            # The lines are laid out by the server.
            await expect(area).to_have_text(re.compile(r"\d"))
            before = await station.figure(area)
            scale = await station.map_scale()
            held, to = scale.pixel(*corners[2]), scale.pixel(*offset(-90, 290))
            await station.page.mouse.move(*held)
            await station.page.mouse.down()
            await station.page.mouse.move(*to, steps=5)
            await station.page.mouse.up()

            async def is_larger() -> bool:
                return await station.figure(area) > before + 0.5

            await station.eventually(is_larger, "the area follows the corner")
            await station.type_into(station.field(survey, "survey.front"), "60")
            await survey.get_by_role("button", name=station.text("survey.done"), exact=True).click()
            row = station.items.filter(has_text=station.text("survey.open"))
            await expect(row).to_have_count(1)
            # Its items are folded until they are asked for.
            await expect(station.items).to_have_count(1)
            await row.get_by_role("button", name=station.text("survey.showItems"), exact=True).click()
            await expect(row).to_have_count(1)
            assert await station.items.count() > 20

            # It goes into a file as one, and can be opened from it.
            saved = await save_as(station, ".plan", tmp_path)
            written = json.loads(saved.read_text(encoding="utf-8"))["mission"]["items"]
            assert [item["complexItemType"] for item in written] == ["survey"]
            await panel.get_by_role("button", name=station.text("plan.clear.mission"), exact=True).click()
            await expect(row).to_have_count(0)
            await open_file(station, saved)
            await row.get_by_role("button").first.click()
            await expect(station.field(survey, "survey.front")).to_have_value("60")
            await survey.get_by_role("button", name=station.text("survey.done"), exact=True).click()

            # One item by hand, and they are plain items, until that is undone.
            await row.get_by_role("button", name=station.text("survey.showItems"), exact=True).click()
            await station.type_into(height_of(station, 1), "150")
            edited = panel.get_by_text(station.text("complex.edited", name=station.text("complex.survey")))
            await expect(edited).to_be_visible()
            await expect(row).to_have_count(0)
            await station.page.keyboard.press("Control+z")
            await expect(edited).to_have_count(0)
            await expect(row).to_have_count(1)

            # Without a landing it is not fine; the remedy is one click away.
            add = station.text("fix.add-landing", course_deg="")
            await panel.get_by_role("button", name=add).click()
            await expect(station.items.last).to_contain_text(station.text("kind.land"))


async def follow_the_rehearsal(station: StationPage) -> None:
    """See the track of a few points on the map, change its wind, and go through it."""

    def is_drawn(more_than: int) -> Callable[[], Awaitable[bool]]:
        async def look() -> bool:
            return await rehearsed_pixels(station) > more_than

        return look

    panel = station.panel("plan")
    await station.eventually(is_drawn(100), "the track on the map")
    told = panel.get_by_text(station.like("rehearsal.total"))
    await expect(told).to_contain_text(station.text("wind.calm"))
    calm = await told.inner_text()
    wind = station.page.get_by_role("slider", name=station.text("wind.handle"), exact=True)
    await station.page.get_by_role("button", name=re.compile(station.text("wind.label"))).click()
    for key in ("PageUp", "ArrowRight"):
        await wind.press(key)
    await expect(wind).to_have_attribute("aria-valuetext", re.compile("^5.0 m/s .* 185°$"))
    await expect(told).to_contain_text("5.0 m/s")
    assert await told.inner_text() != calm
    await station.button("wind.own").click()
    # Of a plane that has just been switched on more becomes known meanwhile, such as its home: the figures need not be the first ones.
    await expect(told).to_contain_text(station.text("wind.calm"))

    scrubber = station.page.get_by_role("slider", name=station.text("rehearsal.scrub"), exact=True)
    track = await rehearsed_pixels(station)
    await scrubber.press("End")
    await station.eventually(is_drawn(track + 50), "the plane on the map")
    item = f"{station.text('rehearsal.item')} "
    last = await scrubber.get_attribute("aria-valuetext")
    await scrubber.press("Home")
    await expect(scrubber).to_have_attribute("aria-valuetext", re.compile(f"{item}1"))
    assert last != await scrubber.get_attribute("aria-valuetext")

    what_if = station.page.get_by_role("combobox", name=station.text("what-if.title"), exact=True)
    answer = station.page.locator(".told")
    await what_if.select_option("return-asked")
    await expect(answer).to_have_text(station.text("what-if.move"))
    for _ in range(3):
        await scrubber.press("PageUp")
    await expect(answer).to_contain_text(station.text("what-if.reaction.returns"))
    await expect(answer).to_contain_text(station.text("rehearsal.ending.returned"))
    await what_if.select_option("link-lost")
    await expect(answer).to_have_text(station.text("what-if.no-action"))
    await what_if.select_option("engine-stopped")
    await expect(answer).to_contain_text(station.like("what-if.glide"))
    # In a folded box too: the map goes on drawing it.
    fold = station.page.get_by_role("button", name=station.text("rehearsal.box"), exact=True)
    await fold.click()
    async with station.page.expect_request(re.compile("/what-if")):
        await wind.press("PageUp")
    await fold.click()
    await station.button("wind.own").click()
    await what_if.select_option(label=station.text("what-if.nothing"))
    await expect(answer).to_be_empty()

    await expect(panel.get_by_text(station.text("battery.unknown.power"))).to_be_visible()
    await panel.get_by_text(station.text("battery.said"), exact=True).click()
    for key, value in (("power_cruise_w", "100"), ("capacity_mah", "10"), ("voltage_v", "11.1")):
        field = panel.get_by_label(re.compile(f"^{re.escape(station.text(f'battery.said.{key}'))}"))
        await field.first.fill(value)
        await field.first.press("Enter")
    await expect(panel.get_by_text(station.like("battery.none")).first).to_be_visible()
    charge = station.text("battery.said.capacity_mah")
    back = station.text("survey.back", what=charge, auto=station.text("battery.said.unknown"))
    await panel.get_by_role("button", name=back, exact=True).click()
    await expect(panel.get_by_text(station.text("battery.unknown.capacity"))).to_be_visible()
    await panel.get_by_role("button", name=station.text("odds.ask"), exact=True).click()
    hide = panel.get_by_role("button", name=station.text("odds.hide"), exact=True)
    await expect(panel.get_by_text(station.text("odds.returned", part="100 %"))).to_be_visible()
    await hide.click()
    await expect(hide).to_have_count(0)
    await panel.get_by_role("button", name=station.text("rehearsal.read"), exact=True).click()
    await expect(panel.get_by_text(station.text("rehearsal.unread"), exact=True)).to_have_count(0)


async def rehearsed_pixels(station: StationPage) -> int:
    """How many pixels of the map have the colour of what is rehearsed."""
    count: int = await station.map.evaluate(
        """map => {
            const token = getComputedStyle(document.documentElement).getPropertyValue('--color-rehearsed').trim();
            const [red, green, blue] = [1, 3, 5].map(at => parseInt(token.slice(at, at + 2), 16));
            let count = 0;
            for (const canvas of map.querySelectorAll('canvas[aria-hidden]')) {
                // of a copy: a canvas that is read is kept elsewhere by the browser from then on
                const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', {
                    willReadFrequently: true,
                });
                copy.drawImage(canvas, 0, 0);
                const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
                for (let at = 0; at < data.length; at += 4)
                    if (data[at] === red && data[at + 1] === green && data[at + 2] === blue) count += 1;
            }
            return count;
        }"""
    )
    return count


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
    with Plane() as plane:
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

            # Whatever grows between what is seen and what is about to be held, that stays under the pointer.
            clear = panel.get_by_role("button", name=station.text("plan.clearVehicle.mission"), exact=True)
            rehearsed = panel.get_by_text(station.text("odds.ask"), exact=True)
            await expect(rehearsed).to_be_visible()
            await clear.hover()
            place = await clear.bounding_box()
            await rehearsed.evaluate(
                """element => {
                    element.style.marginTop = '200px';
                    return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
                }"""
            )
            # Panels scroll by whole pixels; what grows, as a rehearsal's answer may just then, need not.
            assert await clear.bounding_box() == pytest.approx(place, abs=0.999)
            await station.hold(
                clear,
                until=panel.get_by_text(station.text("plan.state.not-sent"), exact=True),
            )
            await expect(station.items).to_have_count(len(demo))
