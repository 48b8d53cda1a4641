"""The fleet in examples/fleet: its compose file is sound, and its commands do what they say, as programs of this machine."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from vencejo.fleet import has_fleet

from tests.fleet.programs import Program
from tests.house.commands import parse
from tests.server.client import Client
from tests.support import ROOT, reserved_ports, wait_for

EXAMPLE = ROOT / "examples/fleet"
COMPOSE: dict[str, Any] = yaml.safe_load((EXAMPLE / "compose.yaml").read_text(encoding="utf-8"))
SERVICES: dict[str, Any] = COMPOSE["services"]
KEYS = {"build", "image", "init", "restart", "environment", "volumes", "ports", "healthcheck", "depends_on", "command"}
CONDITIONS = {"service_started", "service_healthy", "service_completed_successfully"}


def script(service: str) -> str:
    """What a service runs, as its shell reads it."""
    shell, flags, text = SERVICES[service]["command"]
    assert (shell, flags[0], flags[-1]) == ("sh", "-", "c")
    return str(text).replace("$$", "$")


def test_the_compose_file_names_what_there_is() -> None:
    assert {key for key in COMPOSE if not key.startswith("x-")} == {"name", "services", "volumes"}
    for name, service in SERVICES.items():
        assert not service.keys() - KEYS, name
        assert (ROOT / "examples/fleet" / service["build"]["context"]).resolve() == ROOT
        assert (ROOT / service["build"]["dockerfile"]).is_file()
        for other, wanted in service.get("depends_on", {}).items():
            assert wanted["condition"] in CONDITIONS
            assert other in SERVICES, f"{name} waits for {other}"
            assert wanted["condition"] != "service_healthy" or "healthcheck" in SERVICES[other]
        folders = {}
        for volume in service["volumes"]:
            source, folder = volume.split(":")[:2]
            assert source in COMPOSE["volumes"], f"{name} keeps in {source}"
            folders[source] = folder
        environment = service["environment"]
        assert set(re.findall(r"\$([A-Z_]+)", script(name))) <= environment.keys(), name
        assert {environment[key] for key in ("VENCEJO_DATA", "TOKENS") if key in environment} == set(folders.values())
        for found in re.findall(r"\bvencejo [^|<&\n]+", script(name)):
            line = str(found)
            for word, value in {"plane": "plane1", **environment}.items():
                line = re.sub(rf'"?\${word}\b"?', value, line)
            parse(line.strip())
    # What each plane is told differs by its name and place alone.
    planes = [name for name in SERVICES if name.startswith("plane")]
    assert len({script(name) for name in planes}) == 1
    assert [SERVICES[name]["environment"]["PLANE"] for name in planes] == planes
    assert all(f" {name}" in script("enrol") for name in planes)
    copied = re.findall(r"^COPY (\S+)", (EXAMPLE / "Dockerfile").read_text(encoding="utf-8"), re.MULTILINE)
    assert copied[0] == "dist/*.whl"
    assert (ROOT / copied[1]).is_file()


@contextlib.contextmanager
def run(service: str, folder: Path, **other: str) -> Iterator[Program]:
    """A service as a program of this machine, with some of its settings changed."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    own = {"VENCEJO_DATA": str(folder / service), "TOKENS": str(folder / "tokens"), "PATH": path}
    env = {**os.environ, **SERVICES[service]["environment"], **own, **other}
    command = [*SERVICES[service]["command"][:2], script(service)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=env, start_new_session=True) as process:
        try:
            yield Program(process)
        finally:
            # Its simulator as well.
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGTERM)


def until(program: Program, wanted: str) -> str:
    """The next line of a program with some words in it."""
    assert program.process.stdout is not None
    for line in program.process.stdout:
        if re.search(wanted, line):
            return line
    raise AssertionError(f"it ended, and never said {wanted}")


@pytest.mark.e2e
@pytest.mark.skipif(not has_fleet(), reason="this build has no fleets")
@pytest.mark.skipif(sys.platform == "win32", reason="the commands are those of a Linux container")
def test_its_commands_bring_a_plane_and_a_follower_in(tmp_path: Path) -> None:
    options = "--port 0 --no-record --json --fleet-listen tls/127.0.0.1:0 --fleet-door 127.0.0.1:0"
    (tmp_path / "tokens").mkdir()
    with run("ground", tmp_path, GROUND="127.0.0.1", VENCEJO_LINK="udpin:127.0.0.1:0", OPTIONS=options) as ground:
        until(ground, "The fleet acme is made")
        until(ground, "reach this machine as 127.0.0.1")
        ana = Client(ground.line()["url"])
        ana.open_session(name="Ana")
        with run("enrol", tmp_path, VENCEJO_DATA=str(tmp_path / "ground")) as enrol:
            assert enrol.process.wait() == 0
        with (
            reserved_ports() as (port,),
            run("plane1", tmp_path, AUTOPILOT=f"tcp:127.0.0.1:{port}", OPTIONS="--json --no-record"),
            run("follower", tmp_path, PROGRAM=str(EXAMPLE / "follow.py")) as follower,
        ):
            wait_for(lambda: any(each["remote_name"] == "plane1" for each in ana.done("GET", "vehicles")), "the plane")
            # Over TLS what reads and what writes a session must not be two threads (docs/adr/0036).
            tasks = Path(f"/proc/{ground.process.pid}/task").glob("*/comm")
            threads = {task.read_text(encoding="utf-8").rstrip("0123456789\n") for task in tasks}
            assert "tx-" in threads
            assert "rx-" not in threads
            said = until(follower, r"^plane1: \w+, 40\.33\d+ -3\.76\d+, control: nobody")
            assert "LOST" not in said
