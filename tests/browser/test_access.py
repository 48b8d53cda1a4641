"""Every main view in both themes, sizes and languages: no serious fault by axe-core, no small target, no foreign word."""

from __future__ import annotations

import functools
import re
from collections.abc import AsyncIterator

import pytest
import pytest_asyncio
from playwright.async_api import Page, expect
from vencejo import Plan

from tests.browser.chromium import PHONE, WIDE
from tests.browser.conftest import OpenStation
from tests.browser.station_page import PANELS, StationPage, Theme
from tests.browser.test_plan import DEMO, open_file
from tests.browser.texts import Language, catalogues, pattern
from tests.plane import Plane
from tests.server.client import serving
from tests.support import ROOT

AXE = ROOT / "gcs" / "node_modules" / "axe-core" / "axe.min.js"
TARGET_PX = 44.0
SIZES = {"wide": WIDE, "phone": PHONE}
RULES: dict[Theme, list[str]] = {"dark": [], "light": ["color-contrast", "link-in-text-block"]}
"""What axe-core looks for in each theme, all by default: they differ in nothing but colours."""
THEMES = tuple(RULES)


@pytest_asyncio.fixture(name="url", scope="module", loop_scope="session")
async def _url(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[str]:
    with (
        Plane(wind_m_s=4.0) as plane,
        serving("--link", plane.link, data=tmp_path_factory.mktemp("data")) as served,
    ):
        yield served.url


@functools.cache
def axe() -> str:
    return AXE.read_text(encoding="utf-8")


async def faults(page: Page, rules: list[str]) -> list[str]:
    """What axe-core calls serious or critical, by some of its rules, or all."""
    options = {"resultTypes": ["violations"], **({"runOnly": rules} if rules else {})}
    found = await page.evaluate("(options) => axe.run(options)", options)
    assert found["passes"] or found["incomplete"], "axe-core looked at nothing"
    return [
        f"{one['id']}: {one['help']}: " + "; ".join(node["html"][:160] for node in one["nodes"][:3])
        for one in found["violations"]
        if one["impact"] in {"serious", "critical"}
    ]


async def small_targets(page: Page) -> list[str]:
    """Buttons and fields that a finger would miss."""
    small: list[str] = await page.evaluate(
        """(least) => [...document.querySelectorAll('button, select, input, summary')].filter((element) => {
            const target = element.matches('input[type=checkbox], input[type=radio]') ? element.closest('label') : element;
            if (!element.checkVisibility({ visibilityProperty: true }) || element.closest('.visually-hidden')) return false;
            const { width, height } = (target ?? element).getBoundingClientRect();
            return width > 1 && (width < least || height < least);
        }).map((element) => {
            const { width, height } = element.getBoundingClientRect();
            return `${element.outerHTML.slice(0, 120)} is ${width.toFixed(1)} × ${height.toFixed(1)} px`;
        })""",
        TARGET_PX - 0.5,
    )
    return small


async def scrolled(page: Page) -> list[str]:
    """What goes out of sight when something that is only heard takes the focus or is looked for."""
    moved: list[str] = await page.evaluate(
        """() => {
            for (const element of document.querySelectorAll('main *')) element.scrollIntoView();
            const bar = document.querySelector('main [role=region]').getBoundingClientRect();
            return bar.top === 0 ? [] : [`the bar is at ${bar.top} px`];
        }"""
    )
    return moved


FETCHED = {"sensors": "sensor.acceleration", "params": "params.save", "settings": "setting.look"}
"""Panels that are fetched when they are opened, or ask the vehicle then, and a text of each."""


async def views(station: StationPage) -> AsyncIterator[str]:
    """Open one main view after the other, each with something in it."""
    await station.see_plane()
    for name in PANELS:
        panel = await station.open_panel(name)
        if name == "plan":
            # Once: a file that is read while an item is chosen takes the choice away.
            if await station.items.count() != len(Plan.load(DEMO)):
                await open_file(station, DEMO)
                await expect(station.items).to_have_count(len(Plan.load(DEMO)))
            await station.item(5).click()
            await expect(panel.get_by_text(station.text("plan.checks.checking"), exact=True)).to_have_count(0)
        if name in FETCHED:
            await expect(panel.get_by_text(station.text(FETCHED[name]), exact=False).first).to_be_visible()
        yield name
    await station.button("map.layers").click()
    # The panel is loaded when it is first opened, and asks the server for its sources.
    await expect(station.page.get_by_text(station.text("maps.tab.offline"), exact=True)).to_be_visible()
    await expect(station.page.get_by_text(station.text("lazy.loading"), exact=True)).to_have_count(0)
    yield "layers"
    await station.button("map.layers").click()
    await station.page.keyboard.press("Escape")
    left, top, right, bottom = await station.free_map()
    await station.page.mouse.click((left + right) / 2, (top + bottom) / 2 - 40, button="right")
    await expect(station.page.get_by_role("dialog")).to_be_visible()
    yield "menu"
    await station.button("menu.close").click()


@pytest.mark.parametrize("size", SIZES)
async def test_no_view_shuts_anybody_out(open_station: OpenStation, url: str, size: str) -> None:
    wrong: list[str] = []
    looked_at = 0
    async with open_station(url, size=SIZES[size]) as station:
        await station.have_control()
        await station.page.evaluate(axe())
        async for name in views(station):
            # the one that is there first
            for theme in THEMES if looked_at % 4 == 0 else reversed(THEMES):
                await station.choose_theme(theme)
                look = f"{name}, {theme}"
                wrong += [f"{look}: {fault}" for fault in await faults(station.page, RULES[theme])]
                wrong += [f"{look}: {target}" for target in await small_targets(station.page)]
                wrong += [f"{look}: {bar}" for bar in await scrolled(station.page)]
                looked_at += 1
    assert looked_at == (len(PANELS) + 2) * len(THEMES)
    assert not wrong, "\n".join(wrong)


SHOWN = """() => {
    const found = new Set();
    const add = (text) => { const one = (text ?? '').replace(/\\s+/g, ' ').trim(); if (one) found.add(one); };
    const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    for (let node = walk.nextNode(); node; node = walk.nextNode()) {
        if (!node.parentElement.closest('script, style, [data-foreign]')) add(node.textContent);
    }
    for (const element of document.querySelectorAll('*')) {
        for (const name of ['aria-label', 'title', 'placeholder', 'alt']) add(element.getAttribute(name));
    }
    return [...found];
}"""


def keys_shown(shown: list[str], language: Language) -> set[str]:
    """Keys of the catalogue's texts that stand on a page."""
    return {key for key, one in _patterns(language).items() if any(one.fullmatch(text) for text in shown)}


@functools.cache
def _patterns(language: Language) -> dict[str, re.Pattern[str]]:
    """Texts that tell the languages apart: those that nothing of the other language looks like."""
    other = catalogues()["es" if language == "en" else "en"]
    others = [pattern(template) for template in other.values()]
    mine: dict[str, re.Pattern[str]] = {}
    for key, template in catalogues()[language].items():
        sample = " ".join(re.sub(r"\{\w+\}", "7", template).split())
        # a text that is little but its values looks like anything
        words = re.sub(r"\{\w+\}", "", template)
        if len(re.findall(r"[^\W\d_]", words)) > 3 and not any(one.fullmatch(sample) for one in others):
            mine[key] = pattern(template)
    return mine


async def test_each_view_speaks_one_language(open_station: OpenStation, url: str) -> None:
    seen: dict[Language, dict[str, set[str]]] = {"en": {}, "es": {}}
    both: tuple[tuple[Language, Language], ...] = (("en", "es"), ("es", "en"))
    async with open_station(url) as station:
        await station.have_control()
        for language, other in both:
            await station.choose_language(language)
            assert await station.page.locator("html").get_attribute("lang") == language
            async for name in views(station):
                shown: list[str] = await station.page.evaluate(SHOWN)
                foreign = keys_shown(shown, other)
                assert not foreign, f"{name} in {language!r} shows {sorted(foreign)} in {other!r}"
                seen[language][name] = keys_shown(shown, language)
    assert len(set[str]().union(*seen["en"].values())) > 150, "hardly any text was recognised"
    assert seen["en"].keys() == seen["es"].keys()
    told_apart = _patterns("en").keys() & _patterns("es").keys()
    around = set[str].intersection(*seen["en"].values()) | set[str].intersection(*seen["es"].values())
    for name in seen["en"]:
        own = {language: (seen[language][name] - around) & told_apart for language in seen}
        # what comes and goes by itself, such as a hint while the checks run, may differ; a whole view may not
        shared, odd = own["en"] & own["es"], own["en"] ^ own["es"]
        assert len(shared) >= len(odd), f"{name} in one language only: {[sorted(own[one] - shared) for one in own]}"
