"""Plans, parameters and commands of a plane far away, through the same doors: programs of their own, over a way that is cut in the middle."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from vencejo.fleet import has_fleet

from tests.fleet.programs import far_plane
from tests.support import HOME, wait_for

pytestmark = pytest.mark.skipif(not has_fleet(), reason="this build has no fleets")


def plan_of(count: int, alt_m: float) -> dict[str, Any]:
    """A mission of waypoints, of which no two are the same."""
    take_off = {"command": 22, "frame": 3, "params": [12.0, 0, 0, 0, HOME[0], HOME[1], 50.0]}
    points = [
        {"command": 16, "frame": 3, "params": [0, 0, 0, 0, HOME[0] + 0.001 + n * 3.7e-5, HOME[1] + n % 7 * 1e-4, alt_m]}
        for n in range(count - 1)
    ]
    return {"items": [take_off, *points]}


@pytest.mark.e2e
def test_plans_parameters_and_commands_reach_a_plane_far_away_and_a_cut_stops_nothing(tmp_path: Path) -> None:
    with far_plane(tmp_path) as plane:
        ana, at = plane.ana, plane.at

        def on_board() -> dict[str, Any]:
            found: dict[str, Any] = ana.done("GET", f"{at}/plan/mission")
            return found

        def stands(operation: dict[str, Any]) -> dict[str, Any]:
            found: dict[str, Any] = ana.done("GET", f"operations/{operation['id']}")
            return found

        # What the station on board has read is known here, by itself.
        wait_for(lambda: on_board()["state"]["state"] == "empty", "what is on board")
        ana.done("POST", "control/take")

        # Sent, read back and compared on board.
        kept = ana.operation("PUT", f"{at}/plan/mission", plan_of(40, 80.0))
        assert kept["items"][39]["params"][4] == pytest.approx(HOME[0] + 0.001 + 38 * 3.7e-5, abs=1e-7)
        known = on_board()
        assert (known["state"]["state"], known["state"]["count"], known["plan"]) == ("verified", 40, kept)

        # Cut in the middle, wherever it is by then: what has arrived goes on, and when it heals it is told what became of it.
        operation = ana.done("PUT", f"{at}/plan/mission", plan_of(640, 120.0))
        plane.way.cut()
        wait_for(lambda: ana.done("GET", at)["telemetry"]["heartbeat"]["age_s"] > 5.0, "its silence")
        plane.way.heal()
        wait_for(lambda: ana.done("GET", at)["telemetry"]["heartbeat"]["age_s"] < 2.0, "it to come back")
        wait_for(lambda: stands(operation)["state"] != "running", "its end")
        wait_for(lambda: on_board()["state"]["state"] == "verified", "what is on board")
        heights = {item["params"][6] for item in on_board()["plan"]["items"][1:]}
        assert heights == {120.0} or (stands(operation)["state"], heights) == ("failed", {80.0}), (
            "old or new, never mixed"
        )

        # To read is an order too. One that comes too late for being based on what was seen before the cut is given again.
        plane.way.cut()
        operation = ana.done("POST", f"{at}/plan/mission/read")
        wait_for(lambda: ana.done("GET", at)["telemetry"]["heartbeat"]["age_s"] > 6.5, "its silence")
        plane.way.heal()
        wait_for(lambda: stands(operation)["state"] != "running", "its end")
        assert stands(operation)["state"] == "done", stands(operation)
        assert ana.operation("POST", f"{at}/plan/mission/read") == on_board()["plan"]

        # Clearing asks for its confirmation first.
        refused = ana.ask("DELETE", f"{at}/plan/mission")
        assert (refused.status, refused.json["cause"]["act"]) == (428, "clear-mission")
        confirmation = {"Vencejo-Confirmation": refused.json["cause"]["confirmation"]}
        ana.operation("DELETE", f"{at}/plan/mission", **confirmation)
        assert on_board()["state"]["state"] == "empty"

        # Parameters: all in one answer, one, one that is set and read back, one that nobody knows.
        def params() -> dict[str, float]:
            return {each["name"]: each["value"] for each in ana.operation("GET", f"{at}/params")}

        before = params()
        assert len(before) > 100
        assert ana.done("GET", f"{at}/params/RTL_ALTITUDE")["value"] == before["RTL_ALTITUDE"]
        assert ana.done("PUT", f"{at}/params/RTL_ALTITUDE", {"value": 123.0})["value"] == 123.0
        assert params() == {**before, "RTL_ALTITUDE": 123.0}, "what was kept for others is read anew"
        unknown = ana.ask("GET", f"{at}/params/NO_SUCH")
        assert (unknown.status, unknown.json["cause"]["code"]) == (404, "unknown-param")

        # A command by its number; one that has to be confirmed; a message asked for.
        ana.done("POST", f"{at}/command/long", {"command": "DO_SET_MODE", "params": [1, 12]})
        wait_for(lambda: plane.summary["mode"] == "LOITER", "the mode")
        forced = ana.ask("POST", f"{at}/command/long", {"command": 400, "params": [1, 21196]})
        assert (forced.status, forced.json["cause"]["act"]) == (428, "force-arm")
        assert ana.done("POST", f"{at}/messages/AUTOPILOT_VERSION/request")["name"] == "AUTOPILOT_VERSION"
