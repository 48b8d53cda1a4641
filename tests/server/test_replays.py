"""Replays over HTTP: found by name, steered, marked on their vehicles, and closed."""

from __future__ import annotations

import shutil
from pathlib import Path

from tests.server.client import serving
from tests.support import CAPTURES, wait_for


def test_a_recording_is_replayed_over_http(tmp_path: Path) -> None:
    folder = tmp_path / "telemetry"
    folder.mkdir()
    shutil.copy(CAPTURES / "arduplane-takeoff-to-landing.tlog", folder / "flight.tlog")
    (folder / "noise.tlog").write_bytes(b"\0" * 4096)
    link = f"tlog:{CAPTURES / 'arduplane-takeoff-to-landing.tlog'}?speed=2"
    with serving("--link", link, "--record", data=tmp_path) as served:
        client = served.client(name="ana")
        # What was given as a link is a replay as well.
        (given,) = client.done("GET", "replays")
        assert (given["speed"], given["file"]) == (2.0, "arduplane-takeoff-to-landing.tlog")
        client.done("DELETE", f"replays/{given['id']}")
        wait_for(lambda: client.done("GET", "vehicles") == [], "its end")

        (flight,) = [one for one in client.done("GET", "recordings") if one["name"] == "flight.tlog"]
        opened = client.done("POST", "replays", {"name": "flight.tlog", "position_s": 150})
        assert opened["start_unix_s"] == flight["start_unix_s"]
        at = f"replays/{opened['id']}"
        paused = client.done("PATCH", at, {"is_paused": True, "speed": 8})
        assert (paused["is_paused"], paused["speed"], paused["seeks"]) == (True, 8.0, 1)
        kinds = {mark["kind"] for mark in client.done("GET", f"{at}/marks")}
        assert kinds == {"armed", "disarmed", "mode"}

        (identity,) = opened["vehicles"]
        state = f"vehicles/{identity}"
        wait_for(lambda: client.done("GET", state)["telemetry"].get("heartbeat") is not None, "its state there")
        age_s = client.done("GET", state)["telemetry"]["heartbeat"]["age_s"]
        assert client.done("GET", state)["telemetry"]["heartbeat"]["age_s"] == age_s, "nothing ages while it is paused"
        (summary,) = client.done("GET", "vehicles")
        assert (summary["is_recorded"], summary["is_armed"], summary["link"]) == (True, True, None)
        assert summary["replay"] == client.done("GET", "replays")[0]
        assert client.ask("POST", f"{state}/arm").status == 409

        client.done("PATCH", at, {"position_s": 250})
        texts = client.done("GET", f"{state}/texts")
        assert 150 < texts[-1]["time_s"] <= 250, "their time is their place in the recording"
        assert all(abs(text["unix_s"] - opened["start_unix_s"] - text["time_s"]) < 1 for text in texts)
        assert client.done("GET", f"{state}/texts") == texts
        elsewhere = client.done("PATCH", at, {"position_s": 20})
        assert elsewhere["seeks"] == 3
        assert all(text["time_s"] <= 20 for text in client.done("GET", f"{state}/texts")), "it answers once it is there"

        moved = client.done("PATCH", at, {"position_s": 1e6, "is_paused": False})
        assert (moved["seeks"], moved["position_s"]) == (4, moved["duration_s"])
        wait_for(lambda: client.done("GET", "replays")[0]["is_over"], "its end")
        again = client.done("PATCH", at, {"is_paused": False, "speed": 0.01})
        assert not again["is_over"]
        assert again["position_s"] < 1.0

        for body, status in [
            ({"name": "../flight.tlog"}, 404),
            ({"name": "plane7.mcap", "place": "acme"}, 404),
            ({"name": "noise.tlog"}, 422),
            ({"name": "flight.tlog", "speed": 0}, 422),
        ]:
            assert client.ask("POST", "replays", body).status == status, body
        assert client.ask("PATCH", at, {"position_s": -1}).status == 422
        assert client.ask("PATCH", "replays/99", {}).status == 404
        client.done("DELETE", at)
        assert client.ask("DELETE", at).status == 404
        assert client.done("GET", "replays") == []
