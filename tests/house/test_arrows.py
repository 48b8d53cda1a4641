"""The checkout follows its architecture, and the check notices violations."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.house.support import ROOT, load, table_rows

arrows = load("scripts/check_arrows.py")
file_arrows = arrows.file_arrows


@pytest.mark.fault(48, figure="only crate maps can fetch anything, and it knows no vehicle")
def test_the_checkout_follows_its_arrows() -> None:
    found = subprocess.run(
        [sys.executable, "scripts/check_arrows.py"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert found.returncode == 0, found.stdout + found.stderr
    assert "0 failed" in found.stdout


def test_drawn_arrows_mean_the_table() -> None:
    assert arrows.closure(arrows.DRAWN_CRATES) == arrows.CRATES


def test_a_circle_is_refused() -> None:
    with pytest.raises(ValueError, match="circle"):
        arrows.closure({"a": ("b",), "b": ("a",)})


@pytest.mark.parametrize(
    ("crate", "uses", "says"),
    [
        ("proto", "vencejo-link", "must not depend on link"),
        ("vehicle", "tokio", "station, video may use `tokio`"),
        ("flight", "pyo3", "only py may use"),
        ("vehicle", "mavlink", "only proto may use"),
        ("novelty", "serde", "not in the table"),
    ],
)
def test_a_wrong_dependency_is_found(crate: str, uses: str, says: str) -> None:
    dependencies = {name: set[str]() for name in arrows.CRATES}
    package = {"name": f"vencejo-{crate}", "dependencies": [{"name": uses}]}
    dependencies.update(arrows.crate_dependencies(json.dumps({"packages": [package]})))
    report = arrows.Report()
    arrows.check_crates(dependencies, report)
    assert any(says in fault for fault in report.faults), report.faults


def test_a_missing_crate_is_found() -> None:
    report = arrows.Report()
    arrows.check_crates({}, report)
    assert len(report.faults) == len(arrows.CRATES)


@pytest.mark.parametrize(
    ("file", "source", "fault"),
    [
        ("sim/plane.py", "import vencejo", "must not import `vencejo`"),
        ("sim/plane.py", "from vencejo import connect", "must not import"),
        ("sim/plane.py", "from ..plan import Plan", "must not import"),
        ("sim/plane.py", "from vencejo import _native", "must not import"),
        ("sim/plane.py", "from vencejo._native import PlanePilot", None),
        (
            "sim/plane.py",
            "from vencejo._native import PlanePilot, Station",
            "must not import `vencejo._native.Station`",
        ),
        ("sim/autopilot/core.py", "from ..params import Params", None),
        ("cli/fly.py", "import vencejo", None),
        ("cli/fly.py", "from vencejo import _native", "must not import"),
        ("cli/fly.py", "def run():\n    from vencejo.sim import Plane", "must not import"),
        ("cli/sim.py", "def run():\n    from vencejo.sim import Plane", None),
        ("cli/sim.py", "from vencejo.sim import Plane", "must not import"),
        ("cli/fly.py", "import pymavlink.mavutil", "only room sim"),
        ("plan.py", "def dialect():\n    import pymavlink", "only room sim"),
        ("plan.py", "from vencejo import _native", None),
        ("plan.py", "from vencejo.cli import main", "must not import"),
        ("plan.py", "import rich", "only room cli"),
    ],
)
def test_python_rooms(tmp_path: Path, file: str, source: str, fault: str | None) -> None:
    path = tmp_path / "vencejo" / file
    path.parent.mkdir(parents=True)
    path.write_text(source)
    package = ".".join(path.parent.relative_to(tmp_path).parts)
    report = arrows.Report()
    arrows.check_module(path, file, package, report)
    if fault is None:
        assert report.faults == []
    else:
        assert len(report.faults) == 1, report.faults
        assert fault in report.faults[0]


@pytest.mark.parametrize(
    ("name", "text", "opens"),
    [
        ("a.rs", "//! Owns a.\n", True),
        ("a.rs", "// Owns a.\n", False),
        ("a.rs", "", False),
        ("a.py", '#!/usr/bin/env python3\n"""Owns a."""\n', True),
        ("a.py", "import os\n", False),
        ("a.sh", "#!/bin/sh\n# Owns a.\n", True),
        ("a.sh", "#!/bin/sh\nset -e\n", False),
    ],
)
def test_files_open_by_saying_what_they_own(tmp_path: Path, name: str, text: str, opens: bool) -> None:
    path = tmp_path / name
    path.write_text(text)
    assert arrows.opens_with_doc(path) is opens


@pytest.mark.fault(20, figure="the crate that has MAVFTP can name no file")
@pytest.mark.fault(61, figure="no state machine can read a clock")
@pytest.mark.parametrize(
    ("code", "where"),
    [
        ("// std::fs is for others\nfn pure() {}\n", None),
        ("fn a() {}\nuse std::fs;\n", "crates/vehicle/src/a.rs:2"),
        ("let now = Instant::now();\n", "crates/vehicle/src/a.rs:1"),
        ("let now = std::time::SystemTime::now();\n", "crates/vehicle/src/a.rs:1"),
    ],
)
def test_a_clock_in_a_pure_crate_is_found(tmp_path: Path, code: str, where: str | None) -> None:
    file = tmp_path / "crates/vehicle/src/a.rs"
    file.parent.mkdir(parents=True)
    file.write_text(code)
    report = arrows.Report()
    arrows.check_pure(tmp_path, report)
    assert [fault.partition(": ")[0] for fault in report.faults] == ([] if where is None else [where])


@pytest.mark.parametrize(
    ("file", "code", "fault"),
    [
        ("crates/maps/src/a.rs", "std::fs::rename(a, b)?;\n", True),
        ("crates/maps/src/a.rs", "// fs::rename is for store\n", False),
        ("crates/maps/src/a.rs", "#[cfg(test)]\nmod tests { fn a() { std::fs::write(path, b); } }\n", False),
        ("crates/store/src/a.rs", "fs::rename(a, b)?;\n", False),
        ("python/vencejo/a.py", "path.write_text(text)\n", True),
        ("python/vencejo/a.py", "with open(path, 'w') as file:\n    pass\n", True),
        ("python/vencejo/a.py", "with path.open() as file:\n    text.replace('a', 'b')\n", False),
    ],
)
def test_a_file_that_is_written_elsewhere_is_found(tmp_path: Path, file: str, code: str, fault: bool) -> None:
    path = tmp_path / file
    path.parent.mkdir(parents=True)
    path.write_text(code)
    report = arrows.Report()
    arrows.check_writes(tmp_path, report)
    assert any(found.startswith(f"{file}:1: ") for found in report.faults) is fault, report.faults


def test_architecture_shows_the_same_tables() -> None:
    page = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")

    def shown(header: str, second: str) -> dict[str, frozenset[str]]:
        sections = page.split(f"| {header} | {second} |")
        assert len(sections) == 2, f"ARCHITECTURE.md: no table `{header} | {second}`"
        rows = table_rows(f"| {header} | {second} |" + sections[1].partition("\n\n")[0], first_header=header)
        return {
            name: frozenset[str]() if cell == "nothing of ours" else frozenset(cell.split(", ")) for name, cell in rows
        }

    drawn = {crate: frozenset(others) for crate, others in arrows.DRAWN_CRATES.items()}
    assert shown("crate", "may depend on") == drawn
    assert shown("external crate", "only in") == arrows.FENCED
    assert shown("Python room", "may import") == arrows.ROOMS


@pytest.mark.parametrize(
    ("files", "circles"),
    [
        pytest.param(
            {
                "lib.rs": "mod a;\nmod b;",
                "a.rs": "use crate::b::{B, C as D};\nfn f(_: B, _: D) {}",
                "b.rs": "use super::a;\nfn g() { a::f() }",
            },
            [["a.rs", "b.rs"]],
            id="two files",
        ),
        pytest.param(
            # A package re-exports names that its own files import through it: those depend on each other, not on it.
            {
                "lib.rs": "mod a;",
                "a/mod.rs": "mod b;\nmod c;\npub use b::B;\npub(super) use c::C;",
                "a/b.rs": "pub struct B;",
                "a/c.rs": "use super::B;\npub struct C(B);",
            },
            [],
            id="handed on",
        ),
        pytest.param(
            {
                "lib.rs": "mod a;\npub fn top() { a::f() }",
                "a.rs": "pub fn f() {}\n#[cfg(test)]\nmod tests {\n    use crate::top;\n    fn t() { top() }\n}",
            },
            [],
            id="tests do not count",
        ),
        pytest.param(
            {
                "lib.rs": "mod a;\nmod b;",
                "a.rs": '// use crate::b::B;\nconst A: &str = "crate::b::B";',
                "b.rs": "use crate::a::A;\nfn b() -> &str { A }",
            },
            [],
            id="comments and strings do not count",
        ),
    ],
)
def test_circles_of_rust_files_are_found(files: dict[str, str], circles: list[list[str]], tmp_path: Path) -> None:
    source = tmp_path / "crates/one/src"
    for name, text in files.items():
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        (source / name).write_text(text)
    found = file_arrows.circles(file_arrows.rust_arrows(tmp_path, "one"))
    assert [[file.removeprefix("crates/one/src/") for file in circle] for circle in found] == circles


def test_circles_of_python_and_typescript_files_are_found(tmp_path: Path) -> None:
    texts = {
        "python/vencejo/__init__.py": "from vencejo.a import A",
        "python/vencejo/a.py": "def a():\n    from .b import B",
        "python/vencejo/b.py": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from vencejo import A",
        "gcs/src/lib/a.ts": "import { b } from '$lib/b';",
        "gcs/src/lib/b.ts": "export type { A } from './a';",
        "gcs/src/main.ts": "import './lib/a';",
    }
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    assert file_arrows.circles(file_arrows.python_arrows(tmp_path)) == [["python/vencejo/a.py", "python/vencejo/b.py"]]
    assert file_arrows.circles(file_arrows.typescript_arrows(tmp_path)) == [["gcs/src/lib/a.ts", "gcs/src/lib/b.ts"]]
