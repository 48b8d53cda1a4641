"""Flight E6: video from the on-board camera is seen in the station, while the plane flies. Off stops it; a camera that dies returns."""

from __future__ import annotations

import asyncio
import math
import re

from playwright.async_api import Locator, Page, expect
from vencejo import MissionItem, Plan, connect

from tests.browser.conftest import OpenStation, Serve
from tests.browser.station_page import StationPage
from tests.camera.mjpeg_server import MjpegServer, picture
from tests.camera.test_bytes import VIDEO
from tests.plane import Plane, offset
from tests.support import reserved_ports, wait_for


def window(station: StationPage, name: str = "nose") -> Locator:
    """The camera's window."""
    return station.page.get_by_role("region", name=station.text("camera.window", name=name), exact=True)


async def see_state(station: StationPage, key: str) -> None:
    await expect(window(station).get_by_role("status").first).to_have_text(station.text(key))


async def pixels(canvas: Locator, spots: list[tuple[float, float]]) -> list[tuple[int, int, int]]:
    """Red, green and blue of spots of the picture, in parts of its size."""
    found: list[list[int]] = await canvas.evaluate(
        """(canvas, spots) => {
            const copy = new OffscreenCanvas(canvas.width, canvas.height);
            const context = copy.getContext('2d', { willReadFrequently: true });
            context.drawImage(canvas, 0, 0);
            return spots.map(([x, y]) => [...context.getImageData(
                Math.min(canvas.width - 1, Math.round(x * canvas.width)),
                Math.min(canvas.height - 1, Math.round(y * canvas.height)), 1, 1).data]);
        }""",
        spots,
    )
    return [(spot[0], spot[1], spot[2]) for spot in found]


async def horizon(canvas: Locator, x: float) -> float | None:
    """Where sky becomes ground in a column of the picture, in parts of its height; ``None`` without both."""
    rows = [row / 100 for row in range(1, 100)]
    is_sky = [blue > red + 15 for red, _, blue in await pixels(canvas, [(x, row) for row in rows])]
    if not is_sky[0] or is_sky[-1]:
        return None
    return rows[is_sky.index(False)]


async def roll_seen_deg(canvas: Locator) -> float | None:
    """Roll by the horizon of the picture; ``None`` when it is not all in sight."""
    left, right = await horizon(canvas, 0.3), await horizon(canvas, 0.7)
    if left is None or right is None:
        return None
    size: list[int] = await canvas.evaluate("canvas => [canvas.width, canvas.height]")
    # With the right wing down the horizon rises to the right.
    return math.degrees(math.atan2((left - right) * size[1], 0.4 * size[0]))


async def test_e6_video_from_the_plane_is_seen_while_it_flies(open_station: OpenStation, serve: Serve) -> None:
    plan = Plan(
        items=(
            MissionItem.takeoff(*offset(0, -200), alt_rel_home_m=40.0, pitch_deg=15.0),
            MissionItem.waypoint(*offset(250, -350), alt_rel_home_m=60.0),
            MissionItem.waypoint(*offset(250, 250), alt_rel_home_m=60.0),
            MissionItem.loiter(*offset(0, 0), alt_rel_home_m=60.0),
        )
    )
    with Plane(camera="127.0.0.1:0") as plane:
        served = serve("--link", plane.link, "--rate", "20", "--camera", f"nose={plane.camera}")
        async with open_station(served.url) as station:
            await station.button("camera.show").click()
            await see_state(station, "camera.live")
            canvas = window(station).locator("canvas")

            async def is_level() -> bool:
                roll_deg = await roll_seen_deg(canvas)
                return roll_deg is not None and abs(roll_deg) < 3.0

            await station.eventually(is_level, "a level horizon on the ground")
            await asyncio.to_thread(fly, plane.link, plan)
            for _ in range(3):
                # In a turn, however long the page takes to show it; then on to where it flies level, or to the next circle.
                with plane.frozen(lambda truth: abs(truth.roll_deg) > 15.0) as truth:

                    async def is_true(true_deg: float = truth.roll_deg) -> bool:
                        shown_deg = await roll_seen_deg(canvas)
                        return shown_deg is not None and abs(shown_deg - true_deg) <= 6.0

                    await station.eventually(is_true, "the roll of a turn in the picture")
                plane.fly(15.0)
            await window(station).get_by_role("button", name=station.text("camera.hide"), exact=True).click()
            await expect(window(station)).to_have_count(0)
            await nobody_looks(served.url, station)


def fly(link: str, plan: Plan) -> None:
    """Another program sends a mission and starts it."""
    with connect(link, record=False) as plane:
        plane.upload(plan)

        def is_ready() -> bool:
            status = plane.telemetry.sys_status
            return status is not None and status.is_ready_to_arm is True

        wait_for(is_ready, "ready to arm")
        plane.arm()
        plane.set_mode("AUTO")


async def nobody_looks(url: str, station: StationPage) -> None:
    async def none() -> bool:
        listed = await station.page.evaluate("async () => (await (await fetch('/api/v1/cameras')).json())")
        return [camera["viewers"] for camera in listed] == [0]

    await station.eventually(none, "nothing is sent to anybody")


async def test_a_camera_that_dies_says_so_and_returns(open_station: OpenStation, serve: Serve) -> None:
    with reserved_ports(2) as (port, silent), MjpegServer(port) as first:
        tail = f"tail=http://127.0.0.1:{silent}/"
        served = serve("--link", "udpin:127.0.0.1:0", "--camera", f"nose={first.url}", "--camera", tail)
        async with open_station(served.url, language="es") as station:
            first.send(picture(200))
            await station.button("camera.show").click()
            canvas = window(station).locator("canvas")
            await station.eventually(lambda: is_grey(canvas, 200), "the picture")
            # It is not followed by another: it is old, and says so.
            await see_state(station, "camera.late")
            await expect(window(station)).to_contain_text(re.compile(r"Esta imagen tiene|llegan imágenes"))
            first.close()
            await see_state(station, "camera.dead")
            await expect(window(station)).to_contain_text(station.text("camera.deadDetail"))
            with MjpegServer(port) as second:
                second.send(picture(90))
                await station.eventually(lambda: is_grey(canvas, 90), "the picture after its return")
                # A camera without a picture is not shown that of another.
                await station.choice(window(station), "camera.choose").select_option("tail")
                await station.eventually(lambda: is_grey(window(station, "tail").locator("canvas"), 0), "no picture")


async def is_grey(canvas: Locator, level: int) -> bool:
    red, green, blue = (await pixels(canvas, [(0.5, 0.5)]))[0]
    return max(abs(red - level), abs(green - level), abs(blue - level)) <= 3


async def test_h264_is_shown_recorded_and_kept_as_a_picture(open_station: OpenStation, serve: Serve) -> None:
    video = VIDEO / "counter-640x480-30.mp4"
    served = serve(
        "--link", "udpin:127.0.0.1:0", "--camera", f"nose={video}", "--camera", f"tail={VIDEO / 'small-h264.mp4'}"
    )
    async with open_station(served.url) as station:
        page = station.page
        await page.keyboard.press("c")
        await see_state(station, "camera.live")
        canvas = window(station).locator("canvas")
        await expect(canvas).to_have_js_property("width", 640)
        assert await page.evaluate("async () => (await (await fetch('/api/v1/cameras/nose')).json()).codec") == "h264"
        numbers = [await number(canvas)]

        async def moves_on() -> bool:
            numbers.append(await number(canvas))
            return len(set(numbers)) > 5

        await station.eventually(moves_on, "moving pictures")
        async with page.expect_download() as download:
            await station.button("camera.snapshot").click()
        assert (await download.value).suggested_filename.endswith(".jpg")
        await station.button("camera.record").click()
        await expect(window(station)).to_contain_text(station.text("camera.isRecording"))
        await station.button("camera.stop").click()
        await expect(window(station)).to_contain_text(".mkv")
        await station.button("camera.footage").click()
        for kind in ("mkv", "jpg"):
            name = re.compile(rf"^{station.text('camera.download', name='')}[-_0-9]+nose\.{kind}$")
            await expect(window(station).get_by_role("link", name=name)).to_be_visible()
        await station.button("camera.toPicture").click()
        await station.choice(window(station), "camera.choose").select_option("tail")
        await expect(window(station, "tail").locator("canvas")).to_have_js_property("width", 160)
        await moves(station, page)


async def moves(station: StationPage, page: Page) -> None:
    """The window moves and changes its size by keyboard, and changes places with the map."""
    grip = window(station, "tail").get_by_role("button", name=station.text("camera.move"), exact=True)
    before = await window(station, "tail").bounding_box()
    await grip.focus()
    await page.keyboard.press("ArrowRight")
    await page.keyboard.press("Shift+ArrowDown")
    assert before is not None

    async def has_moved() -> bool:
        after = await window(station, "tail").bounding_box()
        return after is not None and (after["x"] - before["x"], after["height"] - before["height"]) == (24, 24)

    await station.eventually(has_moved, "a window that is elsewhere and taller")
    await station.button("camera.swap").click()

    async def has_swapped() -> bool:
        boxes = [await window(station, "tail").bounding_box(), await station.map.bounding_box()]
        widths = [box["width"] for box in boxes if box is not None]
        return len(widths) == 2 and widths[0] > 1400 > 400 > widths[1]

    await station.eventually(has_swapped, "the picture where the map was")
    await station.button("camera.swapBack").click()
    await page.keyboard.press("c")
    await expect(window(station, "tail")).to_have_count(0)


async def number(canvas: Locator) -> int:
    """The number that a picture of the counting film carries."""
    blocks = [((16 + 76 * bit + 30) / 640, 30 / 480) for bit in range(8)]
    return sum(128 >> bit for bit, (red, _, _) in enumerate(await pixels(canvas, blocks)) if red > 127)
