"""Map sources in the browser, against the real server."""

from __future__ import annotations

from typing import Any

from playwright.async_api import Locator, expect

from tests.browser.conftest import OpenStation, Serve
from tests.browser.station_page import StationPage
from tests.server.client import Client


def put(client: Client, settings: dict[str, Any]) -> Any:
    """Make or replace a source, and have no other."""
    for source in client.done("GET", "maps/sources")["sources"]:
        if source["id"] != settings["id"]:
            client.done("DELETE", f"maps/sources/{source['id']}")
    return client.done("PUT", f"maps/sources/{settings['id']}", settings)


async def open_maps(station: StationPage) -> Locator:
    """Open the maps' panel, and see what is in it."""
    await station.button("map.layers").click()
    panel = station.panel("maps")
    await expect(panel.get_by_role("group", name=station.text("maps.tabs"))).to_be_visible()
    return panel


async def test_a_key_is_never_shown_again(open_station: OpenStation, serve: Serve) -> None:
    served = serve()
    client = served.client()
    key = "AIzaSy-never-to-be-seen"
    put(
        client,
        {
            "id": "keyed",
            "name": "Keyed",
            "kind": "xyz",
            "url": "https://example.invalid/{z}/{x}/{y}?key={key}",
            "key": key,
        },
    )
    async with open_station(served.url) as station:
        answers: list[str] = []

        async def keep(response: Any) -> None:
            if "/api/v1/maps/" in response.url:
                answers.append(await response.text())

        station.page.on("response", keep)
        panel = await open_maps(station)
        await panel.get_by_role("button", name=station.text("maps.more", name="Keyed")).click()
        await panel.get_by_role("button", name=station.text("maps.edit"), exact=True).click()
        field = panel.get_by_label(station.text("maps.key"), exact=True)
        await expect(field).to_have_value("")
        await expect(panel.get_by_text(station.text("maps.keyKept"), exact=True)).to_be_visible()
        # saved without typing it: it is kept
        await panel.get_by_role("button", name=station.text("maps.save"), exact=True).click()
        await expect(panel.get_by_role("radio", name="Keyed")).to_be_visible()
        assert answers
        assert not any(key in answer for answer in answers)
    (kept,) = client.done("GET", "maps/config")["sources"]
    assert kept["has_key"] is True
