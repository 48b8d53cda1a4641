#!/usr/bin/env python3
"""Takes the screenshots of the ground station in docs/images, with a real server, the simulated plane and Chromium.

The same seed gives the same flight, and the screenshots are taken at the same items; only the plane's progress within
an item differs between runs. Each is taken in both themes, and some in Spanish.

Usage: ``.venv/bin/python scripts/screenshots.py [--png FOLDER] [SCENE ...]``
"""

from __future__ import annotations

import argparse
import asyncio
import base64
import contextlib
import datetime
import sys
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from playwright.async_api import Browser, expect  # noqa: E402
from vencejo import GeoPoint, Home, MissionItem, Plan  # noqa: E402
from vencejo.landing import Wind, design_landing  # noqa: E402

from tests.browser.chromium import PHONE, WIDE, running  # noqa: E402
from tests.browser.relay import LossyRelay  # noqa: E402
from tests.browser.station_page import FLIGHT_MS, PATIENCE_S, TOLD, StationPage, Theme  # noqa: E402
from tests.browser.texts import Language  # noqa: E402
from tests.plane import Plane, offset  # noqa: E402
from tests.server.client import serving  # noqa: E402

OUTPUT = ROOT / "docs" / "images"
LIMIT_BYTES = 2_000_000
"""Size of all screenshots together."""
QUALITY = 0.9
DEMO = ROOT / "python" / "vencejo" / "data" / "demo.waypoints"
NOW = datetime.datetime(2026, 6, 21, 10, 0, tzinfo=datetime.timezone.utc)
"""Time of day on every screenshot."""
SPEEDUP = 10.0


def plane_in_wind(*, rtl_autoland: int, link: str = "tcp:127.0.0.1:0") -> Plane:
    """Return the plane of every screenshot: the same seed, the same air."""
    params = {"RTL_AUTOLAND": rtl_autoland}
    return Plane(link=link, speedup=SPEEDUP, wind_m_s=4.0, wind_from_deg=240.0, gust_m_s=0.5, params=params)


class Camera:
    """Takes screenshots of pages, as WebP into docs/images, and optionally as PNG elsewhere."""

    def __init__(self, browser: Browser, png: Path | None) -> None:
        self.browser = browser
        self._png = png

    @contextlib.asynccontextmanager
    async def station(
        self, url: str, *, size: tuple[int, int] = WIDE, touch: bool = False
    ) -> AsyncIterator[StationPage]:
        """Open the station in a page."""
        context = await self.browser.new_context(
            viewport={"width": size[0], "height": size[1]},
            device_scale_factor=2 if touch else 1,
            has_touch=touch,
            is_mobile=touch,
            color_scheme="dark",
            locale="en-GB",
            timezone_id="Europe/Madrid",
            reduced_motion="reduce",
        )
        page = await context.new_page()
        # Only the date is faked: Playwright's clock would also stop the map's animations.
        await page.add_init_script(
            f"{{ const real = Date.now, shift = {int(NOW.timestamp() * 1000)} - real(); Date.now = () => real() + shift; }}"
        )
        await page.add_init_script(TOLD)
        await page.goto(url)
        station = StationPage(page, is_touch=touch)
        await station.see_plane()
        yield station
        await context.close()

    async def take(self, station: StationPage, name: str, themes: tuple[Theme, ...] = ("dark", "light")) -> None:
        """Take a screenshot in both themes, or in some of them."""
        if not station.is_touch:
            await station.map_scale()
        await station.page.mouse.move(0, 0)
        await station.page.evaluate("() => document.activeElement?.blur()")
        for theme in themes:
            await station.choose_theme(theme)
            picture = await station.page.screenshot()
            if self._png is not None:
                (self._png / f"{name}-{theme}.png").write_bytes(picture)
            (OUTPUT / f"{name}-{theme}.webp").write_bytes(await self._as_webp(picture))
        await station.choose_theme("dark")
        print(f"{name}: taken", flush=True)

    async def _as_webp(self, picture: bytes) -> bytes:
        """Convert a screenshot to WebP with the browser itself."""
        page = await self.browser.new_page()
        url: str = await page.evaluate(
            """async ([png, quality]) => {
                const picture = new Image();
                picture.src = 'data:image/png;base64,' + png;
                await picture.decode();
                const canvas = Object.assign(document.createElement('canvas'), picture.naturalWidth && {
                    width: picture.naturalWidth, height: picture.naturalHeight });
                canvas.getContext('2d').drawImage(picture, 0, 0);
                return canvas.toDataURL('image/webp', quality);
            }""",
            [base64.b64encode(picture).decode(), QUALITY],
        )
        await page.close()
        return base64.b64decode(url.partition(",")[2])


async def open_plan(station: StationPage, path: Path) -> None:
    """Load a plan file."""
    panel = await station.open_panel("plan")
    async with station.page.expect_file_chooser() as choosing:
        await panel.get_by_role("button", name=station.text("plan.open"), exact=True).click()
    await (await choosing.value).set_files(path)


async def load(station: StationPage, path: Path) -> None:
    """Load a plan file and upload it."""
    await open_plan(station, path)
    await station.send_plan()
    await station.button("map.showPlan").click()


async def flight(camera: Camera, url: str) -> None:
    """Show the demo mission in flight: overview, plan, sensors, in English and Spanish."""
    async with camera.station(url) as station:
        await load(station, DEMO)
        await station.arm()
        await station.start_mission()
        await station.close_panel("plan")
        await station.button("map.showPlan").click()
        await station.see_item(5)
        await camera.take(station, "station")
        for panel, name in (("plan", "plan"), ("sensors", "sensors")):
            await station.open_panel(panel)
            await station.button("map.showPlan").click()
            if panel == "plan":
                await station.item(9).click()
            await camera.take(station, name)
        await station.choose_language("es")
        await station.open_panel("numbers")
        await station.button("map.showPlan").click()
        await camera.take(station, "station-es")


async def phone(camera: Camera, url: str) -> None:
    """Show the demo mission on a phone."""
    async with camera.station(url, size=PHONE, touch=True) as station:
        await load(station, DEMO)
        await station.arm()
        await station.start_mission()
        await station.see_item(4)
        await station.close_panel("fly")
        await station.button("map.showPlan").tap()
        await camera.take(station, "phone")


async def refused(camera: Camera, url: str, folder: Path) -> None:
    """Show the fly panel after a refusal to arm, with the reasons and remedies."""
    landing = (
        MissionItem.land_start(*offset(0, 900), alt_rel_home_m=60.0),
        MissionItem.waypoint(*offset(0, 450), alt_rel_home_m=35.0),
        MissionItem.land(*offset(0, 0)),
    )
    path = folder / "landing.waypoints"
    Plan(items=(MissionItem.takeoff(*offset(0, -200), alt_rel_home_m=50.0), *landing)).save(path)
    async with camera.station(url) as station:
        await load(station, path)
        fly = await station.open_panel("fly")
        await expect(fly.get_by_text(station.text("fly.notReady"), exact=True)).to_be_visible()
        await station.hold(
            fly.get_by_role("button", name=station.text("fly.arm"), exact=True), until=station.answer("arm", "refused")
        )
        await station.close_panel("instruments")
        await station.open_panel("messages")
        await station.button("map.showPlan").click()
        await camera.take(station, "refused")


async def lost(camera: Camera, relay: LossyRelay, url: str) -> None:
    """Show a lost plane: the bar, old values, and the ghost."""
    async with camera.station(url) as station:
        await load(station, DEMO)
        await station.arm()
        await station.start_mission()
        await station.open_panel("numbers")
        await station.see_item(3)
        await station.button("map.showPlan").click()
        relay.loss = 1.0
        await expect(station.lost).to_be_visible()

        async def is_old() -> bool:
            return await station.figure(station.number("number.lastHeard")) >= 12.0

        await station.eventually(is_old, "an old position", PATIENCE_S)
        await camera.take(station, "lost")


async def tutorial(camera: Camera, url: str, language: Language) -> None:
    """Follow the steps of docs/tutorial.md, or of the Spanish one: draw, upload, fly, land."""
    suffix = "" if language == "en" else f"-{language}"
    async with camera.station(url) as station:
        await station.choose_language(language)
        await station.close_panel("settings")
        await station.open_panel("plan")
        await station.show_plane()
        await station.choose_tool("kind.takeoff")
        await station.click_map(offset(0, -200))
        await station.click_map(offset(180, -200))
        await station.choose_tool("kind.land")
        await station.click_map(offset(0, 0))
        await expect(station.items).to_have_count(5)
        await station.send_plan()
        await station.button("map.showPlan").click()
        await camera.take(station, f"tutorial-plan{suffix}", ("light",))
        await station.arm()
        await station.start_mission()
        await station.see_item(5)
        await expect(station.bar("bar.motors")).to_contain_text(station.text("bar.disarmed"), timeout=FLIGHT_MS)
        await station.button("map.showPlan").click()
        await camera.take(station, f"tutorial-landed{suffix}", ("light",))


async def crosswind(camera: Camera, url: str, folder: Path) -> None:
    """Show a landing in 7 m/s crosswind, rehearsed: docs/how-to/rehearse-a-mission.md."""
    field = GeoPoint(40.3332, -3.7978)
    landing = design_landing(field, course_deg=270.0, wind=Wind(180.0, 7.0))
    away = [MissionItem.waypoint(40.3402, lon_deg, alt_rel_home_m=80.0) for lon_deg in (-3.7908, -3.7778)]
    takeoff = MissionItem.takeoff(field.lat_deg, field.lon_deg, alt_rel_home_m=50.0)
    plan = Plan(home=Home(field.lat_deg, field.lon_deg, alt_amsl_m=690.0), items=(takeoff, *away, *landing.items))
    plan.save(folder / "crosswind.plan")
    async with camera.station(url) as station:
        # As if a pilot had set it before.
        await station.page.evaluate(
            "() => localStorage.setItem('vencejo.plan-wind',"
            " JSON.stringify({ from_deg: 180, speed_m_s: 7, set_unix_ms: Date.now() }))"
        )
        await station.page.reload()
        await station.see_plane()
        await open_plan(station, folder / "crosswind.plan")
        for name in ("fly", "instruments"):
            await station.close_panel(name)
        panel = station.panel("plan")
        await expect(panel.get_by_text(station.text("rehearsal.ending.landed"))).to_be_visible()
        await station.button("map.showPlan").click()
        scrubber = station.page.get_by_role("slider", name=station.text("rehearsal.scrub"), exact=True)
        await scrubber.fill("190")
        await camera.take(station, "crosswind-flight", ("light",))
        await panel.get_by_role("button", name=station.text("odds.ask"), exact=True).click()
        hide = panel.get_by_role("button", name=station.text("odds.hide"), exact=True)
        await expect(hide).to_be_visible()
        await hide.scroll_into_view_if_needed()
        await camera.take(station, "crosswind-odds", ("light",))


async def take_all(scenes: list[str], png: Path | None) -> None:
    """Take the screenshots of these scenes."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        async with running() as browser:
            camera = Camera(browser, png)
            if "flight" in scenes:
                with (
                    plane_in_wind(rtl_autoland=2) as plane,
                    serving("--link", plane.link, "--rate", "20", data=folder) as served,
                ):
                    await flight(camera, served.url)
            if "phone" in scenes:
                with (
                    plane_in_wind(rtl_autoland=2) as plane,
                    serving("--link", plane.link, "--rate", "20", data=folder) as served,
                ):
                    await phone(camera, served.url)
            languages: tuple[Language, ...] = ("en", "es")
            for language in languages if "tutorial" in scenes else ():
                with (
                    plane_in_wind(rtl_autoland=2) as plane,
                    serving("--link", plane.link, "--rate", "20", data=folder / language) as served,
                ):
                    await tutorial(camera, served.url, language)
            if "refused" in scenes:
                with (
                    plane_in_wind(rtl_autoland=0) as plane,
                    serving("--link", plane.link, data=folder) as served,
                ):
                    await refused(camera, served.url, folder)
            if "crosswind" in scenes:
                with (
                    plane_in_wind(rtl_autoland=2) as plane,
                    serving("--link", plane.link, "--rate", "20", data=folder / "crosswind") as served,
                ):
                    await crosswind(camera, served.url, folder)
            if "lost" in scenes:
                with (
                    LossyRelay(seed=7) as relay,
                    plane_in_wind(rtl_autoland=2, link=relay.plane_link),
                    serving("--link", relay.driver_link, data=folder) as served,
                ):
                    await lost(camera, relay, served.url)


def main() -> int:
    """Take the screenshots and check their total size."""
    every = ("flight", "phone", "tutorial", "crosswind", "refused", "lost")
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=f"{', '.join(every)}; default all")
    parser.add_argument("--png", type=Path, help="a folder for the same pictures as PNG")
    options = parser.parse_args()
    if unknown := set(options.scenes) - set(every):
        parser.error(f"no such scene: {', '.join(sorted(unknown))}")
    OUTPUT.mkdir(parents=True, exist_ok=True)
    if options.png is not None:
        options.png.mkdir(parents=True, exist_ok=True)
    expect.set_options(timeout=PATIENCE_S * 1000)
    asyncio.run(take_all(options.scenes or list(every), options.png))
    size = sum(path.stat().st_size for path in OUTPUT.glob("*.webp"))
    print(f"{size / 1e6:.2f} MB in {OUTPUT.relative_to(ROOT)}")
    if size > LIMIT_BYTES:
        print(f"screenshots: more than {LIMIT_BYTES / 1e6:g} MB together", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
