"""Findings of plan checks, as `vencejo.Plan.check` returns and `vencejo.PlanRefused` carries them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal

__all__ = ["Finding"]


@dataclass(frozen=True)
class Finding:
    """A finding of a plan check.

    Attributes
    ----------
    severity : {"error", "warning"}
        A plan with an error is not uploaded.
    code : str
        Stable name of the finding.
    item : int or None
        The item concerned, counted from 1.
    message, remedy : str
        What is wrong, and what to do about it, in English.
    figures : mapping of str to bool, int, float, str or None
        What the sentences tell, by name; a name ends in its unit, as in ``length_m``. ``None`` is not known, or without
        limit. `schemas/openapi.json` lists them for each code (``FindingKind``).
    """

    severity: Literal["error", "warning"]
    code: str
    item: int | None
    message: str
    remedy: str
    figures: Mapping[str, bool | int | float | str | None] = field(default_factory=dict, hash=False)

    def __str__(self) -> str:
        return f"{self.message}: {self.remedy}" if self.remedy else self.message


def with_flown(drawn: Iterable[Finding], flown: Iterable[Finding]) -> tuple[Finding, ...]:
    """What is wrong or doubtful in a plan that was rehearsed.

    That is what its lines show, but for the legs that look short, for the flight shows whether they are; and what the
    flight shows.
    """
    return (*(finding for finding in drawn if finding.code != "short-leg"), *flown)
