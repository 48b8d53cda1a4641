"""`vencejo demo`: it flies by itself while one watches, and then the plane is the visitor's."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner
from vencejo.cli.commands import app
from vencejo.cli.common import Failed
from vencejo.cli.demo import camera_options, has_desktop

from tests.server.client import Client, WebSocket
from tests.support import HOME, wait_for

QUICK = ("--speedup", "40", "--json", "--no-record", "--no-open")


@pytest.mark.e2e
def test_it_lands_near_its_point_and_ends_when_told_to() -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        taken = str(other.getsockname()[1])
        result = CliRunner().invoke(app, ["demo", *QUICK, "--exit-after-landing", "--wind", "3", "--port", taken])
    assert result.exit_code == 0, result.output
    assert f"Port {taken} is taken" in result.stderr
    told = [json.loads(line) for line in result.stdout.splitlines()]
    urls = [line["url"] for line in told if "url" in line]
    assert len(urls) == 1
    assert not urls[0].endswith(f":{taken}")
    last = told[-1]
    assert last["outcome"] == "landed"
    assert last["landing_error_m"] < 20.0
    assert 8 * 60 < last["flight_time_s"] < 12 * 60
    assert last["recording"] is None


def short_mission() -> dict[str, Any]:
    """Off to the west and on: enough to be in the air."""
    lat_deg, lon_deg, _ = HOME
    takeoff = {"command": 22, "frame": 3, "params": [12, 0, 0, 0, lat_deg, lon_deg - 0.004, 50]}
    point = {"command": 16, "frame": 3, "params": [0, 0, 0, 0, lat_deg, lon_deg - 0.012, 80]}
    home = {"command": 20, "frame": 2, "params": [0, 0, 0, 0, 0, 0, 0]}
    return {"items": [takeoff, point, home]}


@pytest.mark.e2e
def test_a_visitor_gets_control_and_then_the_plane(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "vencejo.cli", "demo", *QUICK, "--port", "0"]
    env = {**os.environ, "VENCEJO_DATA": str(tmp_path)}
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env) as process:
        try:
            assert process.stdout is not None

            def until(wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
                assert process.stdout is not None
                for line in process.stdout:
                    value: dict[str, Any] = json.loads(line)
                    if wanted(value):
                        return value
                raise AssertionError(process.communicate(timeout=120)[1])

            visitor = Client(until(lambda told: "url" in told)["url"])
            visitor.open_session(name="visitor")
            session = visitor.done("GET", "session")
            assert (session["has_control"], session["holder"]) == (False, "demo")
            (nose,) = visitor.done("GET", "cameras")
            assert (nose["name"], nose["state"], nose["viewers"]) == ("nose", "standby", 0)
            assert visitor.ask("POST", "vehicles/1/disarm").status == 423
            visitor.done("POST", "control/request")
            # An open page keeps the request alive.
            with WebSocket(visitor) as page:
                heard: list[dict[str, Any]] = []

                def follow() -> None:
                    with contextlib.suppress(OSError):  # closed at the end
                        while (message := page.take()) is not None:
                            heard.append(message)

                threading.Thread(target=follow, daemon=True).start()
                until(lambda told: told.get("event") == "control" and told["holder"] == "visitor")
                assert visitor.done("GET", "session")["has_control"] is True
                ended = until(lambda told: told.get("event") == "end")
                assert ended["outcome"] == "landed"
                until(lambda told: told.get("event") == "yours")

                state = visitor.done("GET", "vehicles/1")
                assert state["telemetry"]["heartbeat"]["is_armed"] is False
                assert state["telemetry"]["extended"]["landed"] == "on ground"
                assert state["telemetry"]["batteries"][0]["remaining_pct"] > 40
                assert visitor.done("GET", "vehicles/1/params/SIM_SPEEDUP")["value"] == 1

                visitor.operation("PUT", "vehicles/1/plan/mission", short_mission())
                visitor.done("POST", "vehicles/1/mode", {"mode": "MANUAL"})
                wait_for(lambda: visitor.ask("POST", "vehicles/1/arm").status == 200, "arming")
                heard.clear()
                visitor.done("POST", "vehicles/1/mission/start", {"from_item": 1})
                visitor.done("PUT", "vehicles/1/params/SIM_SPEEDUP", {"value": 40})
                wait_for(lambda: any(one.get("kind") == "item_reached" for one in heard), "the take-off")
                assert visitor.done("GET", "vehicles/1")["telemetry"]["position"]["alt_rel_home_m"] > 20
            process.send_signal(signal.SIGINT)
            _, errors = process.communicate(timeout=60)
            assert process.returncode == 0, errors
            assert "Traceback" not in errors
        finally:
            if process.poll() is None:
                process.kill()


def test_without_its_packages_there_is_no_camera(monkeypatch: pytest.MonkeyPatch) -> None:
    assert camera_options(False) == []
    assert camera_options(None) == camera_options(True) == ["--camera=127.0.0.1:0"]
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    assert camera_options(None) == []
    with pytest.raises(Failed, match=r"pip install.*opencv"):
        camera_options(True)


@pytest.mark.skipif(sys.platform in {"darwin", "win32"}, reason="there always is one")
def test_a_browser_is_opened_where_there_is_a_desktop(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert not has_desktop()
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
    assert has_desktop()
