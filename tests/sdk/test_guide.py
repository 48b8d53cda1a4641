"""Every block of the guide to the package (docs/how-to/python.md) runs as a program of its own."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import vencejo
from vencejo import MissionItem, Plan
from vencejo.fleet import Aircraft, Fleet, default_key_file, has_fleet

from tests.support import HOME, ROOT, simulated_plane

pytestmark = pytest.mark.e2e
PAGE = ROOT / "docs/how-to/python.md"
LINK = '"tcp:127.0.0.1:5760"'
LAT, LON, _ = HOME


def blocks() -> dict[str, str]:
    """The program of each section."""
    found = {}
    for section in PAGE.read_text(encoding="utf-8").split("\n## ")[1:]:
        title, _, text = section.partition("\n")
        (found[title],) = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    return found


BLOCKS = blocks()


def run(title: str, *replaced: tuple[str, str]) -> None:
    code = BLOCKS[title]
    for old, new in replaced:
        assert old in code
        code = code.replace(old, new)
    exec(compile(code, f"{PAGE.name}: {title}", "exec"), {"__name__": "__main__"})


def test_each_block_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    circuit = (
        MissionItem.takeoff(LAT, LON - 0.003, alt_rel_home_m=50.0),
        MissionItem.waypoint(LAT + 0.003, LON - 0.006, alt_rel_home_m=60.0),
        MissionItem.waypoint(LAT + 0.003, LON + 0.01, alt_rel_home_m=50.0),
        MissionItem.waypoint(LAT, LON + 0.008, alt_rel_home_m=35.0),
        MissionItem.land(LAT, LON),
    )
    Plan(items=circuit).save("circuit.plan")
    told: dict[str, str] = {}
    with simulated_plane("--speedup", "50") as link:
        for title, code in BLOCKS.items():
            if "vencejo.fleet" not in code:
                run(title, *([(LINK, f'"{link}"')] if LINK in code else []))
                told[title] = capsys.readouterr().out
    assert len(told) >= 9
    assert "MANUAL" in told["Connect"]
    assert told["Telemetry and its age"].count("GeoPoint(") == 6
    assert "'mode': 'FBWA'" in told["Messages and events"]
    assert len(told["Fly a mission"].splitlines()) > 2
    assert told["Go to a position"] == "GUIDED\n"
    assert told["Parameters"].endswith(" True\n")
    assert "armable" in told["Errors"]
    assert len(told["asyncio"].splitlines()) == 2
    assert "GeoPoint(" in told["Recordings"]


@pytest.mark.skipif(not has_fleet(), reason="this build has no fleets")
def test_the_block_of_a_fleet_runs(capsys: pytest.CaptureFixture[str]) -> None:
    key = default_key_file("acme")
    with (
        simulated_plane() as link,
        vencejo.Station(record=False) as ground,
        Fleet(ground, org="acme", listen="tcp/127.0.0.1:0", key_file=key, history=False) as fleet,
        vencejo.Station(link, system_id=1, component_id=191, heartbeat=False, record=False) as board,
        Aircraft(board, org="acme", name="plane7", dial=fleet.endpoint, trust=[fleet.key], history=False),
    ):
        run("A plane of a fleet", ('org="acme")', f'org="acme", router="{fleet.endpoint}")'))
        assert board.wait_vehicle().telemetry.mode == "LOITER"
    assert "MANUAL [('plane7', None)]" in capsys.readouterr().out
