"""Packaging files are valid as far as can be checked here: units, settings, workflows, templates."""

from __future__ import annotations

import configparser
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.house.commands import parse
from tests.house.support import ROOT, tracked

UNITS = tracked("packaging/*/vencejo*.service")
WORKFLOWS = tracked(".github/workflows/*.yml")
SYSTEMD_ANALYZE = shutil.which("systemd-analyze")


def name_of(path: Path) -> str:
    return f"{path.parent.name}/{path.name}"


def load(path: Path) -> Any:
    return yaml.safe_load(path.read_text(encoding="utf-8"))


@pytest.mark.skipif(SYSTEMD_ANALYZE is None, reason="systemd-analyze is not installed")
@pytest.mark.parametrize("unit", UNITS, ids=name_of)
def test_systemd_finds_the_units_sound_and_little_exposed(unit: Path, tmp_path: Path) -> None:
    # The program started by the unit is not installed here.
    copy = tmp_path / unit.name
    copy.write_text(unit.read_text(encoding="utf-8").replace("/opt/vencejo/bin/vencejo", "/bin/true"), encoding="utf-8")
    for command in (["verify"], ["security", "--offline=yes", "--threshold=20"]):
        told = subprocess.run([str(SYSTEMD_ANALYZE), *command, str(copy)], capture_output=True, text=True, check=False)
        assert told.returncode == 0, told.stdout + told.stderr


@pytest.mark.parametrize("unit", UNITS, ids=name_of)
def test_units_start_commands_that_there_are(unit: Path) -> None:
    text = unit.read_text(encoding="utf-8")
    read = re.search(r"^EnvironmentFile=/etc/vencejo/(.*)$", text, re.MULTILINE)
    start = re.search(r"^ExecStart=/opt/vencejo/bin/(.*)$", text, re.MULTILINE)
    assert read is not None
    assert start is not None
    settings = dict(
        line.split("=", 1)
        for line in (unit.parent / read[1]).read_text(encoding="utf-8").splitlines()
        if line and not line.startswith("#")
    )
    parse(f"{start[1].replace('$VENCEJO_OPTIONS', settings['VENCEJO_OPTIONS'])} --link {settings['VENCEJO_LINK']}")


def test_there_is_a_unit_for_each_machine() -> None:
    units = {"raspberry-pi/vencejo.service", "raspberry-pi/vencejo-onboard.service", "server/vencejo.service"}
    assert {name_of(unit) for unit in UNITS} == units
    entry = configparser.ConfigParser(interpolation=None)
    entry.read(ROOT / "packaging/laptop/vencejo.desktop", encoding="utf-8")
    parse(entry["Desktop Entry"]["Exec"])


def test_udev_rules_name_what_they_match() -> None:
    lines = (ROOT / "packaging/raspberry-pi/60-vencejo.rules").read_text(encoding="utf-8").splitlines()
    rules = [line for line in lines if line and not line.startswith("#")]
    assert any('SYMLINK+="autopilot"' in rule for rule in rules)
    for rule in rules:
        for part in rule.split(", "):
            assert re.fullmatch(r'[A-Z]+(\{\w+\})?(==|!=|\+=|=)"[^"]*"', part), f"{part!r} in {rule!r}"


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda path: str(path.name))
def test_workflows_take_what_is_pinned_and_may_only_read(workflow: Path) -> None:
    steps = [step for job in load(workflow)["jobs"].values() for step in job["steps"]]
    assert steps
    assert load(workflow)["permissions"] == {"contents": "read"}
    text = workflow.read_text(encoding="utf-8")
    used = re.findall(r"uses: (.*)", text)
    assert len(used) == len([step for step in steps if "uses" in step])
    for action in used:
        assert re.fullmatch(r"[\w./-]+@[0-9a-f]{40} # v[\d.]+", action), f"{action}: not pinned by its hash"
    named = re.findall(r"(?:python -m pytest -q|-r) ((?:[\w./-]+ ?)+)", text)
    for path in " ".join(named).split():
        assert (ROOT / path).is_file(), f"{path} is not there"


def test_templates_and_citation_are_read() -> None:
    for path in tracked(".github/ISSUE_TEMPLATE/*.yml"):
        assert isinstance(load(path), dict), path
    citation = load(ROOT / "CITATION.cff")
    version = re.search(r'^version = "(.*)"', (ROOT / "Cargo.toml").read_text(encoding="utf-8"), re.MULTILINE)
    assert version is not None
    assert str(citation["version"]) == version[1]
    assert set(citation["license"]) == {"MIT", "Apache-2.0"}
