"""Durations of the longer benchmarks; `bench/run.py` has an option for each."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Settings:
    """Adjustable durations and counts."""

    narrow_s: float = 60.0
    """Time during which commands are given on a narrow path."""
    cuts: int = 12
    """Times during a plan's upload at which the path is cut."""
    cut_s: float = 60.0
    """Duration of the cut whose gap is filled."""


SETTINGS = Settings()
