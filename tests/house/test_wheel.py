"""The wheel works without a checkout: built, installed in a clean environment, and run from another folder."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.house.support import ROOT, load, tracked

sbom = load("scripts/sbom.py")


def run(*command: str | Path, cwd: Path, **environment: str) -> str:
    """Run a program without the checkout in its environment; return its output."""
    clean = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    found = subprocess.run(
        list(map(str, command)),
        cwd=cwd,
        env={**clean, "NO_COLOR": "1", "COLUMNS": "100", **environment},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    assert found.returncode == 0, f"{command}\n{found.stdout}\n{found.stderr}"
    return found.stdout


@pytest.mark.wheel
@pytest.mark.timeout(900)
def test_wheel_runs_in_a_clean_environment_elsewhere(tmp_path: Path) -> None:
    maturin = Path(sys.executable).parent / "maturin"
    dist = tmp_path / "dist"
    parts = tmp_path / "parts"
    run(sys.executable, "scripts/sbom.py", "parts", parts, cwd=ROOT)
    # Built like `scripts/setup.sh native as-tested`, for the same Python too, so that this is packing rather than
    # compiling, and the next `make test` does not have to rebuild PyO3.
    run(
        maturin, "build", "--profile", "dev", "--features", "as-tested,fleet", "--locked", "--quiet", "--out", dist,
        *(option for part in sorted(parts.iterdir()) for option in ("--sbom-include", part)),
        cwd=ROOT, VIRTUAL_ENV=str(Path(sys.executable).parents[1]), PYO3_CONFIG_FILE=str(ROOT / "crates/py/any-python.txt"),
    )  # fmt: skip
    wheels = list(dist.glob("*.whl"))
    assert len(wheels) == 1
    wheel = wheels[0]
    assert "-cp310-abi3-" in wheel.name, "one wheel for every Python from 3.10"

    packed = set(zipfile.ZipFile(wheel).namelist())
    ours = {str(path.relative_to(ROOT / "python")) for path in tracked("python/vencejo")}
    assert len(ours) > 5
    assert ours <= packed, f"not in the wheel: {sorted(ours - packed)}"
    assert any(name.startswith("vencejo/_native.") and name.endswith(".so") for name in packed)
    assert {Path(name).name for name in packed} >= {"LICENSE-MIT", "LICENSE-APACHE"}
    strange = {name for name in packed if name.partition("/")[0].partition("-")[0] not in {"vencejo", "vencejo.libs"}}
    assert strange == set(), "the wheel brings along what is not the package"

    run(sys.executable, "scripts/sbom.py", "merge", wheel, cwd=ROOT)
    listed = {each["purl"] for each in json.loads(wheel.with_suffix(".cdx.json").read_text("utf-8"))["components"]}
    assert sbom.everything() <= listed, f"not in the list of what the wheel holds: {sorted(sbom.everything() - listed)}"

    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    environment = tmp_path / "environment"
    run(sys.executable, "-m", "venv", "--without-pip", environment, cwd=elsewhere)
    python = environment / "bin/python"
    pip: list[str | Path] = [sys.executable, "-m", "pip", "--python", python, "--quiet", "--disable-pip-version-check"]
    # Compiling all of pymavlink takes longer than everything else here, and only a few modules are used.
    install: list[str | Path] = [*pip, "install", "--no-compile", "--no-deps"]
    run(*install, "--require-hashes", "-r", ROOT / "requirements/run.lock", cwd=elsewhere)
    run(*install, "--no-index", wheel, cwd=elsewhere)
    run(*pip, "check", cwd=elsewhere)

    shown = run(python, "-c", "import vencejo; print(vencejo.__file__, vencejo.__version__)", cwd=elsewhere)
    assert str(environment) in shown
    assert shown.split()[1] == wheel.name.split("-")[1]
    command = environment / "bin/vencejo"
    assert "fly" in run(command, "--help", cwd=elsewhere)
    assert "--help" in run(command, "sim", "--help", cwd=elsewhere)
