"""Maps in the browser, against the real server and a real map service.

Ground where it is in every system, attribution in sight, failures told, areas kept for the field, pictures by corners.
"""

from __future__ import annotations

import functools
import sqlite3
import struct
import urllib.parse
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from playwright.async_api import Locator, Response, expect

from tests.browser.chromium import PHONE
from tests.browser.conftest import OpenStation, Serve
from tests.browser.station_page import MapScale, StationPage
from tests.browser.test_access import axe, faults, small_targets
from tests.maps.mapserver import ATTRIBUTION, LAYER, POINTS, Colour, MapServer, map_server
from tests.server.client import Client, Served, serving
from tests.support import reserved_ports

MIDDLE = {"lat_deg": 40.3332, "lon_deg": -3.7978}
BESIDE_PANEL = (1250, 820)
"""A window in which all of the ground's points are in sight beside a panel, looked at like this:"""
GROUND_VIEW = {"lat_deg": 40.3332, "lon_deg": -3.7898, "zoom": 14.48}
"""Not a whole zoom, so that every tile is drawn larger or smaller than it came."""
BESIDE_NOTICE = {**GROUND_VIEW, "lon_deg": -3.8102}
"""The same with what the map tells on its left."""
PIXEL = 1.0
FINEST_KEPT = 4
"""Level of the UTM grid with about 10 m in a pixel: few tiles are enough."""
DISC_PX = 12
"""Fewer pixels of a colour than this are not a disc."""

CASES = [
    *(("1.3.0", crs) for crs in ("EPSG:3857", "EPSG:4326", "EPSG:32630", "EPSG:25830")),
    *(("1.1.1", crs) for crs in ("EPSG:3857", "EPSG:4326", "EPSG:32630")),
]


@pytest.fixture(name="ground", scope="module")
def _ground(tmp_path_factory: pytest.TempPathFactory) -> Iterator[MapServer]:
    with map_server(tmp_path_factory.mktemp("mapserver")) as server:
        yield server


@pytest.fixture(name="served", scope="module")
def _served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving(data=tmp_path_factory.mktemp("data")) as served:
        yield served


def looking_at(**view: float) -> dict[str, object]:
    """What a page finds stored that shows a place and nothing else: no panels, nothing drawn on the map."""
    return {
        "map-view": view,
        "map": {"hasGrid": False, "hasTrails": False, "follow": "free"},
        "layout": {"left": [], "right": None, "sheet": None},
    }


def wms(server: MapServer, **settings: Any) -> dict[str, Any]:
    """Settings of a source that shows the test's ground."""
    return {
        "id": "ground",
        "name": "Test ground",
        "kind": "wms",
        "role": "base",
        "url": server.url,
        "local_network": True,
        "version": "1.3.0",
        "layers": [LAYER],
        "crs": "EPSG:3857",
        "format": "image/png",
        # few and large, and none coarser than is looked at: each costs a process
        "tile_px": 1024,
        "min_zoom": 13,
        "attribution": [{"text": ATTRIBUTION, "url": "https://example.org/ground"}],
        "bounds": {"west_deg": -3.822, "south_deg": 40.315, "east_deg": -3.774, "north_deg": 40.352},
        **settings,
    }


def have(client: Client, *sources: dict[str, Any]) -> None:
    """Have these sources, and no other."""
    for source in client.done("GET", "maps/sources")["sources"]:
        client.done("DELETE", f"maps/sources/{source['id']}?cache=true")
    for source in sources:
        client.done("PUT", f"maps/sources/{source['id']}", source)


async def centroids(station: StationPage, colours: list[Colour]) -> list[tuple[float, float] | None]:
    """The middles of what is of these colours on the free map, pixels of the window."""
    left, top, right, bottom = await station.free_map()
    clip = {"x": left, "y": top, "width": right - left, "height": bottom - top}
    encoded = np.frombuffer(await station.page.screenshot(clip=clip), np.uint8)  # type: ignore[arg-type]
    decoded = cv2.imdecode(encoded, cv2.IMREAD_COLOR_RGB)
    assert decoded is not None
    picture = decoded.astype(np.int16)
    found: list[tuple[float, float] | None] = []
    for colour in colours:
        rows, columns = np.nonzero(np.abs(picture - np.array(colour)).sum(axis=2) <= 80)
        is_seen = len(rows) >= DISC_PX
        found.append((left + columns.mean() + 0.5, top + rows.mean() + 0.5) if is_seen else None)
    return found


async def see_ground(station: StationPage, scale: MapScale | None = None) -> MapScale:
    """See each known point at its pixel; gives where positions are, which holds as long as the view stays."""
    scale = scale or await station.map_scale()
    wanted = [scale.pixel(point.lat_deg, point.lon_deg) for point in POINTS]
    away: list[float | None] = []

    async def is_there() -> bool:
        nonlocal away
        found = await centroids(station, [point.colour for point in POINTS])
        away = [
            None if at is None else max(abs(at[0] - x), abs(at[1] - y))
            for at, (x, y) in zip(found, wanted, strict=True)
        ]
        return all(one is not None and one <= PIXEL for one in away)

    try:
        await station.eventually(is_there, "the ground's points at their pixels")
    except AssertionError as error:
        names = [point.name for point in POINTS]
        raise AssertionError(f"pixels away: {dict(zip(names, away, strict=True))}") from error
    return scale


async def see_attribution(station: StationPage) -> None:
    """See the ground's attribution, whole, over everything else."""
    shown = station.page.get_by_role("group", name=station.text("maps.attribution")).get_by_text(
        ATTRIBUTION, exact=True
    )
    await expect(shown).to_have_attribute("href", "https://example.org/ground")
    await expect(shown).to_be_in_viewport(ratio=1)
    is_on_top = """link => [...link.getClientRects()].every(({ left, top, right, bottom }) =>
        [left + 1, right - 1].every(x => document.elementFromPoint(x, (top + bottom) / 2) === link))"""
    assert await shown.evaluate(is_on_top), "something lies over the attribution"


def notice(station: StationPage) -> Locator:
    """What the map says of a source that does not come."""
    return station.page.get_by_role("status").filter(has=station.button("maps.hide"))


async def open_maps(station: StationPage) -> Locator:
    """Open the maps' panel, and see what is in it."""
    await station.button("map.layers").click()
    panel = station.panel("maps")
    await expect(panel.get_by_role("group", name=station.text("maps.tabs"))).to_be_visible()
    return panel


def press(station: StationPage, inside: Locator, key: str, /, **values: object) -> Locator:
    """A button inside of something, by its name."""
    return inside.get_by_role("button", name=station.text(key, **values), exact=True)


async def test_known_ground_stands_at_its_pixels_in_every_system(
    open_station: OpenStation, served: Served, ground: MapServer
) -> None:
    names = [f"{crs} by {version}" for version, crs in CASES]
    have(
        served.client(),
        *(
            wms(ground, id=f"ground-{index}", name=name, version=version, crs=crs)
            for index, ((version, crs), name) in enumerate(zip(CASES, names, strict=True))
        ),
    )
    async with open_station(served.url, size=BESIDE_PANEL, stored=looking_at(**GROUND_VIEW)) as station:
        await station.button("welcome.hide").click()
        panel = await open_maps(station)
        scale: MapScale | None = None
        for (version, crs), name in zip(CASES, names, strict=True):
            ground.requests.clear()
            await panel.get_by_role("radio", name=name, exact=True).check()
            # the one before is gone from the map as soon as another is chosen
            await expect(panel.get_by_role("radio", checked=True)).to_have_count(1)
            if name != names[0]:
                await station.eventually(functools.partial(was_asked, ground, version, crs), f"{name} is asked for")
            scale = await see_ground(station, scale)
            await see_attribution(station)
        await expect(notice(station)).to_have_count(0)
        await station.close_panel("maps")

        # in every size and beside every sheet
        await station.page.set_viewport_size({"width": PHONE[0], "height": PHONE[1]})
        await see_attribution(station)
        for name in ("plan", "settings"):
            await station.open_panel(name)
            await see_attribution(station)


async def was_asked(ground: MapServer, version: str, crs: str) -> bool:
    """Whether a map came to be asked for in this version and system."""
    asked = [dict(urllib.parse.parse_qsl(query.upper())) for query in ground.requests]
    return any(
        query.get("REQUEST") == "GETMAP" and query.get("VERSION") == version and crs in query.values()
        for query in asked
    )


async def test_a_source_that_fails_says_why_and_comes_back(
    open_station: OpenStation, served: Served, ground: MapServer
) -> None:
    have(served.client(), wms(ground))
    why = "Invalid layer(s) given in the LAYERS parameter"
    async with open_station(served.url, size=BESIDE_PANEL, stored=looking_at(**BESIDE_NOTICE)) as station:
        await station.button("welcome.hide").click()
        await see_ground(station)
        ground.refuses = True
        try:
            # what was seen is kept, and shown to a page that knows nothing of it
            await station.page.reload()
            await station.button("welcome.hide").click()
            await see_ground(station)
            # finer tiles were never seen
            for _ in range(2):
                await station.button("map.zoomIn").click()
            await expect(notice(station)).to_contain_text("Test ground")
            await notice(station).get_by_role("button", expanded=False).click()
            await expect(notice(station)).to_contain_text(why)
            panel = await open_maps(station)
            await expect(panel.get_by_text(why).first).to_be_visible()
            await press(station, panel, "maps.more", name="Test ground").click()
            await press(station, panel, "maps.test").click()
            await expect(panel.get_by_role("status").filter(has_text=why)).to_be_visible()
        finally:
            ground.refuses = False
        await press(station, panel, "maps.test").click()
        await expect(panel.get_by_text(station.text("maps.testOk"), exact=True)).to_be_visible()
        await expect(notice(station)).to_have_count(0)
        await station.close_panel("maps")
        for _ in range(2):
            await station.button("map.zoomOut").click()
        await see_ground(station)


async def test_a_service_is_added_by_its_address_and_an_area_of_it_kept(
    open_station: OpenStation, serve: Serve, ground: MapServer, tmp_path: Path
) -> None:
    with reserved_ports() as (port,):
        await keep_an_area(open_station, functools.partial(serve, f"--port={port}"), ground, tmp_path)


async def keep_an_area(open_station: OpenStation, serve: Serve, ground: MapServer, tmp_path: Path) -> None:
    served = serve()
    have(served.client())
    async with open_station(served.url, size=BESIDE_PANEL, stored=looking_at(**GROUND_VIEW)) as station:
        await station.button("welcome.hide").click()
        await station.page.evaluate(axe())
        wrong: list[str] = []

        async def look(view: str) -> None:
            wrong.extend(f"{view}: {one}" for one in await faults(station.page, []))
            wrong.extend(f"{view}: {one}" for one in await small_targets(station.page))

        panel = await open_maps(station)
        await press(station, panel, "maps.add").click()
        await look("add")
        # as copied out of a browser
        await station.field(panel, "maps.paste").fill(ground.url + "?request=GetCapabilities&service=WMS")
        await panel.get_by_role("checkbox", name=station.text("maps.localNetwork")).check()
        await press(station, panel, "maps.next").click()
        await panel.get_by_role("checkbox", name="Ground with discs").check()
        await station.choice(panel, "maps.crs").select_option("EPSG:32630")
        await look("service")
        await press(station, panel, "maps.next").click()
        await expect(station.field(panel, "maps.attributionText")).to_have_value(ATTRIBUTION)
        await station.field(panel, "maps.attributionUrl").fill("https://example.org/ground")
        await station.field(panel, "maps.name").fill("By its address")
        await press(station, panel, "maps.role.base").click()
        await look("form")
        await press(station, panel, "maps.save").click()
        await expect(panel.get_by_role("radio", name="By its address")).to_be_checked()
        await see_ground(station)
        await see_attribution(station)
        await look("layers")
        (added,) = served.client().done("GET", "maps/config")["sources"]
        assert (added["kind"], added["layers"], added["crs"]) == ("wms", [LAYER], "EPSG:32630")

        # an area of it: drawn, counted, fetched
        await press(station, panel, "maps.tab.offline").click()
        await press(station, panel, "maps.newArea").click()
        await press(station, panel, "maps.area.box").click()
        left, top, right, bottom = await station.free_map()
        for part in (0.35, 0.65):
            await station.page.mouse.click(left + (right - left) * part, top + (bottom - top) * part)
        await station.choice(panel, "maps.area.to").select_option(index=FINEST_KEPT)
        estimate = panel.get_by_text(station.like("maps.area.estimate"))
        await expect(estimate).to_be_visible()
        tiles = int(await station.figure(estimate))
        assert 2 <= tiles <= 50
        await station.field(panel, "maps.area.name").fill("The field")
        await look("area")
        ground.answers.clear()
        try:
            await press(station, panel, "maps.area.download").click()
            area = panel.get_by_role("listitem").filter(has_text="The field")
            await expect(area).to_contain_text(station.text("maps.area.state.running"))
            await press(station, area, "maps.area.pause").click()
            await expect(area).to_contain_text(station.text("maps.area.state.paused"))
            await press(station, area, "maps.area.resume").click()
            await expect(area).to_contain_text(station.text("maps.area.state.running"))
            await look("areas")
            # the server dies in the middle of it; the next one goes on by itself
            served.process.kill()
            served.process.wait()
            away = station.state_bar.get_by_text(station.text("bar.serverAway"), exact=True)
            await expect(away).to_be_visible()
            served = serve()
            await expect(away).to_have_count(0)
        finally:
            ground.answers.set()
        await expect(area).to_contain_text(station.text("maps.area.state.done"))
        await expect(area).to_contain_text(f"{tiles} of {tiles} tiles")

        # out of the station as a file, and into it again
        async with station.page.expect_download() as download:
            await area.get_by_role("link", name=station.text("maps.area.export")).click()
        saved = tmp_path / "kept.mbtiles"
        await (await download.value).save_as(saved)
        with sqlite3.connect(saved) as file:
            ((count,),) = file.execute("SELECT count(*) FROM tiles").fetchall()
        file.close()
        assert count == tiles
        await press(station, area, "maps.area.delete").click()
        await press(station, area, "maps.area.delete").last.click()
        await expect(area).to_have_count(0)
        await panel.locator("input[type=file]").set_input_files(saved)
        taken = panel.get_by_role("listitem").filter(has_text="kept")
        await expect(taken).to_contain_text(station.text("maps.area.state.done"))
        assert not wrong, "\n".join(wrong)


async def test_a_key_is_never_shown_again(open_station: OpenStation, served: Served) -> None:
    client = served.client()
    key = "AIzaSy-never-to-be-seen"
    keyed = {
        "id": "keyed",
        "name": "Keyed",
        "kind": "xyz",
        "url": "https://example.invalid/{z}/{x}/{y}?key={key}",
        "key": key,
    }
    have(client, keyed)
    async with open_station(served.url) as station:
        responses: list[Response] = []
        station.page.on("response", lambda response: responses.append(response))
        panel = await open_maps(station)
        await press(station, panel, "maps.more", name="Keyed").click()
        await press(station, panel, "maps.edit").click()
        field = panel.get_by_label(station.text("maps.key"), exact=True)
        await expect(field).to_have_value("")
        await expect(panel.get_by_text(station.text("maps.keyKept"), exact=True)).to_be_visible()
        # saved without typing it: it is kept
        await press(station, panel, "maps.save").click()
        await expect(panel.get_by_role("radio", name="Keyed", exact=True)).to_be_visible()
        answers = [await one.text() for one in responses if "/api/v1/maps/" in one.url]
        assert answers
        assert not any(key in answer for answer in answers)
    (kept,) = client.done("GET", "maps/config")["sources"]
    assert kept["has_key"] is True


def png(width: int, height: int, colour: Colour) -> bytes:
    """A picture of one colour."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)
    rows = (b"\0" + bytes(colour) * width) * height
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


async def test_a_picture_is_placed_by_dragging_its_corners(open_station: OpenStation, served: Served) -> None:
    client = served.client()
    have(client)
    colour: Colour = (230, 0, 230)
    async with open_station(served.url, size=BESIDE_PANEL, stored=looking_at(**MIDDLE, zoom=16)) as station:
        await station.button("welcome.hide").click()
        panel = await open_maps(station)
        await press(station, panel, "maps.add").click()
        await panel.locator("input[type=file]").set_input_files(
            {"name": "chart.png", "mimeType": "image/png", "buffer": png(300, 200, colour)}
        )
        fields = [panel.get_by_label(station.text(f"maps.corner.{index}")) for index in range(4)]
        for field in fields:
            await expect(field).not_to_have_value("")
        scale = await station.map_scale()
        left, top, right, bottom = await station.free_map()
        wanted = [
            (left + 90, top + 90),
            (right - 120, top + 130),
            (right - 160, bottom - 110),
            (left + 130, bottom - 150),
        ]
        for field, (x, y) in zip(fields, wanted, strict=True):
            lat_deg, lon_deg = (float(part) for part in (await field.input_value()).split(", "))
            await station.page.mouse.move(*scale.pixel(lat_deg, lon_deg))
            await station.page.mouse.down()
            await station.page.mouse.move(x, y, steps=3)
            await station.page.mouse.up()
        await press(station, panel, "maps.role.base").click()
        await station.field(panel, "maps.name").fill("Chart")
        await press(station, panel, "maps.save").click()
        await expect(panel.get_by_role("radio", name="Chart")).to_be_checked()
        (chart,) = client.done("GET", "maps/sources")["sources"]
        for at, (x, y) in zip(chart["corners"], wanted, strict=True):
            shown_x, shown_y = scale.pixel(at["lat_deg"], at["lon_deg"])
            assert max(abs(shown_x - x), abs(shown_y - y)) <= PIXEL
        # and the station's own tiles of it are of that colour around the middle of that area
        area, middle = middle_of(wanted)

        async def is_shown() -> bool:
            (found,) = await centroids(station, [colour])
            return found is not None and max(abs(found[0] - middle[0]), abs(found[1] - middle[1])) <= 2 * PIXEL

        assert area > 0
        await station.eventually(is_shown, "the picture where it was placed")


def middle_of(corners: list[tuple[float, float]]) -> tuple[float, tuple[float, float]]:
    """Area and centre of gravity of a polygon (Bourke 1988)."""
    turns = [
        (x0 * y1 - x1 * y0, x0 + x1, y0 + y1)
        for (x0, y0), (x1, y1) in zip(corners, [*corners[1:], corners[0]], strict=True)
    ]
    area = sum(turn for turn, _, _ in turns) / 2
    return area, (sum(t * x for t, x, _ in turns) / (6 * area), sum(t * y for t, _, y in turns) / (6 * area))


async def test_a_plan_goes_over_the_date_line(open_station: OpenStation, served: Served) -> None:
    have(served.client())
    view = {"lat_deg": -16.8, "lon_deg": 180.0, "zoom": 12}
    async with open_station(served.url, size=BESIDE_PANEL, stored=looking_at(**view)) as station:
        await station.button("welcome.hide").click()
        await station.open_panel("plan")
        left, top, right, bottom = await station.free_map()
        y = (top + bottom) / 2
        for x in (left + 120, right - 120):
            await station.page.mouse.click(x, y)
        await expect(station.items).to_have_count(2)
        # the leg is the short one, not the one around the world
        await expect(station.items.nth(1)).to_contain_text("km at 09")
        await station.button("map.showPlan").click()
        scale = await station.map_scale()
        # the view has the line in it: eastern longitudes on its left, western ones on its right
        assert scale.lon0_deg > 179.0
        assert scale.x_per_deg < 0.0
