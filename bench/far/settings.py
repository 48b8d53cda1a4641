"""How long the longer ones of these benchmarks take; `bench/run.py` has an option for each."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Settings:
    """What may be chosen."""

    narrow_s: float = 60.0
    """Orders on a narrow way are given for so long."""
    cuts: int = 12
    """Moments of a plan's transfer at which the way is cut."""
    cut_s: float = 60.0
    """How long the way is cut whose gap is filled."""


SETTINGS = Settings()
