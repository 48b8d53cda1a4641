"""One Chromium for all tests of a worker; each test has its own pages, and mostly its own plane and server.

Playwright's asynchronous API is used because its synchronous one leaves an event loop running, in which pytest could
not run the asynchronous tests of the Python package. Everything here shares one loop for the session.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import Protocol

import pytest
import pytest_asyncio
from playwright.async_api import Browser, ConsoleMessage, Page, expect

from tests.browser.chromium import SLOW_DISPLAY, WIDE, running
from tests.browser.station_page import PATIENCE_S, TOLD, StationPage
from tests.browser.texts import Language
from tests.server.client import Served, serving
from tests.support import ROOT

PICTURES = ROOT / ".cache" / "browser"
"""Where the last look of a page whose test failed is kept."""

RATE_HZ = 5

expect.set_options(timeout=PATIENCE_S * 1000)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """All tests here run in the loop that the browser belongs to."""
    here = Path(__file__).parent
    for item in items:
        if here in item.path.parents:
            item.add_marker(pytest.mark.asyncio(loop_scope="session"), append=False)
            item.add_marker(pytest.mark.e2e)


@pytest_asyncio.fixture(name="browser", scope="session", loop_scope="session")
async def _browser() -> AsyncIterator[Browser]:
    async with running() as browser:
        yield browser


class OpenStation(Protocol):
    """Opens the station in a browser of its own: nothing of storage or session is shared.

    `stored` is what the page finds of an earlier visit: values by their names without ``vencejo.``.
    """

    def __call__(
        self,
        url: str,
        *,
        size: tuple[int, int] = WIDE,
        touch: bool = False,
        language: Language = "en",
        stored: Mapping[str, object] | None = None,
    ) -> AbstractAsyncContextManager[StationPage]: ...


@pytest.fixture(name="open_station")
def _open_station(browser: Browser, request: pytest.FixtureRequest) -> OpenStation:
    @contextlib.asynccontextmanager
    async def open_station(
        url: str,
        *,
        size: tuple[int, int] = WIDE,
        touch: bool = False,
        language: Language = "en",
        stored: Mapping[str, object] | None = None,
    ) -> AsyncIterator[StationPage]:
        context = await browser.new_context(
            viewport={"width": size[0], "height": size[1]},
            has_touch=touch,
            is_mobile=touch,
            color_scheme="dark",
            locale={"en": "en-GB", "es": "es-ES"}[language],
            reduced_motion="reduce",
        )
        # One of the rates that a person can choose: drawing without a graphics card is what costs most here.
        for name, value in {"settings": {"rate_hz": RATE_HZ}, **(stored or {})}.items():
            key, text = json.dumps(f"vencejo.{name}"), json.dumps(json.dumps(value))
            await context.add_init_script(f"localStorage.getItem({key}) ?? localStorage.setItem({key}, {text})")
        await context.add_init_script(SLOW_DISPLAY)
        await context.add_init_script(TOLD)
        faults: list[str] = []
        try:
            page = await context.new_page()
            _listen(page, faults)
            await page.goto(url)
            station = StationPage(page, language, is_touch=touch)
            await expect(station.map).to_be_visible()
            yield station
        except BaseException:
            PICTURES.mkdir(parents=True, exist_ok=True)
            picture = PICTURES / f"{request.node.name}-{len(context.pages)}.png"
            await context.pages[-1].screenshot(path=picture)
            print(f"what the page showed: {picture}")  # noqa: T201  (beside the failure)
            raise
        finally:
            await context.close()
        assert not faults, f"the page complained: {faults}"

    return open_station


def _listen(page: Page, faults: list[str]) -> None:
    """Collect errors inside the page, except the browser's own messages about an unreachable server."""

    def on_console(message: ConsoleMessage) -> None:
        is_network = message.text.startswith(("Failed to load resource", "WebSocket connection to"))
        if message.type in {"error", "warning"} and not is_network:
            faults.append(message.text)

    page.on("console", on_console)
    page.on("pageerror", lambda error: faults.append(str(error)))


Serve = Callable[..., Served]


@pytest.fixture(name="serve")
def _serve(tmp_path: Path) -> Iterator[Serve]:
    """Start `vencejo serve` with these options; it ends with the test."""
    with contextlib.ExitStack() as running:
        yield lambda *options: running.enter_context(serving(*options, data=tmp_path))
