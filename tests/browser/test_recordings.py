"""A recorded flight beside a live plane of the same system id: found, replayed, and never taken for the live one."""

from __future__ import annotations

import shutil
from pathlib import Path

from playwright.async_api import expect

from tests.browser.conftest import OpenStation, Serve
from tests.plane import Plane
from tests.support import CAPTURES, wait_for


async def test_a_recording_is_replayed_and_never_taken_for_the_live_plane(
    open_station: OpenStation, serve: Serve, tmp_path: Path
) -> None:
    (tmp_path / "telemetry").mkdir()
    shutil.copy(CAPTURES / "arduplane-takeoff-to-landing.tlog", tmp_path / "telemetry" / "flight.tlog")
    with Plane() as plane:
        served = serve("--link", plane.link, "--record")
        before = served.client(name="before")
        wait_for(lambda: len(before.done("GET", "vehicles")) == 1, "the plane")
        before.done("POST", "control/release")
        async with open_station(served.url) as station:
            await station.see_plane()
            settings = await station.open_panel("settings")
            name = station.text("recordings.replay", name="flight.tlog")
            await settings.get_by_role("button", name=name, exact=True).click()
            replay = station.page.get_by_role("region", name=station.text("replay.badge"), exact=True)
            await expect(replay).to_be_visible()
            await expect(station.bar("bar.link")).to_have_text(station.text("replay.badge"))
            await expect(station.bar("bar.mode")).to_have_text("MANUAL")

            fly = await station.open_panel("fly")
            await expect(fly.get_by_text(station.text("replay.bars"))).to_be_visible()
            await expect(fly.get_by_role("button", name=station.text("fly.arm"), exact=True)).to_have_count(0)

            # To the middle of the flight, and held there.
            await replay.get_by_role("button", name=station.text("replay.pause"), exact=True).click()
            await replay.get_by_role("slider").fill("150")
            await expect(station.bar("bar.mode")).to_have_text("AUTO")
            await expect(station.bar("bar.motors")).to_contain_text(station.text("bar.armed"))
            (shown,) = before.done("GET", "replays")
            assert (shown["is_paused"], round(shown["position_s"])) == (True, 150)

            # Two vehicles of one system id: the live one is as it was, and takes the commands.
            live, recorded = before.done("GET", "vehicles")
            assert (live["system_id"], live["is_recorded"], live["is_armed"]) == (1, False, False)
            assert recorded["is_recorded"]
            await station.page.get_by_role("combobox", name=station.text("bar.selectVehicle")).select_option("1")
            await expect(replay).to_have_count(0)
            await expect(fly.get_by_role("button", name=station.text("fly.arm"), exact=True)).to_be_enabled()

            # Begun again from its end, and closed: the live one is left.
            await station.page.get_by_role("combobox", name=station.text("bar.selectVehicle")).select_option(
                str(recorded["system_id"])
            )
            before.done("PATCH", f"replays/{shown['id']}", {"position_s": 1e6, "is_paused": False})
            await replay.get_by_role("button", name=station.text("replay.again"), exact=True).click()
            await expect(station.bar("bar.mode")).to_have_text("MANUAL")
            await replay.get_by_role("button", name=station.text("replay.close"), exact=True).click()
            await expect(replay).to_have_count(0)
            await expect(station.state_bar).to_contain_text("Plane 1")
            assert [vehicle["system_id"] for vehicle in before.done("GET", "vehicles")] == [1]
