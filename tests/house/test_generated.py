"""Generated files are current."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.house.support import ROOT


@pytest.mark.parametrize(
    ("script", "source"),
    [
        ("message_layouts.py", "MAVLink's definitions"),
        ("telemetry_classes.py", "schemas/openapi.json"),
        ("aio_methods.py", "python/vencejo/vehicle.py"),
    ],
)
def test_what_a_script_writes_is_up_to_date(script: str, source: str) -> None:
    ended = subprocess.run([sys.executable, ROOT / "scripts" / script, "--check"], check=False)
    assert ended.returncode == 0, f"{source} changed: run .venv/bin/python scripts/{script}"
