"""The ground station's page as a person uses it: by what is read on it, by clicks, taps and keys."""

from __future__ import annotations

import asyncio
import contextlib
import math
import re
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import dataclass
from typing import Literal

from playwright.async_api import Locator, Page, expect

from tests.browser import texts
from tests.browser.texts import Language

FLIGHT_MS = 300_000
"""A flight longer than this is a failure."""
PATIENCE_S = 120.0
Theme = Literal["dark", "light"]
TOLD = """
(() => {
  window.told = [];
  let shown = [];
  new MutationObserver(() => {
    const texts = [...document.querySelectorAll('[role=status] strong')].map((title) => title.textContent.trim());
    for (const term of document.querySelectorAll('[role=region] dt'))
      if (/^Mod[eo]$/.test(term.textContent.trim())) texts.push(`Mode: ${term.nextElementSibling.textContent.trim()}`);
    window.told.push(...texts.filter((text) => !shown.includes(text)));
    shown = texts;
  }).observe(document, { childList: true, subtree: true, characterData: true });
})();
"""
"""To be run in a page: records the titles of its messages, such as an accepted command's, shown for ten seconds only, and the modes shown,
in either language."""
SETTLED = """async () => {
    for (;;) {
        const moving = document.getAnimations().filter((each) => each.effect.getComputedTiming().endTime !== Infinity);
        if (moving.length === 0) return;
        await Promise.all(moving.map((each) => each.finished.catch(() => {})));
        await new Promise(requestAnimationFrame);
    }
}"""
"""Waits in the page until the colours of a theme that was just chosen have stopped changing."""
TWO_FRAMES = "() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn)))"
PANELS = ("fly", "instruments", "plan", "numbers", "sensors", "messages", "params", "settings")


@dataclass(frozen=True)
class MapScale:
    """Where positions are in the window, read off two points under the pointer (Web Mercator, EPSG:3857)."""

    x0: float
    lon0_deg: float
    x_per_deg: float
    y0: float
    mercator0: float
    y_per_mercator: float

    def pixel(self, lat_deg: float, lon_deg: float) -> tuple[float, float]:
        """The pixel of a position."""
        return (
            self.x0 + (lon_deg - self.lon0_deg) * self.x_per_deg,
            self.y0 + (_mercator(lat_deg) - self.mercator0) * self.y_per_mercator,
        )


def _mercator(lat_deg: float) -> float:
    return math.log(math.tan(math.pi / 4 + math.radians(lat_deg) / 2))


class StationPage:
    """A browser's page with the station open, in a language."""

    def __init__(self, page: Page, language: Language = "en", *, is_touch: bool = False) -> None:
        self.page = page
        self.is_touch = is_touch
        self.language: Language = language

    def text(self, key: str, /, **values: object) -> str:
        """A text of the app in the page's language."""
        return texts.text(key, self.language, **values)

    def like(self, key: str, /) -> re.Pattern[str]:
        """A text of the app whose values are not known."""
        return texts.pattern(texts.catalogues()[self.language][key])

    # --- Finding ------------------------------------------------------------------------------------------------------

    def bar(self, key: str) -> Locator:
        """A value of the top bar by its name's key, such as ``bar.mode``."""
        return self._described(self.state_bar, self.text(key))

    @property
    def state_bar(self) -> Locator:
        """The top bar."""
        return self.page.get_by_role("region", name=self.text("bar.label"), exact=True)

    def number(self, key: str) -> Locator:
        """A value of the numbers panel by its name's key, such as ``number.roll``."""
        return self._described(self.panel("numbers"), self.text(key))

    @staticmethod
    def _described(inside: Locator, term: str) -> Locator:
        return inside.locator(f"dt:text-is({term!r}) + dd")

    def panel(self, name: str) -> Locator:
        """A panel that is open."""
        return self.page.get_by_role("region", name=self.text(f"panel.{name}"), exact=True)

    def field(self, inside: Locator, key: str, /, **values: object) -> Locator:
        """A field to type into, by its name."""
        return inside.get_by_role("textbox", name=self.text(key, **values), exact=True)

    def choice(self, inside: Locator, key: str, /, **values: object) -> Locator:
        """A list to choose from, by its name."""
        return inside.get_by_role("combobox", name=self.text(key, **values), exact=True)

    def button(self, key: str, /, **values: object) -> Locator:
        """A button by its name."""
        return self.page.get_by_role("button", name=self.text(key, **values), exact=True)

    @property
    def map(self) -> Locator:
        """The map."""
        return self.page.get_by_role("application", name=self.text("map.label"), exact=True)

    @property
    def on_map(self) -> Locator:
        """The description of the planes on the map for screen readers."""
        return self.page.get_by_role("list", name=self.text("map.planes"), exact=True)

    @property
    def lost(self) -> Locator:
        """The line below the bar when a vehicle or the server is not heard."""
        return self.page.get_by_role("status").filter(
            has_text=re.compile(f"^\\s*({self.text('bar.linkLost')}|{self.text('bar.serverAway')})")
        )

    @property
    def items(self) -> Locator:
        """The rows of the plan's table."""
        return self.panel("plan").get_by_role("list", name=self.text("plan.items"), exact=True).get_by_role("listitem")

    def item(self, number: int) -> Locator:
        """The button that selects an item of the plan."""
        return self.items.nth(number - 1).get_by_role("button", name=re.compile(rf"^{number}\b"))

    @property
    def plan_state(self) -> Locator:
        """How the plan stands to the vehicle."""
        return self.panel("plan").get_by_role("tabpanel").get_by_role("status").first

    # --- Reading ------------------------------------------------------------------------------------------------------

    async def figure(self, value: Locator) -> float:
        """The first number in a value, in the writing of either language."""
        shown = (await value.inner_text()).replace("\u2212", "-")
        found = re.search(r"-?\d+(?:[.,]\d+)?", shown)
        return math.nan if found is None else float(found[0].replace(",", "."))

    async def where(self) -> tuple[float, float]:
        """The plane's position in the numbers panel."""
        lat_deg, lon_deg = [
            await self.number(key).inner_text(timeout=PATIENCE_S * 1000)
            for key in ("number.latitude", "number.longitude")
        ]
        return float(lat_deg.split()[0]), float(lon_deg.split()[0])

    async def map_scale(self) -> MapScale:
        """Find out where positions are in the window, when the view has come to rest."""
        before: MapScale | None = None
        deadline = time.monotonic() + PATIENCE_S
        while True:
            scale = await self._read_scale()
            if scale is not None and before is not None and is_same_view(scale, before):
                return scale
            before = scale
            assert time.monotonic() < deadline, "the map does not come to rest"
            # Between two frames every view rests.
            await self.two_frames()

    async def two_frames(self) -> None:
        """Wait until the page was drawn twice: a view that a key moves has moved."""
        await self.page.evaluate(TWO_FRAMES)

    async def _read_scale(self) -> MapScale | None:
        """None when a panel grew over what was free of the map a moment before."""
        left, top, right, bottom = await self.free_map()
        x0, y0, x1, y1 = left + 60, top + 60, right - 60, bottom - 60
        first = await self._point_at(x0, y0)
        second = await self._point_at(x1, y1)
        if first is None or second is None:
            return None
        (lat0, lon0), (lat1, lon1) = first, second
        return MapScale(
            x0=x0,
            lon0_deg=lon0,
            x_per_deg=(x1 - x0) / (lon1 - lon0),
            y0=y0,
            mercator0=_mercator(lat0),
            y_per_mercator=(y1 - y0) / (_mercator(lat1) - _mercator(lat0)),
        )

    async def _point_at(self, x: float, y: float) -> tuple[float, float] | None:
        # off the map first, so that what is read is of this very point
        await self.page.mouse.move(0, 0)
        readout = self.page.get_by_label(self.text("map.pointer"), exact=True)
        await expect(readout).to_have_count(0)
        await self.page.mouse.move(x, y)

        async def is_told_or_covered() -> bool:
            return await readout.count() > 0 or not await self.is_map_at(x, y)

        await self.eventually(is_told_or_covered, "the position under the pointer")
        shown = await readout.all_inner_texts()
        if not shown:
            return None
        lat_deg, lon_deg = shown[0].split(", ")
        return float(lat_deg), float(lon_deg)

    async def is_map_at(self, x: float, y: float) -> bool:
        """Whether nothing lies over the map at a pixel of the window."""
        is_free = "([x, y]) => document.elementFromPoint(x, y)?.closest('[role=application]') != null"
        return bool(await self.page.evaluate(is_free, [x, y]))

    async def free_map(self) -> tuple[float, float, float, float]:
        """What panels leave free of the map: left, top, right and bottom pixel."""
        return await self.map.evaluate(  # type: ignore[no-any-return]
            """map => {
                const box = map.getBoundingClientRect();
                const inset = side => parseFloat(map.style.getPropertyValue('--map-inset-' + side)) || 0;
                return [box.left + inset('left'), box.top + inset('top'),
                        box.right - inset('right'), box.bottom - inset('bottom')];
            }"""
        )

    async def eventually(
        self, holds: Callable[[], Awaitable[bool]], what: str, timeout_s: float = PATIENCE_S, every_s: float = 0.1
    ) -> None:
        """Wait until a condition of the page holds, looking at it twice in a frame of `SLOW_DISPLAY`: each look costs the page."""
        deadline = time.monotonic() + timeout_s
        while not await holds():
            assert time.monotonic() < deadline, f"{what}: not within {timeout_s:g} s"
            await asyncio.sleep(every_s)

    # --- Doing --------------------------------------------------------------------------------------------------------

    async def open_panel(self, name: str) -> Locator:
        """Open a panel by its button, if it is closed."""
        if await self.panel(name).count() == 0:
            await self._rail(name).click()
        await expect(self.panel(name)).to_be_visible()
        return self.panel(name)

    async def see_plane(self) -> None:
        """Wait until the plane reports all its telemetry."""
        await expect(self.bar("bar.gps")).to_contain_text("RTK")
        await expect(self.bar("bar.battery")).to_contain_text("%")

    async def have_control(self) -> None:
        """Have control, or take it as soon as its holder has gone."""
        arm = self.panel("fly").get_by_role("button", name=self.text("fly.arm"), exact=True)
        if await self.page.get_by_role("region", name=self.text("panel.fly"), exact=True).count() == 0:
            await self.open_panel("fly")
        ready = arm.and_(self.page.locator(":enabled"))
        await expect(ready.or_(self.button("control.take")).first).to_be_visible()
        if await self.button("control.take").count() > 0:
            await self.button("control.take").click()
        await expect(arm).to_be_enabled()

    async def choose_language(self, language: Language) -> None:
        """Have the page speak a language."""
        settings = await self.open_panel("settings")
        await settings.get_by_role("button", name={"en": "English", "es": "Español"}[language], exact=True).click()
        self.language = language
        await expect(self.panel("settings")).to_be_visible()

    async def choose_theme(self, theme: Theme) -> None:
        """Have the page in a theme, by its key, with all colours in place."""
        page = self.page.locator("html")
        if await page.get_attribute("data-theme") != theme:
            await self.page.keyboard.press("t")
            await expect(page).to_have_attribute("data-theme", theme)
        await self.page.evaluate(SETTLED)

    async def tap_panel(self, name: str) -> Locator:
        """Open a panel by a touch on its button."""
        await self._rail(name).tap()
        await expect(self.panel(name)).to_be_visible()
        return self.panel(name)

    @contextlib.asynccontextmanager
    async def touching(self, x: float, y: float) -> AsyncIterator[None]:
        """A finger that stays on a spot."""
        touches = await self.page.context.new_cdp_session(self.page)
        await touches.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [{"x": x, "y": y}]})
        try:
            yield
        finally:
            await touches.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
            await touches.detach()

    async def close_panel(self, name: str) -> None:
        """Close a panel, if it is open."""
        if await self.panel(name).count() > 0:
            await self.button("panel.close", panel=self.text(f"panel.{name}")).click()
        await expect(self.panel(name)).to_have_count(0)

    def _rail(self, name: str) -> Locator:
        rail = self.page.get_by_role("navigation", name=self.text("panel.bar"))
        # the button of the messages also counts those that are new
        return rail.get_by_role("button", name=re.compile(f"^{re.escape(self.text(f'panel.{name}'))}(:|$)"))

    async def hold(self, button: Locator, *, until: Locator | Awaitable[object]) -> None:
        """Press a button that wants to be held, and let go when what it does is seen."""
        await expect(button).to_be_enabled()
        await button.hover()
        await self.page.mouse.down()
        await (expect(until).to_be_visible() if isinstance(until, Locator) else until)
        await self.page.mouse.up()

    async def see_accepted(self, command: str) -> None:
        """See that the vehicle accepted a command, such as ``arm``, also when that is shown no more."""
        await self._see_told(re.escape(self.text("answer.accepted", command=self.text(f"command.{command}"))))

    async def see_mode(self, mode: str) -> None:
        """See that the plane was shown in a mode since the last command, also when that is over."""
        await self._see_told(rf"Mode: {mode}\b.*")

    async def _see_told(self, pattern: str) -> None:
        async def is_told() -> bool:
            told: list[str] = await self.page.evaluate("window.told")
            return any(re.fullmatch(pattern, one, re.DOTALL) for one in told)

        await self.eventually(is_told, pattern)

    def answer(self, command: str, outcome: str = "accepted") -> Locator:
        """The vehicle's answer to a command, such as ``arm``."""
        title = self.text(f"answer.{outcome}", command=self.text(f"command.{command}"))
        return self.page.get_by_label(self.text("answer.label"), exact=True).filter(has_text=title)

    async def command(self, button: Locator, command: str) -> None:
        """Hold the button of a command and see that the vehicle accepts it."""
        await self.page.evaluate("window.told = []")
        await self.hold(button, until=self._see_told(f"{re.escape(self.text(f'command.{command}'))}: .*"))
        await self.see_accepted(command)

    async def set_mode(self, mode: str) -> None:
        """Choose a mode in the fly panel."""
        panel = await self.open_panel("fly")
        await self.choice(panel, "fly.changeMode").select_option(value=mode)
        change = f"{self.text('fly.set')}: {self.text('fly.changeMode')}"
        await self.command(panel.get_by_role("button", name=change, exact=True), "mode")
        await expect(self.bar("bar.mode")).to_have_text(re.compile(rf"^\s*{mode}"))

    async def prepare_flight(self, *, from_mode: str) -> None:
        """Read what a flight needs first, and have it done."""
        panel = await self.open_panel("fly")
        await expect(
            panel.get_by_text(self.text("fly.prepareBoth", **{"from": from_mode, "mode": "MANUAL"}))
        ).to_be_visible()
        button = panel.get_by_role("button", name=self.text("fly.prepare"), exact=True)
        await button.click()
        await self.see_accepted("prepare-flight")
        await expect(button).to_have_count(0)
        await expect(self.bar("bar.mode")).to_have_text(re.compile(r"^\s*MANUAL"))

    async def arm(self) -> None:
        """Arm, once the plane is ready."""
        panel = await self.open_panel("fly")
        await expect(panel.get_by_text(self.text("fly.ready"), exact=True)).to_be_visible()
        await self.command(panel.get_by_role("button", name=self.text("fly.arm"), exact=True), "arm")
        await expect(self.bar("bar.motors")).to_contain_text(self.text("bar.armed"))

    async def refuse_to_arm(self, reason: str, *, cure: str) -> None:
        """Ask it to arm, and read why it does not and which mode helps."""
        panel = await self.open_panel("fly")
        answer = self.answer("arm", "refused")
        await self.hold(panel.get_by_role("button", name=self.text("fly.arm"), exact=True), until=answer)
        await expect(answer).to_contain_text(self.text(reason))
        await expect(answer).to_contain_text(self.text("answer.cure", mode=cure))

    async def start_mission(self) -> None:
        """Start the mission that is on board."""
        panel = await self.open_panel("fly")
        await self.command(panel.get_by_role("button", name=self.text("fly.start"), exact=True), "mission/start")
        await self.see_mode("AUTO")

    async def click_map(self, *places: tuple[float, float]) -> None:
        """Click positions on the map, degrees, found by the coordinates under the pointer."""
        scale = await self.map_scale()
        for place in places:
            x, y = scale.pixel(*place)
            assert await self.is_map_at(x, y), f"{place} is not in sight, or something lies over it"
            await self.page.mouse.click(x, y)

    async def show_plane(self) -> None:
        """Bring the plane into the middle of what is free of the map."""
        await self.button("map.showPlane").click()

    async def leave_view_alone(self) -> None:
        """Have the map stay where it is, whatever the plane does."""
        await self._choose_view("map.followFree")

    async def keep_in_sight(self) -> None:
        """Have the map widen when the plane comes near its edge."""
        await self._choose_view("map.followSight")

    async def _choose_view(self, key: str) -> None:
        button = self.page.get_by_role("group", name=self.text("map.controls")).get_by_role(
            "button", name=self.like("map.followNow")
        )
        wanted = self.button("map.followNow", mode=self.text(key))
        for _ in range(3):
            if await wanted.count() > 0:
                return
            await button.click()
        raise AssertionError(f"the view cannot be set to {self.text(key)!r}")

    async def choose_tool(self, key: str) -> None:
        """Choose what a click on the map adds."""
        tools = self.page.get_by_role("group", name=self.text("plan.tools"))
        await tools.get_by_role("button", name=self.text(key), exact=True).click()

    async def add_kind(self, kind: str) -> None:
        """Choose one of the kinds that are not on the toolbar."""
        await self.choice(self.panel("plan"), "plan.more").select_option(value=kind)

    async def type_into(self, field: Locator, text: str) -> None:
        """Type a value and leave the field."""
        await field.fill(text)
        await field.press("Tab")

    async def send_plan(self) -> None:
        """Send the plan and see that the vehicle has it."""
        await self.panel("plan").get_by_role("button", name=self.text("plan.send"), exact=True).click()
        await expect(self.plan_state).to_have_text(self.text("plan.state.verified"))

    async def see_item(self, number: int) -> None:
        """Wait until an item, or a later one, is in execution."""

        async def is_there() -> bool:
            shown = await self.bar("bar.item").inner_text()
            found = re.match(r"\s*(\d+) ", shown)
            return shown.strip().startswith(self.text("bar.itemsDone")) or (
                found is not None and int(found[1]) >= number
            )

        # For long: each look costs the page, which draws the flight meanwhile.
        await self.eventually(is_there, f"item {number}", FLIGHT_MS / 1000, every_s=0.15)


def is_same_view(a: MapScale, b: MapScale) -> bool:
    """Whether the map has not moved between two looks."""
    return all(
        math.isclose(one, other, rel_tol=1e-9) for one, other in zip(vars(a).values(), vars(b).values(), strict=True)
    )
