"""Audits dependencies: licences, sources, duplicates and known faults of crates, Python and npm packages.

`make audit` runs it. Licences, sources and duplicates come from the lock files and the installed packages; advisories
come from each ecosystem's tools, which query their registries. Without network access these are reported as skipped,
and the audit continues; `--need-advisories` makes that a failure.
"""

from __future__ import annotations

import argparse
import functools
import importlib.metadata
import json
import os
import re
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[1]
TOOLS = ROOT / ".cache/tools"
CARGO_DENY = "0.20.2"
CRATES_IO = "registry+https://github.com/rust-lang/crates.io-index"
PIN = re.compile(r"^([A-Za-z0-9._-]+)==([^ \\;]+)", re.MULTILINE)
PYTHON_LOCKS = ("run", "demo", "ice", "dev", "ice-build", "docs", "ros", "audit")
NPM_FOLDERS = ("gcs", "examples/jderobot")

# Python packages are installed beside ours, not built into it, and users can replace them: LGPL is acceptable too.
PYTHON_ALSO = frozenset({"LGPL-2.0-or-later", "LGPL-3.0-only", "MIT-CMU", "PSF-2.0"})
# Trove classifiers of packages without a licence expression.
CLASSIFIERS = {
    "Apache Software License": "Apache-2.0",
    "BSD License": "BSD-3-Clause",
    "GNU Lesser General Public License v2 or later (LGPLv2+)": "LGPL-2.0-or-later",
    "GNU Lesser General Public License v3 (LGPLv3)": "LGPL-3.0-only",
    "ISC License (ISCL)": "ISC",
    "MIT License": "MIT",
}
NO_NETWORK = re.compile(
    r"ConnectionError|ProxyError|Max retries|Connection refused|ECONNREFUSED|ENOTFOUND|EAI_AGAIN|ETIMEDOUT|"
    r"failed to fetch|failed to (?:clone|connect|resolve)|Name or service|timed out|40[345] |50\d |not found on PyPI",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class Outcome:
    """Result of one check, or that it could not be made."""

    what: str
    verdict: Literal["passed", "FAILED", "skipped"]
    text: str

    def __str__(self) -> str:
        """Return the printed line."""
        return f"{self.what}: {self.verdict}{', ' if self.verdict == 'skipped' else ' '}{self.text}"


def outcome(what: str, faults: Iterable[str], looked_at: int) -> Outcome:
    """Return the result of a check; a check without subjects has failed too."""
    found = sorted(faults)
    if found:
        return Outcome(what, "FAILED", "\n  ".join(["", *found]).rstrip())
    return Outcome(what, "passed" if looked_at else "FAILED", f"({looked_at} packages)")


def skipped(what: str, why: str) -> Outcome:
    """Return that advisories could not be queried, with the tool's own message."""
    lines = [line.strip() for line in why.splitlines() if NO_NETWORK.search(line)]
    return Outcome(what, "skipped", f"no network ({lines[-1][:160] if lines else why[:160]})")


def is_allowed(expression: str, allowed: frozenset[str]) -> bool:
    """Return whether an SPDX expression can be met with the allowed licences (`/` is cargo's old OR)."""
    words = re.findall(r"[()]|[^\s()/]+|/", expression)

    def choice() -> bool:
        met = both()
        while words and words[0] in ("OR", "/"):
            words.pop(0)
            met = both() or met
        return met

    def both() -> bool:
        met = one()
        while words and words[0] == "AND":
            words.pop(0)
            met = one() and met
        return met

    def one() -> bool:
        word = words.pop(0) if words else ""
        if word == "(":
            met = choice()
            if not words or words.pop(0) != ")":
                raise ValueError(f"no licence expression: {expression!r}")
            return met
        if words and words[0] == "WITH":
            word = " ".join([word, *(words.pop(0) for _ in range(min(2, len(words))))])
        return word in allowed

    met = choice()
    if words:
        raise ValueError(f"no licence expression: {expression!r}")
    return met


def deny_toml() -> dict[str, Any]:
    """Return the content of deny.toml."""
    return tomllib.loads((ROOT / "deny.toml").read_text(encoding="utf-8"))


def allowed_licences() -> frozenset[str]:
    """Return the licences permitted for built-in dependencies."""
    return frozenset(deny_toml()["licenses"]["allow"])


def licences_of_crate(name: str, version: str) -> frozenset[str]:
    """Return the licences permitted for a crate, including its exceptions in deny.toml."""
    exceptions = deny_toml()["licenses"].get("exceptions", [])
    own = [licence for each in exceptions if each["crate"] == f"{name}@{version}" for licence in each["allow"]]
    return allowed_licences() | frozenset(own)


def run(*command: str | Path, cwd: Path = ROOT) -> subprocess.CompletedProcess[str]:
    """Run a tool and capture its output."""
    return subprocess.run([*map(str, command)], cwd=cwd, capture_output=True, text=True, check=False)


@functools.cache
def crates() -> list[dict[str, Any]]:
    """Return every crate of Cargo.lock, including ours, for all platforms and features."""
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--all-features"]
    result = run(*command, "--offline")
    if result.returncode != 0:
        result = run(*command)
    if result.returncode != 0:
        raise SystemExit(f"audit: {result.stderr.strip()}")
    packages: list[dict[str, Any]] = json.loads(result.stdout)["packages"]
    return packages


def check_crates() -> Iterator[Outcome]:
    """Check the licence, source and number of versions of each crate; cargo-deny does so too, where available."""
    packages = crates()
    unlicensed = [
        f"{package['name']} {package['version']}: {package['license'] or 'no licence named'}"
        for package in packages
        if not is_allowed(package["license"] or "none", licences_of_crate(package["name"], package["version"]))
    ]
    yield outcome("crates, licences", unlicensed, len(packages))
    strange = [
        f"{package['name']} {package['version']}: {package['source']}"
        for package in packages
        if package["source"] not in (None, CRATES_IO)
    ]
    yield outcome("crates, sources", strange, len(packages))
    versions: dict[str, set[str]] = defaultdict(set)
    for package in packages:
        versions[package["name"]].add(package["version"])
    known = {each["crate"] for each in deny_toml()["bans"]["skip"]}
    twice = [
        f"{name}: {', '.join(sorted(found))}; deny.toml gives a reason for all but one of them, or none"
        for name, found in versions.items()
        if len(found - {each.partition("@")[2] for each in known if each.startswith(f"{name}@")}) > 1
    ]
    gone = [
        f"{each}: not in Cargo.lock, take it from deny.toml"
        for each in known
        if each.partition("@")[2] not in versions[each.partition("@")[0]]
    ]
    yield outcome("crates, duplicates", [*twice, *gone], len(versions))


def check_cargo_deny() -> Iterator[Outcome]:
    """Run cargo-deny for the same checks and the advisories; build it from its locked source when it is missing."""
    tool = TOOLS / f"cargo-deny-{CARGO_DENY}/bin/cargo-deny"
    if not tool.exists():
        print(f"· building cargo-deny {CARGO_DENY} (only once; takes minutes)", file=sys.stderr, flush=True)
        # Unoptimised: it only reads a few hundred manifests.
        built = run(
            "cargo", "install", "--quiet", "--debug", "--locked", "--root", tool.parents[1], f"cargo-deny@{CARGO_DENY}"
        )
        if built.returncode != 0:
            yield Outcome("crates, cargo-deny", "skipped", f"it could not be built: {built.stderr.strip()[-200:]}")
            return
    checked = run(tool, "--offline", "--all-features", "check", "--hide-inclusion-graph", "bans", "licenses", "sources")
    verdict: Literal["passed", "FAILED"] = "passed" if checked.returncode == 0 else "FAILED"
    said = "(bans, licences, sources)" if verdict == "passed" else f"\n{checked.stdout}{checked.stderr}"
    yield Outcome("crates, cargo-deny", verdict, said)
    fetched = run(tool, "fetch", "db")
    if fetched.returncode != 0:
        yield skipped("crates, advisories", fetched.stderr + fetched.stdout)
        return
    checked = run(tool, "--all-features", "check", "--disable-fetch", "--hide-inclusion-graph", "advisories")
    verdict = "passed" if checked.returncode == 0 else "FAILED"
    yield Outcome("crates, advisories", verdict, "" if verdict == "passed" else f"\n{checked.stdout}{checked.stderr}")


def pinned(lock: str) -> dict[str, str]:
    """Return the packages of requirements/LOCK.lock, each with one of its versions."""
    return dict(PIN.findall((ROOT / f"requirements/{lock}.lock").read_text(encoding="utf-8")))


def python_licence(name: str) -> str:
    """Return the declared licence of an installed package."""
    declared = importlib.metadata.metadata(name)
    classifiers = [each.rpartition(" :: ")[2] for each in declared.get_all("Classifier") or ()]
    meant = [CLASSIFIERS[each] for each in classifiers if each in CLASSIFIERS]
    named = [*(declared.get_all("License-Expression") or ()), *meant, *(declared.get_all("License") or ())]
    return named[0] if named else "none"


def check_python_licences() -> Outcome:
    """Check the licences of packages installed with ours, the camera's included; tools and peers are not shipped."""
    allowed, faults, looked_at = allowed_licences() | PYTHON_ALSO, [], 0
    for name in pinned("demo"):
        try:
            licence = python_licence(name)
        except importlib.metadata.PackageNotFoundError:
            continue  # for another platform or Python
        looked_at += 1
        if not is_allowed(licence, allowed):
            faults.append(f"{name}: {licence}")
    return outcome("Python, licences", faults, looked_at)


def judge_pip_audit(what: str, code: int, stdout: str, stderr: str) -> Outcome:
    """Interpret pip-audit's result; packages unknown to the registry count as not audited."""
    try:
        packages = json.loads(stdout)["dependencies"]
    except (ValueError, KeyError):
        if NO_NETWORK.search(stderr):
            return skipped(what, stderr)
        return Outcome(what, "FAILED", f"pip-audit ended with {code}: {stderr.strip()[-400:]}")
    faults = [
        f"{package['name']} {package['version']}: {', '.join(each['id'] for each in package['vulns'])}"
        for package in packages
        if package.get("vulns")
    ]
    passed_over = [package["skip_reason"] for package in packages if "skip_reason" in package]
    if not faults and passed_over:
        return skipped(what, f"{len(passed_over)} of {len(packages)}: {passed_over[0]}")
    return outcome(what, faults, len(packages))


def check_python_advisories() -> Iterator[Outcome]:
    """Run pip-audit for each lock file, without resolving or installing anything."""
    place = TOOLS / "python"
    want = (ROOT / "requirements/audit.lock").read_text(encoding="utf-8")
    stamp = place / "audit.lock"
    if not stamp.exists() or stamp.read_text(encoding="utf-8") != want:
        print("· installing requirements/audit.lock", file=sys.stderr, flush=True)
        made = run(sys.executable, "-m", "venv", "--clear", place)
        if made.returncode == 0:
            made = run(
                place / "bin/python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check",
                "--require-hashes", "--no-deps", "-r", ROOT / "requirements/audit.lock",
            )  # fmt: skip
        if made.returncode != 0:
            yield Outcome("Python, advisories", "skipped", f"no pip-audit: {made.stderr.strip()[-200:]}")
            return
        stamp.write_text(want, encoding="utf-8")
    for lock in PYTHON_LOCKS:
        result = run(
            place / "bin/pip-audit", "--disable-pip", "--require-hashes", "--progress-spinner", "off",
            "--format", "json", "--timeout", "10", "-r", ROOT / f"requirements/{lock}.lock",
        )  # fmt: skip
        yield judge_pip_audit(f"Python, advisories of {lock}.lock", result.returncode, result.stdout, result.stderr)


def npm_packages(folder: str) -> dict[str, dict[str, Any]]:
    """Return the locked packages of a folder by path, without the folder's own."""
    lock = json.loads((ROOT / folder / "package-lock.json").read_text(encoding="utf-8"))
    return {place: package for place, package in lock["packages"].items() if place}


def check_npm(folder: str) -> Iterator[Outcome]:
    """Check that each package is locked by hash without an address, and the licences of built-in packages."""
    packages = npm_packages(folder)
    loose = [
        f"{place}: {package.get('resolved', 'no hash')}"
        for place, package in packages.items()
        if "integrity" not in package or "resolved" in package
    ]
    yield outcome(f"npm, sources of {folder}", loose, len(packages))
    if folder == "gcs":
        built_in = {place: package for place, package in packages.items() if not package.get("dev")}
        faults = [
            f"{place}: {package.get('license')}"
            for place, package in built_in.items()
            if not is_allowed(package.get("license") or "none", allowed_licences())
        ]
        yield outcome(f"npm, licences of {folder}", faults, len(built_in))


def judge_npm_audit(what: str, code: int, stdout: str, stderr: str) -> Outcome:
    """Interpret npm audit's result: any fault in built-in packages, severe ones in tools."""
    try:
        report = json.loads(stdout)
    except ValueError:
        report = {}
    if "auditReportVersion" in report:
        faults = [f"{name}: {each.get('severity')}" for name, each in report.get("vulnerabilities", {}).items()]
        return outcome(what, faults if code else [], report["metadata"]["dependencies"]["total"])
    said = str(report.get("message") or stderr)
    if NO_NETWORK.search(said):
        return skipped(what, said)
    return Outcome(what, "FAILED", f"npm audit ended with {code}: {said.strip()[-400:]}")


def check_npm_advisories(folder: str) -> Iterator[Outcome]:
    """Run npm audit."""
    asked: list[tuple[str, list[str]]] = [(f"npm, advisories of {folder}, tools", ["--audit-level=high"])]
    if folder == "gcs":
        asked.insert(0, (f"npm, advisories of {folder}, built in", ["--omit=dev"]))
    for what, options in asked:
        result = run("npm", "audit", "--json", "--package-lock-only", "--fetch-retries=0", *options, cwd=ROOT / folder)
        yield judge_npm_audit(what, result.returncode, result.stdout, result.stderr)


def checks(*, cargo_deny: bool) -> Iterator[Outcome]:
    """Run all checks."""
    yield from check_crates()
    if cargo_deny:
        yield from check_cargo_deny()
    yield check_python_licences()
    yield from check_python_advisories()
    for folder in NPM_FOLDERS:
        yield from check_npm(folder)
        yield from check_npm_advisories(folder)


def main() -> int:
    """Run the audit; return 1 when a check has failed."""
    parser = argparse.ArgumentParser(
        description="Audits licences, sources, duplicates and known faults of dependencies."
    )
    parser.add_argument("--need-advisories", action="store_true", help="fail where advisories cannot be asked for")
    parser.add_argument(
        "--without-cargo-deny", action="store_true", help="do not build cargo-deny; crates have no advisories then"
    )
    arguments = parser.parse_args()
    os.environ["PATH"] = f"{Path.home() / '.cargo/bin'}{os.pathsep}{os.environ['PATH']}"
    counts: dict[str, int] = defaultdict(int)
    for found in checks(cargo_deny=not arguments.without_cargo_deny):
        print(found, flush=True)
        counts[found.verdict] += 1
    print(f"audit: {counts['passed']} passed, {counts['FAILED']} failed, {counts['skipped']} skipped")
    return 1 if counts["FAILED"] or (arguments.need_advisories and counts["skipped"]) else 0


if __name__ == "__main__":
    sys.exit(main())
