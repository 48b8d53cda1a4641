"""Flight E8: a plane moved by hand. The attitude indicator, the numbers and the sensors are true in all three axes."""

from __future__ import annotations

import math
import re

import pytest
from playwright.async_api import Locator, expect

from tests.browser.conftest import OpenStation, Serve
from tests.browser.station_page import StationPage
from tests.plane import Plane

ATTITUDES = [(0, 0, 270), (50, 0, 200), (-35, 25, 90), (20, -40, 7)]
"""Roll, pitch and heading in degrees: level, then one that differs in each axis, both ways."""


async def test_e8_a_plane_moved_by_hand(open_station: OpenStation, serve: Serve) -> None:
    with Plane() as plane:
        served = serve("--link", plane.link, "--rate", "20")
        async with open_station(served.url) as station:
            await expect(station.bar("bar.gps")).to_contain_text("RTK")
            for roll_deg, pitch_deg, heading_deg in ATTITUDES:
                plane.move_by_hand(roll_deg=roll_deg, pitch_deg=pitch_deg, heading_deg=heading_deg)
                await station.open_panel("numbers")
                for key, true_deg in (("roll", roll_deg), ("pitch", pitch_deg), ("heading", heading_deg)):
                    await see_angle(station, f"number.{key}", true_deg)
                await see_described(station, roll_deg, pitch_deg, heading_deg)
                await see_horizon(station, roll_deg, pitch_deg)
                await see_gravity(station, math.radians(roll_deg), math.radians(pitch_deg))


async def see_angle(station: StationPage, key: str, true_deg: float) -> None:
    async def is_true() -> bool:
        shown_deg = await station.figure(station.number(key))
        return abs((shown_deg - true_deg + 180.0) % 360.0 - 180.0) <= 2.0

    await station.eventually(is_true, f"{key} {true_deg}°")


async def see_described(station: StationPage, roll_deg: float, pitch_deg: float, heading_deg: float) -> None:
    """The indicator says in words what it shows."""
    picture = station.panel("instruments").get_by_role("img")

    async def is_true() -> bool:
        told = (await picture.get_attribute("aria-label") or "").replace("−", "-")
        figures = re.match(r"Roll (-?\d+)°, pitch (-?\d+)°, heading (\d+)°", told)
        if figures is None:
            return False
        away = [
            abs(float(one) - true)
            for one, true in zip(figures.groups(), (roll_deg, pitch_deg, heading_deg), strict=True)
        ]
        return max(away) <= 2.0

    await station.eventually(is_true, "the indicator's words")


async def see_horizon(station: StationPage, roll_deg: float, pitch_deg: float) -> None:
    """The picture itself: sky above and ground below, the wing that is down over ground, the nose on what it points at."""
    canvas = station.panel("instruments").locator("canvas")
    middle = -0.08  # the heading tape lies below
    if abs(pitch_deg) > 10.0:
        spots = {(0.0, middle + math.copysign(0.12, pitch_deg)): pitch_deg > 0.0}
    elif abs(roll_deg) > 10.0:
        spots = {(x, middle): x * roll_deg < 0.0 for x in (-0.15, 0.15)}
    else:
        spots = {(x, middle + y): y < 0.0 for x in (-0.1, 0.1) for y in (-0.22, 0.22)}

    async def is_true() -> bool:
        return [await is_sky(canvas, *spot) for spot in spots] == list(spots.values())

    await station.eventually(is_true, "the horizon")


async def is_sky(canvas: Locator, x: float, y: float) -> bool:
    """Whether a spot of the picture, in parts of its size from the middle, is more blue than brown."""
    red, blue = await canvas.evaluate(
        """(canvas, [x, y]) => {
            const side = 8;
            const [left, top] = [(0.5 + x) * canvas.width - side / 2, (0.5 + y) * canvas.height - side / 2];
            const copy = new OffscreenCanvas(side, side).getContext('2d', { willReadFrequently: true });
            copy.drawImage(canvas, -left, -top);
            const { data } = copy.getImageData(0, 0, side, side);
            const sum = (channel) => data.reduce((all, value, at) => all + (at % 4 === channel ? value : 0), 0);
            return [sum(0), sum(2)];
        }""",
        [x, y],
    )
    return bool(blue > red)


async def see_gravity(station: StationPage, roll_rad: float, pitch_rad: float) -> None:
    """The accelerometers feel gravity where it is: specific force in g, in body axes forward, right, down."""
    felt = [
        math.sin(pitch_rad),
        -math.sin(roll_rad) * math.cos(pitch_rad),
        -math.cos(roll_rad) * math.cos(pitch_rad),
    ]
    panel = await station.open_panel("sensors")
    plot = panel.get_by_role("figure", name=re.compile(f"^{station.text('sensor.acceleration')}: "))

    async def is_true() -> bool:
        told = (await plot.get_attribute("aria-label", timeout=30_000) or "").replace("−", "-")
        shown = [float(figure) for figure in re.findall(r"-?\d+\.\d+", told)]
        return shown == pytest.approx(felt, abs=0.06)

    await station.eventually(is_true, f"an acceleration of {felt} g")
