"""Progress of `make demo` and `make native`, on a terminal and in a log, and the output of a failed step."""

from __future__ import annotations

import io
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.house.support import ROOT, load

get_ready = load("scripts/get_ready.py")

CARGO = (
    "    Updating crates.io index\n Downloading crates ...\n  Downloaded serde v1.0.229\n   Compiling libc v0.2.191\n"
    "    Building [=>                    ] 12/297: libc(build), serde\r"
    "    Building [=======>              ] 143/297: mavlink, tokio\r"
)


def test_progress_is_read_from_what_the_programs_say() -> None:
    assert get_ready.cargo_progress(CARGO) == "143 of 297, mavlink"
    assert get_ready.cargo_progress(CARGO.partition("    Building")[0]) == "fetching crates"
    assert get_ready.cargo_progress("") == ""
    pip = "Collecting numpy==2.3.1 (from -r requirements/demo.lock (line 3))\n  Downloading numpy.whl (16.6 MB)\n"
    lock = ROOT / "requirements/demo.lock"
    done, _, packages = get_ready.pip_progress(pip * 3, lock).split()
    assert done == "3"
    assert 20 < int(packages) < 60
    assert get_ready.pip_progress(pip + "Installing collected packages: numpy\n", lock) == "installing"
    npm = "npm http fetch GET 200 https://registry.npmjs.org/ol\nnpm http fetch GET 200 https://registry.npmjs.org/ol/-/ol-10.tgz 1ms\n"
    done, _, packages = get_ready.npm_progress(npm, ROOT / "gcs/package-lock.json").split()
    assert done == "1"
    assert 100 < int(packages) < 250


def test_a_log_gets_a_plain_line_now_and_then() -> None:
    log = io.StringIO()
    display = get_ready.Display(log, 100.0)
    step = get_ready.Step("Rust core", ("core",))
    step.process = subprocess.Popen([sys.executable, "-c", ""])
    step.process.wait()
    for second in range(100, 165):
        display.show([step], float(second), total=5, done=2)
    assert log.getvalue().splitlines() == [f"· 0:{second}  step 3 of 5: Rust core" for second in (20, 40)] + [
        "· 1:00  step 3 of 5: Rust core"
    ]


def steps(*codes: str) -> list[Any]:
    """Return one step for each Python program, each after the previous one; with a leading `&`, in parallel to it."""
    found: list[Any] = []
    before = ""
    for number, code in enumerate(codes):
        after = (before,) if before and not code.startswith("&") else ()
        before = f"step {number}"
        found.append(get_ready.Step(before, (code.removeprefix("&"),), after=after))
    return found


def test_steps_wait_for_what_they_need_and_say_what_they_did(tmp_path: Path) -> None:
    there = tmp_path / "there"
    log = io.StringIO()
    code = get_ready.run(
        steps(
            f"from pathlib import Path; print('first'); Path({str(there)!r}).touch()",
            f"from pathlib import Path; assert Path({str(there)!r}).exists(); print('second')",
        ),
        [sys.executable, "-c"],
        log,
        look_s=0.01,
    )
    assert code == 0
    assert [line for line in log.getvalue().splitlines() if not line.startswith("·")] == ["first", "second"]


def test_a_step_that_fails_is_seen_whole_and_ends_the_others() -> None:
    log = io.StringIO()
    planned = steps(
        "import signal; signal.pause()",
        "&import sys; print('error: no space left'); sys.exit(3)",
        "raise SystemExit('never begun')",
    )
    assert get_ready.run(planned, [sys.executable, "-c"], log, look_s=0.01) == 3
    said = log.getvalue()
    assert "error: no space left\n· step 1: failed after" in said
    assert "never begun" not in said
    first = planned[0]
    assert first.process is not None
    assert first.process.returncode == -15


def test_what_comes_last_of_a_step_that_fails_is_told_before_it_counts_as_over() -> None:
    log = io.StringIO()
    # Printed by a child process half a second after the step has ended.
    late = "import os, time\nif os.fork(): os._exit(3)\ntime.sleep(0.5)\nprint('error: no space left')"
    assert get_ready.run(steps(late), [sys.executable, "-c"], log, look_s=0.0) == 3
    assert log.getvalue() == "error: no space left\n· step 0: failed after 0:00\n"


def test_what_failed_prints_its_log_without_progress_bars(tmp_path: Path) -> None:
    for name in ("scripts/setup.sh", "Cargo.toml", "gcs/package.json", "gcs/package-lock.json"):
        target = tmp_path / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, target)
    programs = tmp_path / "bin"
    programs.mkdir()
    for name, text in {
        "node": "echo v22.12.0",
        "npm": r"printf '    Building [=> ] 1/9: ol\rnpm error code ENOSPC\n' >&2; exit 1",
    }.items():
        (programs / name).write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
        (programs / name).chmod(0o755)
    env = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}"}
    done = subprocess.run(
        [tmp_path / "scripts/setup.sh", "app-packages"], env=env, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "npm error code ENOSPC\nsetup: gcs/package-lock.json could not be installed\n" in done.stderr
    assert "Building" not in done.stderr


@pytest.mark.parametrize("wanted", ["demo", "native"])
def test_every_step_is_one_of_setup_and_comes_after_what_there_is(wanted: str) -> None:
    planned = get_ready.steps_of(wanted)
    setup = (ROOT / "scripts/setup.sh").read_text(encoding="utf-8").partition('case "${1:-}" in')[2]
    titles = {step.title for step in planned}
    assert len(titles) == len(planned) >= 4
    for step in planned:
        assert f"\n    {step.words[0]}) " in setup
        assert titles.issuperset(step.after)
