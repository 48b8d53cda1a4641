#!/usr/bin/env python3
"""Checks the architecture: dependencies of crates and Python rooms, import circles, and leading doc comments.

The tables below define the permitted dependencies; ARCHITECTURE.md shows them, and tests/house/test_docs.py compares
the two. Crates are read from `cargo metadata`, Python rooms from the import statements. Standard library only.
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

#: Crate → our crates that it may depend on in any way (normal, build, dev).
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

#: The dependencies above as drawn, without those that follow from others.
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

#: External crates for I/O or language bindings: only these crates of ours may depend on them.
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

#: Crates without I/O, threads or clocks.
PURE: frozenset[str] = frozenset({"proto", "flight", "vehicle", "fleet"})
#: Exceptions: crate → files and folders of its `src` that are not pure.
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

#: Rooms that a room may *start* without depending on them: imported inside a function only, by the one file named. The
# command runs the simulated plane, which otherwise stays an ordinary peer on a link.
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

#: Native parts that the simulated plane (room `guidance`) may call: the flight crate's control laws, nothing of the
# driver.
NATIVE_GUIDANCE = frozenset({"vencejo._native.PlanePilot"})


#: Only crate `store` may create persistent files: it writes a temporary file, syncs and renames it. The exceptions
# named here create growing files (recordings), temporary ones (uploads in progress, notes of what is being read), or
#: locks.
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
    "python/vencejo/cli/aboard.py": "the lock of a running program, and what it shows of its links",
    "python/vencejo/cli/map_service.py": "a file on its way in",
    "python/vencejo/cli/signing.py": "a key for another station: for its owner alone from the first byte, and only where there is no file",
}


#: Permitted circular imports, with the reason.
BACK: dict[tuple[str, str], str] = {
    (
        "python/vencejo/_vehicle_state.py",
        "python/vencejo/station.py",
    ): "for types alone: a vehicle names the station that hears it",
}


@dataclass(frozen=True)
class Import:
    """One import statement: the absolute module (with the imported name), its position, and whether at module level."""

    module: str
    line: int
    at_top: bool


class Report:
    """Counts passed checks and collects faults."""

    def __init__(self) -> None:
        self.passed = 0
        self.faults: list[str] = []

    def check(self, ok: bool, fault: str) -> None:
        """Count one check; record ``fault`` when it is not ``ok``."""
        if ok:
            self.passed += 1
        else:
            self.faults.append(fault)


def closure(drawn: dict[str, tuple[str, ...]]) -> dict[str, frozenset[str]]:
    """Return all crates that each crate depends on, directly or indirectly."""
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
    """Return the short crate name used in ARCHITECTURE.md (``vencejo-proto`` → ``proto``)."""
    return name.removeprefix("vencejo-")


def check_crates(dependencies: dict[str, set[str]], report: Report) -> None:
    """Check the crates' dependencies, internal and external."""
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
    """Return the room of a module, or None when it is not ours."""
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
    """Yield the imports of a module.

    Parameters
    ----------
    source
        The module's source.
    package
        The dotted package against which relative imports are resolved.
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
    """Check the imports of one file in python/vencejo."""
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
    """Return whether a source file begins with a doc comment."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".rs":
        return next((line for line in text.splitlines() if line.strip()), "").startswith("//!")
    if path.suffix in {".py", ".pyi"}:
        return bool((ast.get_docstring(ast.parse(text)) or "").strip())
    lines = [line for line in text.splitlines() if not line.startswith("#!")]
    return bool(lines) and lines[0].startswith("# ")


def sources(root: Path) -> Iterable[Path]:
    """Return every hand-written source file."""
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
    """Check that every source file begins with a doc comment."""
    for path in sources(root):
        shown = path.relative_to(root)
        try:
            opens = opens_with_doc(path)
        except SyntaxError as error:
            report.check(False, f"{shown}:{error.lineno}: {error.msg}")
            continue
        report.check(opens, f"{shown}: must begin with a doc comment that says what the file contains")


def check_pure(root: Path, report: Report) -> None:
    """Check that pure crates use neither clocks nor I/O; comments may mention them."""
    for crate in sorted(PURE):
        for path in sorted((root / "crates" / crate / "src").rglob("*.rs")):
            if {"tests", "testing"} & {part.partition(".")[0] for part in path.relative_to(root).parts}:
                continue  # tests may read fixtures
            if set(path.relative_to(root / "crates" / crate / "src").parts) & IMPURE_PARTS.get(crate, frozenset()):
                continue
            code = "\n".join(line.partition("//")[0] for line in path.read_text(encoding="utf-8").splitlines())
            found = IMPURE.search(code)
            where = f"{path.relative_to(root)}:{code[: found.start()].count(chr(10)) + 1}" if found else ""
            report.check(found is None, f"{where}: crate {crate} is pure and must not use `{found and found.group()}`")


def check_writes(root: Path, report: Report) -> None:
    """Check that only crate `store` creates persistent files, and that each exception is still needed."""
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
            found is None, f"{where}: `{what}`: persistent files are written by crate store (or vencejo.storage)"
        )
    for unused in sorted(set(WRITERS) - writers):
        report.check(False, f"{unused}: in the table WRITERS, but it does not write files")


def check_circles(root: Path, report: Report) -> None:
    """Check that files do not import each other in a circle, except for the permitted ones."""
    arrows = [file_arrows.rust_arrows(root, path.name) for path in sorted((root / "crates").iterdir())]
    arrows += [file_arrows.python_arrows(root), file_arrows.typescript_arrows(root)]
    for file, other in BACK:
        meant = [each for each in arrows if other in each.get(file, ())]
        report.check(bool(meant), f"{file}: BACK permits its import of {other}, which does not exist")
        for each in meant:
            each[file].discard(other)
    for each in arrows:
        found = file_arrows.circles(each)
        report.check(not found, "these files import each other in a circle: " + "; ".join(map(", ".join, found)))


def check_python(root: Path, report: Report) -> None:
    """Check the imports of every module in python/vencejo."""
    top = root / "python"
    for path in sorted((top / "vencejo").rglob("*.py")):
        package = ".".join(path.parent.relative_to(top).parts)
        # Syntax errors are reported by check_docs.
        with contextlib.suppress(SyntaxError):
            check_module(path, str(path.relative_to(root)), package, report)


def main() -> int:
    """Run all checks; print the faults and a summary."""
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
