"""The examples in the package's docstrings run and print what they say."""

from __future__ import annotations

import doctest
import importlib

import pytest

MODULES = [
    "vencejo",
    *(
        f"vencejo.{name}"
        for name in (
            "aio",
            "errors",
            "geodesy",
            "landing",
            "plan",
            "separation",
            "station",
            "survey",
            "telemetry",
            "vehicle",
        )
    ),
]


@pytest.mark.parametrize("name", MODULES)
def test_examples(name: str) -> None:
    found = doctest.testmod(importlib.import_module(name))
    assert found.attempted > 0
    assert found.failed == 0
