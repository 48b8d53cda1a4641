"""The audit of dependencies: licences, sources, reports of skipped checks, and a complete bill of materials."""

from __future__ import annotations

import importlib.metadata
import json
from typing import Any

import pytest

from tests.house.support import load, tracked

audit = load("scripts/audit.py")
sbom = load("scripts/sbom.py")


def test_licences_sources_and_duplicates_hold_today() -> None:
    found = [*audit.check_crates(), audit.check_python_licences()]
    for folder in audit.NPM_FOLDERS:
        found += audit.check_npm(folder)
    assert len(found) == 7
    assert [str(each) for each in found if each.verdict != "passed"] == []
    locks = {path.stem for path in tracked("requirements/*.lock")}
    assert set(audit.PYTHON_LOCKS) == locks, "every lock is asked about"


@pytest.mark.parametrize(
    ("expression", "is_met"),
    [
        ("MIT", True),
        ("GPL-3.0-only", False),
        ("MIT OR GPL-3.0-only", True),
        ("MIT/Apache-2.0", True),
        ("MIT AND GPL-3.0-only", False),
        ("GPL-3.0-only AND MIT OR ISC", True),
        ("(MIT OR Apache-2.0) AND Unicode-3.0", True),
        ("Apache-2.0 WITH LLVM-exception", True),
        ("Apache-2.0 WITH another-exception", False),
        ("", False),
    ],
)
def test_a_licence_expression_is_met_or_not(expression: str, is_met: bool) -> None:
    allowed = frozenset({"MIT", "ISC", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "Unicode-3.0"})
    assert audit.is_allowed(expression, allowed) is is_met


@pytest.mark.parametrize("expression", ["MIT MIT", "(MIT", "MIT)"])
def test_what_is_no_licence_expression_is_refused(expression: str) -> None:
    with pytest.raises(ValueError, match="no licence expression"):
        audit.is_allowed(expression, frozenset({"MIT"}))


GOOD: dict[str, Any] = {"name": "rich", "version": "15.0.0", "vulns": []}


@pytest.mark.parametrize(
    ("packages", "verdict"),
    [
        ([GOOD], "passed"),
        ([{**GOOD, "vulns": [{"id": "PYSEC-2026-1"}]}], "FAILED"),
        ([GOOD, {"name": "typer", "skip_reason": "Dependency not found on PyPI: typer"}], "skipped"),
        ([{**GOOD, "vulns": [{"id": "PYSEC-2026-1"}]}, {"name": "typer", "skip_reason": "not found"}], "FAILED"),
        ([], "FAILED"),
    ],
)
def test_pip_audit_passes_only_what_it_looked_at(packages: list[dict[str, Any]], verdict: str) -> None:
    assert audit.judge_pip_audit("it", 0, json.dumps({"dependencies": packages}), "").verdict == verdict


@pytest.mark.parametrize(
    ("stderr", "verdict"),
    [("requests.exceptions.ConnectionError: Max retries exceeded", "skipped"), ("KeyError: 'hashes'", "FAILED")],
)
def test_a_network_that_is_not_there_is_told_from_a_fault(stderr: str, verdict: str) -> None:
    assert audit.judge_pip_audit("it", 1, "", stderr).verdict == verdict
    assert audit.judge_npm_audit("it", 1, "", stderr).verdict == verdict
    told = str(audit.judge_pip_audit("it", 1, "", "ConnectionError: nobody there"))
    assert told == "it: skipped, no network (ConnectionError: nobody there)"


def test_npm_audit_is_read() -> None:
    total = {"dependencies": {"total": 7}}
    clean = {"auditReportVersion": 2, "vulnerabilities": {}, "metadata": total}
    assert str(audit.judge_npm_audit("it", 0, json.dumps(clean), "")) == "it: passed (7 packages)"
    faulty = {**clean, "vulnerabilities": {"ol": {"severity": "high"}}}
    assert "ol: high" in str(audit.judge_npm_audit("it", 1, json.dumps(faulty), ""))
    refused = json.dumps({"message": "405 Method Not Allowed - POST", "error": {}})
    assert audit.judge_npm_audit("it", 1, refused, "").verdict == "skipped"


def test_everything_locked_for_running_is_in_the_list_of_parts() -> None:
    """Maturin listed the crates when the installed package was built; the other two lists are made here."""
    files = importlib.metadata.files("vencejo") or []
    told = [json.loads(file.read_text()) for file in files if "sboms" in file.parts and file.suffix == ".json"]
    crates = [each for each in told if each["metadata"]["component"]["name"] == "vencejo-py"]
    assert len(crates) == 1, "build the native module (scripts/setup.sh native)"
    merged = sbom.merge([*crates, sbom.web_part(), sbom.python_part()])
    listed = {each["purl"] for each in merged["components"]}
    everything = sbom.everything()
    assert len(everything) > 250
    assert everything <= listed, f"not in the list (is the native module built anew?): {sorted(everything - listed)}"
    for known in ("axum", "mavlink", "rusqlite"):
        assert any(purl.startswith(f"pkg:cargo/{known}@") for purl in listed), known
    for known in (
        "pkg:npm/svelte@",
        "pkg:npm/ol@",
        "pkg:pypi/pymavlink@",
        "pkg:pypi/zeroc-ice@",
        "pkg:generic/sqlite@",
    ):
        assert any(purl.startswith(known) for purl in listed), known
    refs = {each["bom-ref"] for each in merged["components"]} | {merged["metadata"]["component"]["bom-ref"]}
    assert {each["ref"] for each in merged["dependencies"]} <= refs
    assert {on for each in merged["dependencies"] for on in each["dependsOn"]} <= refs
    assert "file:" not in json.dumps(merged), "where it was built is nobody's business"
