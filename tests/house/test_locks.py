"""Dependencies are pinned and hashed, the locks agree, and crates share one set of lints."""

from __future__ import annotations

import re

import pytest

from tests.house.support import ROOT, tracked

PIN = re.compile(
    r"^([A-Za-z0-9._-]+)==([^ \\]+)(?: ; (.*?))? \\\n((?:    --hash=sha256:[0-9a-f]{64}(?: \\)?\n)+)", re.MULTILINE
)


def pins(name: str) -> set[tuple[str, str, str]]:
    """Return the packages of a lock: name, version, and environment markers."""
    text = (ROOT / f"requirements/{name}.lock").read_text(encoding="utf-8")
    return {(package, version, marker or "") for package, version, marker, _ in PIN.findall(text)}


def canonical(name: str) -> str:
    """Return a package name as normalised by the registries."""
    return re.sub(r"[-_.]+", "-", name).lower()


@pytest.mark.parametrize("name", ["run", "demo", "dev", "docs", "audit"])
def test_every_package_is_pinned_and_hashed(name: str) -> None:
    text = (ROOT / f"requirements/{name}.lock").read_text(encoding="utf-8")
    named = re.findall(r"^([A-Za-z0-9][^ =;]*)", text, re.MULTILINE)
    assert len(named) > 10
    assert sorted(named) == sorted(package for package, _, _ in pins(name))
    assert "://" not in text, "a lock must not say where packages come from"
    assert "index-url" not in text


@pytest.mark.parametrize(("name", "package"), [("ice", "zeroc-ice"), ("ice-build", "setuptools")])
def test_what_is_compiled_for_the_tests_is_pinned_and_hashed(name: str, package: str) -> None:
    assert [found for found, _, _ in pins(name)] == [package]


@pytest.mark.parametrize(("smaller", "larger"), [("run", "demo"), ("demo", "dev"), ("run", "docs")])
def test_a_larger_lock_holds_all_of_the_smaller(smaller: str, larger: str) -> None:
    # Environment markers may be written differently; the installed packages must not differ.
    few, many = ({(package, version) for package, version, _ in pins(name)} for name in (smaller, larger))
    assert few <= many, f"run `make lock`: {sorted(few - many)}"


def test_what_the_project_depends_on_is_locked() -> None:
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    dependencies = re.search(r"^dependencies = \[(.*?)\]", text, re.MULTILINE | re.DOTALL)
    assert dependencies is not None
    wanted = {canonical(name) for name in re.findall(r'"([A-Za-z0-9._-]+)', dependencies[1])}
    assert wanted
    assert wanted <= {canonical(package) for package, _, _ in pins("run")}, "run `make lock`"


def test_every_crate_takes_the_lints_of_the_workspace() -> None:
    manifests = tracked("crates/*/Cargo.toml", "bench/*/Cargo.toml", "fuzz/Cargo.toml")
    assert len(manifests) >= 7
    for manifest in manifests:
        text = manifest.read_text(encoding="utf-8")
        assert "[lints]\nworkspace = true" in text, f"{manifest.relative_to(ROOT)}: no [lints] workspace = true"
        assert "license.workspace = true" in text, manifest
