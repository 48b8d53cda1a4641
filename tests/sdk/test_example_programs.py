"""The programs in examples/ run against simulated planes, in the order in which their README has a person run them."""

from __future__ import annotations

import csv
import io
import itertools
import json
import runpy
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import cast

import pytest
import vencejo

from tests.support import ROOT, simulated_plane

pytestmark = pytest.mark.e2e
EXAMPLES = ROOT / "examples"


@pytest.fixture(scope="module")
def link() -> Iterator[str]:
    with simulated_plane("--speedup", "50", "--wind", "5", "--wind-from", "270") as link:
        yield link


def run(name: str, *arguments: str, monkeypatch: pytest.MonkeyPatch, typed: str = "") -> None:
    """Run an example in this process, as `python NAME ARGUMENTS…` would."""
    monkeypatch.setattr(sys, "argv", [name, *arguments])
    monkeypatch.setattr(sys, "stdin", io.StringIO(typed))
    runpy.run_path(str(EXAMPLES / name), run_name="__main__")


def end_streams_after(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have programs that follow for ever see some real snapshots, and then Ctrl-C."""
    stream = vencejo.Vehicle.stream

    def ended(self: vencejo.Vehicle, *, rate_hz: float = 10.0) -> Iterator[vencejo.Telemetry]:
        yield from itertools.islice(stream(self, rate_hz=50.0), count)
        raise KeyboardInterrupt

    monkeypatch.setattr(vencejo.Vehicle, "stream", ended)


def test_follow_to_csv(
    link: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    end_streams_after(30, monkeypatch)
    run("follow_to_csv.py", str(tmp_path / "flight.csv"), link, monkeypatch=monkeypatch)
    with (tmp_path / "flight.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 30
    assert rows[-1]["mode"] == "MANUAL"
    assert float(rows[-1]["lat_deg"]) == pytest.approx(40.3332, abs=0.001)
    assert "flight.csv" in capsys.readouterr().out


def test_dashboard(link: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    end_streams_after(30, monkeypatch)
    run("dashboard.py", link, monkeypatch=monkeypatch)
    assert "attitude" in capsys.readouterr().out


def test_design_a_landing_fly_it_and_draw_the_flight(
    link: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = str(tmp_path / "circuit.plan")
    run("design_landing.py", file, "270", "5", link, monkeypatch=monkeypatch)
    assert "course 270°, headwind 5.0 m/s" in capsys.readouterr().out
    assert [item.name for item in vencejo.Plan.load(file)][-1] == "NAV_LAND"

    with pytest.raises(SystemExit, match="nothing was armed"):
        run("fly_plan.py", file, link, monkeypatch=monkeypatch, typed="n\n")
    run("fly_plan.py", file, link, monkeypatch=monkeypatch, typed="y\n")
    told = capsys.readouterr().out
    assert "4 items on board, verified" in told
    assert told.endswith("flown to its end\n")

    monkeypatch.setenv("MPLBACKEND", "Agg")
    notebook = json.loads((EXAMPLES / "draw_flight.ipynb").read_text(encoding="utf-8"))
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert len(cells) >= 3
    names: dict[str, object] = {}
    for cell in cells:
        assert (cell["outputs"], cell["execution_count"]) == ([], None), "a notebook is committed without outputs"
        exec(compile("".join(cell["source"]), "draw_flight.ipynb", "exec"), names)
    told = capsys.readouterr().out
    assert "mode AUTO" in told
    positions, highest_m = (int(told.split(word)[0].split()[-1]) for word in (" positions", " m above home at most"))
    assert positions > 50
    track = cast("list[tuple[float, ...]]", names["track"])
    assert all(one[1:] != other[1:] for one, other in itertools.pairwise(track)), "each position once"
    assert 50 <= highest_m <= 80
    import matplotlib.pyplot as plt

    plt.close("all")


def test_two_planes(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    with simulated_plane("--planes", "2", "--speedup", "50") as link:
        run("two_planes.py", link, monkeypatch=monkeypatch)
    told = capsys.readouterr().out.splitlines()
    assert sorted(told) == [f"plane {number} {what}" for number in (1, 2) for what in ("circles", "is up")]


def test_lost_link() -> None:
    """The plane stands armed; its process stands still until the program has said that it is lost."""
    simulator = [sys.executable, str(ROOT / "tests" / "booted.py"), "--link", "tcp:127.0.0.1:0"]
    with subprocess.Popen(simulator, stdout=subprocess.PIPE, text=True) as plane:
        assert plane.stdout is not None
        link = json.loads(plane.stdout.readline())["listening"]
        program = [sys.executable, str(EXAMPLES / "lost_link.py"), link]
        with subprocess.Popen(program, stdout=subprocess.PIPE, text=True) as watching:
            assert watching.stdout is not None
            try:
                with vencejo.connect(link, record=False) as other:
                    other.arm()
                assert watching.stdout.readline() == "armed\n"
                plane.send_signal(signal.SIGSTOP)
                assert watching.stdout.readline().startswith("lost; last seen at GeoPoint(")
                plane.send_signal(signal.SIGCONT)
                assert "in mode RTL" in watching.stdout.readline()
                assert watching.stdout.readline() == "it circles at home\n"
                assert watching.wait(60) == 0
            finally:
                watching.kill()
                plane.kill()


def test_all_are_run() -> None:
    here = Path(__file__).read_text(encoding="utf-8")
    listed = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    programs = [path.name for path in EXAMPLES.iterdir() if path.suffix in (".py", ".ipynb")]
    assert len(programs) >= 6
    for name in programs:
        assert f'"{name}"' in here, f"no test runs {name}"
        assert f"({name})" in listed, f"examples/README.md does not list {name}"
