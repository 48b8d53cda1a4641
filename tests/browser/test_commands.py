"""Commands: refused with reasons and remedies, given by keyboard alone, by a screen reader's presses, and by touch."""

from __future__ import annotations

import re
from pathlib import Path

from playwright.async_api import Locator, expect
from vencejo import MissionItem, Plan

from tests.browser.chromium import PHONE
from tests.browser.conftest import OpenStation, Serve
from tests.browser.station_page import StationPage
from tests.browser.test_plan import open_file
from tests.plane import Plane, offset

STRIDE = 8
SHORT_PRESS = """() => {
    for (const kind of ['keydown', 'keyup'])
        document.activeElement.dispatchEvent(new KeyboardEvent(kind, { key: 'Enter', bubbles: true, cancelable: true }));
}"""
"""However long a busy machine takes between a key's way down and up."""
TWO_PRESSES = """async (button, motors) => {
    button.dispatchEvent(new MouseEvent('click', { bubbles: true }));
    await new Promise(requestAnimationFrame);
    const seen = [button.textContent.trim(), motors.textContent.trim()];
    button.dispatchEvent(new MouseEvent('click', { bubbles: true }));
    return seen;
}"""
"""The second counts within six seconds; what is seen between the two."""
TABS = 160
"""More presses of the Tab key than this to reach something is not within reach."""


async def test_a_refusal_to_arm_lists_reasons_and_remedies(
    open_station: OpenStation, serve: Serve, tmp_path: Path
) -> None:
    landing = (
        MissionItem.land_start(*offset(0, 900), alt_rel_home_m=60.0),
        MissionItem.waypoint(*offset(0, 450), alt_rel_home_m=35.0),
        MissionItem.land(*offset(0, 0)),
    )
    path = tmp_path / "landing.waypoints"
    Plan(items=(MissionItem.takeoff(*offset(0, -200), alt_rel_home_m=50.0), *landing)).save(path)
    with Plane(params={"RTL_AUTOLAND": 0}) as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url) as station:
            fly = await station.open_panel("fly")
            await expect(fly.get_by_text(station.text("fly.ready"), exact=True)).to_be_visible()
            arm = fly.get_by_role("button", name=station.text("fly.arm"), exact=True)
            await station.set_mode("RTL")
            await station.refuse_to_arm("refusal.mode-not-armable", cure="MANUAL")
            refused = station.answer("arm", "refused")
            await refused.get_by_role("button", name=station.text("answer.dismiss")).click()
            await expect(refused).to_have_count(0)
            await station.set_mode("MANUAL")

            await station.open_panel("plan")
            await open_file(station, path)
            await station.send_plan()
            await expect(fly.get_by_text(station.text("fly.notReady"), exact=True)).to_be_visible()
            await station.hold(arm, until=refused)
            for part in ("refusal.landing-needs-rtl-autoland", "refusal.landing-needs-rtl-autoland.remedy"):
                await expect(refused).to_contain_text(station.text(part))
            await expect(refused).to_contain_text(re.compile("The vehicle says: .*RTL_AUTOLAND"))
            await expect(station.bar("bar.motors")).to_contain_text(station.text("bar.disarmed"))

            # The parameter that is named leads to where it is set.
            await refused.get_by_role("button", name="RTL_AUTOLAND", exact=True).first.click()
            await expect(station.panel("params").get_by_role("searchbox")).to_have_value("RTL_AUTOLAND")
            await expect(
                station.panel("params").get_by_role("button", name=re.compile("^RTL_AUTOLAND"))
            ).to_be_visible()


async def test_a_mission_is_flown_by_keyboard_alone(open_station: OpenStation, serve: Serve) -> None:
    with Plane() as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url) as station:
            keys = station.page.keyboard
            await expect(station.page.get_by_text(station.text("fly.ready"), exact=True)).to_be_visible()
            await keys.press("p")
            await expect(station.panel("plan")).to_be_visible()
            await tab_to(station, station.button("map.showPlane"))
            await keys.press("Enter")
            # The middle of the map is where Enter adds; the arrows move the map.
            await tab_to(station, station.map)
            for _ in range(2):
                await keys.press("ArrowLeft")
                await station.two_frames()
                before = await station.items.count() if await station.item(1).count() > 0 else 0
                await keys.press("Enter")
                await expect(station.item(before + 1)).to_be_visible()
            await tab_to(
                station, station.panel("plan").get_by_role("button", name=station.text("plan.send"), exact=True)
            )
            await keys.press("Enter")
            await expect(station.plan_state).to_have_text(station.text("plan.state.verified"))
            fly = station.panel("fly")
            for key, command in (("fly.arm", "arm"), ("fly.start", "mission/start")):
                await expect(fly.get_by_role("button", name=station.text(key), exact=True)).to_be_enabled()
                await tab_to(station, fly.get_by_role("button", name=station.text(key), exact=True))
                # Too short a press does nothing but say what is wanted.
                await station.page.evaluate(SHORT_PRESS)
                await expect(fly.get_by_text(station.text("fly.hold"), exact=True).first).to_be_visible()
                await expect(fly.get_by_role("button", name=station.text(key), exact=True)).to_be_visible()
                await keys.down("Enter")
                await station.see_accepted(command)
                await keys.up("Enter")
            await station.see_mode("AUTO")
            # A large change of height is held: Enter in its field sends nothing, however often.
            height = fly.get_by_role("textbox", name=re.compile(re.escape(station.text("fly.height"))))
            await height.fill("1000")
            for _ in range(3):
                await keys.press("Enter")
            await station.two_frames()
            assert await fly.get_by_label(station.text("answer.label"), exact=True).count() <= 2, (
                "of arming and starting"
            )
            await expect(height).to_have_value("1000")


async def tab_to(station: StationPage, wanted: Locator) -> None:
    """Go with the Tab key until something has the focus."""
    keys = station.page.keyboard
    has_focus = "element => element === document.activeElement"
    # several steps at a time, and back when it was passed
    await wanted.evaluate(
        "element => element.addEventListener('focus', () => (element.dataset.met = ''), { once: true })"
    )
    for _ in range(TABS // STRIDE):
        for _ in range(STRIDE):
            await keys.press("Tab")
        if await wanted.evaluate("element => 'met' in element.dataset"):
            break
    for _ in range(STRIDE):
        if await wanted.evaluate(has_focus):
            return
        await keys.press("Shift+Tab")
    raise AssertionError(f"{wanted} cannot be reached with the Tab key")


async def test_a_screen_reader_presses_twice(open_station: OpenStation, serve: Serve) -> None:
    with Plane() as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url) as station:
            fly = station.panel("fly")
            await expect(fly.get_by_text(station.text("fly.ready"), exact=True)).to_be_visible()
            # Such a press is a click without pointer or key.
            arm = fly.get_by_role("button", name=station.text("fly.arm"), exact=True)
            motors = await station.bar("bar.motors").element_handle()
            asked, shown = await arm.evaluate(TWO_PRESSES, motors)
            assert station.text("fly.pressAgain") in asked
            assert station.text("bar.disarmed") in shown
            await station.see_accepted("arm")
            await expect(station.bar("bar.motors")).to_contain_text(station.text("bar.armed"))


async def test_a_phone_plans_and_flies_by_touch(open_station: OpenStation, serve: Serve) -> None:
    with Plane() as plane:
        served = serve("--link", plane.link)
        async with open_station(served.url, size=PHONE, touch=True) as station:
            await expect(station.bar("bar.gps")).to_contain_text("RTK")
            await station.tap_panel("plan")
            await station.button("map.showPlane").tap()
            left, top, right, bottom = await station.free_map()
            for part in (0.3, 0.6):
                before = await station.items.count()
                await station.page.touchscreen.tap(left + (right - left) * part, top + (bottom - top) * 0.3)
                await expect(station.item(before if before > 1 else 1)).to_be_visible()
            await expect(station.items).to_have_count(2)
            await station.panel("plan").get_by_role("button", name=station.text("plan.send"), exact=True).tap()
            await expect(station.plan_state).to_have_text(station.text("plan.state.verified"))
            # A long touch on the map opens its menu.
            menu = station.page.get_by_role("dialog", name=station.text("menu.title"))
            async with station.touching(left + 40, top + 40):
                await expect(menu).to_be_visible()
                # However long the finger stays, its release is no click: that would close the menu, or add a waypoint.
                since_ms = await station.page.evaluate("performance.now()")
                await station.page.wait_for_function("(since_ms) => performance.now() > since_ms + 1100", arg=since_ms)
            await station.button("menu.close").tap()
            await expect(menu).to_have_count(0)

            await station.tap_panel("fly")
            fly = station.panel("fly")
            await expect(fly.get_by_text(station.text("fly.ready"), exact=True)).to_be_visible()
            for key, command in (("fly.arm", "arm"), ("fly.start", "mission/start")):
                button = fly.get_by_role("button", name=station.text(key), exact=True)
                await expect(button).to_be_enabled()
                await button.scroll_into_view_if_needed()
                box = await button.bounding_box()
                assert box is not None
                async with station.touching(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2):
                    await station.see_accepted(command)
            await station.see_mode("AUTO")
