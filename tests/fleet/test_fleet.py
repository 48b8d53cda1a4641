"""A plane far away: the simulated plane, the station on board and the ground station as programs of their own, over a way that is cut."""

from __future__ import annotations

import contextlib
import threading
import time
from pathlib import Path
from typing import Any

import pytest
from vencejo.fleet import has_fleet

from tests.fleet.programs import far_plane
from tests.support import HOME, simulated_plane, wait_for

pytestmark = pytest.mark.skipif(not has_fleet(), reason="this build has no fleets")


@pytest.mark.e2e
def test_a_plane_is_seen_and_commanded_over_a_network_that_is_cut_and_heals(tmp_path: Path) -> None:
    with far_plane(tmp_path) as plane:
        ana, at = plane.ana, plane.at

        def telemetry() -> dict[str, Any]:
            found: dict[str, Any] = ana.done("GET", at)["telemetry"]
            return found

        wait_for(lambda: telemetry().get("position") is not None, "its position")
        position = telemetry()["position"]
        assert position["lat_deg"] == pytest.approx(HOME[0], abs=0.01)
        assert position["lon_deg"] == pytest.approx(HOME[1], abs=0.01)

        # An act asks for control first; its answer comes when the autopilot shows it.
        ana.done("POST", "control/take")
        ana.done("POST", f"{at}/mode", {"mode": "FBWA"})
        plane.board.until(holder="Ana")
        wait_for(lambda: plane.summary["mode"] == "FBWA", "the mode")
        refused = ana.ask("POST", f"{at}/mode", {"mode": "NONSENSE"})
        assert (refused.status, refused.json["cause"]["code"]) == (409, "remote-refused")
        assert "NONSENSE" in refused.json["detail"]
        # What an order has no form of its own for goes by its name; its danger is known on both sides.
        unconfirmed = ana.ask("POST", f"{at}/switch-fence", {"on": False})
        assert (unconfirmed.status, unconfirmed.json["cause"]["act"]) == (428, "fence-off")
        confirmation = {"vencejo_confirmation": unconfirmed.json["cause"]["confirmation"]}
        assert ana.ask("POST", f"{at}/switch-fence", {"on": False}, **confirmation).status == 200
        unsent = ana.ask("POST", f"{at}/messages", {"name": "HEARTBEAT", "fields": {}})
        assert (unsent.status, unsent.json["cause"]["code"]) == (409, "remote-refused")
        assert "COMMAND_LONG" in unsent.json["detail"]

        plane.way.cut()
        wait_for(lambda: telemetry()["heartbeat"]["age_s"] > 5.0, "its silence")
        lost = ana.ask("POST", f"{at}/mode", {"mode": "CIRCLE"})
        assert (lost.status, lost.json["cause"]["code"]) == (504, "vehicle-lost")

        plane.way.heal()
        wait_for(lambda: telemetry()["heartbeat"]["age_s"] < 2.0, "it to come back")
        assert plane.summary["mode"] == "FBWA", "what could not be sent is not done later"
        ana.done("POST", f"{at}/mode", {"mode": "MANUAL"})
        wait_for(lambda: plane.summary["mode"] == "MANUAL", "the mode")

        ana.done("POST", "control/release")
        plane.board.until(holder=None)


@pytest.mark.e2e
def test_a_station_that_is_not_trusted_sees_and_does_nothing(tmp_path: Path) -> None:
    from vencejo import Station
    from vencejo.errors import ControlHeld, NotPossibleNow, VehicleLost
    from vencejo.fleet import Aircraft, Fleet

    quiet: dict[str, Any] = {"record": False, "signing": False}
    with (
        simulated_plane() as link,
        Station(operator="here", **quiet) as here,
        Fleet(here, org="acme", listen="tcp/127.0.0.1:0", key_file=tmp_path / "here.key") as fleet,
        Station(operator="elsewhere", **quiet) as elsewhere,
        Fleet(elsewhere, org="acme", router=fleet.endpoint, key_file=tmp_path / "elsewhere.key") as stranger,
        Station(link, system_id=1, component_id=191, heartbeat=False, operator="board", **quiet) as board,
        contextlib.ExitStack() as stack,
    ):

        def start() -> Aircraft:
            return stack.enter_context(
                Aircraft(board, org="acme", name="plane7", dial=fleet.endpoint, trust=[fleet.key])
            )

        aircraft = start()
        plane, seen = here.wait_vehicle(), elsewhere.wait_vehicle()
        assert (plane.remote_name, seen.remote_name) == ("plane7", "plane7")
        # By its name, so the same in each station and each time; none that a vehicle at a link can have.
        assert plane.system_id == seen.system_id
        assert 256 <= plane.system_id <= 65_535
        assert board.wait_vehicle().remote_name is None
        with pytest.raises(NotPossibleNow, match=stranger.key):
            seen.set_mode("FBWA")
        plane.set_mode("FBWA")
        wait_for(lambda: aircraft.status.holder == "here", "control from far away")
        # Started again, an order at once: it was not done, or is; but somebody knows.
        for _ in range(3):
            aircraft.close()
            again: list[Aircraft] = []
            starts = threading.Thread(target=lambda into=again: into.append(start()))
            starts.start()
            with contextlib.suppress(NotPossibleNow, VehicleLost):
                plane.set_mode("MANUAL")
            starts.join()
            aircraft = again[0]
            wait_for(lambda: again[0].status.is_connected, "it to be there again")  # noqa: B023
            there_at = time.monotonic()
        # What was heard of it before it started again is no ground for an order.
        wait_for(lambda: fleet.aircraft[0].age_s < time.monotonic() - there_at, "it to be heard again")
        plane.set_mode("FBWA")
        # Whoever is beside the aircraft comes before all the others.
        board.operator.request()
        wait_for(lambda: aircraft.status.holder == "board", "control on board")
        with pytest.raises(ControlHeld):
            plane.set_mode("CIRCLE")
        assert board.wait_vehicle().telemetry.mode == "FBWA"
        # The cable comes off: the computer on board is heard, and says so.
        assert (fleet.aircraft[0].autopilot_silent_s, aircraft.status.links) == (None, None)
        for each in board.links:
            board.close_link(each.id)
        wait_for(lambda: fleet.aircraft[0].autopilot_silent_s is not None, "the autopilot's silence")
        assert (fleet.aircraft[0].is_present, fleet.aircraft[0].links) == (True, "no link")
        assert (aircraft.status.autopilot_silent_s or 0.0) > 5.0
