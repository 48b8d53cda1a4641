#!/usr/bin/env python3
"""Checks the layout: which crate and which Python room may use which, no circles of files, and a word of each file on what it owns.

The tables below are the law; ARCHITECTURE.md shows them and tests/house/test_docs.py compares the two.
Crates are read from `cargo metadata`, Python rooms from the import statements. Standard library only.
"""

from __future__ import annotations

import ast
import contextlib
import json
import re
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from scripts import file_arrows  # noqa: E402

#: Crate → crates of ours that it may depend on, in any way (normal, build, dev).
CRATES: dict[str, frozenset[str]] = {
    "proto": frozenset(),
    "store": frozenset(),
    "video": frozenset(),
    "flight": frozenset({"proto"}),
    "vehicle": frozenset({"proto", "flight"}),
    "link": frozenset({"proto", "store"}),
    "maps": frozenset({"proto", "flight", "store"}),
    "station": frozenset({"proto", "flight", "vehicle", "link", "store"}),
    "fleet": frozenset({"proto", "flight", "vehicle", "link", "station", "store"}),
    "server": frozenset({"proto", "flight", "vehicle", "link", "maps", "station", "store", "video"}),
    "py": frozenset({"proto", "flight", "vehicle", "link", "maps", "station", "fleet", "server", "store", "video"}),
    "bench-load": frozenset(),
    "fuzz": frozenset({"proto", "flight", "vehicle", "link", "maps", "station", "fleet", "server", "store", "video"}),
}

#: What the arrows above stand for when drawn without what follows from them.
DRAWN_CRATES: dict[str, tuple[str, ...]] = {
    "proto": (),
    "store": (),
    "video": (),
    "flight": ("proto",),
    "vehicle": ("proto", "flight"),
    "link": ("proto", "store"),
    "maps": ("flight", "store"),
    "station": ("vehicle", "link", "flight"),
    "fleet": ("station",),
    "server": ("station", "maps", "video"),
    "py": ("server", "fleet", "station", "flight"),
    "bench-load": (),
    "fuzz": ("server", "fleet"),
}

#: External crates that mean I/O or a language: only these crates of ours may name them.
FENCED: dict[str, frozenset[str]] = {
    "axum": frozenset({"server"}),
    "tokio": frozenset({"link", "maps", "station", "fleet", "video", "server", "py"}),
    "zenoh": frozenset({"fleet"}),
    "prost": frozenset({"fleet", "fuzz"}),
    "rcgen": frozenset({"fleet"}),
    "ring": frozenset({"fleet"}),
    "x509-parser": frozenset({"fleet"}),
    "reqwest": frozenset({"maps"}),
    "rusqlite": frozenset({"maps"}),
    "tokio-serial": frozenset({"link"}),
    "serialport": frozenset({"link"}),
    "pyo3": frozenset({"py"}),
    "mavlink": frozenset({"proto"}),
}

#: Crates without I/O, thread or clock, and what would be one.
PURE: frozenset[str] = frozenset({"proto", "flight", "vehicle", "fleet"})
#: What of them is not: crate → files and folders of its `src`.
IMPURE_PARTS: dict[str, frozenset[str]] = {"fleet": frozenset({"carrier", "operator.rs"})}
IMPURE = re.compile(r"\bstd::(?:fs|net|process|thread)\b|\bInstant::now\b|\bSystemTime::now\b")

#: Python room → rooms that it may import. `sdk` is python/vencejo itself without its sub-rooms.
ROOMS: dict[str, frozenset[str]] = {
    "sdk": frozenset({"_native"}),
    "camera": frozenset({"sdk"}),
    "cli": frozenset({"sdk"}),
    "jderobot": frozenset({"sdk"}),
    "sim": frozenset({"guidance"}),
}

#: Rooms that a room may *start* without depending on them: imported inside a function only, by the
#: one file named. The command runs the simulated plane; the plane stays an honest peer on a link.
STARTS: dict[tuple[str, str], frozenset[str]] = {
    ("cli", "sim"): frozenset({"sim.py", "demo.py"}),
    ("cli", "jderobot"): frozenset({"ice.py"}),
    ("cli", "camera"): frozenset({"camera.py"}),
}

#: Third-party modules that only these rooms may import.
FENCED_MODULES: dict[str, frozenset[str]] = {
    "pymavlink": frozenset({"sim"}),
    "jsbsim": frozenset({"sim"}),
    "typer": frozenset({"cli"}),
    "rich": frozenset({"cli"}),
    "segno": frozenset({"cli"}),
    "Ice": frozenset({"jderobot"}),
}

#: The native part that the simulated plane may call, as room `guidance`: the flight crate's laws, nothing of the driver.
NATIVE_GUIDANCE = frozenset({"vencejo._native.PlanePilot"})


#: How a file that is kept comes to be: in crate `store` alone, which writes beside, forces to the disk and renames. The files
#: named here make what grows (recordings), what is not kept (uploads on their way, notes of what is being read), or a lock.
WRITES = re.compile(
    r"\bfs::(?:rename|write|copy|hard_link)\b|\bFile::create\w*|\bOpenOptions\b|\bNamedTempFile\b"
    r"|\.write_(?:text|bytes)\(|\bos\.(?:replace|rename|link|O_CREAT)\b|\bshutil\.(?:move|copy\w*)\("
    r"|\b(?:open|fdopen)\([^)\n]*[\"'][wax]b?\+?[\"']|\b(?:partial|temporary|beside|path)\.(?:replace|rename)\("
)
WRITERS: dict[str, str] = {
    "crates/link/src/recorder/storage.rs": "a .tlog or .mcap file grows",
    "crates/maps/src/aside.rs": "notes of what is being read, and the lock of a run",
    "crates/maps/src/uploads.rs": "a file on its way in",
    "python/vencejo/camera/recorder.py": "a video grows",
    "python/vencejo/cli/map_service.py": "a file on its way in",
    "python/vencejo/cli/signing.py": "a key for another station: for its owner alone from the first byte, and only where there is no file",
}


#: Arrows back that are meant, with the reason.
BACK: dict[tuple[str, str], str] = {
    (
        "python/vencejo/vehicle.py",
        "python/vencejo/station.py",
    ): "for types alone: a vehicle names the station that hears it",
}


@dataclass(frozen=True)
class Import:
    """One import statement: the absolute module (with the name taken from it), where, and whether at module level."""

    module: str
    line: int
    at_top: bool


class Report:
    """Counts what was checked and keeps what was wrong."""

    def __init__(self) -> None:
        self.passed = 0
        self.faults: list[str] = []

    def check(self, ok: bool, fault: str) -> None:
        """Count one check; keep ``fault`` when it is not ``ok``."""
        if ok:
            self.passed += 1
        else:
            self.faults.append(fault)


def closure(drawn: dict[str, tuple[str, ...]]) -> dict[str, frozenset[str]]:
    """Return what each crate reaches by following the drawn arrows."""
    reached: dict[str, frozenset[str]] = {}

    def reach(crate: str, path: tuple[str, ...]) -> frozenset[str]:
        if crate in path:
            raise ValueError(f"the arrows go in a circle: {' → '.join((*path, crate))}")
        if crate not in reached:
            below = [reach(other, (*path, crate)) for other in drawn[crate]]
            reached[crate] = frozenset(drawn[crate]).union(*below)
        return reached[crate]

    for crate in drawn:
        reach(crate, ())
    return reached


def crate_dependencies(metadata: str) -> dict[str, set[str]]:
    """Return, from the output of ``cargo metadata --no-deps``, each crate's dependencies without our prefix."""
    packages = json.loads(metadata)["packages"]
    return {
        short(package["name"]): {short(dependency["name"]) for dependency in package["dependencies"]}
        for package in packages
    }


def short(name: str) -> str:
    """Return a crate's name as ARCHITECTURE.md writes it (``vencejo-proto`` → ``proto``)."""
    return name.removeprefix("vencejo-")


def check_crates(dependencies: dict[str, set[str]], report: Report) -> None:
    """Check the crates' arrows and the fences around external crates."""
    for crate, used in sorted(dependencies.items()):
        allowed = CRATES.get(crate)
        report.check(
            allowed is not None,
            f"crates/{crate}: not in the table; add it to scripts/check_arrows.py and ARCHITECTURE.md",
        )
        for other in sorted(used & (set(CRATES) | set(dependencies))):
            report.check(
                allowed is not None and other in allowed,
                f"crates/{crate}/Cargo.toml: {crate} must not depend on {other}",
            )
        for external in sorted(used & set(FENCED)):
            report.check(
                crate in FENCED[external],
                f"crates/{crate}/Cargo.toml: only {', '.join(sorted(FENCED[external]))} may use `{external}`",
            )
    for crate in sorted(set(CRATES) - set(dependencies)):
        report.check(False, f"{crate}: in the table but not in crates/")


def room_of(module: str) -> str | None:
    """Return the room a module of ours belongs to, or None when it is not ours."""
    parts = module.split(".")
    if parts[0] != "vencejo":
        return None
    if len(parts) > 1 and parts[1] in {"camera", "cli", "jderobot", "sim"}:
        return parts[1]
    if module in NATIVE_GUIDANCE:
        return "guidance"
    if len(parts) > 1 and parts[1] == "_native":
        return "_native"
    return "sdk"


def imports(source: str, package: str) -> Iterator[Import]:
    """Yield what a module imports.

    Parameters
    ----------
    source
        The module's text.
    package
        The dotted package that relative imports start from.
    """
    tree = ast.parse(source)
    type_only = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        for inner in ast.walk(node)
    }
    in_function = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
        for inner in ast.walk(node)
    }
    for node in ast.walk(tree):
        at_top = id(node) not in in_function and id(node) not in type_only
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield Import(alias.name, node.lineno, at_top)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                above = package.split(".")
                above = above[: len(above) - node.level + 1]
                base = ".".join([*above, base] if base else above)
            for alias in node.names:
                yield Import(f"{base}.{alias.name}", node.lineno, at_top)


def check_module(path: Path, shown: str, package: str, report: Report) -> None:
    """Check the imports of one file of python/vencejo."""
    room = room_of(package)
    assert room is not None
    for found in imports(path.read_text(encoding="utf-8"), package):
        where = f"{shown}:{found.line}"
        other = room_of(found.module)
        if other is not None and other != room:
            started = path.name in STARTS.get((room, other), frozenset()) and not found.at_top
            report.check(
                other in ROOMS[room] or started,
                f"{where}: room `{room}` must not import `{found.module}` (room `{other}`)",
            )
        outside = found.module.split(".")[0]
        fence = FENCED_MODULES.get(outside)
        if fence is not None:
            report.check(room in fence, f"{where}: only room {', '.join(sorted(fence))} may import `{found.module}`")


def opens_with_doc(path: Path) -> bool:
    """Return whether a source file opens by saying what it owns."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".rs":
        return next((line for line in text.splitlines() if line.strip()), "").startswith("//!")
    if path.suffix in {".py", ".pyi"}:
        return bool((ast.get_docstring(ast.parse(text)) or "").strip())
    lines = [line for line in text.splitlines() if not line.startswith("#!")]
    return bool(lines) and lines[0].startswith("# ")


def sources(root: Path) -> Iterable[Path]:
    """Return every source file that we wrote."""
    patterns = {
        "crates": ("*.rs",),
        "python": ("*.py", "*.pyi"),
        "tests": ("*.py",),
        "scripts": ("*.py", "*.sh"),
        "bench": ("*.py", "*.rs"),
        "examples": ("*.py", "*.rs"),
    }
    return sorted(
        path
        for folder, globs in patterns.items()
        for glob in globs
        for path in (root / folder).rglob(glob)
        if not {"target", "fixtures", "__pycache__", "out"} & set(path.relative_to(root).parts)
    )


def check_docs(root: Path, report: Report) -> None:
    """Check that every source file opens with a doc comment."""
    for path in sources(root):
        shown = path.relative_to(root)
        try:
            opens = opens_with_doc(path)
        except SyntaxError as error:
            report.check(False, f"{shown}:{error.lineno}: {error.msg}")
            continue
        report.check(opens, f"{shown}: must open with a doc comment that says what the file owns")


def check_pure(root: Path, report: Report) -> None:
    """Check that the crates that are to be pure read no clock and do no I/O; comments may speak of it."""
    for crate in sorted(PURE):
        for path in sorted((root / "crates" / crate / "src").rglob("*.rs")):
            if {"tests", "testing"} & {part.partition(".")[0] for part in path.relative_to(root).parts}:
                continue  # they read fixtures
            if set(path.relative_to(root / "crates" / crate / "src").parts) & IMPURE_PARTS.get(crate, frozenset()):
                continue
            code = "\n".join(line.partition("//")[0] for line in path.read_text(encoding="utf-8").splitlines())
            found = IMPURE.search(code)
            where = f"{path.relative_to(root)}:{code[: found.start()].count(chr(10)) + 1}" if found else ""
            report.check(found is None, f"{where}: crate {crate} is pure and must not use `{found and found.group()}`")


def check_writes(root: Path, report: Report) -> None:
    """Check that files which are kept are written by crate `store` alone, and that the exceptions are ones."""
    rust = [path for path in (root / "crates").glob("*/src/**/*.rs") if "crates/store/" not in path.as_posix()]
    python = [path for path in (root / "python/vencejo").rglob("*.py") if "sim" not in path.parts]
    writers = set()
    for path in sorted([*rust, *python]):
        shown = path.relative_to(root)
        if {"tests", "testing"} & {part.partition(".")[0] for part in shown.parts}:
            continue
        text = path.read_text(encoding="utf-8").partition("#[cfg(test)]")[0]
        comment = "//" if path.suffix == ".rs" else "#"
        code = "\n".join(line.partition(comment)[0] for line in text.splitlines())
        found = WRITES.search(code)
        if found is not None and shown.as_posix() in WRITERS:
            writers.add(shown.as_posix())
            continue
        where = f"{shown}:{code[: found.start()].count(chr(10)) + 1}" if found else ""
        what = found and found.group()
        report.check(
            found is None, f"{where}: `{what}`: a file that is kept is written by crate store (or vencejo.storage)"
        )
    for unused in sorted(set(WRITERS) - writers):
        report.check(False, f"{unused}: in the table of WRITERS, but it writes no file")


def check_circles(root: Path, report: Report) -> None:
    """Check that no files import each other in a circle, but for the arrows back that are meant."""
    arrows = [file_arrows.rust_arrows(root, path.name) for path in sorted((root / "crates").iterdir())]
    arrows += [file_arrows.python_arrows(root), file_arrows.typescript_arrows(root)]
    for file, other in BACK:
        meant = [each for each in arrows if other in each.get(file, ())]
        report.check(bool(meant), f"{file}: BACK names its import of {other}, which is not there")
        for each in meant:
            each[file].discard(other)
    for each in arrows:
        found = file_arrows.circles(each)
        report.check(not found, "these files import each other in a circle: " + "; ".join(map(", ".join, found)))


def check_python(root: Path, report: Report) -> None:
    """Check the imports of every module of python/vencejo."""
    top = root / "python"
    for path in sorted((top / "vencejo").rglob("*.py")):
        package = ".".join(path.parent.relative_to(top).parts)
        # A file that does not parse is check_docs' to report.
        with contextlib.suppress(SyntaxError):
            check_module(path, str(path.relative_to(root)), package, report)


def main() -> int:
    """Check everything; print what is wrong and one closing line."""
    report = Report()
    report.check(
        closure(DRAWN_CRATES) == CRATES,
        "check_arrows.py: DRAWN_CRATES and CRATES say different things",
    )
    metadata = subprocess.run(
        ["cargo", "metadata", "--no-deps", "--format-version=1"],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    check_crates(crate_dependencies(metadata), report)
    check_pure(ROOT, report)
    check_writes(ROOT, report)
    check_python(ROOT, report)
    check_circles(ROOT, report)
    check_docs(ROOT, report)
    for fault in report.faults:
        print(fault)
    print(f"arrows: {report.passed} passed, {len(report.faults)} failed")
    return 1 if report.faults else 0


if __name__ == "__main__":
    sys.exit(main())
