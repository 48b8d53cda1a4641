"""Parameters: read by themselves, searched, set and seen to be verified, told to another browser, and written from a file."""

from __future__ import annotations

import re
from pathlib import Path

from playwright.async_api import Locator, expect

from tests.browser.chromium import PHONE
from tests.browser.conftest import OpenStation, Serve
from tests.browser.station_page import StationPage
from tests.plane import Plane

DRAWN = 60
"""More rows than this in the document are not only those in sight."""


def row(station: StationPage, name: str) -> Locator:
    """The row of a parameter, by which it is opened and closed."""
    return station.panel("params").get_by_role("button", name=re.compile(rf"^{name}\b"))


async def search(station: StationPage, text: str) -> None:
    """Type into the search."""
    await station.panel("params").get_by_role("searchbox").fill(text)


async def type_value(station: StationPage, name: str, text: str) -> Locator:
    """Open a parameter and type a value for it."""
    await row(station, name).click()
    field = station.field(station.panel("params"), "params.value", name=name)
    await expect(field).to_be_focused()
    await field.fill(text)
    return field


async def test_parameters_are_read_searched_and_set(open_station: OpenStation, serve: Serve) -> None:
    with Plane() as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url) as station, open_station(served.url, language="es", size=PHONE) as other:
            await station.have_control()
            panel = await station.open_panel("params")
            await expect(panel.get_by_text(station.text("params.count", count=1399), exact=True)).to_be_visible()
            assert await panel.get_by_role("listitem").count() < DRAWN

            await search(station, "rtl autoland")
            await expect(
                panel.get_by_text(station.text("params.found", shown=1, count=1399), exact=True)
            ).to_be_visible()
            field = await type_value(station, "RTL_AUTOLAND", "1.5")
            await expect(panel.get_by_text(station.text("params.fault.whole"), exact=True)).to_be_visible()
            await field.fill("1")
            await field.press("Enter")
            await expect(row(station, "RTL_AUTOLAND")).to_contain_text(
                station.text("params.wasSet", value="1", was="0")
            )
            # The keyboard is back at the row: the arrows go on from it.
            await expect(row(station, "RTL_AUTOLAND")).to_be_focused()
            # Only what is no default, and back to it.
            await search(station, "")
            await panel.get_by_role("checkbox", name=re.compile(re.escape(station.text("params.changedOnly")))).check()
            await row(station, "RTL_AUTOLAND").click()
            await panel.get_by_role("button", name=station.like("params.toDefault")).click()
            field = station.field(panel, "params.value", name="RTL_AUTOLAND")
            await expect(field).to_have_value("0")
            await field.press("Enter")
            await expect(row(station, "RTL_AUTOLAND")).to_have_count(0)
            # The row has left the list: the keyboard is at its neighbour, or at the search of an empty list.
            await expect(panel.locator(":is([data-row], [type=search]):focus")).to_have_count(1)
            await panel.get_by_role("checkbox").uncheck()

            # Another browser types a value, which it may not send, while this one sets it.
            theirs = await other.open_panel("params")
            await search(other, "wp_radius")
            await row(other, "WP_RADIUS").click()
            await expect(theirs.get_by_text(other.text("fly.needControl"), exact=True)).to_be_visible()
            await search(station, "wp_radius")
            await (await type_value(station, "WP_RADIUS", "61")).press("Enter")
            await expect(row(station, "WP_RADIUS")).to_contain_text(station.like("params.wasSet"))
            await expect(theirs.get_by_text(other.text("params.told", value="61 m"))).to_be_visible()
            await expect(row(other, "WP_RADIUS")).to_contain_text("61 m")

            # While it is armed the button is held, and Enter does nothing.
            await station.arm()
            field = await type_value(station, "WP_RADIUS", "62")
            await field.press("Enter")
            await expect(panel.get_by_text(station.text("params.holdArmed"), exact=True)).to_be_visible()
            await station.hold(
                panel.get_by_role("button", name=re.compile(f"^{station.text('params.set')}: ")),
                until=row(station, "WP_RADIUS").get_by_text(re.compile("62 m.*61 m")),
            )


async def test_a_file_is_compared_and_written(open_station: OpenStation, serve: Serve, tmp_path: Path) -> None:
    path = tmp_path / "field.param"
    path.write_text("WP_RADIUS,70\nWP_LOITER_RAD,60\nFENCE_ENABLE,0\nNO_SUCH_NAME,5\nFENCE_ALT_MAX,120\n")
    with Plane(params={"FENCE_ENABLE": 1}) as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url) as station:
            await station.have_control()
            panel = await station.open_panel("params")
            await expect(panel.get_by_text(station.text("params.count", count=1399), exact=True)).to_be_visible()
            async with station.page.expect_file_chooser() as chooser:
                await station.button("params.open").click()
            await (await chooser.value).set_files(path)
            differing = panel.get_by_role("listitem")
            await expect(differing).to_have_count(4)
            await expect(panel.get_by_text(station.text("params.fileUnknown", count=1), exact=True)).to_be_visible()
            await panel.get_by_role("checkbox", name=station.text("params.chooseOne", name="WP_LOITER_RAD")).uncheck()
            await station.button("params.write", count=3).click()
            # What switches the fence off wants to be confirmed, and is told at its row.
            written = station.text("params.writtenRefused", set=2, refused=1)
            await expect(panel.get_by_text(written, exact=True)).to_be_visible()
            await expect(differing).to_have_count(2)
            fence = differing.filter(has_text="FENCE_ENABLE")
            await station.hold(
                fence.get_by_role("button", name=re.compile(station.text("params.confirm"))),
                until=expect(fence).to_have_count(0),
            )
            await station.button("params.back").click()

            async with station.page.expect_download() as download:
                await station.button("params.save").click()
            saved = (await (await download.value).path()).read_text()
            assert len(saved.splitlines()) == 1399
            assert "WP_RADIUS,70\n" in saved
            assert "WP_LOITER_RAD,80\n" in saved
