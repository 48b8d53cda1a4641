"""Orders to a plane of a fleet from a terminal, and over HTTP as docs/fleet.md shows it."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result
from vencejo.cli.commands import app
from vencejo.fleet import Fleet, FleetStatus, has_fleet

from tests.fleet.programs import FarPlane, far_plane
from tests.house.test_docs_commands import lines
from tests.server.client import WebSocket
from tests.support import wait_for

pytestmark = [pytest.mark.skipif(not has_fleet(), reason="this build has no fleets"), pytest.mark.e2e]


@pytest.fixture(scope="module")
def plane(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[FarPlane, Path]]:
    """A plane far away, and the data folder of its ground station."""
    folder = tmp_path_factory.mktemp("fleet")
    with far_plane(folder) as plane:
        yield plane, folder / "ground"


def run(plane: tuple[FarPlane, Path], *args: str) -> Result:
    far, data = plane
    router = ["--fleet-router", far.told["fleet"]["endpoint"]]
    return CliRunner().invoke(app, [*args, *router], env={"VENCEJO_DATA": str(data), "VENCEJO_LINK": "tcp:nobody:1"})


def test_commands_act_on_a_plane_of_a_fleet(plane: tuple[FarPlane, Path], tmp_path: Path) -> None:
    far, _ = plane
    on = ("--fleet", "acme", "--plane", "plane7")

    def done(*args: str) -> Any:
        result = run(plane, *args, *on, "--json")
        assert result.exit_code == 0, result.output
        return json.loads(result.stdout)

    def mode_is(mode: str) -> bool:
        return bool(far.summary["mode"] == mode)

    far.ana.ask("POST", "control/release")
    wait_for(lambda: far.ana.done("GET", far.at)["telemetry"].get("position") is not None, "its position")
    sample = done("telemetry", "--once", "--groups", "position")
    assert (sample["remote_name"], sample["position"]["lat_deg"] is not None) == ("plane7", True)
    assert run(plane, "telemetry", "--once", "--groups", "position", *on).stdout.split()[0] == "plane7"
    assert done("params", "get", "WP_RADIUS") == {"WP_RADIUS": 50}
    assert done("ask", "mode", "mode=FBWA")["done"] is True
    wait_for(lambda: mode_is("FBWA"), "the mode")
    assert done("params", "save", str(tmp_path / "plane7.param"))["count"] > 1_000

    # Nobody is overruled unless that is wanted.
    with WebSocket(far.ana):  # with a page, she keeps control
        far.ana.done("POST", "control/take")
        far.ana.done("POST", f"{far.at}/mode", {"mode": "MANUAL"})
        far.board.until(holder="Ana")
        held = run(plane, "ask", "mode", "mode=CIRCLE", *on)
    assert held.exit_code == 1
    assert "Ana has control of plane7: wait until it is given up; --take-control takes it from" in held.stderr
    assert done("ask", "request-message", "message=AUTOPILOT_VERSION")["message"] == "AUTOPILOT_VERSION"
    assert mode_is("MANUAL")
    assert done("ask", "mode", "mode=CIRCLE", "--take-control")["done"] is True
    wait_for(lambda: mode_is("CIRCLE"), "the mode")


def test_what_is_not_meant_is_said(plane: tuple[FarPlane, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    def says(*args: str) -> tuple[int, str]:
        result = run(plane, "telemetry", "--once", *args)
        return result.exit_code, result.stderr

    # Each aircraft says something each second.
    code, said = says("--fleet", "acme", "--plane", "plane9", "--timeout", "5")
    assert (code, "called plane9 was heard within 5 s; heard: plane7" in said) == (1, True), said
    with monkeypatch.context() as unreached:
        missed = FleetStatus(is_connected=False, problem="tcp/127.0.0.1:7447: it is reached and answers nothing")
        unreached.setattr(Fleet, "status", missed)
        code, said = says("--fleet", "acme", "--plane", "plane9", "--timeout", "0.1")
    assert (code, f"plane9 was not heard within 0.1 s: {missed.problem}" in said) == (1, True), said
    code, said = says("--fleet", "acme")
    assert (code, "--plane NAME (plane7)" in said) == (2, True), said
    code, said = says("--fleet", "acne", "--plane", "plane7")
    assert (code, "not a ground station of a fleet acne" in said) == (1, True), said
    code, said = says("--plane", "plane7")
    assert (code, "--fleet ORG (none is here yet)" in said) == (2, True), said
    code, said = says()
    assert (code, "add --plane" in said) == (2, True), said
    code, said = says("--plane", "plane7", "--link", "tcp:127.0.0.1:1")
    assert (code, "not of a fleet" in said) == (2, True), said


@pytest.mark.skipif(shutil.which("curl") is None, reason="there is no curl")
def test_the_http_example_ends_with_an_order(plane: tuple[FarPlane, Path], tmp_path: Path) -> None:
    far, _ = plane
    far.ana.ask("POST", "control/release")
    commands = [command for page, command in lines() if page == "docs/fleet.md" and command.startswith("curl ")]
    assert len(commands) == 3
    for command in [*commands, "curl -b cookies -X DELETE http://127.0.0.1:8765/api/v1/session"]:
        line = command.replace("http://127.0.0.1:8765", far.told["url"]).replace("40713", str(far.summary["system_id"]))
        ended = subprocess.run(["sh", "-c", line], cwd=tmp_path, capture_output=True, text=True, check=True)
        assert '"status"' not in ended.stdout, ended.stdout
    wait_for(lambda: bool(far.summary["mode"] == "RTL"), "the way home")
